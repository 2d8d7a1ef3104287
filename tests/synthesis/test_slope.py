"""A gait up a slope: solved, checked by the check's own means, and repeated by its closed loop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.analysis import (
    AllocationLimits,
    ContactBounds,
    compare,
    contact_report,
    samples_of_gait,
    samples_of_trace,
)
from amble.control import joint_outputs
from amble.control.actuator import PAPER
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.hybrid import FLAT, GaitPattern, Ground, Plane, gait_pattern
from amble.hybrid.gaits import amble
from amble.robot import catalogue
from amble.simulation import simulate
from amble.stability import certify
from amble.stability.stabilize import stabilize
from amble.synthesis import GaitProblem, default_limits, gait_problem, synthesize
from amble.synthesis.layout import NORMAL_FORCE_MARGIN, build_layout, variable_bounds
from amble.synthesis.link_blocks import switch_block
from amble.synthesis.node_block import node_block
from amble.synthesis.program import build_program
from amble.synthesis.rows import RowKind
from amble.verification.check import check
from amble.verification.stance_model import terms

SLOPE = Plane(slope=np.radians(10.0))


def problem(pattern: GaitPattern) -> GaitProblem:
    """A coarse mesh, where accelerations may overshoot their limit between the nodes."""
    limits = default_limits(pattern)
    durations = dict.fromkeys(limits.durations, (0.1, 0.2))
    limits = replace(limits, durations=durations, acceleration=500.0)
    return gait_problem(pattern.robot, pattern, speed=0.2, limits=limits, intervals=6)


@pytest.fixture(scope="module")
def gait() -> Gait:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")  # solving once is shorter than compiling
        return synthesize(problem(amble(catalogue.astro(), SLOPE)), tolerance=1e-7)


def test_a_gait_up_a_slope_passes_its_check(gait: Gait) -> None:
    # six intervals a domain: the motion between the nodes is off by 1e-4, with fifteen by less than 1e-5
    report = check(gait, grid=2, tolerance=2e-4, slack=1e-2)
    assert report.passed, str(report)


def test_the_robot_climbs(gait: Gait) -> None:
    first, last = gait.domains[0].positions[0], gait.domains[-1].positions[-1]
    advance = last - gait.robot.mirror.position(first)
    assert advance[0] == pytest.approx(0.2 * gait.period / 2.0, abs=1e-9)
    assert advance[2] == pytest.approx(np.tan(SLOPE.slope) * advance[0], abs=1e-9)


def test_the_check_sees_another_slope(gait: Gait) -> None:
    flatter = replace(gait, pattern=replace(gait.pattern, ground=Plane(slope=np.radians(9.9))))
    failed = {row.kind for row in check(flatter, grid=1, tolerance=1e-4, slack=1e-2).failed}
    assert {"contact", "guard", "periodicity"} <= failed


def test_the_closed_loop_walks_along_the_slope(gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    system = closed_loop(gait)
    assert [symmetry.name for symmetry in system.symmetries] == ["x", "y"]  # no turn about the vertical
    trace = simulate(system, start_state(gait), 1)
    moved = trace.state[-1, :3] - trace.state[0, :3]
    assert trace.ended == "completed"
    # touchdown falls where the optimised motion has it, to the error of the coarse mesh times its growth in a cycle
    assert moved[2] == pytest.approx(np.tan(SLOPE.slope) * moved[0], abs=2e-3)
    assert moved[2] > 5e-3


def test_a_mirrored_gait_refuses_ground_that_is_not() -> None:
    with pytest.raises(InputError, match="the same on the left and on the right"):
        amble(catalogue.astro(), Plane(slope=0.1, heading=0.5))


@pytest.mark.slow
def test_lift_off_on_a_slope_is_a_row_where_it_is_a_bound_on_the_level() -> None:
    """Walking with four and three feet by turns: a foot lifts while none lands."""
    robot = catalogue.astro()
    feet = robot.foot_names
    table = [row for swing in feet for row in (feet, [foot for foot in feet if foot != swing])]
    joints = robot.joint_names
    free = {f"D{k}": [name for name in joints if "pitch" in name or name in joints[:6:3]] for k in (1, 3, 5, 7)}
    for k, swing in zip((2, 4, 6, 8), feet, strict=True):
        free[f"D{k}"] = [name for name in joints if "pitch" in name and not name.startswith(swing)]
    programs = []
    for ground in (FLAT, SLOPE):
        pattern = gait_pattern(robot, table, ground=ground)
        outputs = joint_outputs(pattern, free=free)
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("AMBLE_COMPILER", "none")
            programs.append(
                build_program(gait_problem(pattern.robot, pattern, speed=0.1, outputs=outputs, intervals=2))
            )
    level, sloped = (set(program.program.row_names) for program in programs)
    assert level < sloped
    extra = sloped - level
    assert {name for name in extra if "lift-off" in name} == {
        f"D{2 * k + 1}->D{2 * k + 2} lift-off force {foot}" for k, foot in enumerate(feet)
    }
    words = {
        "lift-off force": RowKind.LIFT_OFF,
        "normal force": RowKind.NORMAL_FORCE,
        "base above the ground": RowKind.BASE_HEIGHT,
    }
    rows = programs[1].program
    kinds = dict(zip(rows.row_names, rows.row_kinds, strict=True))
    assert all([kinds[name]] == [kind for word, kind in words.items() if word in name] for name in extra)
    fixed = [np.count_nonzero(program.lower == program.upper) for program in programs]
    assert fixed[0] - fixed[1] == 4  # the normal forces at the four lift-offs


@pytest.mark.parametrize("ground", [FLAT, SLOPE])
def test_every_foot_that_leaves_does_so_at_the_smallest_force_inside_its_cone(ground: Ground) -> None:
    """Of two feet one was left out, and the other ended at a force of zero with its friction free."""
    robot = catalogue.astro()
    pattern = gait_pattern(robot, (("fl", "rr"), (), ("fr", "rl"), ()), mirrored=True, ground=ground)
    problem = gait_problem(robot, pattern, speed=0.4, intervals=2)
    layout = build_layout(problem)
    domain, least = layout.domains[0], problem.limits.normal_force
    nodes, switch = node_block(problem, layout, domain), switch_block(problem, layout, 0)
    friction = [place for place, label in enumerate(nodes.labels) if label.name.startswith("friction")]
    assert len(friction) == 8
    assert np.all(nodes.lower[:, friction] == 0.0)
    lower, upper = variable_bounds(problem, layout)
    for foot in ("fl", "rr"):
        force = domain.force[-1, pattern.contacts(domain.stance).normal_index(foot)]
        if ground.level:
            assert lower[force] == upper[force] == least
        else:
            row = [label.name for label in switch.labels].index(f"lift-off force {foot}")
            assert switch.lower[0, row] == switch.upper[0, row] == least
    margin = NORMAL_FORCE_MARGIN * robot.mass * robot.gravity
    kept = replace(problem, node_margins=True)
    if ground.level:
        lower, upper = variable_bounds(kept, layout)
        force = domain.force[:, pattern.contacts(domain.stance).normal_index("fl")]
        np.testing.assert_array_equal(lower[force], [least + margin] * (domain.nodes - 1) + [least])
        assert upper[force[-1]] == least
    else:
        rows = node_block(kept, layout, domain)
        row = [label.name for label in rows.labels].index("normal force fl")
        np.testing.assert_array_equal(rows.lower[:, row], [least + margin] * (domain.nodes - 1) + [-np.inf])
    with pytest.raises(InputError, match="foot 'fl' leaves the ground by its force"):
        replace(problem, limits=replace(problem.limits, normal_force=0.0))


def test_samples_follow_the_slope_and_turn_forces_into_it(gait: Gait) -> None:
    samples = samples_of_gait(gait, cycles=2)
    joins = np.flatnonzero(np.diff(samples.segments))
    np.testing.assert_allclose(samples.positions[joins, :3], samples.positions[joins + 1, :3], atol=1e-8)
    climbed = samples.positions[-1, 2] - samples.positions[0, 2]
    assert climbed == pytest.approx(2 * gait.period * gait.speed * np.tan(SLOPE.slope), abs=1e-8)
    local = samples.local_forces(samples.forces)
    for domain, stance in zip(gait.domains, gait.pattern.solved, strict=True):
        at = terms(gait.pattern.contacts(stance), domain.positions, domain.velocities)
        rows = np.flatnonzero(samples.stances == gait.pattern.stances.index(stance))[: len(domain.times)]
        for foot in stance.feet:
            expected = at.local_force(foot, domain.forces)
            np.testing.assert_allclose(local[rows, gait.robot.foot_names.index(foot)], expected, atol=1e-10)


def test_check_monitors_and_comparison_name_the_same_forces(gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    """Normal force and friction used at the entry of the first stance, from three places, under the slope's normal."""
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    trace = simulate(closed_loop(gait), start_state(gait), 1)
    report = contact_report(trace, gait.pattern, ContactBounds.of_gait(gait))
    bounds = AllocationLimits(SLOPE.friction, 0.0, {})
    motions = [samples_of_gait(gait), samples_of_trace(trace, gait.pattern)]
    nominal, compared = (entry.limits for entry in compare(motions, {"pinv": gait.law}, [PAPER], bounds).metrics)
    assert nominal is not None
    assert compared is not None
    assert compared.friction_used == pytest.approx(report.max_friction, rel=1e-9)
    assert compared.min_normal_force == pytest.approx(report.min_normal_force, rel=1e-9)
    rows = {row.name: row.value for row in check(gait, grid=1).rows}
    smallest = min(value for name, value in rows.items() if " normal force " in name)
    assert nominal.min_normal_force == pytest.approx(smallest, rel=1e-6)  # check solves for the forces itself
    normal = np.asarray(SLOPE.normal(np.zeros(3)))
    lightest = min(float(np.min(d.forces.reshape(len(d.times), -1, 3) @ normal)) for d in gait.domains)
    assert nominal.min_normal_force == pytest.approx(lightest, rel=1e-12)


