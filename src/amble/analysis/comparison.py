"""Allocation laws side by side along the same motions: what each costs, and how close it comes to the limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite

from amble.analysis.energy import TorqueMetrics, torque_metrics
from amble.analysis.limit_use import AllocationLimits, LimitUse, limit_use
from amble.analysis.reallocation import reallocate
from amble.analysis.samples import Samples
from amble.control import AllocationLaw
from amble.control.actuator import Actuator
from amble.errors import InputError, UnknownNameError
from amble.io.facts import rows_html


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


@dataclass(frozen=True, kw_only=True)
class LawMetrics:
    """What one law does along one motion.

    Attributes:
        law: label of the law.
        motion: label of the motion.
        energy: actuator model -> cost of transport and torques.
        limits: how close it comes to the limits; None where it was not held against any.
    """

    law: str
    motion: str
    energy: Mapping[str, TorqueMetrics]
    limits: LimitUse | None = None

    @property
    def torques(self) -> TorqueMetrics:
        """The numbers that are the same for every actuator model: peak and RMS torque."""
        return next(iter(self.energy.values()))


@dataclass(frozen=True)
class Comparison:
    """Metrics of several laws, along several motions, for several actuator models."""

    metrics: tuple[LawMetrics, ...]

    @property
    def laws(self) -> tuple[str, ...]:
        """Labels of the laws, in the order in which they were given."""
        return tuple(dict.fromkeys(entry.law for entry in self.metrics))

    def along(self, motion: str) -> tuple[LawMetrics, ...]:
        """Return what every law does along one motion.

        Raises:
            UnknownNameError: where there is no such motion.
        """
        found = tuple(entry for entry in self.metrics if entry.motion == motion)
        if not found:
            raise UnknownNameError("motion", motion, dict.fromkeys(entry.motion for entry in self.metrics))
        return found

    def __str__(self) -> str:
        """Return one line for every law, motion and actuator model, in columns."""
        rows = self._rows()
        widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
        return "\n".join(
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
        )

    def _repr_html_(self) -> str:
        """Show the same in a notebook."""
        header, *rows = self._rows()
        return rows_html("allocation laws along the same motions", header, rows)

    def _rows(self) -> list[list[str]]:
        rows = [["motion", "law", "actuator", "CoT", "power/weight (m/s)", "peak torque (N m)", "RMS torque (N m)"]]
        for entry in self.metrics:
            for model, energy in entry.energy.items():
                values = (energy.cot, energy.specific_power, energy.peak_torque, energy.rms_torque)
                numbers = [f"{value:.4g}" if isfinite(value) else "-" for value in values]
                rows.append([entry.motion, entry.law, model, *numbers])
        return rows

    def of(self, law: str, motion: str, actuator: str) -> TorqueMetrics:
        """Look one entry up.

        Raises:
            UnknownNameError: where there is no such law, motion or actuator.
        """
        entries = {entry.law: entry for entry in self.along(motion)}
        if law not in entries:
            raise UnknownNameError("law", law, entries)
        if actuator not in entries[law].energy:
            raise UnknownNameError("actuator", actuator, entries[law].energy)
        return entries[law].energy[actuator]

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
            cot=_percent(before.specific_power, after.specific_power),  # along one motion the same share
            peak_torque=_percent(before.peak_torque, after.peak_torque),
            rms_torque=_percent(before.rms_torque, after.rms_torque),
        )


def compare(
    motions: Sequence[Samples],
    laws: Mapping[str, AllocationLaw],
    actuators: Sequence[Actuator],
    limits: AllocationLimits | None = None,
) -> Comparison:
    """Evaluate every law along every motion with every actuator model.

    Args:
        motions: the motions, whichever law walked them.
        laws: label -> law; labels tell laws of one kind with different parameters apart.
        actuators: models for the cost of transport.
        limits: what torques and contact forces are held against, where they are.

    Raises:
        InputError: where no law is given, a law does not fit a stance, a motion cannot be integrated, or two motions
            have the same label.
    """
    labels = [samples.label for samples in motions]
    if len(set(labels)) != len(labels):
        raise InputError(f"two motions have the same label: {', '.join(labels)}")
    if not laws:
        raise InputError("no allocation law was given to compare")
    found = []
    for samples in motions:
        for label, law in laws.items():
            applied = reallocate(samples, [law])[law.name]
            motion = samples.motion({label: applied.torques})
            found.append(
                LawMetrics(
                    law=label,
                    motion=samples.label,
                    energy={model.name: torque_metrics(motion, label, model) for model in actuators},
                    limits=None if limits is None else limit_use(samples, applied, limits),
                )
            )
    return Comparison(tuple(found))


def _percent(before: float, after: float) -> float:
    return 100.0 * (before - after) / before
