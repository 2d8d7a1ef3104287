"""Options that several commands share: a robot, feet, gait and speed instead of a specification, laws, the method.

A law is ``NAME`` or ``NAME:key=value,key=value``; a value is JSON or plain text.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from amble.defaults import METHODS, Method
from amble.errors import InputError, shown
from amble.io.reader import parse_json

if TYPE_CHECKING:
    from amble.control.allocation import AllocationLaw
    from amble.gait import Gait
    from amble.gait.control_law import ControlLaw
    from amble.hybrid import GaitPattern
    from amble.synthesis.specification import Specification

FEET = typer.Option(
    "--feet", help="Feet of a URDF robot: label=link,... such as fl=FL_foot,fr=FR_foot.", show_default=False
)
GAIT = typer.Option("--gait", help="Gait, by name.", show_default=False)
SPEED = typer.Option("--speed", help="Mean forward velocity, m/s, or with a unit.", show_default=False)
LATERAL = typer.Option("--lateral-speed", help="Mean velocity to the left, m/s, or with a unit.", show_default="0")
YAW_RATE = typer.Option("--yaw-rate", help="Mean rate of the heading, rad/s, or with a unit.", show_default="0")
COST = typer.Option(
    "--cost",
    help="What is minimised, such as style:power=0.1,attitude=10; the weights are in `[cost]` of a specification.",
    show_default="torque squared",
)
SYMMETRIZE = typer.Option(
    "--symmetrize/--no-symmetrize",
    help="Average left and right inertias; where nothing is said, up to 5 % asymmetry and with a notice.",
    show_default=False,
)

CONTROL_HELP = (
    "Feedback law: impedance, ... or with parameters, such as impedance:stance_stiffness=80. The name alone of the "
    "gait's own law leaves its gains."
)
LAW_HELP = "Allocation law: pinv, drop, ... or with parameters, such as power:actuator=datasheet."


def is_robot(argument: str) -> bool:
    """Whether an argument is a robot: a name of the catalogue, or a file of a robot format that is not TOML.

    A specification is TOML; a robot of a TOML format that a plug-in reads is named inside one.
    """
    from amble.robot import catalogue
    from amble.robot.readers import format_of

    return argument in catalogue.names() or format_of(Path(argument)) not in (None, "toml")


def specification(
    robot: str,
    feet: str | None,
    gait: str | None,
    speed: str | None,
    symmetrize: bool | None,
    propose: bool,
    lateral: str | None = None,
    yaw_rate: str | None = None,
    cost: str | None = None,
) -> Specification:
    """Return the specification that the options make.

    Args:
        robot: name of the catalogue or URDF file.
        feet: the text of ``--feet``.
        gait: name of the gait.
        speed: the text of ``--speed``.
        symmetrize: whether left and right inertias are averaged.
        lateral: the text of ``--lateral-speed``.
        yaw_rate: the text of ``--yaw-rate``.
        cost: the text of ``--cost``.
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
    return described(
        robot,
        labelled,
        gait,
        _speed(speed),
        symmetrize,
        lateral_speed=_speed(lateral or "0"),
        yaw_rate=_speed(yaw_rate or "0"),
        cost=None if cost is None else _parts(cost, "cost"),
    )


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


def _method(text: str) -> Method:
    if text not in METHODS:
        raise typer.BadParameter(f"'{text}' is not one of {', '.join(METHODS)}")
    return text


METHOD_OPTION = typer.Option(
    help="What chooses the weights: the paper's bilinear matrix inequalities.",
    parser=_method,
    metavar=f"[{'|'.join(METHODS)}]",
)


def parse_law(text: str, pattern: GaitPattern) -> AllocationLaw:
    """Return the law that a word on the command line means, for a gait pattern."""
    from amble.control.laws import law_for

    return law_for(pattern, *_parts(text))


def parse_control(text: str) -> ControlLaw:
    """Return the feedback law that a word on the command line means."""
    import amble.gait.codec  # noqa: F401  (registers those that ship)
    from amble.gait.control_law import CONTROL_LAWS

    return CONTROL_LAWS.build(*_parts(text))


def under(gait: Gait, control: str | None) -> Gait:
    """Return a gait under the feedback law that a word on the command line means; its own where there is none.

    The name alone of the law that the gait has already means that law, with its gains.
    """
    if control is None or (gait.control is not None and control == gait.control.name):
        return gait
    return replace(gait, control=parse_control(control))


def _parts(text: str, what: str = "law") -> tuple[str, dict[str, Any]]:
    """Split a word into name and parameters; ``what`` it is, for the sentence."""
    name, _, rest = text.partition(":")
    parameters: dict[str, Any] = {}
    for part in filter(None, _split(rest)):
        key, mark, value = part.partition("=")
        if not mark:
            raise InputError(f"{what} '{shown(text)}': '{shown(part)}' is not key=value")
        parameters[key.strip()] = _value(value.strip(), f"{what} '{shown(text)}'")
    return name, parameters


def _split(text: str) -> list[str]:
    """Split at commas that are not inside brackets."""
    parts, depth = [""], 0
    for character in text:
        depth += (character in "[{") - (character in "]}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def _value(text: str, what: str) -> Any:
    """What begins like JSON is JSON, bounded and strict as in a file; anything else is a word."""
    begins = text[:1] in '[{"-0123456789' or text in ("true", "false", "null")
    return parse_json(text, what) if text and begins else text
