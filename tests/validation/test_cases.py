"""What a case of the battery asks for is what the plant and the loop get."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.codegen import compiler
from amble.gait import Gait
from amble.gait.impedance import Impedance
from amble.types import Vector
from amble.validation import MORE, Case, validate
from amble.validation.cases import STEP, Scales
from amble.validation.loop import Loop
from amble.validation.mujoco_model import mujoco_model

mujoco = pytest.importorskip("mujoco")
needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler")


@pytest.fixture(scope="module")
def under(stabilised_gait: Gait) -> Gait:
    return replace(stabilised_gait, control=Impedance())


def first_torques(gait: Gait, case: Case) -> tuple[Vector, Vector]:
    """Torques of the first step of the plant, and the state there, joints only; figures of the case as they are."""
    plant, schedule = Scales().applied(case, gait)
    model, joints = mujoco_model(gait.robot, plant), len(gait.robot.joints)
    row = Loop(gait, None, 1e-3)(model, replace(schedule, cycles=1), interval=1).trace[0]
    order = [model.joint(name).qposadr[0] for name in gait.robot.joint_names]
    rates = [model.nq + model.joint(name).dofadr[0] for name in gait.robot.joint_names]
    state = np.concatenate([row[2:][order], row[2:][rates]])
    return row[2 + model.nq + model.nv :][:joints], state


@needs_compiler
def test_joints_are_measured_in_steps(under: Gait) -> None:
    """The law is linear in what it measures, with gains that are known: rounding moves torques by P and D times it."""
    joints = len(under.robot.joints)
    exact, state = first_torques(under, Case(name="exact"))
    found, _ = first_torques(under, Case(name="coarse", quantum_angle=0.02, quantum_rate=0.3))
    moved = np.concatenate([0.02 * np.rint(state[:joints] / 0.02), 0.3 * np.rint(state[joints:] / 0.3)]) - state
    gains = Impedance().numbers(under, None)[0].parameters[2 : 2 + 2 * joints]
    expected = exact - gains[:joints] * moved[:joints] - gains[joints:] * moved[joints:]
    assert np.abs(exact - expected).max() > 0.1
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@needs_compiler
def test_motors_lag_and_have_a_cap(under: Gait) -> None:
    exact, _ = first_torques(under, Case(name="exact"))
    lagging, _ = first_torques(under, Case(name="lag", lag=2e-3))
    capped, _ = first_torques(under, Case(name="cap", cap=3.0))
    assert np.abs(exact).max() > 3.0
    np.testing.assert_allclose(lagging, exact * (1.0 - np.exp(-STEP / 2e-3)), rtol=1e-12)
    np.testing.assert_allclose(capped, np.clip(exact, -3.0, 3.0), rtol=1e-12)


@pytest.mark.parametrize("period", [1e-3, 2e-3, 1.0 / 300.0, 1.0 / 7300.0, 0.0])
def test_a_controller_may_have_any_period(stabilised_gait: Gait, period: float) -> None:
    plant, schedule = Scales(time=1.3).applied(Case(name="held", period=period), stabilised_gait)
    every = schedule.period / plant.step
    assert every == pytest.approx(round(every), rel=1e-12)
    assert round(every) >= 1
    assert plant.step <= 1.3 * STEP * (1.0 + 1e-12)
    assert schedule.period == pytest.approx(1.3 * (period or STEP))


def test_figures_scale_with_the_robot(stabilised_gait: Gait) -> None:
    scales = Scales(mass=2.0, length=3.0, time=1.7, gravity=12.0)
    case = Case(name="all", push=(1.0, -2.0, 3.0), push_at=2.5, rise=-0.01, cap=12.0, lag=1e-3, quantum_angle=1e-3,
                quantum_rate=0.05)  # fmt: skip
    plant, schedule = scales.applied(case, stabilised_gait)
    began, end = schedule.push[3:]
    weight = 2.0 * 12.0 / 9.81
    np.testing.assert_allclose(np.array(schedule.push[:3]) * (end - began), weight * 1.7 * np.array(case.push))
    assert began == pytest.approx(2.5 * stabilised_gait.period)
    assert (plant.rise, schedule.rise) == pytest.approx((-0.03, -0.03))
    assert (schedule.cap, schedule.lag) == pytest.approx((12.0 * weight * 3.0, 1.7e-3))
    assert (schedule.quantum_angle, schedule.quantum_rate) == pytest.approx((1e-3, 0.05 / 1.7))


@pytest.mark.parametrize("rise", [0.05, -0.05])
@pytest.mark.parametrize("speed", [0.2, -0.2])
def test_the_ground_has_a_step_ahead(stabilised_gait: Gait, rise: float, speed: float) -> None:
    """Rays from above, short of the edge and past it."""
    gait, length = replace(stabilised_gait, speed=speed), stabilised_gait.robot.leg_length
    plant, schedule = Scales.of(gait.robot).applied(Case(name="step", rise=rise), gait)
    model = mujoco_model(gait.robot, plant)
    data = mujoco.MjData(model)
    data.qpos[1] = 50.0  # the robot is out of the way
    mujoco.mj_forward(model, data)
    towards = np.sign(speed)
    assert (plant.ahead, schedule.edge) == (towards, plant.edge)
    for way, height in ((-2.0, 0.0), (0.99, 0.0), (1.01, rise), (60.0, rise)):
        place = np.array([towards * way * length, 0.3, 10.0])
        distance = mujoco.mj_ray(model, data, place, np.array([0.0, 0.0, -1.0]), None, 1, -1, np.zeros(1, np.int32))
        assert 10.0 - distance == pytest.approx(height - plant.radius, abs=1e-6)


def test_other_links_weigh_more(stabilised_gait: Gait) -> None:
    walker = stabilised_gait.robot
    plant, _ = Scales().applied(Case(name="heavy", links=1.1, trunk=0.9), stabilised_gait)
    model = mujoco_model(walker, plant)
    for place, link in enumerate(walker.links):
        body, factor = model.body(link.name), 1.1 if place else 0.9
        assert body.mass[0] == pytest.approx(factor * link.mass, rel=1e-12)
        assert body.inertia.sum() == pytest.approx(factor * np.trace(link.inertia), rel=1e-9)


@needs_compiler
def test_a_walk_has_to_pass_the_step(under: Gait) -> None:
    short = validate(under, cases=(Case(name="step", rise=0.005),), cycles=3).results[0]
    assert short.failures == ("the walk ended before the step of the ground was behind it",)


@needs_compiler
@pytest.mark.slow
def test_astros_amble_walks_on_in_cases_beside_the_battery(under: Gait) -> None:
    """Measured: all upright for 60 cycles; at 300 Hz with 2 ms of delay its commands ring at the torque limit."""
    found = validate(under, cases=MORE)
    assert found.upright == len(MORE), str(found)
    assert found.passed >= len(MORE) - 1, str(found)
