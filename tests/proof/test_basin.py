"""Balls that are proved to be attracted: a thousand starts on the boundary of each come closer as is proved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
import pytest
from examples import rimless_wheel, simplest_walker
from flint import arb, arb_mat

from amble.hybrid import Domain, HybridSystem, Transition
from amble.proof import Proof, ProofError, Settings, prove, verification
from amble.proof.arithmetic import column, exact_matrix, from_decimals, working_precision
from amble.proof.basin import prove_basin
from amble.proof.leg import Leg
from amble.proof.loop_field import LoopField
from amble.proof.moving_set import MovingSet
from amble.proof.orbit import prove_orbit, refined
from amble.proof.quotient import complement, contracts, contracts_along, factored, translations
from amble.proof.return_map import ReturnMap
from amble.proof.switched_field import SwitchedField
from amble.stability import fixed_point
from amble.types import Matrix, Vector
from tests.proof import gaits
from tests.proof.near import Near, all_near, differences, loop_rate, spread
from tests.proof.points import BITS, Rate, landed

STARTS, ERROR = 1000, 1e-6
"""On the boundary; error of their integration as a share of the ball's size: doubling the steps changes less."""


def rate_of(leg: Leg) -> Rate:
    field = leg.field
    if isinstance(field, SwitchedField):
        (only,) = field.fields
        assert isinstance(only, LoopField)
        return loop_rate(lambda _: only.loop)
    return lambda clock, state: field.part(clock, state).rate


@dataclass(frozen=True, kw_only=True)
class Ball:
    """What is proved: |x - x*| in the norm of W falls to a share of it or less, from everywhere in a ball."""

    weight: Matrix
    size: float
    rate: float
    state: list[arb]
    durations: list[arb]


def boundary(basin: Ball, span: Matrix, draws: np.random.Generator) -> Matrix:
    """Differences of starts from the fixed point, (k, n_x); of the first none."""
    factor = np.linalg.cholesky(basin.weight).T
    directions = draws.normal(size=(STARTS + 1, len(factor)))
    directions *= basin.size / np.linalg.norm(directions, axis=1, keepdims=True)
    directions[0] = 0.0
    return np.linalg.solve(factor, directions.T).T @ span.T


def come_closer(prepared: ReturnMap, basin: Ball, cycles: int, accuracy: tuple[int, int]) -> None:
    """Every start, in every cycle, by integration in 60 digits of the fixed point and of all differences from it."""
    along = translations(prepared.system, np.array([float(value) for value in basin.state]))
    span, _ = complement(along)
    factor = np.linalg.cholesky(basin.weight).T

    def distances(state: Sequence[Near]) -> Vector:
        return np.asarray(np.linalg.norm(factor @ span.T @ differences(state).T, axis=0))

    with working_precision(BITS):
        state = spread([value.mid() for value in basin.state], boundary(basin, span, np.random.default_rng(0)))
        before = distances(state)
        np.testing.assert_allclose(before[1:], basin.size, rtol=1e-9)
        for _ in range(cycles):
            for leg, clock in zip(prepared.legs, basin.durations, strict=True):
                _, image = landed(leg, rate_of(leg), state, clock.mid(), *accuracy)  # type: ignore[arg-type]
                state = all_near(image)
            after = distances(state)
            assert np.all(after <= basin.rate * before + ERROR * basin.size)
            before = after
        back = [value.first - start for value, start in zip(state, basin.state, strict=True)]
        moved = span.T @ np.array([float(value.mid()) for value in back])
        assert np.linalg.norm(factor @ moved) < ERROR * basin.size


def test_a_moving_ball_holds_its_points() -> None:
    """Points of it under linear maps that lie in the enclosed slopes; its hull is less wide than that of a box."""
    draws = np.random.default_rng(3)
    with working_precision(128):
        centre = [arb(float(value)) for value in draws.normal(size=4)]
        off = [arb(float(value), 1e-6) for value in 1e-6 * draws.normal(size=4)]
        basis = exact_matrix(draws.normal(size=(4, 3)))
        start = here = MovingSet.ball(centre, off, basis, arb(2.0**-10))
        directions = draws.normal(size=(50, 3))
        ys = 2.0**-10 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
        points = [[c.mid() + o.mid() for c, o in zip(centre, off, strict=True)] for _ in ys]
        points = [
            [p + m for p, m in zip(point, (basis * column([arb(float(v)) for v in y])).entries(), strict=True)]
            for point, y in zip(points, 0.999 * ys, strict=True)
        ]
        for _ in range(3):
            slope, width = draws.normal(size=(4, 4)), 1e-7
            wide = arb_mat(4, 4, [value + arb(0, width) for value in exact_matrix(slope).entries()])
            here = here.moved((exact_matrix(slope) * column(here.centre)).entries(), wide)
            inner = exact_matrix(slope + width * draws.uniform(-0.9, 0.9, (4, 4)))
            middle = column(centre)
            points = [(exact_matrix(slope) * middle + inner * (column(point) - middle)).entries() for point in points]
            centre = (exact_matrix(slope) * middle).entries()
        hull = here.hull()
        assert all(ball.contains(value) for point in points for ball, value in zip(hull, point, strict=True))
        reached = max(
            float(abs(value - ball.mid())) / float(ball.rad())
            for point in points
            for value, ball in zip(point, hull, strict=True)
        )
        assert reached > 0.8
        boxed = replace(start, rounded=False).hull()
        assert all(outer.contains(inner_ball) for outer, inner_ball in zip(boxed, start.hull(), strict=True))


