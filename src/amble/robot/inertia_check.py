"""Whether the masses of a robot can be moved: a link may be without mass where what hangs on it has enough."""

from __future__ import annotations

import numpy as np

from amble.errors import InputError, listed
from amble.robot.model import Robot
from amble.robot.parts import Link
from amble.robot.plausibility import SMALLEST_SHARE, smallest_share

ROUNDING = 1e-9
"""Smallest principal moment of a link that counts as one, as a share of its largest: files hold 1e-35."""


def check_inertias(robot: Robot, file: str) -> None:
    """Refuse a robot whose mass matrix is singular, and name the links that make it so.

    A link without mass or without a moment of inertia, such as the cross between two hip joints, moves with what hangs
    on it; only the whole mass matrix tells whether that is enough.

    Raises:
        InputError: the mass matrix is singular.
    """
    moments = np.linalg.eigvalsh(np.stack([link.inertia for link in robot.links]))
    whole = moments[:, 0] > ROUNDING * moments[:, -1]
    weak = [link for link, own in zip(robot.links, whole, strict=True) if not (link.mass > 0.0 and own)]
    if weak and not smallest_share(robot) > SMALLEST_SHARE:
        raise InputError(_singular(weak, robot, file))


def _singular(weak: list[Link], robot: Robot, file: str) -> str:
    """One link is named with its numbers, several by name."""
    first = weak[0]
    flat = all(link.mass > 0.0 and np.ptp(np.diag(link.inertia)) > 0.0 for link in weak)
    if len(weak) == len(robot.links) and flat:
        return (
            f"{file}: no link has three positive moments of inertia (link '{first.name}': {_smallest(first)}), which "
            "makes a robot of the plane: planar = true in [robot], or Adaptation(planar=True); in space every link "
            "needs all its moments"
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
