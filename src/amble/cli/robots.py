"""``amble robots``: the catalogue."""

from __future__ import annotations

from amble.cli.console import print_table


def robots() -> None:
    """List the robots that ship with the package: mass, joints, feet."""
    from amble.robot import catalogue

    rows = []
    for name in catalogue.names():
        robot = catalogue.load(name)
        rows.append([name, f"{robot.mass:.2f}", str(len(robot.joints)), " ".join(robot.foot_names)])
    print_table(["name", "mass (kg)", "joints", "feet"], rows, right=(1, 2))
