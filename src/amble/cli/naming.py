"""Options that name a robot, its feet, a gait and a speed instead of a specification."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from amble.errors import InputError, shown

if TYPE_CHECKING:
    from amble.synthesis.specification import Specification

FEET = typer.Option(
    "--feet", help="Feet of a URDF robot: label=link,... such as fl=FL_foot,fr=FR_foot.", show_default=False
)
GAIT = typer.Option("--gait", help="Gait, by name.", show_default=False)
SPEED = typer.Option("--speed", help="Mean forward velocity, m/s, or with a unit.", show_default=False)
SYMMETRIZE = typer.Option(
    "--symmetrize/--no-symmetrize",
    help="Average left and right inertias; where nothing is said, up to 5 % asymmetry and with a notice.",
    show_default=False,
)


def is_robot(argument: str) -> bool:
    """Whether an argument is a robot, not a specification: a name of the catalogue or a URDF file."""
    from amble.robot import catalogue

    return argument in catalogue.names() or Path(argument).suffix.lower() in (".urdf", ".xml")


def specification(
    robot: str, feet: str | None, gait: str | None, speed: str | None, symmetrize: bool | None, propose: bool
) -> Specification:
    """Return the specification that the options make.

    Args:
        robot: name of the catalogue or URDF file.
        feet: the text of ``--feet``.
        gait: name of the gait.
        speed: the text of ``--speed``.
        symmetrize: whether left and right inertias are averaged.
        propose: take feet by position where none are named; else say which these would be.

    Raises:
        InputError: something is missing, all of it said at once, or cannot be used.
    """
    from amble.hybrid.gaits import GAITS
    from amble.robot import catalogue
    from amble.robot.proposal import proposed_feet
    from amble.workflow.proposal import described

    known, lacking, labelled = robot in catalogue.names(), [], {}
    if known and (feet is not None or symmetrize is not None):
        raise InputError(f"robot '{robot}' of the catalogue takes neither --feet nor --symmetrize")
    if feet is not None:
        labelled = feet_of(feet)
    elif not known:
        labelled = proposed_feet(robot)
        if not propose:
            listing = ",".join(f"{label}={frame}" for label, frame in labelled.items())
            lacking.append(f"--feet (by position these may be {listing})")
    if gait is None:
        lacking.append(f"--gait ({', '.join(GAITS)})")
    if speed is None:
        lacking.append("--speed (m/s)")
    if gait is None or speed is None or lacking:
        raise InputError(f"robot '{shown(robot)}' needs also {'; '.join(lacking)}")
    return described(robot, labelled, gait, _speed(speed), symmetrize)


def feet_of(text: str) -> dict[str, str]:
    """Return label -> frame of the text of ``--feet``; InputError where it is no such list."""
    found: dict[str, str] = {}
    for entry in text.split(","):
        label, equals, frame = (part.strip() for part in entry.partition("="))
        if not (label and equals and frame) or label in found:
            raise InputError(f"--feet '{shown(text)}' is not a list label=link,... with every label once")
        found[label] = frame
    return found


def _speed(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
