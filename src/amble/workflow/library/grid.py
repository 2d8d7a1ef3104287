"""The grid of a library's gaits, and the way through it: every gait has one neighbour that it starts from.

The way begins at one point. A point's parent is one step nearer to that point along the last axis in which they differ,
so the first axis is walked first, from each of its points the second, and so on: chains of neighbours. It depends on
the grid alone, not on who is ready first, so that a library is the same whatever solves it and however often it was
stopped.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from math import prod

Point = tuple[int, ...]
"""Places of a point along the axes."""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """All combinations of the axes' values.

    Attributes:
        names: of the axes.
        values: of every axis, ascending.
        first: where the way begins.
    """

    names: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    first: Point

    @property
    def size(self) -> int:
        """Number of points."""
        return prod(len(values) for values in self.values)

    def points(self) -> tuple[Point, ...]:
        """Return all points, parents before their children, nearest to the first one first."""
        every = itertools.product(*(range(len(values)) for values in self.values))
        return tuple(sorted(every, key=lambda point: (self._distance(point), point)))

    def parent(self, point: Point) -> Point | None:
        """Return the neighbour that a point starts from; None of the first."""
        axis = self._last(point)
        if axis is None:
            return None
        step = 1 if point[axis] > self.first[axis] else -1
        return (*point[:axis], point[axis] - step, *point[axis + 1 :])

    def chain(self, point: Point) -> Point:
        """Return the first point of the chain that a point belongs to; a chain goes straight along one axis."""
        axis = self._last(point)
        if axis is None:
            return point
        step = 1 if point[axis] > self.first[axis] else -1
        return (*point[:axis], self.first[axis] + step, *point[axis + 1 :])

    def at(self, point: Point) -> dict[str, float]:
        """Return axis -> its value at a point."""
        return {name: values[i] for name, values, i in zip(self.names, self.values, point, strict=True)}

    def _last(self, point: Point) -> int | None:
        """The last axis in which a point differs from the first one."""
        apart = [axis for axis, (here, first) in enumerate(zip(point, self.first, strict=True)) if here != first]
        return apart[-1] if apart else None

    def _distance(self, point: Point) -> int:
        return sum(abs(here - first) for here, first in zip(point, self.first, strict=True))
