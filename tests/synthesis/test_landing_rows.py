"""Rows behind landings: released feet, feet that land one by one in overlap and three at once (a trot: tests/gait)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

from amble.export.stances import exported_stances
from amble.hybrid import FLAT, ONE_BY_ONE, POINT, SIMULTANEOUS, GaitPattern, gait_pattern
from amble.hybrid.gaits import GAITS
from amble.robot import catalogue, kinematics
from amble.robot.natural_units import velocity_unit
from amble.synthesis import gait_problem
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.landing_rows import DEPTH, depth_rows, landing_blocks, release_rows
from amble.synthesis.layout import build_layout
from amble.synthesis.link_blocks import switch_block
from amble.synthesis.node_block import parameter_values
from tests.robots import hexapod, random_states

FEET = catalogue.astro().foot_names


def overlap() -> GaitPattern:
    """Stances of 2, 4, 2, 4 feet: old feet stay until both new ones have landed."""
    table = (("fl", "rr"), FEET, ("fr", "rl"), FEET)
    return gait_pattern(catalogue.astro(), table, True, landing_rule=ONE_BY_ONE)


def tripod() -> GaitPattern:
    table = (("fl", "rr", "ml"), ("fr", "rl", "mr"))
    return gait_pattern(hexapod(), table, landing_rule=ONE_BY_ONE)


@pytest.mark.parametrize(("walk", "count"), [(overlap, 2), pytest.param(tripod, 12, marks=pytest.mark.slow)])
def test_every_stance_between_landings_has_variables_that_its_rows_define(
    walk: Callable[[], GaitPattern], count: int
) -> None:
    """As many equalities as variables; filled by elimination they are met by rows of inverse dynamics."""
    pattern = walk()
    problem = gait_problem(pattern.robot, pattern, speed=0.1, intervals=2)
    layout = build_layout(problem)
    guess = initial_guess(problem, layout)
    blocks = [block for number in range(len(layout.domains)) for block in landing_blocks(problem, layout, number)]
    landings = [landing for domain in layout.domains for landing in domain.landings]
    assert len(blocks) == len(landings) == count
    for block, landing in zip(blocks, landings, strict=True):
        rows = ca.Function("rows", [block.variables, block.constants, block.parameters], [block.rows])
        values = np.asarray(rows(guess[block.columns[0]], [], parameter_values(problem))).ravel()
        equal = block.lower[0] == block.upper[0]
        assert int(equal.sum()) == landing.index.size
        assert np.abs(values[equal]).max() < 1e-9
        mine = np.isin(block.columns[0], landing.index)
        symbols = [block.variables, block.constants, block.parameters]
        slope = ca.Function("slope", symbols, [ca.jacobian(block.rows, block.variables)])
        matrix = np.asarray(slope(guess[block.columns[0]], [], parameter_values(problem)))[equal][:, mine]
        assert np.linalg.matrix_rank(matrix) == landing.index.size


def test_stances_without_a_mirror_have_laws_of_their_own() -> None:
    pattern = tripod()
    stances = exported_stances(SimpleNamespace(pattern=pattern, robot=pattern.robot))  # type: ignore[arg-type]
    assert sorted(entry.law for entry in stances) == list(range(14))
    assert not any(entry.mirrored for entry in stances)
    assert [entry.stance for entry in stances] == list(pattern.visited)


@pytest.mark.parametrize("gait", ["trot", "amble"])
def test_a_foot_that_a_landing_releases_goes_up_where_all_land_at_once(gait: str) -> None:
    """The row of every released foot is its velocity along the vertical, behind the impact."""
    pattern = replace(GAITS[gait](catalogue.astro(), FLAT, POINT), landing_rule=SIMULTANEOUS)
    problem = replace(gait_problem(pattern.robot, pattern, speed=0.1, intervals=2), release=3e-4)
    robot, switch = problem.pattern.robot, problem.pattern.switches[0]
    q, v = ca.SX.sym("q", robot.size), ca.SX.sym("v", robot.size)
    found = release_rows(problem, switch, q, v, "behind the impact")
    names = [label.name for label in found.labels]
    assert names == [f"behind the impact: velocity up {foot}" for foot in switch.lifting]
    block = switch_block(problem, build_layout(problem), 0)
    rows = {label.name: row for row, label in enumerate(block.labels)}
    assert [block.lower[0, rows[name]] for name in names] == pytest.approx([3e-4 * velocity_unit(robot)] * len(names))
    value = ca.Function("rows", [q, v], [ca.vertcat(*found.rows)])
    at, rates = (states[0] for states in random_states(robot, 1))
    moved = [ca.jtimes(kinematics.foot_position(robot, foot, q)[2], q, v) for foot in switch.lifting]
    expected = ca.Function("expected", [q, v], [ca.vertcat(*moved)])(at, rates)
    assert np.asarray(value(at, rates)) == pytest.approx(np.asarray(expected))


def test_a_landing_foot_would_go_on_into_the_ground() -> None:
    """The row is zero where the parabola of its velocity and acceleration at touchdown turns at the depth asked for."""
    problem = gait_problem(catalogue.astro(), "trot", speed=0.1, intervals=2)
    robot, switch = problem.pattern.robot, problem.pattern.switches[0]
    q, v, a = (ca.SX.sym(letter, robot.size) for letter in "qva")
    found = depth_rows(problem, switch, q, v, a)
    value = ca.Function("rows", [q, v, a], [ca.vertcat(*found.rows)])
    at, rates = (states[0] for states in random_states(robot, 1))
    time = ca.SX.sym("t")
    for row, foot in enumerate(switch.landing):
        rising = np.random.default_rng(row).normal(0.0, 10.0, robot.size)
        along = at + rates * time + 0.5 * rising * time**2
        height = kinematics.foot_position(robot, foot, along)[2]
        slopes = ca.Function("slopes", [time], [ca.jacobian(height, time), ca.hessian(height, time)[0]])(0.0)
        speed, up = (float(slope) for slope in slopes)
        depth = speed**2 - 2.0 * up * DEPTH * robot.leg_length
        assert float(value(at, rates, rising)[row]) == pytest.approx(depth / velocity_unit(robot) ** 2)
    block = switch_block(problem, build_layout(problem), 0)
    names = [label.name for label in block.labels]
    for label in found.labels:
        assert block.lower[0, names.index(label.name)] == 0.0
