"""Commands over time as a file, and a steered walk as a table: CSV with a head, times in s."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from amble.errors import InputError, shown, shown_path
from amble.io.reader import parse_number, read_text
from amble.io.storage import atomic_write
from amble.io.table import table_text
from amble.simulation.steering import MOST_COMMANDS, Steered

TIME = "time"

LARGEST = 8 * 2**20
"""Bytes of a file of commands."""


def read_commands(path: str | Path, axes: Sequence[str]) -> list[tuple[float, tuple[float, ...]]]:
    """Read commands: a head ``time,speed`` with all axes in any order, then a row for every change of the command.

    Args:
        path: the file.
        axes: what is commanded.

    Returns:
        (time, one number an axis) in the order of ``axes``.

    Raises:
        InputError: in one sentence.
    """
    what = f"commands '{shown_path(path)}'"
    try:
        rows = [row for row in csv.reader(io.StringIO(read_text(path, "commands", LARGEST)), strict=True) if row]
    except csv.Error as error:
        raise InputError(f"{what}: {shown(str(error))}") from None
    if not rows:
        raise InputError(f"{what} are empty; the first line is {','.join((TIME, *axes))}")
    head = [word.strip() for word in rows[0]]
    if sorted(head) != sorted((TIME, *axes)):
        raise InputError(f"{what}: the first line is {','.join((TIME, *axes))}, not {shown(','.join(head), 200)}")
    if len(rows) - 1 > MOST_COMMANDS:
        raise InputError(f"{what} are {len(rows) - 1}; at most {MOST_COMMANDS} are taken")
    found = []
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(head):
            raise InputError(f"{what}, row {number}: {len(row)} entries, not {len(head)}")
        try:
            values = dict(zip(head, (parse_number(word.strip()) for word in row), strict=True))
        except ValueError as error:
            raise InputError(f"{what}, row {number}: {error}") from None
        found.append((values[TIME], tuple(values[axis] for axis in axes)))
    return found


def write_steered(found: Steered, path: str | Path) -> Path:
    """Write a row for every step: time, what was asked for, what was followed, the state at its entry.

    Args:
        found: the walk.
        path: the file.
    """
    asked, followed = ([f"{what}_{axis}" for axis in found.axes] for what in ("asked", "followed"))
    head = [TIME, *asked, *followed, "irregular_contacts", *found.state_names]
    rows = [[step.time, *step.asked, *step.command, step.irregular, *map(float, step.state)] for step in found.steps]
    return atomic_write(Path(path), table_text([head, *rows]))
