"""A trot whose feet land one by one: no foot is stopped in the air, and the return map is continuous."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.analysis import monitors
from amble.defaults import FREE
from amble.errors import InputError
from amble.export import exported_loop
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.files import from_dict, load_gait, to_dict
from amble.hybrid import ONE_BY_ONE, HybridSystem
from amble.hybrid.system import numeric
from amble.simulation import simulate
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.landing_orders import orders_of
from amble.stability.monodromy import prepare_variational
from amble.stability.weight_search import WeightSearch
from amble.synthesis import gait_problem
from amble.synthesis.layout import build_layout
from amble.synthesis.link_blocks import RELEASE, landing_rows, switch_block
from amble.types import Matrix, Vector
from amble.verification.check import check

TROT = Path(__file__).parents[1] / "data" / "trot.json"


def one_by_one(gait: Gait) -> Gait:
    return replace(gait, pattern=replace(gait.pattern, landing_rule=ONE_BY_ONE))


@pytest.fixture(scope="module")
def together() -> Gait:
    """A trot of ASTRo on 8 intervals, both feet of a pair stopped by the touchdown of the first."""
    return load_gait(TROT)


@pytest.fixture(scope="module")
def trot(together: Gait) -> Gait:
    return one_by_one(together)


@pytest.fixture(scope="module", autouse=True)
def interpreted() -> Iterator[None]:
    """Compiling takes longer than these few cycles."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")
        yield


@pytest.fixture(scope="module")
def half(trot: Gait) -> HybridSystem:
    return closed_loop(trot, half=True)


@pytest.fixture(scope="module")
def orbit(trot: Gait) -> Vector:
    """The closed loop's own fixed point."""
    return closed_loop_fixed_point(trot)[1].state


@pytest.fixture(scope="module")
def in_turn(trot: Gait, orbit: Vector) -> list[tuple[HybridSystem, Matrix]]:
    """The map of every order and its derivative."""
    systems = [closed_loop(trot, half=True, orders=order) for order in orders_of(trot)]
    return [(system, prepare_variational(system)(orbit, 1e-10).matrix) for system in systems]


@pytest.mark.parametrize(("change", "seed"), [(0.0, 0), (1e-3, 1), (1e-2, 2), (1e-2, 3)])
def test_no_foot_is_stopped_in_the_air(together: Gait, trot: Gait, change: float, seed: int) -> None:
    """From the same start one touchdown for both stops the other foot up to 2 cm off the ground."""
    trace = simulate(trot, cycles=1, perturbation=change, seed=seed)
    assert trace.completed
    assert len(trace.events) == 4
    report = monitors(trot, trace)
    assert report.max_landing_gap < 1e-9
    assert {row.name for row in report.rows if "height at touchdown" in row.name} == {
        f"{event.transition} height at touchdown {foot}"
        for event, step in ((event, step) for event in trace.events for step in trot.pattern.steps)
        if event.transition == step.name
        for foot in step.landing
    }
    before = monitors(together, simulate(together, cycles=1, perturbation=change, seed=seed))
    assert (before.max_landing_gap > 1e-3) == (change > 0.0)


def test_both_halves_of_the_cycle_are_mirror_images(trot: Gait, half: HybridSystem) -> None:
    start = start_state(trot) + np.random.default_rng(5).normal(0.0, 1e-3, 2 * trot.robot.size)
    whole, halves = simulate(trot, start, 1, 1e-10), simulate(half, start, 2, 1e-10)
    assert len(whole.events) == len(halves.events) == 4
    np.testing.assert_allclose(whole.events[-1].after[2:], halves.events[-1].after[2:], atol=1e-7)


def landing(half: HybridSystem, start: Vector) -> tuple[str, Vector]:
    """Which foot lands first, and the return map."""
    trace = simulate(half, start, 1, 1e-12)
    return trace.events[0].transition, trace.events[-1].after


