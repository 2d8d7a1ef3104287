"""What each allocation law costs and how close it comes to the limits, all along one motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.analysis.energy import torque_metrics
from amble.analysis.quadrature import segment_bounds
from amble.analysis.reallocation import reallocate
from amble.analysis.samples import Samples
from amble.control import AllocationLaw
from amble.control.actuator import Actuator
from amble.errors import InputError
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


@dataclass(frozen=True, kw_only=True)
class LawMetrics:
    """What one law does along one motion.

    Attributes:
        law: label of the law.
        motion: label of the motion.
        cot: actuator model -> cost of transport, 1.
        rms_torque: over all joints and the whole time, N m.
        peak_torque: largest |torque|, N m.
        peak_joint: the joint that has it.
        peak_relative_torque: largest |torque| relative to the joint's limit, 1; 0 where no joint has a limit.
        friction_used: largest share of the cone that a stance foot uses, |f_t| / f_n, 1; infinite where a foot pulls.
        min_normal_force: smallest normal force of a stance foot, N.
        active: share of the time at which some limit is reached or missed, 1.
        missed: share of the time at which some limit is missed, 1.
        torque_jump: largest |change of a torque| from one sample to the next of the same domain, N m.
    """

    law: str
    motion: str
    cot: Mapping[str, float]
    rms_torque: float
    peak_torque: float
    peak_joint: str
    peak_relative_torque: float
    friction_used: float
    min_normal_force: float
    active: float
    missed: float
    torque_jump: float


def law_torques(samples: Samples, laws: Mapping[str, AllocationLaw]) -> dict[str, NodeValues]:
    """Return the torques of each law along a motion, by label, (n, n_joints), N m."""
    return {label: reallocate(samples, [law])[law.name].torques for label, law in laws.items()}


def allocation_metrics(
    samples: Samples, laws: Mapping[str, AllocationLaw], limits: AllocationLimits, actuators: Sequence[Actuator]
) -> tuple[LawMetrics, ...]:
    """Evaluate laws along the same motion.

    Args:
        samples: the motion.
        laws: label -> law; labels tell laws of one kind with different parameters apart.
        limits: what the laws are held against.
        actuators: models for the cost of transport.

    Raises:
        InputError: where no law is given, or a law does not fit a stance.
    """
    if not laws:
        raise InputError("no allocation law was given to compare")
    return tuple(_metrics(samples, label, law, limits, actuators) for label, law in laws.items())


def _metrics(
    samples: Samples, label: str, law: AllocationLaw, limits: AllocationLimits, actuators: Sequence[Actuator]
) -> LawMetrics:
    found = reallocate(samples, [law])[law.name]
    motion = samples.motion({label: found.torques})
    entries = [torque_metrics(motion, label, model) for model in actuators]
    stances = samples.pattern.stances
    down = np.array([[foot in stance.feet for foot in samples.robot.foot_names] for stance in stances])[samples.stances]
    force, contact = samples.local_forces(found.forces), samples.pattern.contact
    normal = np.where(down, contact.normal_force(force), np.inf)
    used = np.where(down, contact.friction_used(force), 0.0)
    largest = np.array([limits.torques.get(joint, np.inf) for joint in samples.robot.joint_names])
    relative = np.abs(found.torques) / largest
    weight = samples.robot.mass * samples.robot.gravity
    margins = (
        1.0 - np.max(relative, axis=1),
        1.0 - np.max(used, axis=1) / limits.friction,
        (np.min(normal, axis=1) - limits.normal_force) / weight,
    )
    margin = np.min(margins, axis=0)
    first = entries[0]
    return LawMetrics(
        law=label,
        motion=samples.label,
        cot={entry.actuator: entry.cot for entry in entries},
        rms_torque=first.rms_torque,
        peak_torque=first.peak_torque,
        peak_joint=first.peak_joint,
        peak_relative_torque=float(np.max(relative)),
        friction_used=float(np.max(used)),
        min_normal_force=float(np.min(normal)),
        active=_share(samples, margin <= AT_LIMIT),
        missed=_share(samples, margin < -AT_LIMIT),
        torque_jump=_largest_step(samples, found.torques),
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
