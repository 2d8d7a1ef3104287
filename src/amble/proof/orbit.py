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
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import scipy.linalg
from flint import acb, acb_mat, arb, arb_mat

from amble.errors import InputError
from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport
from amble.proof.arc import ProofError
from amble.proof.arithmetic import column, exact_matrix, largest, midpoints
from amble.proof.return_map import ReturnMap
from amble.stability.group import generators
from amble.stability.monodromy import monodromy
from amble.types import Matrix, Vector

REFINEMENTS = 6
RATE_SHARES = (0.5, 0.25, 0.1)
"""Shares of the distance from the proved rate to 1 that are left on a basin; W is that of the first."""
FINENESS = 1e-4
"""Remainder of a step on a ball, as a share of the ball's radius."""
WIDER = 1.001
"""By which a box about a ball is taken wider than floating-point arithmetic says."""
Lengths: TypeAlias = Sequence[Sequence[arb]]
"""Of the steps in every domain."""

RATE_MARGINS = (1e-6, 1e-4, 1e-3, 1e-2, 0.05)
"""Shares of the distance to 1 by which the proved rate may lie above the estimate of the spectral radius."""


@dataclass(frozen=True, kw_only=True)
class ProvedOrbit:
    """What is proved of an orbit.

    Attributes:
        centre: c, exact.
        radii: rho, of the box in which the fixed point is the only one, exact.
        state: balls that hold the fixed point.
        shift: balls that hold how far a cycle moves along every translation.
        durations: balls that hold the time spent in every domain, s.
        derivative: balls that hold DP at the fixed point.
        multipliers: balls that hold its eigenvalues on the quotient; empty where they could not be separated.
        weight: W, on the quotient.
        rate: r, proved bound of the spectral radius; above 1 where stability is not proved.
        unstable: a proved lower bound of the spectral radius that is above 1; None otherwise.
        lengths: of the steps in every domain, exact, s.
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

    @property
    def stable(self) -> bool:
        """Whether exponential stability is proved."""
        return self.rate < 1.0


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


def refined(prepared: ReturnMap, guess: Vector, goal: float, progress: Progress | None = None) -> list[arb]:
    """Return a point close to the fixed point, by Newton with the derivative in floating point.

    Args:
        prepared: the map.
        guess: a fixed point to floating-point accuracy, (n_x,).
        goal: residual at which to stop.
        progress: called after every evaluation.

    Raises:
        ProofError: the motion from a point on the way could not be enclosed.
    """
    system = prepared.system
    along = translations(system, guess)
    matrix = bordered(exact_matrix(monodromy(system, guess).matrix), along).mid()
    centre = [arb(float(value)) for value in guess]
    best, smallest = centre, np.inf
    for number in range(REFINEMENTS):
        image = prepared(centre, [arb(0)] * len(centre)).image
        correction = matrix.solve(_residual(image, centre, along)[0]).entries()[: len(centre)]
        size = float(largest(value.mid() for value in correction))
        if progress is not None:
            progress(ProgressReport(what="point of high precision", done=number + 1, quantity="step", value=size))
        if not size < 0.5 * smallest:
            break
        best, smallest = centre, size
        centre = [(value - change.mid()).mid() for value, change in zip(centre, correction, strict=True)]
        if size < goal:
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
        ProofError: what could not be proved.
    """
    system = prepared.system
    along = translations(system, np.array([float(value) for value in centre]))
    thin = prepared(centre, [arb(0)] * len(centre), lengths)
    used = [arc.lengths for arc in thin.arcs]
    whole = prepared(centre, radii, used)
    matrix = bordered(whole.derivative, along)
    try:
        missed, shift = _residual(thin.image, centre, along)
        newton = matrix.solve(-missed).entries()
    except ZeroDivisionError:
        raise ProofError("the derivative of P(x) - x is not proved to be invertible over the box") from None
    size = len(centre)
    for name, found, radius in zip(system.state_names, newton, radii, strict=False):
        if not found.abs_upper() < radius:
            raise ProofError(
                f"the interval Newton image leaves the box in '{name}': {float(found.abs_upper()):.3g} of {float(radius):.3g}"
            )
    state = [value + change for value, change in zip(centre, newton[:size], strict=True)]
    reduced = quotient(whole.derivative, along)
    weight, rate = _contraction(reduced) if claim is None else _claimed(reduced, *claim)
    values = _eigenvalues(reduced)
    return ProvedOrbit(
        centre=list(centre),
        radii=list(radii),
        state=state,
        shift=[known + change for known, change in zip(shift, newton[size:], strict=True)],
        durations=[arc.duration for arc in whole.arcs],
        derivative=whole.derivative,
        multipliers=values,
        weight=weight,
        rate=rate,
        unstable=_outside(values),
        lengths=used,
    )