def test_a_contraction_along_the_ball_is_one_along_the_states() -> None:
    draws = np.random.default_rng(4)
    with working_precision(128):
        for _ in range(20):
            matrix, root = 0.4 * draws.normal(size=(3, 3)), draws.normal(size=(3, 3))
            weight = root @ root.T + 0.1 * np.eye(3)
            weight = 0.5 * (weight + weight.T)
            factors = factored(weight)
            assert factors is not None
            size = np.linalg.norm(
                np.linalg.cholesky(weight).T @ matrix @ np.linalg.inv(np.linalg.cholesky(weight).T), 2
            )
            for rate in (size * (1 - 1e-9), size * (1 + 1e-9)):
                along = contracts_along(exact_matrix(matrix) * factors[1], weight, rate)
                assert along == contracts(exact_matrix(matrix), weight, rate) == (rate > size)


@pytest.mark.parametrize(
    ("system", "start", "order", "most"),
    [
        pytest.param(*rimless_wheel.rolling(), 14, 1e-3, id="rimless-wheel"),
        pytest.param(*simplest_walker.long_step(), 14, 1e-4, id="simplest-walker"),
    ],
)
def test_a_thousand_starts_of_a_walker_come_closer(
    system: HybridSystem, start: Vector, order: int, most: float
) -> None:
    """In three cycles, each at the proved rate."""
    with working_precision(128):
        prepared = ReturnMap.of(system, order, 1e-22)
        centre = refined(prepared, fixed_point(system, start).state, 1e-18)
        orbit = prove_orbit(prepared, centre, [arb(1e-15)] * len(centre))
        basin, limit = prove_basin(prepared, orbit, most)
    assert basin is not None
    assert limit.startswith("on a ball that reaches")
    assert basin.extent.max() > 1e-5
    ball = Ball(weight=basin.weight, size=basin.size, rate=basin.rate, state=orbit.state, durations=orbit.durations)
    come_closer(prepared, ball, 3, (6, 8))


@pytest.mark.slow
def test_a_thousand_starts_of_a_gait_come_closer() -> None:
    proof = gaits.proof()
    found, proved = proof.found, proof.proved
    assert found.basin_size is not None
    assert proved.basin_rate is not None
    assert max(proved.basin_extent) > 5e-11
    assert "a contraction does not follow" in proof.basin_limit
    with working_precision(BITS):
        prepared = verification._prepared(gaits.stabilised(), found.order)
        ball = Ball(
            weight=np.array(found.basin_weight),
            size=found.basin_size,
            rate=proved.basin_rate,
            state=[from_decimals(*pair) for pair in proved.state.values()],
            durations=[from_decimals(*pair) for pair in proved.durations],
        )
        come_closer(prepared, ball, 1, (8, 7))


def test_a_margin_that_fails_on_the_ball_alone_ends_it() -> None:
    """All is linear, so every ball contracts; the orbit keeps the margin, and a ball only as far as it is small."""
    x = ca.SX.sym("x", 2)
    clock, off = ca.vertsplit(x)
    reach = 1e-4
    stride = Domain.from_expressions("stride", x, ca.vertcat(1 + 0 * off, -off), admissibility=reach - off)
    step = Transition.from_expressions("stride", "stride", x, clock - 1, ca.vertcat(0, off + 1e-6), +1)
    system = HybridSystem([stride], [step], state_names=("clock", "off"))
    proof = prove(system, np.array([0.0, 1.6e-6]), Settings(order=12, radius=1e-15, basin=1e-2))
    assert reach / 20 < proof.proved.basin_extent[1] < reach
    assert "the margin of admissibility is only known to be above -" in proof.basin_limit
    verification.verify(proof, system)
    tree = proof.model_dump(mode="json")
    tree["found"]["basin_size"] *= 8
    with pytest.raises(ProofError, match="contraction on the basin does not follow: the margin of admissibility"):
        verification.verify(Proof.model_validate(tree, strict=False), system)
