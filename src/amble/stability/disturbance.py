"""What disturbances do to a certified gait: how far they can grow, and from which size of them it comes back.

The certificate speaks about small disturbances; how small, it does not say. Here the size is tried: states count in
units of the leg length l and sqrt(l / g), so that one number means the same for every robot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.analysis import ContactBounds, ContactReport, contact_report
from amble.gait import Gait
from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport, silent
from amble.robot.natural_units import natural_units
from amble.simulation import Trace, simulate
from amble.simulation.simulate import perturbed
from amble.stability.group import closest_shift
from amble.stability.orbit_conditions import GROUND
from amble.stability.poincare import TIME_LIMIT
from amble.stability.spectrum import Spectrum
from amble.types import Json, Matrix, Vector

MOST_CYCLES = 100_000
"""Powers that are looked at; a radius of 0.9999 needs fewer."""

SIZES = (1e-4, 1e-3, 1e-2)
"""Sizes of a start's change that are tried, ascending; every state is changed by so much of its unit, up or down."""

SMALLEST = 1e-3
"""A gait that does not return from this size is warned of: an encoder's error or a stone is larger."""

SEEDS = (0, 1, 2, 3)
"""Of the signs of the changes, the same for every size."""

CYCLES, SETTLED = 20, 10
"""Cycles that are walked, and after which of them every contact has to be sound."""

TOLERANCE = 1e-8
"""Of the integrator."""


@dataclass(frozen=True)
class Growth:
    """max over k of ||A^k||, k from 1: the factor, 1 or less where nothing grows, and the k."""

    factor: float
    cycles: int


def growth(matrix: Matrix) -> Growth:
    """Find the largest 2-norm of the powers of a matrix with spectral radius below 1.

    Once ||A^k|| < 1 nothing larger follows: with n = q k + j, ||A^n|| <= ||A^k||^q ||A^j||, and the largest of the
    first k powers has been seen. So the search ends there.

    Args:
        matrix: A.
    """
    power, best, at = matrix, float(np.linalg.norm(matrix, 2)), 1
    size = best
    for cycles in range(2, MOST_CYCLES + 1):
        if size < 1.0:
            break
        power = power @ matrix
        size = float(np.linalg.norm(power, 2))
        if size > best:
            best, at = size, cycles
    return Growth(best, at)


def in_units(spectrum: Spectrum, units: Vector) -> Matrix:
    """Return the reduced return map where a state is measured by its unit and a deviation modulo the symmetries.

    The norm of a deviation is then the least that any shift along the symmetries leaves of it.

    Args:
        spectrum: A in its basis Q.
        units: how large a change of each state counts as one, (n_x,).

    Returns:
        T A T^-1 with T = Q_s^T S Q, S the division by the units and Q_s an orthonormal basis of the complement of the
        scaled generators, (m, m).
    """
    change = to_units(spectrum, units)
    return np.asarray(change @ spectrum.matrix @ np.linalg.inv(change))


