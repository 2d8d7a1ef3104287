"""``amble robots``: the catalogue, or what a URDF file holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli import options
from amble.cli.console import print_table
from amble.cli.output import result, show
from amble.errors import InputError

if TYPE_CHECKING:
    from amble.robot import Robot


def robots(
    file: Annotated[Path | None, typer.Argument(help="URDF file to look at.", show_default=False)] = None,
    feet: Annotated[str | None, options.FEET] = None,
) -> None:
    """List the robots that ship with the package, or one of a file with what the file says and amble does not use.

    Of a file it also says what cannot work, and with feet whether the robot stands on them and mirrors left and right.
    """
    from amble.errors import printable
    from amble.robot import catalogue

    if feet is not None and file is None:
        raise InputError("--feet are those of a URDF file; name that too")
    labelled = {} if feet is None else options.feet_of(feet)
    notes: list[str] = []
    if file is None:
        found = [catalogue.load(name) for name in catalogue.names()]
    else:
        robot, notes = _looked_at(file, labelled)
        found = [robot]
    rows = [
        [printable(robot.name), f"{robot.mass:.2f}", str(len(robot.joints)), " ".join(robot.foot_names)]
        for robot in found
    ]
    print_table(["name", "mass (kg)", "joints", "feet"], rows, right=(1, 2))
    if file is not None:
        show("What is odd or cannot work:")
        for note in notes or ("nothing",):
            show(f"- {printable(note)}")
        result(notes=notes)
        show("Rotors, damping and dry friction of the joints:")
        for drive in _drives(found[0]) or ("none",):
            show(f"- {printable(drive)}")
        show("What the file says and amble does not use:")
        for note in found[0].unused or ("nothing",):
            show(f"- {printable(note)}")
    result(
        robots=[
            {
                "name": robot.name,
                "mass_kg": robot.mass,
                "joints": list(robot.joint_names),
                "feet": list(robot.foot_names),
                "unused": list(robot.unused),
                "drives": _drives(robot),
            }
            for robot in found
        ]
    )


def _drives(robot: Robot) -> list[str]:
    """Say what stands between the torques and the motion, joint by joint."""
    turning, sliding = ("kg m^2", "N m s/rad", "N m", "rad/s"), ("kg", "N s/m", "N", "m/s")
    found = []
    for joint in robot.joints:
        inertia, damping, load, rate = sliding if joint.prismatic else turning
        if not joint.driven_freely:
            found.append(
                f"{joint.name}: rotor {joint.rotor_inertia:.3g} {inertia}, damping {joint.damping:.3g} {damping}, dry "
                f"friction {joint.dry_friction:.3g} {load} over {joint.friction_width:.2g} {rate}"
            )
    return found


def _looked_at(path: Path, feet: dict[str, str]) -> tuple[Robot, list[str]]:
    """Read a file once; return its robot and what is odd about it, and where no feet are named, which they may be."""
    from amble.robot.loading import carried_frames, robot_from
    from amble.robot.plausibility import asymmetry, doubts
    from amble.robot.proposal import feet_by_position, standing_posture
    from amble.robot.readers import read_robot

    file = read_robot(path)
    robot = robot_from(file, path, feet)
    notes = list(doubts(robot))
    if not robot.feet:
        try:
            proposed = feet_by_position(robot, carried_frames(file, path), path.name)
        except InputError as error:
            return robot, [*notes, str(error)]
        listing = ",".join(f"{label}={frame}" for label, frame in proposed.items())
        return robot, [*notes, f"no feet are named; by position these may be --feet {listing}"]
    try:
        standing_posture(robot)
    except InputError as error:
        notes.append(str(error))
    uneven = asymmetry(robot)
    return robot, notes if uneven is None else [*notes, uneven]
