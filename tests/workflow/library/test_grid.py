"""The way through a grid: parents before children, one step apart, whatever the grid."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from amble.workflow.library.grid import Grid, Point


def drawn(seed: int) -> Grid:
    generator = np.random.default_rng(seed)
    counts = generator.integers(1, 6, size=int(generator.integers(1, 4)))
    return Grid(
        names=tuple(f"axis {i}" for i in range(len(counts))),
        values=tuple(tuple(float(value) for value in range(count)) for count in counts),
        first=tuple(int(generator.integers(count)) for count in counts),
    )


@pytest.mark.parametrize("seed", range(12))
def test_every_point_has_its_parent_before_it_one_step_away(seed: int) -> None:
    grid = drawn(seed)
    points = grid.points()
    assert len(points) == len(set(points)) == grid.size
    assert points[0] == grid.first
    for place, point in enumerate(points[1:], start=1):
        parent = grid.parent(point)
        assert parent in points[:place]
        assert parent is not None
        assert sum(abs(a - b) for a, b in zip(point, parent, strict=True)) == 1
    assert grid.parent(grid.first) is None


@pytest.mark.parametrize("seed", range(12))
def test_chains_go_straight_and_part_the_grid(seed: int) -> None:
    """Along a chain every point is the parent of the next, and only one coordinate changes."""
    grid = drawn(seed)
    chains: dict[Point, list[Point]] = {}
    for point in grid.points():
        chains.setdefault(grid.chain(point), []).append(point)
    assert sorted(itertools.chain(*chains.values())) == sorted(grid.points())
    for head, members in chains.items():
        assert members[0] == head
        assert [grid.parent(point) for point in members[1:]] == members[:-1]
        assert sum(len({point[axis] for point in members}) > 1 for axis in range(len(head))) <= 1