@pytest.mark.parametrize(("heading", "mirrored"), [(0.0, True), (np.pi, True), (0.5, False), (0.5 * np.pi, False)])
def test_the_mirror_holds_along_the_fall_line_only(heading: float, mirrored: bool) -> None:
    """And a gait by name across it has to give its mirror up: by a table that does not claim it."""
    ground = Plane(slope=np.radians(10.0), heading=heading)
    assert ground.mirrored == mirrored
    if not mirrored:
        with pytest.raises(InputError, match="the same on the left and on the right"):
            amble(catalogue.astro(), ground)
    across = gait_pattern(catalogue.astro(), [("fl", "rr"), ("fr", "rl")], ground=ground)
    assert not across.mirrored


@pytest.mark.slow
def test_a_gait_up_ten_degrees_is_certified_and_walks() -> None:
    walking = synthesize(gait_problem(catalogue.astro(), "amble", speed=0.2, ground=SLOPE))
    assert check(walking).passed
    stable = stabilize(walking)
    certificate = certify(stable)
    assert certificate.radius < 0.95
    trace = simulate(stable, certificate.state, 20)
    assert trace.completed, trace.ended
    moved = trace.state[-1, :3] - trace.state[0, :3]
    assert moved[2] == pytest.approx(np.tan(SLOPE.slope) * moved[0], abs=1e-6)
    assert moved[0] == pytest.approx(0.2 * (trace.time[-1] - trace.time[0]), rel=1e-4)
