"""What a command says: results on standard output, progress and errors on standard error."""

from __future__ import annotations

import logging
import sys
from collections.abc import Sequence

import typer

from amble.cli.output import show
from amble.errors import printable


def say(text: str) -> None:
    """Print lines on standard error; what a message quotes writes nothing else to the terminal."""
    typer.echo(printable(text, keep="\n"), err=True)


class _Plain(logging.Formatter):
    """A notice is a bare line; a warning says that it is one."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line of a record."""
        message = record.getMessage()
        return f"{record.levelname.lower()}: {message}" if record.levelno >= logging.WARNING else message


def log_to_stderr() -> None:
    """Show what the package logs, such as "compiling ..." and "no C compiler"."""
    logger = logging.getLogger("amble")
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(_Plain())
    logger.handlers = [handler]
    logger.setLevel(logging.INFO)


def print_table(header: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[int] = ()) -> None:
    """Print aligned columns on standard output; those whose number is in ``right`` are aligned to the right."""
    widths = [max(len(row[column]) for row in (header, *rows)) for column in range(len(header))]
    for row in (header, *rows):
        cells = (
            cell.rjust(width) if column in right else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        show("  ".join(cells).rstrip())