def test_the_return_map_is_continuous_where_both_land_at_once(trot: Gait, half: HybridSystem) -> None:
    """Along a line of starts the order of landing changes; the image of both sides meets there."""
    direction = np.random.default_rng(6).normal(size=2 * trot.robot.size)
    low, high = -1e-3, 1e-3
    start = start_state(trot)
    first, last = (landing(half, start + share * direction)[0] for share in (low, high))
    assert first != last
    for _ in range(22):  # until the two are 5e-10 apart
        middle = 0.5 * (low + high)
        low, high = (middle, high) if landing(half, start + middle * direction)[0] == first else (low, middle)
    sides = [landing(half, start + share * direction) for share in (low, high)]
    assert [side[0] for side in sides] == [first, last]
    # the derivatives are up to 700 in size
    assert np.max(np.abs(sides[0][1] - sides[1][1])) < 1e-6


@pytest.mark.slow
def test_every_order_has_its_derivative(
    trot: Gait, half: HybridSystem, orbit: Vector, in_turn: list[tuple[HybridSystem, Matrix]]
) -> None:
    """From a start that lands in an order the map changes as that order's derivative says, and not as the other's."""
    state, orders = orbit, orders_of(trot)
    assert [set(order["D1->D2"]) for order in orders] == [{"fr", "rl"}] * 2
    slopes = [slope for _, slope in in_turn]
    assert np.linalg.norm(slopes[0] - slopes[1]) > 1.0
    twin, image = trot.robot.mirror.feet, landing(half, state)[1]
    names = [f"D1->D1 {twin[order['D1->D2'][0]]}" for order in orders]
    seen = set()
    for seed in range(4):
        change = np.zeros(state.size)  # of rates alone: a foot that has just lifted must not land again
        change[trot.robot.size :] = np.random.default_rng(seed).normal(0.0, 1e-5, trot.robot.size)
        transition, moved = landing(half, state + change)
        missed = [np.linalg.norm(moved - image - slope @ change) for slope in slopes]
        taken = names.index(transition)
        seen.add(taken)
        # the curvature leaves about 1e-4, and the 3e-7 s between the orbit's own landings 3e-5
        assert missed[taken] < 0.4 * missed[1 - taken]
        assert missed[taken] < 2e-4 < np.linalg.norm(moved - image)
    assert seen == {0, 1}


def test_the_map_of_one_order_is_smooth_where_the_other_comes_first(
    orbit: Vector, in_turn: list[tuple[HybridSystem, Matrix]]
) -> None:
    """Central differences along random directions, half of whose starts go back to a touchdown that came early."""
    for system, slope in in_turn:
        went_back = set()
        for seed in range(2):
            change = np.random.default_rng(seed).normal(0.0, 1e-5, orbit.size)
            sides = [simulate(system, orbit + side * change, 1, 1e-12) for side in (1.0, -1.0)]
            went_back |= {any("back" in event.transition for event in side.events) for side in sides}
            found = 0.5 * (sides[0].events[-1].after - sides[1].events[-1].after)
            np.testing.assert_allclose(found, slope @ change, atol=1e-5 * float(np.linalg.norm(slope @ change)))
        assert went_back == {True, False}


def test_torques_do_not_jump_where_the_last_foot_lands(trot: Gait) -> None:
    """Nor do the accelerations, but for the velocity that the impact takes away."""
    system = closed_loop(trot)
    states = start_state(trot) + np.random.default_rng(4).normal(0.0, 1e-2, (3, 2 * trot.robot.size))
    for step in trot.pattern.steps:
        if step.source in trot.pattern.stances:
            continue
        between, after = system.domain(step.source.name), system.domain(step.target.name)
        (transition,) = system.leaving(between.name)
        for state in states:
            torques = [
                numeric(domain.signals(0.0, x, domain.parameters)[0])
                for domain, x in (
                    (between, state),
                    (after, numeric(transition.reset(0.0, state, between.parameters))),
                )
            ]
            np.testing.assert_allclose(torques[0], torques[1], atol=1e-9 * float(np.abs(torques[0]).max()))