def prove_basin(prepared: ReturnMap, orbit: ProvedOrbit, most: float = 1e-2, progress: Progress | None = None) -> Basin:
    """Find a large region that is proved to contract towards a proved orbit.

    Its norm is another than that of the proved rate: W of a rate half-way to 1 is better conditioned.

    Args:
        prepared: the map.
        orbit: proved exponentially stable.
        most: the largest radius tried, as a change of the coordinate that may change most.
        progress: called after every attempt.

    Raises:
        ProofError: not even the box of the orbit's own proof contracts: its reason.
    """
    along = translations(prepared.system, np.array([float(value) for value in orbit.centre]))
    middle = midpoints(quotient(orbit.derivative, along))
    rates = [1.0 - (1.0 - orbit.rate) * share for share in RATE_SHARES]
    weight = _lyapunov(middle, rates[0])
    weight /= np.diag(weight).max()
    reach = float(np.sqrt(np.diag(np.linalg.inv(weight))).max())
    size, reason = most / reach, ProofError("the return map is not proved to contract on any ball")
    while size * reach > float(largest(orbit.radii)):
        try:
            found = contraction_on_ball(prepared, orbit, weight, size, rates)
        except ProofError as error:
            found, reason = None, error
        if progress is not None:
            progress(ProgressReport(what="basin", quantity="radius", value=size * reach))
        if found is not None:
            return found
        size /= 4.0
    raise reason


def contraction_on_ball(
    prepared: ReturnMap,
    orbit: ProvedOrbit,
    weight: Matrix,
    size: float,
    rates: Sequence[float],
    lengths: Lengths | None = None,
) -> Basin | None:
    """Prove that P contracts on a ball of W about the fixed point; None where it does at none of the rates.

    Args:
        prepared: the map.
        orbit: proved exponentially stable.
        weight: W.
        size: of the ball.
        rates: that are tried, the first that holds is the result's.
        lengths: of the steps where they are known.

    Raises:
        ProofError: the map could not be enclosed over the ball.
    """
    along = translations(prepared.system, np.array([float(value) for value in orbit.centre]))
    span, _ = _complement(along)
    # |U v|_i <= |v|_W sqrt((U W^-1 U^T)_ii); what rounding spoils here, the share below is far more
    reach = np.sqrt(np.diag(span @ np.linalg.inv(weight) @ span.T))
    off = [(value - centre).abs_upper() for value, centre in zip(orbit.state, orbit.centre, strict=True)]
    radii = [(arb(float(size * value)) * WIDER + extra).upper() for value, extra in zip(reach, off, strict=True)]
    # steps need not be more accurate than the set is small
    coarse = replace(prepared, tolerance=max(prepared.tolerance, FINENESS * float(largest(radii))))
    found = coarse(orbit.centre, radii, lengths)
    reduced = quotient(found.derivative, along)
    for rate in rates:
        if rate < 1.0 and contracts(reduced, weight, rate):
            extent = size * np.sqrt(np.diag(np.linalg.inv(weight)))
            return Basin(weight=weight, size=size, extent=extent, rate=rate, lengths=[arc.lengths for arc in found.arcs])
    return None


def translations(system: HybridSystem, state: Vector) -> Matrix:
    """Return the symmetries of a system as columns, (n_x, n_symmetries).

    Raises:
        InputError: one of them is no translation.
    """
    for symmetry in system.symmetries:
        if symmetry.generator.jac_sparsity(0, 0).nnz():
            raise InputError(f"symmetry '{symmetry.name}' is no translation: no proof modulo it; leave it out")
    if system.invariants:
        raise InputError("a system with conserved quantities has families of orbits: no proof of one")
    return generators(system, state)


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


