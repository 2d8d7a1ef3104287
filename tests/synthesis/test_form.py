"""Programs that are kept for a form: nothing that a program is written from may differ between problems of one form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from amble.codegen.cache import function_key
from amble.control import DropActuator, PseudoInverse
from amble.gait.clearances import Clearances, Motor
from amble.gait.cost import Cost, Instant, TorqueSquared
from amble.gait.limits import Limits
from amble.hybrid import Plane
from amble.hybrid.landing import SIMULTANEOUS
from amble.robot import catalogue
from amble.robot.catalogue import Posture
from amble.synthesis import GaitProblem, gait_problem
from amble.synthesis.block_functions import value_function
from amble.synthesis.form import Form
from amble.synthesis.layout import build_layout, variable_bounds
from amble.synthesis.node_block import parameter_values
from amble.synthesis.program import _blocks, build_program
from tests.grounds import on_friction


class HeavyTorque(TorqueSquared):
    """Another cost of the same form, with a weight on the torques' rates."""

    def torque_rate(self, robot: Any) -> float:
        """Return a weight."""
        del robot
        return 1e-4


@pytest.fixture(scope="module")
def turning() -> GaitProblem:
    """A trot that turns and goes sideways, without a mirror."""
    return gait_problem(catalogue.astro(), "trot", speed=0.2, lateral_speed=0.05, yaw_rate=0.3, intervals=2)


def limited(problem: GaitProblem, **changes: Any) -> GaitProblem:
    """The problem with other limits."""
    return replace(problem, limits=replace(problem.limits, **changes))


def raised(problem: GaitProblem) -> GaitProblem:
    """The problem with the base 1 cm higher."""
    low, high = problem.limits.positions["z"]
    return limited(problem, positions={**problem.limits.positions, "z": (low + 0.01, high + 0.01)})


