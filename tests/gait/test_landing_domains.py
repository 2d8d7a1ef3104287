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
from amble.errors import NotSolvedError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.files import from_dict, load_gait, to_dict
from amble.hybrid import ONE_BY_ONE, HybridSystem, gaits
from amble.hybrid.system import numeric
from amble.robot import catalogue
from amble.robot.natural_units import natural_units
from amble.simulation import simulate
from amble.simulation.simulate import perturbed
from amble.stability import certify
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.group import closest_shift
from amble.stability.landing_orders import orders_of
from amble.stability.monodromy import prepare_variational
from amble.stability.stabilize import stabilize
from amble.stability.weight_search import WeightSearch
from amble.synthesis import gait_problem, synthesize
from amble.synthesis.landing_rows import landing_blocks
from amble.synthesis.layout import build_layout
from amble.synthesis.link_blocks import switch_block
from amble.synthesis.node_block import parameter_values
from amble.synthesis.problem import RELEASE
from amble.synthesis.result import from_gait
from amble.types import Matrix, Vector
from amble.verification.check import check
from tests.robots import robot

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


@pytest.mark.slow
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
    """But for those of its own leg, which carried nothing."""
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
            others = [joint not in trot.robot.legs[step.landing[0]] for joint in trot.robot.joint_names]
            size = float(np.abs(torques[1]).max())
            np.testing.assert_allclose(torques[0][others], torques[1][others], atol=1e-9 * size)
            assert np.abs(torques[0] - torques[1]).max() > 0.1 * size


def test_the_check_says_which_foot_an_order_leaves_in_the_ground(together: Gait, trot: Gait) -> None:
    rows = {row.name: row for row in check(trot, grid=1).rows if row.kind == "landing order"}
    assert len(rows) == 3 * 4
    worst = rows["D1->D2 with rl landed, velocity upwards fl"]
    assert worst.value == pytest.approx(-0.00975, abs=1e-5)
    assert not worst.passed
    assert rows["D1->D2 with rl landed, impulse rl"].passed
    assert not [row for row in check(together, grid=1).rows if row.kind == "landing order"]


def test_a_trot_of_the_gait_problem_with_the_rule_can_land_in_every_order() -> None:
    """Solved with the rows of every order (255.9 instead of 252.0 N^2 m^2): released feet go up at 0.001 sqrt(g l)."""
    gait = load_gait(TROT.with_name("trot-one-by-one.json"))
    assert gait.pattern.landing_rule == ONE_BY_ONE
    rows = [row for row in check(gait, grid=1).rows if row.kind == "landing order"]
    assert len(rows) == 3 * 4
    assert all(row.passed for row in rows)
    slowest = RELEASE * np.sqrt(gait.robot.gravity * gait.robot.leg_length)
    released = [row for row in rows if "upwards fl" in row.name or "upwards rr" in row.name]
    assert len(released) == 6
    assert min(row.value for row in released) == pytest.approx(slowest, rel=1e-3)
    forces = [row for row in check(gait, grid=1).rows if row.kind == "landing force"]
    assert len(forces) == 2 * 2
    assert all(row.passed for row in forces)


@pytest.fixture(scope="module")
def landing_values(trot: Gait) -> dict[str, float]:
    """Rows of the gait problem at the recorded motion, by kind and name; those between landings filled from it."""
    problem = replace(gait_problem(trot.robot, trot.pattern, speed=0.2, intervals=8), outputs=trot.outputs)
    layout = build_layout(problem)
    natural, found = from_gait(problem, trot, layout), {}
    for block in (switch_block(problem, layout, 0), *landing_blocks(problem, layout, 0)):
        rows = ca.Function("rows", [block.variables, block.constants, block.parameters], [block.rows])
        values = np.asarray(rows(natural[block.columns[0]], [], parameter_values(problem))).ravel()
        assert values.size == len(block.labels) == block.lower.size == block.upper.size
        names = [f"{label.kind}: {label.name}" for label in block.labels]
        found |= dict(zip(names, map(float, values), strict=True))
    return found


def test_the_rows_of_the_gait_problem_are_those_of_the_check(trot: Gait, landing_values: dict[str, float]) -> None:
    found = sorted(value for name, value in landing_values.items() if name.startswith("landing order"))
    checked = [row for row in check(trot, grid=1).rows if row.kind == "landing order"]
    flipped = [-row.value if row.upper == 0.0 else row.value for row in checked]
    np.testing.assert_allclose(found, sorted(flipped), atol=1e-6)


def test_the_variables_between_landings_follow_from_the_others(landing_values: dict[str, float]) -> None:
    """They are filled by elimination; the rows are inverse dynamics."""
    for name, value in landing_values.items():
        if name.startswith(("impact: after", "landing force: after")) and ("dynamics" in name or "impact " in name):
            assert abs(value) < 1e-8, name
    assert sum("dynamics" in name for name in landing_values) == 2 * (15 + 3)


