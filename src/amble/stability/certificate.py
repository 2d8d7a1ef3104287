"""The stability certificate of a periodic orbit: every number twice where it matters, and refused when in doubt.

The orbit is exponentially stable when the spectral radius of the reduced return map A is below 1. The certificate holds
A by variational equations, and by differences of the whole map as a second opinion (``two_ways``). The error bar of the
radius is an estimate, not a strict bound: nothing here encloses roundoff, the integrator's error or the motion itself
as interval arithmetic would.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite

import numpy as np

from amble.hybrid import HybridSystem
from amble.io.facts import rows_html
from amble.progress import Progress, silent
from amble.residual import Residual
from amble.stability.contraction import LeadingMode, leading_mode
from amble.stability.disturbance import Disturbance
from amble.stability.group import closest_shift
from amble.stability.landing_orders import LandingOrders
from amble.stability.lyapunov import QuadraticBound, quadratic_bound
from amble.stability.poincare import TIME_LIMIT, Differences
from amble.stability.spectrum import Spectrum
from amble.stability.two_ways import differentiate
from amble.types import Json, Vector, frozen

TOLERANCES = (1e-8, 1e-10, 1e-12)
LARGEST_RESIDUAL = 1e-8
LARGEST_DISAGREEMENT = 1e-4
LARGEST_DEFECT = 1e-6
LARGEST_DIFFERENCE = 0.1
"""How far the contraction that a simulation shows may be from the leading multiplier, relative."""


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """What is known about the stability of an orbit.

    Attributes:
        state: the fixed point at the entry of the first domain, (n_x,).
        state_names: names of the states.
        residual: largest |P(x) - g x|.
        period: duration of the orbit, s.
        shift: how far a cycle moves along each symmetry, by name.
        spectrum: multipliers modulo the symmetries, and the symmetries as measured, at the tightest tolerance.
        error: error bar of the spectral radius, an estimate.
        disagreement: distance of the two matrices A (2-norm), relative to the first where that is above 1: against 1 is
            a return map judged, and of a superstable orbit it is nearly 0.
        sweep: (tolerance of the integrator, spectral radius).
        differences: the second opinion: its step and its own sweep.
        bound: W > 0 and r < 1 with r^2 W - A^T W A > 0, verified, in the basis of the spectrum; None where the radius
            is not below 1.
        mode: the decay of the leading mode in a simulation; None where the radius is not below 1, or so small that no
            cycle shows it.
        conditions: what else was checked on the orbit.
        cycles: of the orbit.
        invariants: values of the conserved quantities, by name; the orbit is stable among motions with these values,
            and nothing is said of others.
        disturbance: of a gait, how far disturbances grow and from which size of them it comes back.
        landing: of a gait whose feet land one by one, every order of landing; all else is of the order that the orbit
            takes.
    """

    state: Vector
    state_names: tuple[str, ...]
    residual: float
    period: float
    shift: dict[str, float]
    spectrum: Spectrum
    error: float
    disagreement: float
    sweep: tuple[tuple[float, float], ...]
    differences: Differences
    bound: QuadraticBound | None
    mode: LeadingMode | None
    conditions: tuple[Residual, ...] = ()
    cycles: int = 1
    invariants: Mapping[str, float] = field(default_factory=dict)
    disturbance: Disturbance | None = None
    landing: LandingOrders | None = None

    @property
    def radius(self) -> float:
        """Spectral radius of the cycle."""
        return self.spectrum.radius

    @property
    def warnings(self) -> tuple[str, ...]:
        """What does not refuse the certificate but has to be known, in sentences."""
        return () if self.disturbance is None else self.disturbance.warnings

    def rows(self) -> tuple[Residual, ...]:
        """Return everything that must hold as rows."""
        defects = [
            Residual(f"defect of symmetry '{neutral.name}'", 0.0, neutral.residual, LARGEST_DEFECT)
            for neutral in self.spectrum.neutral
        ]
        losses = [
            Residual(f"defect of invariant '{neutral.name}'", 0.0, neutral.residual, LARGEST_DEFECT)
            for neutral in self.spectrum.conserved
        ]
        contraction = [] if self.mode is None else [_contraction(self.mode)]
        bound = () if self.bound is None else self.bound.rows()
        return (
            Residual(
                "spectral radius plus its error bar", 0.0, self.radius + self.error, float(np.nextafter(1.0, 0.0))
            ),
            Residual("residual of the fixed point", 0.0, self.residual, LARGEST_RESIDUAL),
            Residual("disagreement of the two Jacobians, relative", 0.0, self.disagreement, LARGEST_DISAGREEMENT),
            *defects,
            *losses,
            *contraction,
            *bound,
            *(() if self.landing is None else self.landing.rows(LARGEST_DISAGREEMENT)),
            *self.conditions,
        )

    def _repr_html_(self) -> str:
        """Show the certificate in a notebook: what must hold, and by how much it does."""
        rows = [(row.name, f"{row.value:.4g}", f"{row.lower:g}", f"{row.upper:g}") for row in self.rows()]
        warned = [(f"WARNING: {warning}", "", "", "") for warning in self.warnings]
        title = f"spectral radius {self.radius:.6f} ± {self.error:.1e} (estimated), period {self.period:.6f} s"
        return rows_html(title, ("condition", "value", "lower", "upper"), [*rows, *warned])

    def to_dict(self) -> Json:
        """Return the certificate as a dictionary for a JSON file."""
        return {
            "spectral_radius": self.radius,
            "spectral_radius_error": self.error,
            "multipliers": [[float(value.real), float(value.imag)] for value in self.spectrum.multipliers],
            "symmetries": [
                {
                    "name": neutral.name,
                    "multiplier": neutral.multiplier,
                    "defect": neutral.residual,
                    "shift": self.shift[neutral.name],
                }
                for neutral in self.spectrum.neutral
            ],
            "invariants": [
                {"name": neutral.name, "value": self.invariants[neutral.name], "defect": neutral.residual}
                for neutral in self.spectrum.conserved
            ],
            "cycles": self.cycles,
            "contraction": None
            if self.mode is None
            else {
                "measured": self.mode.rate,
                "predicted": self.mode.predicted,
                "cycles": self.mode.cycles,
                "multipliers": self.mode.modes,
            },
            "conditions": [row_to_dict(row) for row in self.rows()],
            "period_s": self.period,
            "fixed_point": dict(zip(self.state_names, map(float, self.state), strict=True)),
            "fixed_point_residual": self.residual,
            "jacobians": {
                "disagreement_relative": self.disagreement,
                "difference_step": self.differences.step,
                "difference_sweep": [[step, finite(distance)] for step, distance in self.differences.sweep],
            },
            "tolerance_sweep": [[tolerance, finite(distance)] for tolerance, distance in self.sweep],
            "return_map": self.spectrum.matrix.tolist(),
            "basis": self.spectrum.basis.tolist(),
            "contraction_bound": None if self.bound is None else self.bound.to_dict(),
            "landing": None if self.landing is None else self.landing.to_dict(),
            "disturbance": None if self.disturbance is None else self.disturbance.to_dict(),
            "warnings": list(self.warnings),
        }


def assess(
    system: HybridSystem,
    state: Vector,
    tolerances: Sequence[float] = TOLERANCES,
    time_limit: float = TIME_LIMIT,
    progress: Progress | None = None,
    cycles: int = 1,
    max_step: float | None = None,
) -> Certificate:
    """Compute everything that a certificate holds, without judging it: what ``certify`` refuses can be looked at.

    Arguments and errors are those of ``certify``, but for CertificateError.
    """
    entry = np.array(state, dtype=np.float64).reshape(-1)
    known = differentiate(system, entry, tolerances, progress or silent, time_limit, cycles, max_step)
    there, best = known.monodromy, known.spectrum
    shift = closest_shift(system, entry, there.image)
    stable = best.radius < 1.0
    names = [symmetry.name for symmetry in system.symmetries]
    return Certificate(
        state=frozen(entry),
        state_names=tuple(system.state_names),
        residual=float(np.abs(there.image - shift.image).max()),
        period=there.period,
        shift=dict(zip(names, map(float, shift.amounts), strict=True)),
        spectrum=best,
        error=known.error,
        disagreement=known.disagreement,
        sweep=known.sweep,
        differences=known.differences,
        bound=quadratic_bound(best.matrix) if stable else None,
        mode=leading_mode(system, entry, best, cycles, time_limit, max_step) if stable else None,
        cycles=cycles,
        invariants={item.name: float(item.function(entry)) for item in system.invariants},
    )


def row_to_dict(row: Residual) -> Json:
    """Return a row as a dictionary for a JSON file; a bound that is not there, or no number, is None."""
    numbers = {"lower": row.lower, "value": row.value, "upper": row.upper}
    written = {key: finite(value) for key, value in numbers.items()}
    return {"name": row.name, **written, "holds": row.passed}


def finite(value: float) -> float | None:
    """Return the number, or None for infinity and NaN, which JSON does not have."""
    return float(value) if isfinite(value) else None


def _contraction(mode: LeadingMode) -> Residual:
    margin = LARGEST_DIFFERENCE * mode.predicted
    name = "contraction of the leading mode in simulation"
    return Residual(name, mode.predicted - margin, mode.rate, mode.predicted + margin)