def to_units(spectrum: Spectrum, units: Vector) -> Matrix:
    """Return T of ``in_units``: the size of T xi is that of a deviation xi in the basis of the spectrum, (m, m)."""
    size, kept = spectrum.basis.shape
    whole = np.linalg.qr(spectrum.basis, mode="complete")[0]
    generators = whole[:, kept:] / units[:, np.newaxis]
    scaled = np.linalg.qr(generators, mode="complete")[0][:, size - kept :] if kept < size else np.eye(size)
    return np.asarray(scaled.T @ (spectrum.basis / units[:, np.newaxis]))


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """How a gait takes disturbances, in units of l and sqrt(l / g).

    Attributes:
        length: l, m.
        time: sqrt(l / g), s.
        growth: how much a small one can grow, and after how many cycles it has.
        returns: largest size tried from which every start comes back, as from all smaller ones; 0 where none does.
        failed: the size that does not come back; None where all do.
        seed: of the start of that size that does not come back first.
        reason: how it fails.
    """

    length: float
    time: float
    growth: Growth
    returns: float
    failed: float | None = None
    seed: int | None = None
    reason: str = ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user of the gait has to know, in sentences."""
        if self.returns >= SMALLEST:
            return ()
        return (
            f"small basin: a start with every state changed by {self.failed:g} (lengths by l, time by sqrt(l/g)) does "
            f"not come back: {self.reason}",
        )

    def __str__(self) -> str:
        """Both results in one sentence."""
        cycles = "cycle" if self.growth.cycles == 1 else "cycles"
        size = f"{self.returns:g}" if self.returns else f"less than {SIZES[0]:g}"
        where = "" if self.failed is None else f"; by {self.failed:g} (seed {self.seed}): {self.reason}"
        return (
            f"disturbed, in units of l = {self.length:.3g} m and sqrt(l/g) = {self.time:.3g} s: grows by the factor "
            f"{self.growth.factor:.3g} at most, after {self.growth.cycles} {cycles}; comes back in {CYCLES} cycles "
            f"with sound contacts from every state changed by {size} ({len(SEEDS)} seeded starts a size){where}"
        )

    def to_dict(self) -> Json:
        """Return it as a dictionary for a JSON file."""
        return {
            "length_m": self.length,
            "time_s": self.time,
            "growth": {"factor": self.growth.factor, "cycles": self.growth.cycles},
            "basin": {
                "returns_from": self.returns,
                "tried": list(SIZES),
                "seeds": list(SEEDS),
                "cycles": CYCLES,
                "contacts_sound_after_cycles": SETTLED,
                "failed": None
                if self.failed is None
                else {"size": self.failed, "seed": self.seed, "reason": self.reason},
            },
        }


def disturb(
    gait: Gait,
    system: HybridSystem,
    state: Vector,
    spectrum: Spectrum,
    progress: Progress | None = None,
    time_limit: float = TIME_LIMIT,
    max_step: float | None = None,
) -> Disturbance:
    """Compute how far a disturbance of a stable gait grows, and walk from changed starts of ascending size.

    A start comes back where all cycles are completed, the last entry is nearer to the orbit than the first was, and
    after the first cycles (``SETTLED``) every stance foot pushes within its friction cone, and every landing foot is
    stopped on the ground (``orbit_conditions.GROUND``). The first size with a start that does not ends the trials.

    Args:
        gait: the gait.
        system: its closed loop over the full cycle.
        state: the fixed point at the entry of the first domain, (2 n_q,).
        spectrum: of the Poincare map there, radius below 1.
        progress: called with what is being walked.
        time_limit: the longest that one domain may last, s.
        max_step: the longest time between two event samples, s (``simulate``).
    """
    notify = progress or silent
    length, gravity = gait.robot.leg_length, gait.robot.gravity
    units = natural_units(gait.robot, length)
    grown = growth(in_units(spectrum, units))
    returns, failed, by, reason = 0.0, None, None, ""
    for size in SIZES:
        for seed in SEEDS:
            notify(ProgressReport(what=f"start changed by {size:g}, seed {seed}, {CYCLES} cycles"))
            start = state + units * perturbed(np.zeros(len(state)), size, seed)
            trace = simulate(system, start, CYCLES, TOLERANCE, time_limit=time_limit, max_step=max_step)
            reason = _outcome(gait, system, state, units, trace)
            if reason:
                failed, by = size, seed
                break
        if reason:
            break
        returns = size
    return Disturbance(
        length=length,
        time=float(np.sqrt(length / gravity)),
        growth=grown,
        returns=returns,
        failed=failed,
        seed=by,
        reason=reason,
    )


def _outcome(gait: Gait, system: HybridSystem, state: Vector, units: Vector, trace: Trace) -> str:
    """Say why a walk does not come back; empty where it does."""
    if not trace.completed:
        return trace.ended
    first, last = (
        float(np.linalg.norm((row - closest_shift(system, state, row).image) / units))
        for row in (trace.section[0], trace.section[-1])
    )
    if not last < first:
        return f"after {CYCLES} cycles it is {last / first:.3g} times as far from the orbit as at the start"
    report = contact_report(trace, gait.pattern, ContactBounds.of_gait(gait))
    if report.sound_from is None or report.sound_from > SETTLED:
        return _unsound(report, gait.pattern.ground.friction)
    gap = float(report.landing_gaps[SETTLED:].max())
    if gap > GROUND * gait.robot.leg_length:
        return (
            f"after cycle {SETTLED} a landing foot is stopped {1e3 * gap:.2g} mm from the ground: the feet of one "
            f"switch do not land at once, as its landing rule '{gait.pattern.landing_rule}' has it"
        )
    return ""


def _unsound(report: ContactReport, friction: float) -> str:
    force, used = float(report.normal_forces[SETTLED:].min()), float(report.frictions[SETTLED:].max())
    return (
        f"after cycle {SETTLED} its contacts are not sound: smallest normal force {force:.3g} N, "
        f"friction used {used:.3g} of {friction:g}"
    )
