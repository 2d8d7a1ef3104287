"""Allocation laws side by side along the same trajectory: the paper's Table 1 as records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from amble.analysis.energy import TorqueMetrics, torque_metrics
from amble.analysis.motion import Motion
from amble.control.actuator import Actuator
from amble.errors import InputError, UnknownNameError


@dataclass(frozen=True, kw_only=True)
class Reduction:
    """How much less one law takes than a baseline, in percent of the baseline; negative where it takes more."""

    motion: str
    actuator: str
    baseline: str
    law: str
    cot: float
    peak_torque: float
    rms_torque: float


@dataclass(frozen=True)
class Comparison:
    """Metrics of several laws, along several motions, for several actuator models."""

    metrics: tuple[TorqueMetrics, ...]

    def __str__(self) -> str:
        """Return one line for every law, motion and actuator model, in columns."""
        rows = [["motion", "law", "actuator", "CoT", "peak torque (N m)", "RMS torque (N m)"]]
        for entry in self.metrics:
            numbers = [f"{value:.4g}" for value in (entry.cot, entry.peak_torque, entry.rms_torque)]
            rows.append([entry.motion, entry.law, entry.actuator, *numbers])
        widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
        return "\n".join(
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
        )

    def of(self, law: str, motion: str, actuator: str) -> TorqueMetrics:
        """Look one entry up.

        Raises:
            UnknownNameError: where there is no such law, motion or actuator.
        """
        for kind, name in (("law", law), ("motion", motion), ("actuator", actuator)):
            known = dict.fromkeys(getattr(entry, kind) for entry in self.metrics)
            if name not in known:
                raise UnknownNameError(kind, name, known)
        for entry in self.metrics:
            if (entry.law, entry.motion, entry.actuator) == (law, motion, actuator):
                return entry
        raise InputError(f"no metrics of law '{law}' on the {motion} motion with actuator '{actuator}'")

    def reduction(self, baseline: str, law: str, motion: str, actuator: str) -> Reduction:
        """Compare a law with a baseline on one motion with one actuator model.

        Raises:
            UnknownNameError: where there is no such law, motion or actuator.
        """
        before, after = self.of(baseline, motion, actuator), self.of(law, motion, actuator)
        return Reduction(
            motion=motion,
            actuator=actuator,
            baseline=baseline,
            law=law,
            cot=_percent(before.cot, after.cot),
            peak_torque=_percent(before.peak_torque, after.peak_torque),
            rms_torque=_percent(before.rms_torque, after.rms_torque),
        )


def compare(motions: Sequence[Motion], actuators: Sequence[Actuator]) -> Comparison:
    """Evaluate every law of every motion with every actuator model.

    Args:
        motions: the trajectories, each with the torques of its laws.
        actuators: the models.

    Raises:
        InputError: where a motion cannot be integrated, or two motions have the same label.
    """
    labels = [motion.label for motion in motions]
    if len(set(labels)) != len(labels):
        raise InputError(f"two motions have the same label: {', '.join(labels)}")
    return Comparison(
        tuple(torque_metrics(motion, law, model) for motion in motions for law in motion.torques for model in actuators)
    )


def _percent(before: float, after: float) -> float:
    return 100.0 * (before - after) / before
