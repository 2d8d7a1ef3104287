"""Tables as records, printed as text that lines up or as Markdown."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from math import isinf

from amble.errors import InputError, printable
from amble.io.facts import rows_html
from amble.residual import Residual

_MEANINGFUL = re.compile(r"[\\|<>`*\[\]$&]|(?<![A-Za-z0-9])_|_(?![A-Za-z0-9])")
"""What Markdown reads as more than text; an underline inside a word is none."""


@dataclass(frozen=True)
class Table:
    """A table of text cells.

    Attributes:
        title: one line.
        header: column names, units included.
        rows: cells, as many a row as there are columns.
        notes: sentences below the table.

    Raises:
        InputError: where a row has another number of cells than the header.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check that the table is rectangular."""
        for row in self.rows:
            if len(row) != len(self.header):
                raise InputError(f"a row of table '{self.title}' has {len(row)} cells, not {len(self.header)}: {row}")

    def text(self, width: int = 120) -> str:
        """Lay the table out in columns that line up in a terminal; numbers to the right.

        Args:
            width: characters a line.
        """
        from io import StringIO

        from rich import box
        from rich.console import Console
        from rich.table import Table as RichTable
        from rich.text import Text  # plain text: rich reads markup and emoji codes into a str

        drawn = RichTable(title=Text(self.title), title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
        for column, name in enumerate(self.header):
            drawn.add_column(Text(name), justify="right" if self.numeric[column] else "left", overflow="fold")
        for row in self.rows:
            drawn.add_row(*(Text(cell) for cell in row))
        buffer = StringIO()
        console = Console(file=buffer, width=width, color_system=None, force_terminal=False)
        console.print(drawn)
        for note in self.notes:
            console.print(Text(note))
        return "\n".join(line.rstrip() for line in buffer.getvalue().splitlines()) + "\n"

    def markdown(self) -> str:
        """Write the table as Markdown, its cells padded so that the source lines up too."""
        cells = [self.header, *self.rows]
        safe = [tuple(markdown_text(cell) for cell in row) for row in cells]
        widths = [max(3, *(len(row[column]) for row in safe)) for column in range(len(self.header))]
        numeric = self.numeric
        rule = ["-" * (width - 1) + (":" if right else "-") for width, right in zip(widths, numeric, strict=True)]
        body = [_aligned(row, widths, numeric) for row in safe]
        lines = [f"**{markdown_text(self.title)}**", "", body[0], _aligned(rule, widths, numeric), *body[1:], ""]
        for note in self.notes:
            lines += [markdown_text(note), ""]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Show the table in a notebook, its notes below."""
        notes = "".join(f"<p>{escape(printable(note))}</p>" for note in self.notes)
        return rows_html(self.title, self.header, self.rows) + notes

    @property
    def numeric(self) -> tuple[bool, ...]:
        """Whether each column holds numbers, which stand to the right."""
        return tuple(self._is_numeric(column) for column in range(len(self.header)))

    def _is_numeric(self, column: int) -> bool:
        """Whether every cell that is filled starts like a number."""
        filled = [row[column] for row in self.rows if row[column].strip("- ")]
        return bool(filled) and all(cell.lstrip("+-").replace(".", "", 1)[:1].isdigit() for cell in filled)


def number(value: float, digits: int = 4) -> str:
    """Write a number with a number of significant digits, trailing zeros kept, so that columns compare."""
    if value == 0.0:
        return "0"
    return f"{value:#.{digits}g}".rstrip(".") if 1e-3 <= abs(value) < 1e5 else f"{value:.{digits - 1}e}"


def residual_table(title: str, residuals: Sequence[Residual], notes: tuple[str, ...] = ()) -> Table:
    """List residuals with their bounds and when their worst value occurred.

    Args:
        title: one line.
        residuals: one a row.
        notes: sentences below the table.
    """
    header = ("quantity", "lower", "worst value", "upper", "violated by", "time (s)", "cycle")
    return Table(title, header, tuple(_residual_cells(residual) for residual in residuals), notes)


def _residual_cells(residual: Residual) -> tuple[str, ...]:
    lower, upper = ("-" if isinf(bound) else number(bound) for bound in (residual.lower, residual.upper))
    numbers = (lower, number(residual.value), upper, number(residual.violation))
    time = "-" if residual.time is None else f"{residual.time:.4f}"
    return (residual.name, *numbers, time, "-" if residual.cycle is None else str(residual.cycle))


def _aligned(row: Sequence[str], widths: Sequence[int], numeric: Sequence[bool]) -> str:
    padded = [
        cell.rjust(width) if right else cell.ljust(width)
        for cell, width, right in zip(row, widths, numeric, strict=True)
    ]
    return f"| {' | '.join(padded)} |"


def markdown_text(text: str) -> str:
    """Write any text as Markdown that shows it: no cell, link, image, tag or formula ends or begins in it."""
    return _MEANINGFUL.sub(r"\\\g<0>", printable(text))
