"""The rows of a lift-off: the second derivative of the foot's height, in the problem, the check and the certificate."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.hybrid import FLAT, Ground, Plane
from amble.robot import kinematics
from amble.synthesis import gait_problem
from amble.synthesis.layout import build_layout
from amble.synthesis.lift_off_rows import RISE, lift_off_rows
from amble.synthesis.link_blocks import switch_block
from tests.robots import random_states, robot


@pytest.mark.parametrize("ground", [FLAT, Plane(slope=0.2)])
def test_a_row_is_the_second_derivative_of_the_gap(ground: Ground) -> None:
    problem = gait_problem(robot("astro"), "running trot", speed=0.5, ground=ground, intervals=2)
    switch, of = problem.pattern.switches[0], problem.pattern.robot
    q, v, a = (ca.SX.sym(letter, of.size) for letter in "qva")
    rows, labels = lift_off_rows(problem, switch, q, v, a)
    value = ca.Function("rows", [q, v, a], [ca.vertcat(*rows)])
    assert [label.name for label in labels] == [f"lift-off acceleration {foot} (g)" for foot in ("fl", "rr")]
    at, rate = random_states(of, 5)
    for number, (place, velocity) in enumerate(zip(at, rate, strict=True)):
        acceleration = np.random.default_rng(number).normal(0.0, 10.0, of.size)
        t = ca.SX.sym("t")
        along = place + velocity * t + 0.5 * acceleration * t**2
        for row, foot in enumerate(switch.leaving):
            gap = ground.gap(kinematics.foot_position(of, foot, along))
            second = ca.Function("second", [t], [ca.hessian(gap, t)[0]])(0.0)
            found = float(value(place, velocity, acceleration)[row])
            assert found == pytest.approx(float(second) / of.gravity, rel=1e-9, abs=1e-9)


def test_the_last_switch_of_a_mirrored_gait_looks_at_the_mirrored_entry() -> None:
    """Of a walking trot the second solved stance ends in the mirror of the first, whose swing feet have just left."""
    problem = gait_problem(robot("astro"), "walking trot", speed=0.5, intervals=2)
    layout = build_layout(problem)
    block = switch_block(problem, layout, 1)
    names = [label.name for label in block.labels]
    places = [names.index(f"lift-off acceleration {foot} (g)") for foot in problem.pattern.switches[1].leaving]
    assert np.all(block.lower[0, places] == RISE)
    slopes = ca.Function("slopes", [block.variables], [ca.jacobian(block.rows[places], block.variables)])
    touched = np.flatnonzero(np.abs(np.asarray(slopes(np.full(block.variables.shape[0], 0.3)))).max(axis=0))
    columns = block.columns[0, touched]
    assert set(columns) & set(layout.domains[0].a[0])
    assert not set(columns) & set(layout.domains[1].a.ravel())
