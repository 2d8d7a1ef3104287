"""What a command says: results on standard output, progress and errors on standard error."""

from __future__ import annotations

import contextlib
import logging
import sys
import time
from collections.abc import Callable, Iterator, Sequence

import typer

from amble.cli.output import quiet, show, wrote
from amble.errors import printable
from amble.progress import Progress, ProgressReport, silent

PAUSE = 5.0
"""Seconds between plain lines; the task and the first of them come at once."""


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


@contextlib.contextmanager
def progress(task: str) -> Iterator[Progress]:
    """Yield a function that shows how far a task is, and tells of the files that it writes."""
    if quiet():
        yield _telling(silent)
        return
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.text import Text  # rows carry names, and rich reads markup into a str

        with Console(stderr=True).status(Text(task)) as status:
            yield _telling(lambda report: status.update(Text(f"{task}: {report}")))
        return
    say(f"{task} ...")
    last = -PAUSE

    def update(report: ProgressReport) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= PAUSE:
            last = now
            say(f"{task}: {report}")

    yield _telling(update)


def _telling(update: Callable[[ProgressReport], None]) -> Progress:
    """Files that were written are results; everything else is progress."""

    def notify(report: ProgressReport) -> None:
        if report.file is None:
            update(report)
        else:
            wrote(report.file)

    return notify
