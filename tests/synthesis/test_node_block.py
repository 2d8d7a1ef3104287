"""Rows of the nodes: outputs over a phase of the configuration, least normal forces."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from examples.extending.phase_configuration import ConfigurationPhase

from amble.control.phase import Phase
from amble.gait import Gait
from amble.hybrid import FLAT, Ground, Plane
from amble.synthesis import GaitProblem, gait_problem
from amble.synthesis.block import Block
from amble.synthesis.layout import Layout, build_layout, variable_bounds
from amble.synthesis.link_blocks import phase_block
from amble.synthesis.node_block import SLOWEST, node_block, parameter_values
from amble.synthesis.program import build_program
from amble.synthesis.result import from_gait
from amble.types import Matrix
from tests.robots import PLANAR, robot

PHASE = ConfigurationPhase({"D1": {"roll": 1.0}})
NUMBERS = (-0.2, 0.3)
ROLL = 3


def on(problem: GaitProblem, phase: Phase) -> GaitProblem:
    return replace(problem, outputs=replace(problem.outputs, phase=phase))


def rows(problem: GaitProblem, block: Block, variables: Matrix, share: float) -> dict[str, float]:
    function = ca.Function("rows", [block.variables, block.constants, block.parameters], [block.rows])
    constants = [share, 1.0] if block.constants.numel() else []
    values = np.asarray(function(variables, constants, parameter_values(problem))).ravel()
    return dict(zip((label.name for label in block.labels), values, strict=True))


@pytest.fixture(scope="module")
def blocks(small_problem: GaitProblem) -> tuple[Block, Block]:
    """The nodes of D1 over time and over roll."""
    found = []
    for problem in (small_problem, on(small_problem, PHASE)):
        layout = build_layout(problem)
        found.append(node_block(problem, layout, layout.domains[0]))
    return found[0], found[1]


def test_where_the_phase_grows_evenly_the_rows_are_those_of_time(
    small_problem: GaitProblem, blocks: tuple[Block, Block]
) -> None:
    """A random node whose roll is at its share of the range, with the mean rate and no acceleration."""
    timed, over_roll = blocks
    size, share, duration = small_problem.pattern.robot.size, 0.3, 0.2
    variables = np.random.default_rng(0).normal(0.0, 0.3, timed.variables.numel())
    joints, feet = len(small_problem.pattern.robot.joints), 2
    variables[3 * size + joints + 3 * feet] = duration
    start, end = NUMBERS
    variables[ROLL], variables[size + ROLL], variables[2 * size + ROLL] = (
        start + share * (end - start), (end - start) / duration, 0.0,
    )  # fmt: skip
    ours = rows(small_problem, over_roll, np.concatenate([variables[:-1], NUMBERS, variables[-1:]]), share)
    theirs = rows(small_problem, timed, variables, share)
    assert ours.pop("rate of the phase") == pytest.approx(1.0)
    assert list(ours) == list(theirs)
    for name, value in theirs.items():
        assert ours[name] == pytest.approx(value, abs=1e-12 * (1.0 + abs(value))), name  # rates of 5 per 0.5


def test_the_acceleration_row_is_the_second_derivative_of_the_curve(
    small_problem: GaitProblem, blocks: tuple[Block, Block]
) -> None:
    """Along q + v t + a t^2 / 2 the rows are the first two derivatives of q_c - B(s(q))."""
    _, block = blocks
    size, step = small_problem.pattern.robot.size, 1e-4
    at = np.random.default_rng(1).normal(0.0, 0.3, block.variables.numel())
    at[-3:-1] = NUMBERS

    def moved(t: float) -> dict[str, float]:
        there = at.copy()
        there[:size] += at[size : 2 * size] * t + 0.5 * at[2 * size : 3 * size] * t**2
        there[size : 2 * size] += at[2 * size : 3 * size] * t
        return rows(small_problem, block, there, 0.0)

    before, here, after = moved(-step), moved(0.0), moved(step)
    for name in small_problem.outputs.of("D1").coordinates:
        rate = (after[f"output {name}"] - before[f"output {name}"]) / (2.0 * step)
        second = (after[f"output rate of {name}"] - before[f"output rate of {name}"]) / (2.0 * step)
        # truncation step^2 times third derivatives of up to 1e3
        assert here[f"output rate of {name}"] == pytest.approx(rate, abs=1e-4)
        assert here[f"output acceleration of {name}"] == pytest.approx(second, abs=1e-4)


def test_numbers_are_tied_to_the_ends(small_problem: GaitProblem) -> None:
    problem = on(small_problem, PHASE)
    layout = build_layout(problem)
    block = phase_block(problem, layout.domains[0])
    variables = np.random.default_rng(2).normal(size=block.variables.numel())
    size = problem.pattern.robot.size
    found = rows(problem, block, variables, 0.0)
    assert found["theta_start"] == pytest.approx(variables[-2] - variables[ROLL])
    assert found["theta_end"] == pytest.approx(variables[-1] - variables[size + ROLL])
    assert block.lower.tolist() == block.upper.tolist() == [[0.0, 0.0]]


def test_time_adds_neither_variables_nor_rows(small_problem: GaitProblem, blocks: tuple[Block, Block]) -> None:
    timed, over_roll = blocks
    layouts = [build_layout(problem) for problem in (small_problem, on(small_problem, PHASE))]
    assert layouts[1].size == layouts[0].size + 2 * len(NUMBERS)
    assert {label.name for label in set(over_roll.labels) - set(timed.labels)} == {"rate of the phase"}
    assert over_roll.lower[:, -1].tolist() == [SLOWEST] * layouts[1].domains[0].nodes


def test_a_gait_on_time_is_a_start_for_another_phase(small_problem: GaitProblem, walking_gait: Gait) -> None:
    """Its motion at the nodes stays; numbers and curves are those of the motion over the new phase."""
    problem = on(small_problem, PHASE)
    layout: Layout = build_layout(problem)
    start = from_gait(problem, walking_gait, layout)
    domain, known = layout.domains[0], walking_gait.domains[0]
    np.testing.assert_allclose(start[domain.phase_numbers], known.positions[[0, -1], ROLL], atol=1e-12)
    np.testing.assert_array_equal(start[layout.domains[1].phase_numbers], 0.0)
    curves = start[domain.coefficients].reshape((-1, problem.outputs.order + 1), order="F")
    outputs = [problem.pattern.robot.coordinate_names.index(n) for n in problem.outputs.of("D1").coordinates]
    np.testing.assert_allclose(curves[:, 0], known.positions[0, outputs], atol=1e-12)
    np.testing.assert_allclose(curves[:, -1], known.positions[-1, outputs], atol=1e-12)


def test_the_program_is_built_with_the_numbers_rows(small_problem: GaitProblem) -> None:
    program = build_program(replace(on(small_problem, PHASE), intervals=2))
    names = program.program.row_names
    assert names.count("D1 phase theta_start") == 1
    assert sum(name.endswith(" rate of the phase") for name in names) == program.layout.domains[0].nodes


@pytest.mark.parametrize("ground", [FLAT, Plane(slope=0.1)])
def test_feet_that_stay_carry_and_one_that_leaves_does_so_linearly(ground: Ground) -> None:
    """Of a run: bounds of variables on level ground, of rows on a slope."""
    problem = gait_problem(robot(PLANAR), "run", speed=0.3, ground=ground, intervals=3)
    problem = replace(problem, node_margins=False)
    limits, layout = problem.limits, build_layout(problem)
    assert limits.standing_force is not None
    assert limits.standing_force > limits.normal_force
    lower, _ = variable_bounds(problem, layout)
    for domain in layout.domains:
        contacts = problem.pattern.contacts(domain.stance)
        block = node_block(problem, layout, domain)
        names = [label.name for label in block.labels]
        for foot in contacts.feet:
            if ground.level:
                found = lower[domain.force[:, contacts.normal_index(foot)]]
            else:
                found = block.lower[:, names.index(f"normal force {foot}")]
            least = np.full(domain.nodes, limits.standing_force)
            if foot in domain.switch.leaving:
                least = np.linspace(limits.standing_force, limits.normal_force, domain.nodes)
            np.testing.assert_allclose(found[:-1], least[:-1], rtol=1e-12)
    assert any(domain.switch.leaving for domain in layout.domains)
