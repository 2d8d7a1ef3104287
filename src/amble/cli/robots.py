"""``amble robots``: the catalogue, or what a URDF file holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.console import print_table
from amble.cli.output import result, show


def robots(
    file: Annotated[Path | None, typer.Argument(help="URDF file to look at.", show_default=False)] = None,
) -> None:
    """List the robots that ship with the package, or one of a file with what the file says and amble does not use."""
    from amble.errors import printable
    from amble.robot import catalogue
    from amble.robot.loading import load_robot

    found = [load_robot(file, {})] if file is not None else [catalogue.load(name) for name in catalogue.names()]
    rows = [
        [printable(robot.name), f"{robot.mass:.2f}", str(len(robot.joints)), " ".join(robot.foot_names)]
        for robot in found
    ]
    print_table(["name", "mass (kg)", "joints", "feet"], rows, right=(1, 2))
    if file is not None:
        show("Feet are named when the robot is loaded. What the file says and amble does not use:")
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
            }
            for robot in found
        ]
    )
