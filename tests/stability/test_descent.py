"""Descents where feet land one by one: each order contracts by itself, and one W has to serve them all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from amble.errors import NotSolvedError
from amble.stability.common_bound import common_bound
from amble.stability.descent import least_common_bound
from amble.stability.weight_search import least_bound
from amble.types import Matrix, Vector


@dataclass(frozen=True)
class Linear:
    """Maps that are linear in the parameters, with nothing that is ill-conditioned."""

    matrices: tuple[Matrix, ...]
    slopes: tuple[Matrix, ...]

    def gradient(self, outers: Sequence[Matrix]) -> Vector:
        """Of a function with these slopes in the matrices."""
        return np.array(
            [
                sum(float(np.sum(outer * slope)) for outer, slope in zip(outers, two, strict=True))
                for two in zip(*self.slopes, strict=True)
            ]
        )

    def conditioning(self) -> tuple[float, Vector]:
        """None."""
        return 0.0, np.zeros(len(self.slopes[0]))


SHEARS = np.array([[[0.3, 3.0], [0.0, 0.3]], [[0.3, 0.0], [3.0, 0.3]]])
"""Radii of 0.3 each, and one of 3 in turn."""

SLOPES = (
    np.array([[[0.2, 0.0], [0.0, 0.2]], [[0.0, -1.0], [0.1, 0.0]]]),
    np.array([[[0.2, 0.0], [0.0, 0.2]], [[0.0, 0.1], [-1.0, 0.0]]]),
)
"""The first parameter changes the radii, and the second how the maps follow each other."""


def shears(theta: Vector) -> Linear:
    maps = tuple(start + np.tensordot(theta, slope, 1) for start, slope in zip(SHEARS, SLOPES, strict=True))
    return Linear(maps, SLOPES)


def test_one_quadratic_function_is_found_where_the_orders_by_themselves_leave_none() -> None:
    """Radii below 1 in every order were the end of a stabilisation whose gait no certificate accepted."""
    alone = least_bound(shears, np.zeros(2))
    assert max(np.abs(np.linalg.eigvals(matrix)).max() for matrix in shears(alone).matrices) < 1.0
    assert common_bound(shears(alone).matrices).rate > 1.0
    together = common_bound(shears(least_common_bound(shears, alone, 0.0)).matrices)
    assert together.verified
    assert together.rate < 1.0


def test_a_map_that_cannot_be_evaluated_is_said() -> None:
    with pytest.raises(NotSolvedError, match="no return map"):
        least_common_bound(lambda theta: shears(np.full(2, np.nan) if theta.any() else theta), np.zeros(2), 0.0)
