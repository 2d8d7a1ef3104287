"""Collocation schemes as data that check themselves: Lobatto IIIA of any number of stages, and curves through nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, reduce

import numpy as np

from amble.errors import InputError, UnknownNameError
from amble.types import Matrix, NodeValues, Vector, frozen

BITS = 200
"""Of the irrational nodes in exact arithmetic; numbers are rounded once, to double precision."""


@dataclass(frozen=True)
class CollocationScheme:
    """An implicit Runge-Kutta scheme whose first node is the start and whose last node is the end of the interval.

    At the nodes, x_i = x_0 + h sum_j integration[i, j] x'_j: the polynomial through the rates is integrated exactly.

    Attributes:
        name: the scheme's name.
        nodes: position of the nodes in the unit interval, (s,).
        integration: Butcher matrix, (s, s); its first row is zero.
        order: order of convergence of the end point.
    """

    name: str
    nodes: Vector
    integration: Matrix
    order: int

    def __post_init__(self) -> None:
        """Check the collocation conditions sum_j a_ij c_j^(k-1) = c_i^k / k and the quadrature order (Butcher)."""
        c, a = self.nodes, self.integration
        if c[0] != 0.0 or c[-1] != 1.0 or a.shape != (c.size, c.size):
            raise InputError(f"collocation scheme '{self.name}' does not span the unit interval")
        for k in range(1, c.size + 1):
            if not np.allclose(a @ c ** (k - 1), c**k / k, rtol=0.0, atol=1e-14):
                raise InputError(f"collocation scheme '{self.name}' is not exact for degree {k - 1}")
        for k in range(1, self.order + 1):
            if not np.isclose(self.weights @ c ** (k - 1), 1.0 / k, rtol=0.0, atol=1e-14):
                raise InputError(f"the weights of collocation scheme '{self.name}' are not of order {self.order}")

    @property
    def stages(self) -> int:
        """Number of nodes of an interval, s."""
        return self.nodes.size

    @property
    def weights(self) -> Vector:
        """Quadrature weights over the unit interval, (s,)."""
        return self.integration[-1]


HERMITE_SIMPSON = "hermite-simpson"
"""Hermite-Simpson in its separated form, which is Lobatto IIIA with three nodes (Hargraves and Paris, 1987)."""

STAGES = {HERMITE_SIMPSON: 3, "lobatto-5": 5, "lobatto-7": 7}
"""Scheme -> number of its stages: the schemes that problems, specifications and files name."""

Polynomial = list[Fraction]
"""Coefficients, the constant one first."""


@cache
def collocation_scheme(name: str) -> CollocationScheme:
    """Return a scheme by its name.

    Raises:
        UnknownNameError: there is no scheme of that name; known ones are named.
    """
    if name not in STAGES:
        raise UnknownNameError("collocation scheme", name, STAGES)
    stages = STAGES[name]
    nodes, lines = _nodes(stages), _lines(stages)
    integrals = [[_value(_integral(line), node) for line in lines] for node in nodes]
    return CollocationScheme(name, frozen([*map(float, nodes)]), frozen(np.array(integrals, float)), 2 * stages - 2)


@cache
def rate_products(name: str) -> Matrix:
    """Return the integrals over the unit interval of l_i' l_j', (s, s), l_i the polynomial that is 1 at node i only."""
    slopes = [_derivative(line) for line in _lines(STAGES[name])]
    products = [[_value(_integral(_times(a, b)), Fraction(1)) for b in slopes] for a in slopes]
    return frozen(np.array(products, float))


def node_positions(scheme: CollocationScheme, intervals: int) -> Vector:
    """Return the positions in [0, 1] of all nodes of equal intervals, shared ends once, (intervals (s-1) + 1,)."""
    inner = scheme.nodes[1:]
    steps = np.arange(intervals)[:, None]
    return frozen(np.concatenate([[0.0], ((steps + inner) / intervals).ravel()]))


def node_weights(scheme: CollocationScheme, intervals: int) -> Vector:
    """Return quadrature weights over [0, 1] for ``node_positions``; they sum to one."""
    weights = np.zeros(intervals * (scheme.nodes.size - 1) + 1)
    stride = scheme.nodes.size - 1
    for interval in range(intervals):
        weights[interval * stride : (interval + 1) * stride + 1] += scheme.weights / intervals
    return frozen(weights)


def through_nodes(name: str, values: NodeValues, at: Vector) -> Matrix:
    """Return the curve that is one polynomial of degree s - 1 in every interval through its nodes.

    Args:
        name: the scheme.
        values: at ``node_positions``, (n, width).
        at: positions in [0, 1], (points,).

    Returns:
        (points, width).
    """
    interval, share = _places(name, values, at)
    return np.einsum("pj,pjw->pw", _powers(share, _table(name)), _of_intervals(name, values)[interval])


def hermite(name: str, values: NodeValues, rates: NodeValues, at: Vector) -> Matrix:
    """Return the curve that is a polynomial of degree 2 s - 1 in every interval, through values and rates at its nodes.

    Where values follow from the rates by the scheme it is the collocation polynomial, whose degree is s: that meets all
    of them.

    Args:
        name: the scheme.
        values: at ``node_positions``, (n, width).
        rates: of the values over the position, (n, width).
        at: positions in [0, 1], (points,).

    Returns:
        (points, width).
    """
    interval, share = _places(name, values, at)
    squares = _powers(share, _table(name)) ** 2
    nodes, slopes = collocation_scheme(name).nodes, _own_slopes(name)
    beyond = share[:, None] - nodes
    of_values, of_rates = _of_intervals(name, values), _of_intervals(name, rates)
    curve = np.einsum("pj,pjw->pw", (1.0 - 2.0 * beyond * slopes) * squares, of_values[interval])
    return curve + np.einsum("pj,pjw->pw", beyond * squares, of_rates[interval]) / len(of_rates)


def _of_intervals(name: str, values: NodeValues) -> NodeValues:
    """Values at the nodes of every interval, (intervals, s, width)."""
    stride = STAGES[name] - 1
    return values[np.arange(0, len(values) - 1, stride)[:, None] + np.arange(stride + 1)]


def _places(name: str, values: NodeValues, at: Vector) -> tuple[np.ndarray, Vector]:
    """Interval of positions, and where in it they are, in [0, 1]."""
    count = (len(values) - 1) // (STAGES[name] - 1)
    interval = np.clip(np.floor(at * count).astype(np.int64), 0, count - 1)
    return interval, at * count - interval


def _powers(share: Vector, table: Matrix) -> Matrix:
    return np.vander(share, len(table), increasing=True) @ table


@cache
def _table(name: str) -> Matrix:
    """Coefficients of the l_j, (s, s), a power a row."""
    return frozen(np.array(_lines(STAGES[name]), float).T)


@cache
def _own_slopes(name: str) -> Vector:
    """l_j' at node j, (s,)."""
    lines = _lines(STAGES[name])
    slopes = [_value(_derivative(line), node) for line, node in zip(lines, _nodes(STAGES[name]), strict=True)]
    return frozen([*map(float, slopes)])


