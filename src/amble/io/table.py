"""Tables of comma-separated values: those that others wrote are bounded before and while they are read."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator
from pathlib import Path

from amble.errors import InputError, shown, shown_path
from amble.io.reader import read_text

LARGEST_TABLE = 64 * 2**20
"""Bytes of a table; 150,000 rows of 25 numbers of 17 digits have 70 % of that."""

MOST_CELLS = 4_000_000
"""Cells of a table: each takes 60 bytes of memory, and a million of numbers a second or two."""


def read_table(path: str | Path, what: str) -> tuple[str, list[list[str]]]:
    """Read a table; errors as in ``reader.read_text``.

    Args:
        path: the file.
        what: what it is, such as "log"; sentences begin with it.

    Returns:
        The comment that is its first line, without the mark ("# "), empty where there is none; and its rows.

    Raises:
        InputError: also where it is no table, or has too many cells.
    """
    name, text = f"{what} '{shown_path(path)}'", read_text(path, what, LARGEST_TABLE)
    comment, start = "", 0
    if text.startswith("# "):
        comment = text.partition("\n")[0]
        start = len(comment) + 1
    rows, cells = list[list[str]](), 0
    try:
        for row in csv.reader(_lines(text, start)):
            cells += len(row) + 1
            if cells > MOST_CELLS:
                raise InputError(f"{name} cannot be read: it has more than {MOST_CELLS} cells")
            rows.append(row)
    except csv.Error as error:
        raise InputError(f"{name} is no table: {shown(str(error))}") from None
    return comment.removeprefix("# ").rstrip("\r"), rows


def table_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as comma-separated values, a line each; None is an empty cell."""
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue()


def _lines(text: str, start: int) -> Iterator[str]:
    """Yield the lines of a text from a place on, without a copy of all of it."""
    while start < len(text):
        end = text.find("\n", start) + 1 or len(text)
        yield text[start:end]
        start = end