def test_the_check_says_which_foot_an_order_leaves_in_the_ground(together: Gait, trot: Gait) -> None:
    rows = {row.name: row for row in check(trot, grid=1).rows if row.kind == "landing order"}
    assert len(rows) == 3 * 4
    worst = rows["D1->D2 with rl landed, velocity upwards fl"]
    assert worst.value == pytest.approx(-0.00975, abs=1e-5)
    assert not worst.passed
    assert rows["D1->D2 with rl landed, impulse rl"].passed
    assert not [row for row in check(together, grid=1).rows if row.kind == "landing order"]


def test_a_trot_of_the_gait_problem_with_the_rule_can_land_in_every_order() -> None:
    """Solved with the rows of every order (254.5 instead of 252.0 N^2 m^2): released feet go up at 0.001 sqrt(g l)."""
    gait = load_gait(TROT.with_name("trot-one-by-one.json"))
    assert gait.pattern.landing_rule == ONE_BY_ONE
    rows = [row for row in check(gait, grid=1).rows if row.kind == "landing order"]
    assert len(rows) == 3 * 4
    assert all(row.passed for row in rows)
    slowest = RELEASE * np.sqrt(gait.robot.gravity * gait.robot.leg_length)
    released = [row for row in rows if "upwards fl" in row.name or "upwards rr" in row.name]
    assert len(released) == 6
    assert min(row.value for row in released) == pytest.approx(slowest, rel=1e-3)


def test_the_rows_of_the_gait_problem_are_those_of_the_check(trot: Gait) -> None:
    problem = gait_problem(trot.robot, trot.pattern, speed=0.2, intervals=2)
    layout = build_layout(problem)
    block = switch_block(problem, layout, 0)
    last = trot.domains[0]
    q, v = (ca.DM(values[-1]) for values in (last.positions, last.velocities))
    group = landing_rows(problem, trot.pattern.switches[0], q, v)
    assert {label.name for label in group.labels} <= {label.name for label in block.labels}
    found = sorted(float(ca.DM(row)) for row in group.rows)
    checked = [row for row in check(trot, grid=1).rows if row.kind == "landing order"]
    flipped = [-row.value if row.upper == 0.0 else row.value for row in checked]
    np.testing.assert_allclose(found, sorted(flipped), atol=1e-6)
    assert len(group.lower) == len(group.upper) == len(group.rows)


def test_the_rule_is_part_of_the_file(trot: Gait) -> None:
    tree = to_dict(trot)
    assert tree["landing_rule"] == {"name": "one by one"}
    assert from_dict(tree).pattern == trot.pattern


def test_what_does_not_know_the_rule_says_so(trot: Gait) -> None:
    with pytest.raises(InputError, match="the exported controller knows the landing rule 'simultaneous' only"):
        exported_loop(trot)


@pytest.mark.slow
def test_weights_are_found_for_every_order(trot: Gait) -> None:
    """The model of the map under new weights is the map of every order, and its slope that of differences."""
    search = WeightSearch.of(trot, FREE)
    draw = np.random.default_rng(1)
    theta, direction = (draw.normal(0.0, 0.3, search.weighting.size) for _ in range(2))
    gait = search.gait_with(theta)
    here = search.evaluate(theta)
    assert len(here.matrices) == 2
    for order, found in zip(orders_of(gait), here.matrices, strict=True):
        passage = prepare_variational(closed_loop(gait, half=True, orders=order))(search.orbit.start, 1e-10)
        expected = search.orbit.dual @ passage.matrix @ search.orbit.basis
        # the second order is taken 3e-7 s from its own landing times
        assert np.linalg.norm(found - expected) < 1e-4 * np.linalg.norm(expected)
    outers = [draw.normal(size=matrix.shape) for matrix in here.matrices]
    sides = [search.evaluate(theta + step * direction).matrices for step in (1e-5, -1e-5)]
    change = sum(float(np.sum(outer * (up - down))) / 2e-5 for outer, up, down in zip(outers, *sides, strict=True))
    assert here.gradient(outers) @ direction == pytest.approx(change, rel=1e-5)