def quotient(derivative: arb_mat, along: Matrix) -> arb_mat:
    """Return the block of the derivative on the quotient by the translations.

    With T = (Xi, U) invertible, D Xi = Xi S, so T^-1 D T is block triangular and its last block is that of the quotient.
    """
    span, full = _complement(along)
    inverse = exact_matrix(full).inv()
    turned = (inverse * derivative * exact_matrix(span)).tolist()
    return arb_mat(turned[along.shape[1] :])


def contracts(matrix: arb_mat, weight: Matrix, rate: float) -> bool:
    """Whether r^2 W - A^T W A > 0 and W > 0 for every matrix in the balls, by an interval Cholesky factorisation."""
    w = exact_matrix(weight)
    return _positive_definite(w) and _positive_definite(arb(rate) ** 2 * w - matrix.transpose() * w * matrix)


def _complement(along: Matrix) -> tuple[Matrix, Matrix]:
    """Return U, columns that complete the translations, and (Xi, U)."""
    if not along.shape[1]:
        return np.eye(along.shape[0]), np.eye(along.shape[0])
    factor, _ = np.linalg.qr(along, mode="complete")
    span = factor[:, along.shape[1] :]
    return span, np.hstack([along, span])


def _residual(image: Sequence[arb], centre: Sequence[arb], along: Matrix) -> tuple[arb_mat, list[arb]]:
    """Return F(c, s_c), equation (1), as a column, and s_c, the shift that leaves the smallest residual, exact."""
    moved = [value - start for value, start in zip(image, centre, strict=True)]
    amounts = np.linalg.pinv(along) @ np.array([float(value.mid()) for value in moved])
    shift = [arb(float(amount)) for amount in amounts]
    xi = exact_matrix(along) if shift else None
    rest = column(moved) if xi is None else column(moved) - xi * column(shift)
    return column([*rest.entries(), *([arb(0)] * len(shift))]), shift


def _contraction(matrix: arb_mat) -> tuple[Matrix, float]:
    """Return W and the smallest rate r that a factorisation proves; a rate of 2 where none below 1 is."""
    middle = midpoints(matrix)
    estimate = float(np.abs(np.linalg.eigvals(middle)).max())
    for margin in RATE_MARGINS:
        rate = estimate + margin * (1.0 - estimate)
        if not 0.0 < rate < 1.0:
            break
        weight = _lyapunov(middle, rate)
        if contracts(matrix, weight, rate):
            return weight, rate
    return np.eye(len(middle)), 2.0


def _lyapunov(matrix: Matrix, rate: float) -> Matrix:
    """Return W with W - (A/r)^T W (A/r) = 1, symmetric."""
    weight = scipy.linalg.solve_discrete_lyapunov((matrix / rate).T, np.eye(len(matrix)))
    return np.asarray(0.5 * (weight + weight.T))


def _claimed(matrix: arb_mat, weight: Matrix, rate: float | None) -> tuple[Matrix, float]:
    """Check W and r that a proof claims."""
    if rate is None:
        return weight, 2.0
    if not (0.0 < rate < 1.0 and np.array_equal(weight, weight.T) and contracts(matrix, weight, rate)):
        raise ProofError(f"the claimed bound {rate:.6g} of the spectral radius does not follow with the claimed W")
    return weight, rate


def _positive_definite(matrix: arb_mat) -> bool:
    """Whether every symmetric matrix in the balls is positive definite: all pivots are positive."""
    rows = matrix.tolist()
    size = len(rows)
    for k in range(size):
        if not rows[k][k] > 0:
            return False
        for i in range(k + 1, size):
            share = rows[i][k] / rows[k][k]
            for j in range(k + 1, i + 1):
                rows[i][j] = rows[i][j] - share * rows[j][k]
    return True


def _eigenvalues(matrix: arb_mat) -> list[acb]:
    """Enclose the eigenvalues; none where the enclosures cannot be separated."""
    try:
        return list(acb_mat(matrix).eig(multiple=True, nonstop=False))
    except (ValueError, ZeroDivisionError):
        return []


def _outside(values: Sequence[acb]) -> arb | None:
    """Return the largest proved lower bound of an eigenvalue's size that is above 1."""
    found = [arb(abs(value).lower()) for value in values if abs(value).lower() > 1]
    return max(found, key=float) if found else None
