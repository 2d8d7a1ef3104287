"""A short table in HTML: how a record shows itself in a notebook."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from amble.errors import printable


def facts_html(title: str, facts: Mapping[str, str]) -> str:
    """Return a title and one row a fact.

    Args:
        title: one line.
        facts: what -> value, with its unit.
    """
    return rows_html(title, (), list(facts.items()))


def rows_html(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table; what a name holds is shown and never read as HTML.

    Args:
        title: one line.
        header: column names; none for no head.
        rows: cells.
    """
    head = f"<thead>{_row('th', header)}</thead>" if header else ""
    body = "".join(_row("td", row) for row in rows)
    return f"<table><caption>{_text(title)}</caption>{head}<tbody>{body}</tbody></table>"


def _row(tag: str, cells: Sequence[str]) -> str:
    return f"<tr>{''.join(f'<{tag}>{_text(cell)}</{tag}>' for cell in cells)}</tr>"


def _text(text: str) -> str:
    return escape(printable(text))
