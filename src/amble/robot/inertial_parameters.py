"""Inertial parameters of the links, regrouped so that recursions over them need the fewest operations.

Matter that is symmetric about a revolute joint's axis moves the same whether it is fixed to the child or to the
parent: point masses on the axis, and so every combination of their parameters m, s m a and s^2 m (I - a a'). Each
child hands its mass, its first moment along the axis and one of its transverse moments of inertia to its parent
(minimum inertial parameters; Khalil and Dombre, Modeling, Identification and Control of Robots, 2002, section 9.4.2).
Forces, energy and momentum of the whole robot stay the same; parameters of a single body lose their meaning.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from amble.robot.rotation import skew
from amble.types import Matrix, Vector

if TYPE_CHECKING:
    from amble.robot.model import Joint, Robot


@dataclass(frozen=True)
class Body:
    """Regrouped parameters of a link.

    Attributes:
        mass: kg.
        first_moment: first moment of mass about the link's origin, link axes, (3,), kg m.
        inertia: second moment about the link's origin, link axes, (3, 3), kg m^2.
    """

    mass: float
    first_moment: Vector
    inertia: Matrix


def base_inertial_parameters(robot: Robot) -> list[Body]:
    """Return one body a link, base first; all but the base have mass zero."""
    bodies = []
    for link in robot.links:
        arm = skew(link.center)
        bodies.append(Body(link.mass, link.mass * link.center, link.inertia - link.mass * arm @ arm))
    for j in reversed(robot.ordered_joints):
        joint = robot.joints[j]
        handed = _symmetric_part(bodies[joint.child], joint.axis)
        bodies[joint.child] = _sum(bodies[joint.child], handed, -1.0)
        bodies[joint.parent] = _sum(bodies[joint.parent], _seen_from_parent(handed, joint), 1.0)
    return bodies


def _symmetric_part(body: Body, axis: Vector) -> Body:
    """What can be handed to the parent: symmetric about the axis, chosen to leave as many zeros as possible."""
    across = np.eye(3) - np.outer(axis, axis)
    transverse = int(np.flatnonzero(np.diag(across) == np.diag(across).max())[-1])
    share = body.inertia[transverse, transverse] / across[transverse, transverse]
    return Body(body.mass, axis * (axis @ body.first_moment), share * across)


def _seen_from_parent(body: Body, joint: Joint) -> Body:
    """Express a body that is symmetric about the joint's axis in the parent's frame (parallel axes)."""
    turn, arm = joint.rotation, joint.translation
    moment = turn @ body.first_moment
    shift = skew(arm) @ skew(moment)
    inertia = turn @ body.inertia @ turn.T - shift - shift.T - body.mass * skew(arm) @ skew(arm)
    return Body(body.mass, moment + body.mass * arm, inertia)


def _sum(body: Body, other: Body, factor: float) -> Body:
    return Body(
        body.mass + factor * other.mass,
        body.first_moment + factor * other.first_moment,
        body.inertia + factor * other.inertia,
    )
