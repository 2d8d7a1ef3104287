"""Numbers of many points that lie near one: the one in high precision, and how far each of the others is from it.

Sums, products and functions give the differences of the results from those of the operands, all terms of them and
without cancellation, so they keep 15 digits however small they are. ``points.moved`` moves a thousand points at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb

from amble.proof.arithmetic import column, midpoints
from amble.proof.loop_tapes import LoopTapes
from amble.types import Vector
from tests.proof.points import Rate


@dataclass(frozen=True, eq=False)
class Near:
    """Attributes: the number of the first point, and the differences of the others from it, (k,)."""

    first: arb
    off: Vector

    def __add__(self, other: Near | arb | int) -> Near:
        first, off = _parts(other)
        return Near((self.first + first).mid(), self.off + off)

    def __neg__(self) -> Near:
        return Near(-self.first, -self.off)

    def __sub__(self, other: Near | arb | int) -> Near:
        return self + -other

    def __rsub__(self, other: arb | int) -> Near:
        return -self + other

    def __mul__(self, other: Near | arb | int) -> Near:
        first, off = _parts(other)
        return Near((self.first * first).mid(), float(self.first) * off + self.off * (float(first) + off))

    def __truediv__(self, other: Near | arb | int) -> Near:
        first, off = _parts(other)
        ratio = (self.first / first).mid()
        return Near(ratio, (self.off - float(ratio) * off) / (float(first) + off))

    def __rtruediv__(self, other: arb | int) -> Near:
        return Near(arb(other), 0.0 * self.off) / self

    __radd__, __rmul__ = __add__, __mul__

    def sin(self) -> Near:
        return Near(self.first.sin().mid(), 2.0 * np.cos(float(self.first) + self.off / 2.0) * np.sin(self.off / 2.0))

    def cos(self) -> Near:
        return Near(self.first.cos().mid(), -2.0 * np.sin(float(self.first) + self.off / 2.0) * np.sin(self.off / 2.0))

    def sqrt(self) -> Near:
        root = self.first.sqrt().mid()
        return Near(root, self.off / (float(root) + np.sqrt(float(self.first) + self.off)))

    def __lt__(self, other: Near | arb | int) -> bool:
        return bool(np.all(self.above(other) < 0.0))

    def __le__(self, other: Near | arb | int) -> bool:
        return bool(np.all(self.above(other) <= 0.0))

    def __gt__(self, other: Near | arb | int) -> bool:
        return bool(np.all(self.above(other) > 0.0))

    def __ge__(self, other: Near | arb | int) -> bool:
        return bool(np.all(self.above(other) >= 0.0))

    def above(self, other: Near | arb | int) -> Vector:
        """Return by how much every point lies above another number."""
        apart = self - other
        return np.asarray(float(apart.first) + apart.off)

    def mid(self) -> Near:
        """The points themselves: nothing is enclosed here."""
        return self


def _parts(value: Near | arb | int) -> tuple[arb, Vector | float]:
    return (value.first, value.off) if isinstance(value, Near) else (arb(value), 0.0)


def spread(first: Sequence[arb], offsets: Vector) -> list[Near]:
    """Return states, the first of which is given, from the differences of all from it, (k, n_x)."""
    return [Near(value, off) for value, off in zip(first, offsets.T, strict=True)]


def differences(state: Sequence[Near]) -> Vector:
    """Return how far the states are from the first one, (k, n_x)."""
    return np.stack([value.off for value in state], axis=1)


def all_near(state: Sequence[Near | arb]) -> list[Near]:
    """Return states of which some are the same for all points."""
    none = next(0.0 * value.off for value in state if isinstance(value, Near))
    return [value if isinstance(value, Near) else Near(value.mid(), none) for value in state]


def loop_rate(loop_at: Callable[[arb], LoopTapes]) -> Rate:
    """Return the field of a closed loop at many points: M dz = db - dM z, by the inverse of the first one's M."""

    def rate(clock: arb | Near, state: list[Near]) -> list[Near]:
        loop = loop_at(_parts(clock)[0])
        matrix, right = loop.equations([clock], state, loop.parameters)
        whole = loop.of_matrix([_parts(value)[0] for value in matrix])
        solution = whole.solve(column([_parts(value)[0] for value in right])).mid()
        inverse, z = np.linalg.inv(midpoints(whole)), midpoints(solution)
        rest = np.zeros((loop.unknowns, state[0].off.size))
        for row, value in enumerate(right):
            rest[row] += _parts(value)[1]
        places = zip(loop.matrix_places, matrix, strict=True)
        changed = [(place, value.off) for place, value in places if isinstance(value, Near)]
        found = np.zeros_like(rest)
        for _ in range(REFINEMENTS):
            missed = rest.copy()
            for (row, at), off in changed:
                missed[row] -= off * (z[at, 0] + found[at])
            found = inverse @ missed
        half = loop.size // 2
        return [*state[half:], *(Near(solution[i, 0], found[i]) for i in range(half))]

    return rate


REFINEMENTS = 4
"""Of differences: each leaves the share |M^-1 dM| of the error, which is below 1e-7 on a ball that reaches 1e-11."""
