"""Whether the masses of a robot can be moved: a link may be without mass where what hangs on it has enough."""

from __future__ import annotations

import numpy as np

from amble.errors import InputError, listed
from amble.robot.model import Robot
from amble.robot.parts import Link
from amble.robot.plausibility import SMALLEST_SHARE, smallest_share

ROUNDING = 1e-9
"""What roundoff may take from a principal moment, as a share of the largest moment of the robot: files hold -1e-35."""


def check_inertias(robot: Robot, file: str) -> None:
    """Refuse a robot whose mass matrix is singular, and name the links that make it so.

    A link without mass or without a moment of inertia, such as the cross between two hip joints, moves with what hangs
    on it; only the whole mass matrix tells whether that is enough.

    Raises:
        InputError: a mass or a principal moment is negative, or the mass matrix is singular.
    """
    weak, largest = [], max(float(np.abs(link.inertia).max()) for link in robot.links)
    for index, link in enumerate(robot.links):
        moments = np.linalg.eigvalsh(link.inertia)
        reason = "; is this a fixed-base robot?" if index == 0 else ""
        if link.mass < 0.0 or (index == 0 and not link.mass > 0.0 and not robot.mass > 0.0):
            raise InputError(f"{file}: the moving link '{link.name}' has no mass ({link.mass:g} kg){reason}")
        if moments[0] < -ROUNDING * largest:
            raise InputError(f"{file}: the inertia of link '{link.name}' is not positive definite ({_smallest(link)})")
        if not (link.mass > 0.0 and moments[0] > ROUNDING * moments[-1]):
            weak.append(link)
    if weak and not smallest_share(robot) > SMALLEST_SHARE:
        raise InputError(_singular(weak, robot, file))


def _singular(weak: list[Link], robot: Robot, file: str) -> str:
    """One link is named with its numbers, several by name."""
    first = weak[0]
    if len(weak) == len(robot.links) and all(np.ptp(np.diag(link.inertia)) > 0.0 for link in weak):
        return (
            f"{file}: no link has three positive moments of inertia (link '{first.name}': {_smallest(first)}), which "
            "makes a robot of a plane; amble walks in space: give every link all its moments"
        )
    fixed = "; is this a fixed-base robot?" if first is robot.links[0] else ""
    if not first.mass > 0.0:
        what = f"the moving link '{first.name}' has no mass ({first.mass:g} kg){fixed}"
    else:
        what = f"the inertia of link '{first.name}' is not positive definite ({_smallest(first)})"
    others = f"; nor have {listed([link.name for link in weak[1:4]])}" if len(weak) > 1 else ""
    return f"{file}: {what}{others}, and nothing on it has enough to move it"


def _smallest(link: Link) -> str:
    return f"smallest principal moment {float(np.linalg.eigvalsh(link.inertia)[0]):.3g} kg m^2"
