"""Every citation of a theory page resolves: the page is there, and so are its equation and its section.

A citation is ``docs/theory/PAGE.md``, optionally followed by equations ("eq. 5", "eq. 12 to 17 and 20") or sections
("section 2", "sections 1 and 2"); in the documentation it may be a link to the page. Line breaks may fall anywhere.
"(eq. 5)" alone means the one page that the file cites.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
THEORY = "docs/theory"
PLACES = ("src", "tests", "benchmarks", "examples", "docs", "README.md", "CHANGELOG.md")
KINDS = {".py", ".md", ".c", ".h", ".toml", ".ipynb"}

TAG = re.compile(r"\\tag\{(\d+)\}|\|\s*\((\d+)\)\s*\|\n\|[-|: ]+\|$", re.MULTILINE)
"""Number of a displayed equation, or of a table: the last cell of its head."""

HEADING = re.compile(r"^#+ (\d+)\. \S", re.MULTILINE)
NUMBERS = r"\d+(?:(?: to |, | and |, and )\d+)*"
TAIL = rf"(?:,?\s(?:eq\. (?P<equations>{NUMBERS})|sections? (?P<sections>{NUMBERS})))?"
PLAIN = re.compile(rf"(?<![\w/])docs/theory/(?P<page>[\w.-]+\.md){TAIL}")
LINK = re.compile(rf"\]\((?P<path>[\w./-]+\.md)(?P<anchor>#[\w-]*)?\){TAIL}")
SHORT = re.compile(rf"\(eq\. (?P<equations>{NUMBERS})\)")
MISSPELT = re.compile(r",?\s\(?(?:eqs?\b|[Ee]quation|Eq|sect?\b|Section|§)")
"""What follows a page where somebody meant a number and wrote it in a way that nothing resolves."""

BARE = re.compile(r"(?<![\w/-])theory\.md")
OWN_EQUATION = re.compile(r"(?<!\w)\((\d+)\)")
OWN_SECTIONS = re.compile(rf"\bsections? ({NUMBERS})")


@dataclass(frozen=True)
class Page:
    """What can be cited of a page."""

    equations: tuple[int, ...]
    sections: tuple[int, ...]

    @classmethod
    def of(cls, text: str) -> Page:
        return cls(
            tuple(int(a or b) for a, b in TAG.findall(text)), tuple(int(number) for number in HEADING.findall(text))
        )


def test_every_citation_resolves() -> None:
    """None dangles, and none is of the page without a folder that nobody can find."""
    pages = theory_pages()
    wrong = {
        str(path.relative_to(ROOT)): found
        for path in cited_files()
        if (found := dangling(path.read_text(encoding="utf-8"), path.relative_to(ROOT).parent.as_posix(), pages))
    }
    assert not wrong


def test_pages_are_cited() -> None:
    """The search finds what is there: every page is cited by code, test or another page."""
    cited = {page for path in cited_files() for page in pages_named(path)}
    assert cited >= set(theory_pages())


@pytest.mark.parametrize("name", [path.name for path in sorted((ROOT / THEORY).glob("*.md"))])
def test_equations_and_sections_of_a_page_are_numbered_in_order(name: str) -> None:
    """Equations count 1, 2, ... without a gap or a repetition, every displayed one has a number, and so do sections."""
    text = (ROOT / THEORY / name).read_text(encoding="utf-8")
    page = Page.of(text)
    assert page.equations == tuple(range(1, len(page.equations) + 1))
    assert page.sections == tuple(range(1, len(page.sections) + 1))
    assert page.sections
    displayed = re.findall(r"\$\$(.+?)\$\$", text, re.DOTALL)
    assert displayed
    assert [block for block in displayed if len(TAG.findall(block)) != 1] == []


@pytest.mark.parametrize("name", [path.name for path in sorted((ROOT / THEORY).glob("*.md"))])
def test_a_page_refers_to_what_it_holds(name: str) -> None:
    """A number in parentheses in the text of a page is one of its equations; a section without a page is its own."""
    text = (ROOT / THEORY / name).read_text(encoding="utf-8")
    page = Page.of(text)
    prose = re.sub(r"\$\$.+?\$\$|\$[^$]+\$|^## Sources.*", "", text, flags=re.DOTALL | re.MULTILINE)
    prose = LINK.sub("", prose)
    assert {int(number) for number in OWN_EQUATION.findall(prose)} <= set(page.equations)
    assert {k for numbers in OWN_SECTIONS.findall(prose) for k in _listed(numbers)} <= set(page.sections)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("see docs/theory/page.md, eq. 2", ""),
        ("see docs/theory/page.md,\n    eq. 1 to 2, and more", ""),
        ("# see docs/theory/page.md,\n    # section 1.", ""),
        ("sections: docs/theory/page.md, sections 1 and 2", "section 2"),
        ("docs/theory/page.md, eq. 1 and 3", "equation 3"),
        ("docs/theory/page.md, eq. 1 to\n// 4", "equation 3"),
        ("docs/theory/other.md, eq. 1", "other.md"),
        ("as in theory" + ".md, section 1", "theory" + ".md"),
        ("[the page](theory/page.md), eq. 7", "equation 7"),
        ("[the page](theory/page.md#1-heading)", "anchor"),
        ("docs/theory/page.md, equation 1", "write"),
        ("docs/theory/page.md (Eq. 1)", "write"),
        ("by docs/theory/page.md it holds (eq. 1 and 2)", ""),
        ("by docs/theory/page.md it holds (eq. 3)", "equation 3"),
        ("holds (eq. 1)", "names no page"),
        ("[notation](notation.md), [code](https://example.org/code.md)", ""),
        ("[elsewhere](nowhere.md)", "nowhere.md"),
    ],
)
def test_a_dangling_citation_is_found(text: str, complaint: str) -> None:
    """The resolver itself, on citations that are right and wrong."""
    pages = {"page.md": Page((1, 2), (1,))}
    found = dangling(text, "docs", pages)
    assert any(complaint in line for line in found) if complaint else not found


def dangling(text: str, folder: str, pages: dict[str, Page]) -> list[str]:
    """Return a line for everything that a text cites and that is not there.

    Args:
        text: of a source file or a page.
        folder: of the file, from the root of the project; links start there.
        pages: the theory pages by name.
    """
    flat = re.sub(r"\s*\n[ \t]*(?:#|//|\*)?[ \t]*", " ", text)
    wrong = [f"{match.group()} has no folder" for match in BARE.finditer(flat)]
    for match in PLAIN.finditer(flat):
        wrong += _missing(match, match["page"], pages)
    wrong += _short(flat, pages)
    for match in LINK.finditer(flat):
        place = (ROOT / folder / match["path"]).resolve()
        if place.parent != ROOT / THEORY:
            wrong += [] if place.is_file() else [f"{match.group()}: there is no file {match['path']}"]
        else:
            wrong += _missing(match, place.name, pages)
            wrong += [f"{match.group()}: cite by number, not by anchor"] if match["anchor"] else []
    return wrong


def _short(flat: str, pages: dict[str, Page]) -> list[str]:
    """Equations without a page."""
    named = {match["page"] for match in PLAIN.finditer(flat)}
    wrong = []
    for match in SHORT.finditer(flat):
        wrong += _missing(match, named.copy().pop(), pages) if len(named) == 1 else [f"{match.group()} names no page"]
    return wrong


def _missing(match: re.Match[str], name: str, pages: dict[str, Page]) -> list[str]:
    if name not in pages:
        return [f"{match.group()}: there is no page {name}"]
    page = pages[name]
    if match.re is not SHORT and match["equations"] is None and match["sections"] is None:
        after = MISSPELT.match(match.string, match.end())
        return [f"{match.group()}{after.group()}: write 'eq. N' or 'section N'"] if after else []
    numbers = match.groupdict()
    wrong = [(f"equation {k}", k in page.equations) for k in _listed(numbers["equations"])]
    wrong += [(f"section {k}", k in page.sections) for k in _listed(numbers.get("sections"))]
    return [f"{match.group()}: {name} has no {what}" for what, there in wrong if not there]


def _listed(numbers: str | None) -> list[int]:
    """Numbers of "12 to 17 and 20", each of a range."""
    found: list[int] = []
    for part in re.split(r", and |, | and ", numbers) if numbers else []:
        first, *last = (int(number) for number in part.split(" to "))
        found += range(first, (last[-1] if last else first) + 1)
    return found


def theory_pages() -> dict[str, Page]:
    return {path.name: Page.of(path.read_text(encoding="utf-8")) for path in (ROOT / THEORY).glob("*.md")}


def cited_files() -> list[Path]:
    """Everything written by hand but this file, whose examples dangle on purpose."""
    found = [path for place in PLACES for path in [ROOT / place, *(ROOT / place).rglob("*")]]
    return [path for path in found if path.is_file() and path.suffix in KINDS and path != Path(__file__).resolve()]


def pages_named(path: Path) -> set[str]:
    text = path.read_text(encoding="utf-8")
    return {match["page"] for match in PLAIN.finditer(text)}
