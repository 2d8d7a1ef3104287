"""A proved region of attraction: the largest ball that was found on which the return map contracts.

With S close to T^-1, W close to T^T T, the ball is x* + U S y, |y| <= size: it is followed as such, not as a box, and
what is enclosed is the derivative along y, (DP) U S. Where every matrix A S in it obeys docs/theory/proof.md, eq. 4,
the map is a contraction in the norm of W on the ball.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from flint import arb, arb_mat

from amble.progress import Progress, ProgressReport
from amble.proof.arithmetic import exact_matrix, largest, midpoints
from amble.proof.arithmetic import radius as ball_radius
from amble.proof.errors import ProofError
from amble.proof.moving_set import MovingSet
from amble.proof.orbit import Lengths, ProvedOrbit
from amble.proof.quotient import complement, contracts_along, factored, holds_ball, lyapunov, quotient, translations
from amble.proof.return_map import ReturnMap
from amble.types import Matrix, Vector

RATE_SHARES = (0.5, 0.25, 0.1)
"""Shares of the distance from the proved rate to 1 that are left on a basin; W is that of the first."""
FINENESS = 1e-4
"""Remainder of a step on a ball, as a share of the ball's radius."""
SHRINKING = 4.0
"""By how much a ball is smaller than the last one that was tried."""
NO_TURNS = "the orbit is stable up to a turn about the vertical, and balls are only tried up to translations"
WIDER = 1.001
"""By which the ball in y that is followed is wider than that of W, which it is proved to hold."""
SMALLEST = 2.0**-900
"""Reach below which floating-point numbers lose the digits that rounding down takes for granted."""
ROUNDED_DOWN = 1.0 - 2.0**-50
"""Share of a bound that stays below it where it becomes a floating-point number."""


@dataclass(frozen=True, kw_only=True)
class Basin:
    """A proved region of attraction: {x: |x - x*|_W <= size} in quotient coordinates.

    Attributes:
        weight: W, on the quotient.
        size: in the norm of W.
        extent: how far it reaches in every coordinate of the quotient.
        rate: at which the distance shrinks in every cycle.
        lengths: of the steps in every domain, exact, s.
    """

    weight: Matrix
    size: float
    extent: Vector
    rate: float
    lengths: list[list[arb]]


def prove_basin(
    prepared: ReturnMap, orbit: ProvedOrbit, most: float = 1e-2, progress: Progress | None = None
) -> tuple[Basin | None, str]:
    """Find a large region that is proved to contract towards a proved orbit.

    Its norm is another than that of the proved rate: W of a rate half-way to 1 is better conditioned.

    Returns:
        The region; None where not even one of the size of the orbit's own box contracts. What stopped a larger one, in
        a sentence; empty where the largest that was tried is proved.

    Args:
        prepared: the map.
        orbit: proved exponentially stable.
        most: the largest radius tried, as a change of the coordinate that may change most.
        progress: called after every attempt.
    """
    if prepared.turns:
        return None, NO_TURNS
    along = translations(prepared.system, np.array([float(value) for value in orbit.centre]))
    middle = midpoints(quotient(orbit.derivative, along))
    rates = [1.0 - (1.0 - orbit.rate) * share for share in RATE_SHARES]
    weight = lyapunov(middle, rates[0])
    weight /= np.diag(weight).max()
    reach = float(np.sqrt(np.diag(np.linalg.inv(weight))).max())
    size, found, limit = most / reach, None, ""
    while found is None and size * reach > float(largest(orbit.radii)):
        try:
            found = contraction_on_ball(prepared, orbit, weight, size, rates)
        except ProofError as error:
            limit = f"on a ball that reaches {size * reach:.3g} {error}"
        if progress is not None:
            progress(ProgressReport(what="basin", quantity="radius", value=size * reach))
        size /= SHRINKING
    return found, limit


def contraction_on_ball(
    prepared: ReturnMap,
    orbit: ProvedOrbit,
    weight: Matrix,
    size: float,
    rates: Sequence[float],
    lengths: Lengths | None = None,
) -> Basin:
    """Prove that P contracts on a ball of W about the fixed point.

    Args:
        prepared: the map.
        orbit: proved exponentially stable.
        weight: W.
        size: of the ball.
        rates: that are tried, the first that holds is the result's.
        lengths: of the steps where they are known.

    Raises:
        ProofError: the map could not be enclosed over the ball, or contracts at none of the rates.
    """
    if prepared.turns:
        raise ProofError(NO_TURNS)
    along = translations(prepared.system, np.array([float(value) for value in orbit.centre]))
    span, full = complement(along)
    factors = factored(weight)
    if factors is None:
        raise ProofError("the weight of the ball is not proved to be positive definite")
    if not holds_ball(factors[1], weight, WIDER):
        raise ProofError("the weight of the ball is too ill-conditioned: a ball followed is not proved to hold it")
    basis = exact_matrix(span) * factors[1]
    # with zero in this box the centre is a point of the set, as steps and crossings ask
    off = [(value - centre).union(arb(0)) for value, centre in zip(orbit.state, orbit.centre, strict=True)]
    radius = (arb(size) * arb(WIDER)).upper()
    extent = _extent(weight, size)
    # steps need not be more accurate than the set is small
    coarse = replace(prepared, tolerance=max(prepared.tolerance, FINENESS * float(extent.max())))
    found = coarse.of_set(MovingSet.ball(orbit.centre, off, basis, radius), lengths)
    if lengths is None:
        found = found.roomy()
    moved = arb_mat((exact_matrix(full).inv() * found.derivative).tolist()[along.shape[1] :])
    for rate in rates:
        if rate < 1.0 and contracts_along(moved, weight, rate):
            return Basin(
                weight=weight,
                size=size,
                extent=extent,
                rate=rate,
                lengths=[arc.lengths for arc in found.arcs],
            )
    width = 2.0 * float(largest(map(ball_radius, (factors[0] * moved).entries())))
    raise ProofError(f"a contraction does not follow: the derivative, in coordinates of the ball, is {width:.3g} wide")


def _extent(weight: Matrix, size: float) -> Vector:
    """Return lower bounds of how far the ball reaches in every coordinate, size sqrt((W^-1)_ii).

    Raises:
        ProofError: one is not proved to be above 0, or is too small to be written.
    """
    inverse = exact_matrix(weight).inv()
    reaches = [float((arb(size) * inverse[i, i].sqrt()).abs_lower()) * ROUNDED_DOWN for i in range(inverse.nrows())]
    if not all(SMALLEST < reach < np.inf for reach in reaches):
        raise ProofError("the weight of the ball is too ill-conditioned: how far it reaches is not proved")
    return np.array(reaches)
