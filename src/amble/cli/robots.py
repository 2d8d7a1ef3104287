"""``amble robots``: the catalogue."""

from __future__ import annotations

from amble.cli.console import print_table
from amble.cli.output import result


def robots() -> None:
    """List the robots that ship with the package: mass, joints, feet."""
    from amble.robot import catalogue

    known = {name: catalogue.load(name) for name in catalogue.names()}
    rows = [
        [name, f"{robot.mass:.2f}", str(len(robot.joints)), " ".join(robot.foot_names)] for name, robot in known.items()
    ]
    print_table(["name", "mass (kg)", "joints", "feet"], rows, right=(1, 2))
    result(
        robots=[
            {"name": name, "mass_kg": robot.mass, "joints": list(robot.joint_names), "feet": list(robot.foot_names)}
            for name, robot in known.items()
        ]
    )
