"""A periodic orbit proved: existence and uniqueness, exponential stability or instability, a basin.

Shorthand of this file: P the return map, X = c + [-rho, rho] a box, D balls that hold DP on X, xi the translations
under which the system is invariant, as columns Xi, s how far a cycle moves along them. The zeros of

    F(x, s) = (P(x) - x - Xi s, Xi^T (x - c))                                                                   (1)

are the fixed points modulo the translations. With M = ((D - 1, -Xi), (Xi^T, 0)) the interval Newton image
N = -M^-1 F(c, s_c) of X: if its first part lies inside [-rho, rho], X holds exactly one zero, and it lies in c + N
(Neumaier 1990, Interval methods for systems of equations, theorem 5.1.8). On the quotient by the translations, A the
block of D there, r^2 W - A^T W A > 0 with W > 0 for every matrix in the balls bounds the spectral radius by r and
makes P a contraction in the norm of W on every ball inside X about the fixed point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from flint import acb, arb, arb_mat

from amble.progress import Progress, ProgressReport
from amble.proof.arithmetic import column, exact_matrix, largest
from amble.proof.errors import ProofError
from amble.proof.invariance import require_invariance
from amble.proof.quotient import claimed, contraction, gershgorin, quotient, translations
from amble.proof.return_map import ReturnMap
from amble.stability.monodromy import monodromy
from amble.types import Matrix, Vector

REFINEMENTS = 6
NOT_ALONE = (
    "the derivative of P(x) - x is singular: fixed points come in families, as along a translation that is not "
    "declared as a symmetry, or a state that never changes"
)
Lengths: TypeAlias = Sequence[Sequence[arb]]
"""Of the steps in every domain."""


@dataclass(frozen=True, kw_only=True)
class ProvedOrbit:
    """What is proved of an orbit.

    Attributes:
        centre: c, exact.
        radii: rho, of the box in which the fixed point is the only one, exact.
        state: balls that hold the fixed point.
        shift: balls that hold how far a cycle moves along every translation.
        durations: balls that hold the time spent in every domain, s.
        derivative: balls that hold DP at the fixed point, and in the box.
        multipliers: balls that hold one of its eigenvalues on the quotient each, those that could be separated.
        weight: W, on the quotient.
        rate: r, proved bound of the spectral radius; above 1 where stability is not proved.
        unstable: a proved lower bound of the spectral radius that is above 1; None otherwise.
        lengths: of the steps in every domain, exact, s.
        margins: of every domain, name -> proved lower bound along every motion of the box.
        points: of every domain, clock and state of points near the orbit, exact (``Arc.points``).
    """

    centre: list[arb]
    radii: list[arb]
    state: list[arb]
    shift: list[arb]
    durations: list[arb]
    derivative: arb_mat
    multipliers: list[acb]
    weight: Matrix
    rate: float
    unstable: arb | None
    lengths: list[list[arb]]
    margins: list[dict[str, arb]]
    points: list[list[tuple[arb, list[arb]]]]

    @property
    def stable(self) -> bool:
        """Whether exponential stability is proved."""
        return self.rate < 1.0


def refined(prepared: ReturnMap, guess: Vector, goal: float, progress: Progress | None = None) -> list[arb]:
    """Return a point close to the fixed point, by Newton with the derivative in floating point.

    Args:
        prepared: the map.
        guess: a fixed point to floating-point accuracy, (n_x,).
        goal: residual at which to stop.
        progress: called after every evaluation.

    Raises:
        ProofError: the motion from a point on the way does not return, or the fixed point is not alone.
    """
    system = prepared.system
    along, known = translations(system, guess), monodromy(system, guess)
    matrix = bordered(exact_matrix(known.matrix), along).mid()
    centre = [arb(float(value)) for value in guess]
    best, smallest = centre, np.inf
    for number in range(REFINEMENTS):
        missed = _residual(prepared.point(centre, known.durations), centre, along)[0]
        try:
            correction = matrix.solve(missed).entries()[: len(centre)]
        except ZeroDivisionError:
            raise ProofError(NOT_ALONE) from None
        size = float(largest(value.mid() for value in correction))
        if progress is not None:
            progress(ProgressReport(what="point of high precision", done=number + 1, quantity="step", value=size))
        if not size < 0.5 * smallest:
            break
        falls = size / smallest if number else 1.0
        best, smallest = centre, size
        centre = [(value - change.mid()).mid() for value, change in zip(centre, correction, strict=True)]
        if size < goal or size * falls < goal:  # the next step would be smaller by the same factor, at least
            return centre
    return best


def prove_orbit(
    prepared: ReturnMap,
    centre: Sequence[arb],
    radii: Sequence[arb],
    lengths: Lengths | None = None,
    claim: tuple[Matrix, float | None] | None = None,
) -> ProvedOrbit:
    """Prove that a box holds exactly one fixed point, and bound its multipliers.

    Args:
        prepared: the map.
        centre: c, exact.
        radii: rho, exact.
        lengths: of the steps where they are known (``ProvedOrbit.lengths``).
        claim: W and r that are to hold, r None where no stability is claimed; otherwise they are searched.

    Raises:
        InputError: a translation that the system declares is not proved to be a symmetry of it.
        ProofError: what could not be proved.
    """
    system = prepared.system
    along = translations(system, np.array([float(value) for value in centre]))
    require_invariance(system, prepared.legs, along)
    whole = prepared(centre, radii, lengths)
    if claim is None:
        whole = whole.roomy()  # all that is claimed has to hold in another precision too
    matrix = bordered(whole.derivative, along)
    try:
        missed, shift = _residual(whole.centre, centre, along)
        newton = matrix.solve(-missed).entries()
    except ZeroDivisionError:
        raise ProofError("the derivative of P(x) - x is not proved to be invertible over the box") from None
    size = len(centre)
    for name, found, radius in zip(system.state_names, newton, radii, strict=False):
        if not found.abs_upper() < radius:
            reached = f"{float(found.abs_upper()):.3g} of {float(radius):.3g}"
            raise ProofError(f"the interval Newton image leaves the box in '{name}': {reached}")
    state = [value + change for value, change in zip(centre, newton[:size], strict=True)]
    reduced = quotient(whole.derivative, along, [turn.balls(state)[0] for turn in prepared.turns])
    weight, rate = contraction(reduced) if claim is None else claimed(reduced, *claim)
    discs = gershgorin(reduced)
    return ProvedOrbit(
        centre=list(centre),
        radii=list(radii),
        state=state,
        shift=[known + change for known, change in zip(shift, newton[size:], strict=True)],
        durations=[arc.duration for arc in whole.arcs],
        derivative=whole.derivative,
        multipliers=[ball for ball, alone in discs if alone],
        weight=weight,
        rate=rate,
        unstable=_outside(discs),
        lengths=[arc.lengths for arc in whole.arcs],
        margins=[arc.margins for arc in whole.arcs],
        points=[arc.points for arc in whole.arcs],
    )


def bordered(derivative: arb_mat, along: Matrix) -> arb_mat:
    """Return M of the module's page, ((D - 1, -Xi), (Xi^T, 0))."""
    size, count = along.shape
    xi = exact_matrix(along)
    rows = []
    for i in range(size):
        rows.append([derivative[i, j] - int(i == j) for j in range(size)] + [-xi[i, k] for k in range(count)])
    for k in range(count):
        rows.append([xi[i, k] for i in range(size)] + [arb(0)] * count)
    return arb_mat(rows)


def _residual(image: Sequence[arb], centre: Sequence[arb], along: Matrix) -> tuple[arb_mat, list[arb]]:
    """Return F(c, s_c), equation (1), as a column, and s_c, the shift that leaves the smallest residual, exact."""
    moved = [value - start for value, start in zip(image, centre, strict=True)]
    amounts = np.linalg.pinv(along) @ np.array([float(value.mid()) for value in moved])
    shift = [arb(float(amount)) for amount in amounts]
    xi = exact_matrix(along) if shift else None
    rest = column(moved) if xi is None else column(moved) - xi * column(shift)
    return column([*rest.entries(), *([arb(0)] * len(shift))]), shift


def _outside(discs: Sequence[tuple[acb, bool]]) -> arb | None:
    """Return the largest proved lower bound of an eigenvalue's size that is above 1."""
    found = [ball.abs_lower() for ball, alone in discs if alone and ball.abs_lower() > 1]
    return max(found, key=float) if found else None