@cache
def _nodes(stages: int) -> tuple[Fraction, ...]:
    """Zeros of d^(s-2)/dx^(s-2) of x^(s-1) (x-1)^(s-1) (Hairer and Wanner II, section IV.5), by Newton's method."""
    polynomial = reduce(_times, [[Fraction(0), Fraction(-1), Fraction(1)]] * (stages - 1))
    for _ in range(stages - 2):
        polynomial = _derivative(polynomial)
    slope, unit = _derivative(polynomial), Fraction(1, 2**BITS)
    zeros = []
    for guess in np.sort(np.roots(np.array(polynomial[::-1], float)).real):
        zero = Fraction(float(guess))
        for _ in range(5):  # from 1e-12 each step doubles the digits
            zero = round((zero - _value(polynomial, zero) / _value(slope, zero)) / unit) * unit
        zeros.append(zero)
    return tuple(zeros)


@cache
def _lines(stages: int) -> tuple[Polynomial, ...]:
    """The polynomials l_j through the nodes, 1 at node j and 0 at the others (Lagrange)."""
    nodes = _nodes(stages)
    return tuple(
        reduce(_times, [[-other / (node - other), 1 / (node - other)] for other in nodes if other != node])
        for node in nodes
    )


def _times(a: Sequence[Fraction], b: Sequence[Fraction]) -> Polynomial:
    product = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, first in enumerate(a):
        for j, second in enumerate(b):
            product[i + j] += first * second
    return product


def _derivative(a: Polynomial) -> Polynomial:
    return [k * coefficient for k, coefficient in enumerate(a)][1:]


def _integral(a: Polynomial) -> Polynomial:
    return [Fraction(0), *(coefficient / k for k, coefficient in enumerate(a, start=1))]


def _value(a: Polynomial, x: Fraction) -> Fraction:
    return reduce(lambda total, coefficient: total * x + coefficient, reversed(a), Fraction(0))
