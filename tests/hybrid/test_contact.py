"""Internal forces span exactly the null space of the grasp map, on level and uneven ground."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.hybrid.contact import POINT
from amble.types import Matrix, Vector

FREE = {0: 0, 1: 0, 2: 1, 3: 3, 4: 6}


def grasp(positions: Vector) -> Matrix:
    """Net force and moment about the origin of forces at the feet, (6, 3 n_c)."""
    blocks = []
    for x, y, z in positions.reshape(-1, 3):
        arm = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        blocks.append(np.vstack([np.eye(3), arm]))
    return np.hstack(blocks) if blocks else np.zeros((6, 0))


@pytest.mark.parametrize("count", FREE)
@pytest.mark.parametrize("level", [True, False])
def test_they_span_the_null_space_of_the_grasp_map(count: int, level: bool) -> None:
    symbol = ca.SX.sym("p", 3 * count)
    feet = ca.vertsplit(symbol, 3) if count else []
    function = ca.Function("W", [symbol], [POINT.internal_forces(feet, [ca.DM.eye(3)] * count, FREE[count])])
    generator = np.random.default_rng(count)
    corners = np.array([[0.3, 0.2, 0.0], [0.3, -0.2, 0.0], [-0.3, 0.2, 0.0], [-0.3, -0.2, 0.0]])[:count]
    for _ in range(50):
        places = corners + generator.uniform(-0.08, 0.08, corners.shape) * [1.0, 1.0, 0.0 if level else 1.0]
        W = np.asarray(function(places.ravel()).full())
        assert W.shape == (3 * count, FREE[count])
        if not FREE[count]:
            continue
        np.testing.assert_allclose(grasp(places.ravel()) @ W, 0.0, atol=1e-12 * np.abs(W).max())
        values = np.linalg.svd(W / np.linalg.norm(W, axis=0), compute_uv=False)
        assert values[-1] > 1e-2  # independent, and by far
        rank = np.linalg.matrix_rank(grasp(places.ravel()), tol=1e-9)
        assert 3 * count - rank == FREE[count]  # so they are all


def test_any_three_of_four_feet_may_stand_on_one_line() -> None:
    """A crawl may stride as far as its body is long: three feet come on one line, a fore foot on a hind one."""
    symbol = ca.SX.sym("p", 12)
    W = POINT.internal_forces(ca.vertsplit(symbol, 3), [ca.DM.eye(3)] * 4, FREE[4])
    function = ca.Function("W", [symbol], [W, ca.jacobian(W, symbol)])
    corners = np.array([[0.0, 0.2, 0.0], [0.1, 0.2, 0.0], [-0.1, 0.2, 0.0], [-0.3, -0.2, 0.0]])
    close = np.array([[0.0, 0.2, 0.0], [0.3, -0.2, 0.0], [0.0, 0.2, 0.0], [-0.3, -0.2, 0.0]])
    generator = np.random.default_rng(1)
    for places in [*(corners[generator.permutation(4)] for _ in range(20)), close]:
        basis, slope = (np.asarray(part.full()) for part in function(places.ravel()))
        np.testing.assert_allclose(grasp(places.ravel()) @ basis, 0.0, atol=1e-12)
        assert np.linalg.svd(basis, compute_uv=False)[-1] > 0.1
        assert np.abs(slope).max() < 100.0  # 1/m, of unit forces