def test_the_forces_between_landings_are_those_of_the_check_and_of_the_closed_loop(
    trot: Gait, landing_values: dict[str, float]
) -> None:
    """Three code paths: variables of the gait problem, a dense system, signals of the domain between two landings."""
    last = np.concatenate([trot.domains[0].positions[-1], trot.domains[0].velocities[-1]])
    checked = {row.name: row for row in check(trot, grid=1).rows if row.kind == "landing force"}
    system = closed_loop(trot)
    for foot in ("rl", "fr"):
        where, push = f"D1->D2 with {foot} landed", landing_values[f"landing force: after {foot}: normal force {foot}"]
        assert checked[f"{where}, normal force {foot}"].value == pytest.approx(push, rel=1e-9)
        lands = next(t for t in system.leaving("D1") if t.target == f"D2 {foot}")
        domain = system.domain(lands.target)
        entry = numeric(lands.reset(0.0, last, system.domain("D1").parameters))
        signals = domain.signals(0.0, entry, domain.parameters)
        force = numeric(signals[domain.signals.name_out().index("force")]).reshape(-1, 3)
        x, y, z = force[trot.robot.foot_names.index(foot)]
        # the recorded motion meets its own references and periodicity to the solver's 1e-6
        assert z == pytest.approx(push, rel=1e-4)
        assert checked[f"{where}, friction {foot}"].value == pytest.approx(np.hypot(x, y) / z, rel=1e-4)
        inner = [value for name, value in landing_values.items() if f"after {foot}: friction {foot}" in name]
        # pyramid inside the cone, with the margin
        assert min(inner) == pytest.approx(0.99 * 0.6 / np.sqrt(2.0) * z - max(abs(x), abs(y)), rel=1e-3)


def test_the_rule_is_part_of_the_file(trot: Gait) -> None:
    tree = to_dict(trot)
    assert tree["landing_rule"] == {"name": "one by one"}
    assert from_dict(tree).pattern == trot.pattern


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


@pytest.fixture(scope="module")
def stabilised() -> Gait:
    """The trot of the gait problem with the rule, as `amble stabilize` leaves it."""
    return load_gait(TROT.with_name("stabilised-trot-one-by-one.json"))


def returned(gait: Gait, seed: int, cycles: int) -> float:
    """Walk from every state changed by 1e-2 of its unit; how much nearer to the orbit the end is than the start.

    No foot is stopped off the ground, and after ten cycles every contact is sound.
    """
    system, start = closed_loop(gait), start_state(gait)
    units = natural_units(gait.robot, gait.robot.leg_length)
    trace = simulate(system, start + units * perturbed(np.zeros(start.size), 1e-2, seed), cycles, 1e-8)
    assert trace.completed, trace.ended
    report = monitors(gait, trace)
    assert report.max_landing_gap < 1e-6
    assert report.sound_from is not None
    assert report.sound_from <= 10
    first, last = (
        np.linalg.norm((row - closest_shift(system, start, row).image) / units)
        for row in (trace.section[0], trace.section[-1])
    )
    return float(last / first)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_trot_comes_back_from_a_hundredth(stabilised: Gait, seed: int) -> None:
    """With a stance's torques on a leg that carries nothing 28 of 32 such starts fell."""
    assert returned(stabilised, seed, 12) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 112))
def test_a_trot_walks_five_hundred_cycles_from_a_hundredth(
    stabilised: Gait, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("AMBLE_COMPILER")
    assert returned(stabilised, seed, 500) < 1e-5


@pytest.mark.slow
def test_the_certificate_speaks_for_both_orders(stabilised: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AMBLE_COMPILER")
    certificate = certify(stabilised)
    landing = certificate.landing
    assert landing is not None
    assert [order.feet["D1->D2"] for order in landing.orders] == [("rl", "fr"), ("fr", "rl")]
    assert landing.bound.rate < 0.75
    assert certificate.disturbance is not None
    assert certificate.disturbance.returns == 1e-2


@pytest.mark.slow
def test_a_trot_from_a_cold_start_is_certified(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AMBLE_COMPILER")
    pattern = replace(gaits.trot(catalogue.astro()), landing_rule=ONE_BY_ONE)
    gait = stabilize(synthesize(gait_problem(pattern.robot, pattern, speed=0.2, intervals=8)))
    certificate = certify(gait)
    assert certificate.landing is not None
    assert len(certificate.landing.orders) == 2
    assert certificate.disturbance is not None
    assert certificate.disturbance.returns == 1e-2


@pytest.mark.slow
def test_a_kink_without_a_fixed_point_beside_it_is_seen_in_one_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton jumped across the kink of Go2's trot; the map of either order is smooth, and both land the other way."""
    monkeypatch.delenv("AMBLE_COMPILER")
    pattern = replace(gaits.trot(robot("go2")), landing_rule=ONE_BY_ONE)
    problem = gait_problem(pattern.robot, pattern, speed=0.35, intervals=10)
    gait = synthesize(replace(problem, limits=replace(problem.limits, standing_force=None)))
    with pytest.raises(NotSolvedError):
        closed_loop_fixed_point(gait)
    system, found = closed_loop_fixed_point(gait, one_order=True)
    assert len(system.leaving("D1")) == 1
    assert found.residual < 1e-10
