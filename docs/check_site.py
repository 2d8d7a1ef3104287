"""Look through a built site: every relative link resolves, no page takes a script, style or font from elsewhere.

``python -m docs.check_site FOLDER`` prints what is wrong and exits with 1 where anything is.
"""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {
    "script": "src",
    "link": "href",
    "img": "src",
    "iframe": "src",
    "source": "src",
    "video": "src",
    "embed": "src",
}
"""Element -> attribute that a browser fetches without being asked."""

OF_STYLES = re.compile(r"""url\(\s*["']?([^"')]+)|@import\s+["']([^"']+)""")

POINTERS = ("canonical", "next", "prev", "index", "search", "author")
"""Relations of ``link`` elements that name another page and load nothing."""


class _Page(HTMLParser):
    """Links, what is loaded, and the anchors of one page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors: set[str] = set()
        self.styles = ""
        self._in_style = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect one element."""
        found = {name: value or "" for name, value in attrs}
        self.anchors |= {found[key] for key in ("id", "name") if key in found}
        self.styles += found.get("style", "")
        self._in_style = tag == "style"
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        if tag in LOADED and LOADED[tag] in found and found.get("rel") not in POINTERS:
            self.loaded.append(found[LOADED[tag]])

    def handle_data(self, data: str) -> None:
        """Collect the text of style elements."""
        self.styles += data if self._in_style else ""


def complaints(folder: Path) -> list[str]:
    """Return a line for everything that is wrong with the pages below a folder."""
    pages = {path.resolve(): _Page(path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.html"))}
    wrong = [] if pages else [f"{folder} holds no page"]
    for path, page in pages.items():
        name = path.relative_to(folder.resolve())
        for address in [*page.loaded, *_addresses(page.styles)]:
            parts = urlsplit(address)
            if parts.scheme == "data":
                continue
            if parts.scheme or parts.netloc:
                wrong.append(f"{name}: loads {address[:80]}")
            elif not _target(path, parts.path).is_file():
                wrong.append(f"{name}: loads '{address}', which is not there")
        wrong += [f"{name}: {said}" for link in page.links if (said := _broken(path, link, pages))]
    for path in sorted(folder.rglob("*.css")):
        for address in _addresses(path.read_text(encoding="utf-8")):
            if urlsplit(address).scheme not in ("", "data") or urlsplit(address).netloc:
                wrong.append(f"{path.relative_to(folder)}: loads {address[:80]}")
    return wrong


def _addresses(style: str) -> list[str]:
    return [first or second for first, second in OF_STYLES.findall(style) if not (first or second).startswith("#")]


def _target(page: Path, path: str) -> Path:
    return (page.parent / unquote(path)).resolve()


def _broken(page: Path, link: str, pages: dict[Path, _Page]) -> str:
    """What is wrong with a link; empty where it resolves or leads out of the site."""
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return ""
    target = _target(page, parts.path) if parts.path else page
    target = target / "index.html" if target.is_dir() else target
    if not target.is_file():
        return f"links to '{link}', which is not there"
    known = pages.get(target)
    if parts.fragment and known is not None and unquote(parts.fragment) not in known.anchors:
        return f"links to '{link}', and that page has no such place"
    return ""


if __name__ == "__main__":
    found = complaints(Path(sys.argv[1]))
    print("\n".join(found) or f"{sys.argv[1]}: every link resolves, nothing is loaded from elsewhere")
    sys.exit(1 if found else 0)
