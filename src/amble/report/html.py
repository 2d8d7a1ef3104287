"""report.html: the same page for a browser, with values under the pointer and the motion; one file, no network."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from html import escape
from importlib.resources import files
from pathlib import Path

from amble.errors import printable
from amble.io.storage import atomic_write
from amble.report.hover import HoverFigure
from amble.report.page import Page
from amble.report.tables import Table
from amble.view import Replay, replay_fragment

FRAME = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
{style}
</style>
</head>
<body>
<main>
{body}
</main>
<script>
{program}
</script>
</body>
</html>
"""


def html_text(page: Page, figures: Sequence[tuple[HoverFigure, str]], replays: Sequence[Replay]) -> str:
    """Return the page as HTML: summary, first table, motion, figures, then the other tables folded away.

    Args:
        page: what it says; of its figures the titles in ``figures`` are used.
        figures: figure and caption, in the order of the page.
        replays: one or two motions; none for a page without.
    """
    title = escape(printable(page.title))
    summary = "".join(f"<p>{_text(sentence)}</p>" for sentence in page.summary)
    parts = [f"<header><h1>{title}</h1>{summary}</header>"]
    parts += [f"<section>{_table(table)}</section>" for table in page.tables[:1]]
    if replays:
        parts.append(f"<section><h2>Motion</h2>{replay_fragment(replays, 'motion')}</section>")
    if figures:
        drawn = "".join(_figure(figure, caption) for figure, caption in figures)
        parts.append(f'<section><h2>Figures</h2><div class="figures">{drawn}</div></section>')
    folded = [*page.tables[1:], _pairs("Settings", page.settings), _pairs("Versions", page.versions)]
    parts.append("<section><h2>Tables</h2>" + "".join(map(_folded, folded)) + "</section>")
    return FRAME.format(
        title=title, style=_resource("report.css"), body="\n".join(parts), program=_resource("report.js")
    )


def write_html(
    path: str | Path, page: Page, figures: Sequence[tuple[HoverFigure, str]], replays: Sequence[Replay]
) -> Path:
    """Write the page, whole or not at all; arguments as in ``html_text``.

    Raises:
        InputError: where the place cannot be written.
    """
    return atomic_write(path, html_text(page, figures, replays))


@cache
def _resource(name: str) -> str:
    return files("amble.report").joinpath(name).read_text(encoding="utf-8")


def _text(text: str) -> str:
    return escape(printable(text))


def _figure(figure: HoverFigure, caption: str) -> str:
    width, height = figure.size
    panels = json.dumps(figure.panels, allow_nan=False).replace("<", "\\u003c")
    return (
        f'<figure style="width: {1.7 * width:g}px"><div class="plot" data-size="{width:g} {height:g}" '
        f'style="aspect-ratio: {width:g} / {height:g}">'
        f'<img alt="{_text(caption)}" src="data:{figure.kind};base64,{figure.picture}">'
        f'<script type="application/json">{panels}</script></div><figcaption>{_text(caption)}</figcaption></figure>'
    )


def _pairs(title: str, values: Mapping[str, str]) -> Table:
    return Table(title, ("name", "value"), tuple(values.items()))


def _folded(table: Table) -> str:
    return f"<details><summary>{_text(table.title)}</summary>{_table(table, caption=False)}</details>"


def _table(table: Table, caption: bool = True) -> str:
    numeric = table.numeric
    head = "".join(_cell("th", text, right) for text, right in zip(table.header, numeric, strict=True))
    rows = "".join(
        f"<tr>{''.join(_cell('td', text, right) for text, right in zip(row, numeric, strict=True))}</tr>"
        for row in table.rows
    )
    said = f"<caption>{_text(table.title)}</caption>" if caption else ""
    notes = "".join(f'<p class="note">{_text(note)}</p>' for note in table.notes)
    return f'<div class="wide"><table>{said}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{notes}'


def _cell(tag: str, text: str, right: bool) -> str:
    kind = ' class="number"' if right else ""
    return f"<{tag}{kind}>{_text(text)}</{tag}>"
