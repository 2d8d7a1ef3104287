"""How close the torques and contact forces of an allocation law come to their limits along one motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.analysis.quadrature import segment_bounds
from amble.analysis.reallocation import Allocated
from amble.analysis.samples import Samples
from amble.gait import Gait
from amble.types import NodeValues, Vector

AT_LIMIT = 1e-6
"""Relative distance from a limit up to which it counts as active."""


@dataclass(frozen=True)
class AllocationLimits:
    """What the laws are held against; contact quantities in the frame of the ground.

    Attributes:
        friction: coefficient mu of the contact's exact cone.
        normal_force: smallest normal force of a stance foot, N.
        torques: joint name -> largest |torque|, N m; a joint that is not named has no limit.
    """

    friction: float
    normal_force: float
    torques: Mapping[str, float]

    @classmethod
    def of(cls, gait: Gait) -> AllocationLimits:
        """Take a gait's limits and the friction of its ground; for torques the robot's own where they are smaller."""
        joints, limits = gait.robot.joints, gait.limits
        torques = {joint.name: min(joint.effort, limits.torques.get(joint.name, joint.effort)) for joint in joints}
        return cls(gait.pattern.ground.friction, limits.normal_force, torques)


@dataclass(frozen=True, kw_only=True)
class LimitUse:
    """How close one law comes to the limits along one motion.

    Attributes:
        peak_relative_torque: largest |torque| relative to the joint's limit, 1; 0 where no joint has a limit.
        friction_used: largest share of the cone that a stance foot uses, |f_t| / f_n, 1; infinite where a foot pulls.
        min_normal_force: smallest normal force of a stance foot, N.
        active: share of the time at which some limit is reached or missed, 1.
        missed: share of the time at which some limit is missed, 1.
        torque_jump: largest |change of a torque| from one sample to the next of the same domain, N m.
    """

    peak_relative_torque: float
    friction_used: float
    min_normal_force: float
    active: float
    missed: float
    torque_jump: float


def limit_use(samples: Samples, applied: Allocated, limits: AllocationLimits) -> LimitUse:
    """Hold what a law applies along a motion against limits.

    Args:
        samples: the motion.
        applied: torques and contact forces of the law along it.
        limits: the limits.
    """
    stances = samples.pattern.visited
    down = np.array([[foot in stance.feet for foot in samples.robot.foot_names] for stance in stances])[samples.stances]
    force, contact = samples.local_forces(applied.forces), samples.pattern.contact
    normal = np.where(down, contact.normal_force(force), np.inf)
    used = np.where(down, contact.friction_used(force), 0.0)
    largest = np.array([limits.torques.get(joint, np.inf) for joint in samples.robot.joint_names])
    relative = np.abs(applied.torques) / largest
    weight = samples.robot.mass * samples.robot.gravity
    margins = (
        1.0 - np.max(relative, axis=1),
        1.0 - np.max(used, axis=1) / limits.friction,
        (np.min(normal, axis=1) - limits.normal_force) / weight,
    )
    margin = np.min(margins, axis=0)
    return LimitUse(
        peak_relative_torque=float(np.max(relative)),
        friction_used=float(np.max(used)),
        min_normal_force=float(np.min(normal)),
        active=_share(samples, margin <= AT_LIMIT),
        missed=_share(samples, margin < -AT_LIMIT),
        torque_jump=_largest_step(samples, applied.torques),
    )


def _share(samples: Samples, holds: NDArray[np.bool_]) -> float:
    """Share of the time at which something holds, by the trapezoidal rule within the domains."""
    value: Vector = holds.astype(np.float64)
    spent = total = 0.0
    for first, last in segment_bounds(samples.segments):
        spent += float(np.trapezoid(value[first:last], samples.times[first:last]))
        total += float(samples.times[last - 1] - samples.times[first])
    return spent / total


def _largest_step(samples: Samples, torques: NodeValues) -> float:
    """Largest change of a torque between neighbouring samples of one domain, N m."""
    inside = np.diff(samples.segments) == 0
    return float(np.max(np.abs(np.diff(torques, axis=0))[inside]))