def scaled(numbers: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """The numbers, or intervals, times a factor."""
    return {name: tuple(factor * e for e in n) if isinstance(n, tuple) else factor * n for name, n in numbers.items()}


def changes(problem: GaitProblem) -> dict[str, GaitProblem]:
    """Another value of every field of a problem and its limits and posture."""
    limits, pattern, outputs = problem.limits, problem.pattern, problem.outputs
    joint, other = pattern.robot.joint_names[0], replace(outputs, order=outputs.order + 1)
    (x, y, (low, high)) = limits.touchdown_velocity
    return {
        "pattern": replace(problem, pattern=replace(pattern, landing_rule=SIMULTANEOUS)),
        "pattern.friction": on_friction(problem, 0.9 * pattern.ground.friction),
        "outputs": replace(problem, outputs=other),
        "law": replace(problem, law=DropActuator((joint,))),
        "speed": replace(problem, speed=problem.speed + 0.1),
        "posture.height": replace(problem, posture=replace(problem.posture, height=problem.posture.height - 0.01)),
        "posture.angles": replace(
            problem, posture=replace(problem.posture, angles=scaled(problem.posture.angles, 0.9))
        ),
        "intervals": replace(problem, intervals=problem.intervals + 1),
        "scheme": replace(problem, scheme="lobatto-5"),
        "node_margins": replace(problem, node_margins=not problem.node_margins),
        "gains": replace(problem, gains=(50.0, 10.0)),
        "cost": replace(problem, cost=HeavyTorque()),
        "lateral_speed": replace(problem, lateral_speed=problem.lateral_speed + 0.05),
        "yaw_rate": replace(problem, yaw_rate=problem.yaw_rate + 0.1),
        "release": replace(problem, release=0.5 * problem.release),
        "outputs_by_default": replace(problem, outputs_by_default=not problem.outputs_by_default),
        "limits.durations": limited(problem, durations=scaled(limits.durations, 0.9)),
        "limits.positions": raised(problem),
        "limits.speeds": limited(problem, speeds=scaled(limits.speeds, 0.9)),
        "limits.torques": limited(problem, torques=scaled(limits.torques, 0.9)),
        "limits.acceleration": limited(problem, acceleration=0.9 * limits.acceleration),
        "limits.touchdown_velocity": limited(problem, touchdown_velocity=(x, y, (0.9 * low, high))),
        "limits.normal_force": limited(problem, normal_force=limits.normal_force + 0.5),
        "limits.clearance": limited(problem, clearance=0.9 * limits.clearance),
        "limits.standing_force": limited(problem, standing_force=limits.normal_force + 1.0),
        "limits.clearances": limited(problem, clearances=Clearances(knees=0.05)),
        "limits.motors": limited(problem, motors={joint: Motor(stall_torque=60.0, no_load_speed=9.0)}),
    }


def assert_same_blocks(one: GaitProblem, other: GaitProblem) -> None:
    """What ``assemble`` takes is the same to the last bit: functions, places, names, bounds."""
    layouts = build_layout(one), build_layout(other)
    np.testing.assert_array_equal(layouts[0].scale, layouts[1].scale)
    for ours, theirs in zip(*(map(_blocks, (one, other), layouts)), strict=True):
        assert function_key(value_function(ours)) == function_key(value_function(theirs))
        assert (ours.name, ours.labels, ours.places) == (theirs.name, theirs.labels, theirs.places)
        for part in ("columns", "values", "lower", "upper"):
            np.testing.assert_array_equal(getattr(ours, part), getattr(theirs, part))


def numbers(problem: GaitProblem) -> list[bytes]:
    """What a program takes from its own problem: parameters and bounds of variables."""
    parts = (parameter_values(problem), *variable_bounds(problem, build_layout(problem)))
    return [part.tobytes() for part in parts]


def test_every_field_is_changed(turning: GaitProblem) -> None:
    """A new field has to be added to ``changes``, and so is held by the next test."""
    names = {name.split(".")[-1] for name in changes(turning)}
    for record in (GaitProblem, Limits, Posture):
        assert {each.name for each in fields(record)} <= names | {"limits", "posture"}


def test_what_a_change_leaves_of_the_form_it_leaves_of_the_program(turning: GaitProblem) -> None:
    """Equal forms: the same blocks, other numbers. Every other change makes another form."""
    form, own, parameters = Form.of(turning), numbers(turning), set[str]()
    assert form is not None
    assert form == Form.of(replace(turning))
    for name, changed in changes(turning).items():
        if Form.of(changed) == form:
            parameters.add(name)
            assert_same_blocks(turning, changed)
            assert numbers(changed) != own, name
    assert parameters == {"speed", "lateral_speed", "yaw_rate", "pattern.friction", "limits.positions"}


@pytest.mark.parametrize("gait", ["amble", "running trot", "turning"])
def test_a_program_that_is_kept_is_that_of_the_problem(gait: str, turning: GaitProblem) -> None:
    """The problem that stands for a form has none of its numbers, and gives the same blocks."""
    known = turning if gait == "turning" else gait_problem(catalogue.astro(), gait, speed=0.23, intervals=2)
    form = Form.of(raised(on_friction(known, 0.47)))
    assert form is not None
    assert form.problem.limits.positions == {}
    assert form.problem.pattern.ground.friction == 1.0
    assert_same_blocks(form.problem, known)


def test_a_slope_keeps_its_bounds_of_positions() -> None:
    """There the height of the base is a row, whose bounds are the program's."""
    problem = gait_problem(catalogue.astro(), "amble", speed=0.2, ground=Plane(slope=0.05), intervals=2)
    assert Form.of(raised(problem)) != Form.of(problem)
    assert Form.of(replace(problem, speed=0.3)) == Form.of(problem)


def test_a_neighbour_takes_the_same_functions_with_its_own_numbers(small_problem: GaitProblem) -> None:
    one = build_program(small_problem)
    other = build_program(on_friction(replace(raised(small_problem), speed=0.3), 0.4))
    assert other.program is one.program
    assert other.layout is one.layout
    np.testing.assert_array_equal(other.parameters, [0.3, 0.0, 0.0, 0.4])
    height = one.layout.domains[0].q[:, 2]
    higher = (other.lower[height] - one.lower[height]) * one.layout.scale[height]
    np.testing.assert_allclose(higher, 0.01, rtol=1e-9)
    assert one.problem is small_problem
    assert other.problem.speed == 0.3


def test_limits_that_are_changed_in_place_make_another_form(small_problem: GaitProblem) -> None:
    durations = dict(small_problem.limits.durations)
    problem = limited(small_problem, durations=durations)
    before = Form.of(problem)
    durations["D1"] = (0.11, 0.29)
    assert Form.of(problem) != before
    assert before is not None
    assert before.problem.limits.durations["D1"] == (0.1, 0.3)


class Moody(PseudoInverse):
    """A law with a number that its record does not have: two of them are equal whatever it is."""

    def __init__(self, factor: float) -> None:
        object.__setattr__(self, "factor", factor)


class Fickle(Cost):
    """A cost that is no record."""

    factor, name, unit = 1.0, "fickle", "1"

    def running(self, instant: Instant) -> ca.SX:
        """The squared torques times the factor."""
        return self.factor * ca.sumsqr(instant.torques)


def test_what_can_change_is_written_every_time(small_problem: GaitProblem) -> None:
    """Neither a law nor a cost with state is ever taken for what it was before."""
    cost = Fickle()
    assert Moody(1.0) == Moody(2.0)
    for problem in (replace(small_problem, law=Moody(1.0)), replace(small_problem, cost=cost)):
        assert Form.of(problem) is None
    problem, point = replace(small_problem, cost=cost, intervals=2), None
    found = []
    for factor in (1.0, 3.0):
        cost.factor = factor  # type: ignore[misc]
        program = build_program(problem)
        point = np.full(program.layout.size, 0.1) if point is None else point
        found.append(float(program.program.nlp(point, program.parameters)[0]))
    assert found[1] == pytest.approx(3.0 * found[0], rel=1e-12)
