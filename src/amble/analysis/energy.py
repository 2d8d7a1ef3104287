"""Cost of transport, peak and RMS torque, as the paper defines them (section 4)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from amble.analysis.motion import Motion
from amble.analysis.quadrature import segment_bounds, splines
from amble.control.actuator import Actuator
from amble.types import IntegerVector, NodeValues, Vector


@dataclass(frozen=True, kw_only=True)
class TorqueMetrics:
    """What one law costs along one motion.

    Attributes:
        motion: label of the motion.
        law: name of the allocation law.
        actuator: name of the actuator model behind ``cot``, ``mechanical_power`` and ``heat_power``.
        cot: cost of transport, 1; infinite where no distance is walked.
        specific_power: mean power over the weight, (P_mec + P_heat) / (m g), m/s: cost of transport times speed.
        cot_error: change of ``cot`` when every second sample is left out, 1; the integration error of ``cot`` itself
            is about a sixteenth of it (fourth order). Infinite with it.
        peak_torque: largest |torque| of all joints and samples, N m.
        peak_joint: the joint that has it.
        peak_time: when it has it, s.
        rms_torque: root mean square over all joints and the whole time, N m.
        mechanical_power: mean of the summed P_mec, W.
        heat_power: mean of the summed P_heat, W.
    """

    motion: str
    law: str
    actuator: str
    cot: float
    specific_power: float
    cot_error: float
    peak_torque: float
    peak_joint: str
    peak_time: float
    rms_torque: float
    mechanical_power: float
    heat_power: float


def torque_metrics(motion: Motion, law: str, actuator: Actuator) -> TorqueMetrics:
    """Evaluate the paper's metrics for one law along one motion.

    CoT = 1/(m g d) int sum_actuators (P_mec + P_heat) dt, P_mec = max(tau omega, 0), P_heat = R (tau/(N K_t))^2
    (paper, section 4), without recuperation. Integrals are of order four in the sample spacing, corners and events
    included (``amble.analysis.quadrature``).

    Args:
        motion: the samples.
        law: which of the motion's torques.
        actuator: the actuator model.

    Raises:
        UnknownNameError: where the motion holds no torques of that law, or has no joint that the actuator names.
        InputError: where times do not ascend within a segment, or a segment has fewer than two samples.
    """
    torque = motion.torque(law)
    duration = motion.duration
    coefficients = actuator.heat_coefficients(motion.joints)
    mechanical, squares = _integrals(motion.times, motion.segments, torque, motion.speeds)
    heat = float(coefficients @ squares)
    weight = motion.mass * motion.gravity
    kept = _every_second(motion.segments)
    rough_mechanical, rough_squares = _integrals(
        motion.times[kept], motion.segments[kept], torque[kept], motion.speeds[kept]
    )
    rough = rough_mechanical + float(coefficients @ rough_squares)
    row, joint = np.unravel_index(int(np.argmax(np.abs(torque))), torque.shape)
    return TorqueMetrics(
        motion=motion.label,
        law=law,
        actuator=actuator.name,
        cot=_per_distance((mechanical + heat) / weight, motion.distance),
        specific_power=(mechanical + heat) / (weight * duration),
        cot_error=_per_distance(abs(mechanical + heat - rough) / weight, motion.distance),
        peak_torque=float(abs(torque[row, joint])),
        peak_joint=motion.joints[int(joint)],
        peak_time=float(motion.times[row]),
        rms_torque=float(np.sqrt(np.sum(squares) / (len(motion.joints) * duration))),
        mechanical_power=mechanical / duration,
        heat_power=heat / duration,
    )


def _per_distance(height: float, distance: float) -> float:
    return height / distance if distance > 0.0 else inf


def _integrals(times: Vector, segments: IntegerVector, torque: NodeValues, speeds: NodeValues) -> tuple[float, Vector]:
    """Integrals of the summed positive mechanical power, J, and of the squared torques, (n_joints,), (N m)^2 s."""
    width = torque.shape[1]
    cubics = splines(times, segments, np.hstack([torque * speeds, np.square(torque)]))
    mechanical = cubics.positive_integral()[:width]
    return float(np.sum(mechanical)), cubics.integral()[width:]


def _every_second(segments: IntegerVector) -> IntegerVector:
    """Indices of every second sample of each segment, its ends always kept."""
    kept = []
    for first, last in segment_bounds(segments):
        inside = np.arange(first, last, 2)
        kept.append(inside if inside[-1] == last - 1 else np.append(inside, last - 1))
    return np.concatenate(kept)
