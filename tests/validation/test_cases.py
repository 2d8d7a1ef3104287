"""What a case of the battery asks for is what the plant and the loop get."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.codegen import compiler
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.impedance import Impedance
from amble.types import Vector
from amble.validation import BATTERY, MORE, Case, validate
from amble.validation.cases import RANGES, STEP, Scales
from amble.validation.loop import Loop
from amble.validation.mujoco_model import mujoco_model

mujoco = pytest.importorskip("mujoco")
needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler")

OWN_RMS, OWN_PEAK = 5.289, 12.6
"""Torques of amble's own walk of this gait, N m (docs/validation.md)."""


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


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300, -1.5, "1", None])
@pytest.mark.parametrize("what", [*RANGES, "push"])
def test_figures_that_no_plant_has_are_refused(what: str, value: object) -> None:
    given: dict[str, object] = {what: (value, 0.0, 0.0) if what == "push" else value}
    if what == "push" and value == -1.5:
        given = {"push": (1.0, 0.0)}
    with pytest.raises(InputError, match=f"{what}.* of case 'wrong'"):
        Case(name="wrong", **given)  # type: ignore[arg-type]


def test_a_period_below_every_step_of_a_plant_is_refused() -> None:
    with pytest.raises(InputError, match=r"period of case 'wrong' is 1e-09; it can be from 1e-05 to 0\.1"):
        Case(name="wrong", period=1e-9)


def _torques(gait: Gait, case: Case) -> np.ndarray:
    """Torques of the first steps of the plant, a row each."""
    plant, schedule = Scales().applied(case, gait)
    model, joints = mujoco_model(gait.robot, plant), len(gait.robot.joints)
    trace = Loop(gait, None, 1e-3)(model, replace(schedule, cycles=1), interval=1).trace
    return np.asarray(trace[:8, 2 + model.nq + model.nv :][:, :joints])


@needs_compiler
def test_commands_are_held_and_late(under: Gait) -> None:
    """At the first step the state is the same whatever comes after, so the first command is."""
    exact = _torques(under, Case(name="exact"))
    held = _torques(under, Case(name="held", period=4.0 * STEP))
    late = _torques(under, Case(name="late", delay=3.0 * STEP))
    assert np.all(held[:4] == exact[0])
    assert np.all(held[4] != held[3])
    assert np.all(late[:3] == late[0])
    np.testing.assert_array_equal(late[3], exact[0])
    assert np.all(late[4] != late[3])


@needs_compiler
def test_a_push_reaches_the_base(under: Gait) -> None:
    """Upward, by more than the weight: momentum grows by the impulse less that of the weight; contacts only push."""

    def rise(push: float) -> float:
        plant, schedule = Scales().applied(Case(name="up", push=(0.0, 0.0, push), push_at=0.0), under)
        model = mujoco_model(under.robot, plant)
        trace = Loop(under, None, 1e-3)(model, replace(schedule, cycles=1), interval=1).trace
        velocity = trace[round(0.02 / plant.step), 2 + model.nq :][:3]
        return float(velocity[2])

    weight = under.robot.mass * under.robot.gravity * 0.02
    assert rise(10.0 * weight) - rise(0.0) > 5.0 * weight / under.robot.mass


@needs_compiler
def test_a_walk_that_ends_before_its_push_or_its_step_does_not_pass(under: Gait) -> None:
    cases = (Case(name="push", push=(1.0, 0.0, 0.0)), Case(name="step", rise=0.01))
    found = validate(under, cases=cases, cycles=2)
    assert [result.failures for result in found.results] == [
        ("the walk ended before the push was over",),
        ("the walk ended before the step of the ground was behind it",),
    ]


@needs_compiler
@pytest.mark.slow
def test_astros_amble_walks_long_and_with_late_commands(under: Gait) -> None:
    """A thousand cycles at the orbit's torques and speed; a hundred with commands that are 2 ms late."""
    nominal = validate(under, cases=BATTERY[:1], cycles=1000).results[0]
    assert nominal.passed
    assert nominal.walk.rms == pytest.approx(OWN_RMS, rel=0.02)
    assert nominal.walk.peak <= 1.4 * OWN_PEAK
    assert nominal.speed == pytest.approx(under.speed, rel=0.03)
    late = (Case(name="1 kHz", period=1e-3, delay=2e-3), Case(name="500 Hz", period=2e-3, delay=2e-3))
    assert validate(under, cases=late, cycles=100).passed == 2


@needs_compiler
@pytest.mark.slow
def test_astros_amble_walks_on_in_cases_beside_the_battery(under: Gait) -> None:
    """Measured: all upright for 60 cycles; at 300 Hz with 2 ms of delay its commands ring at the torque limit."""
    found = validate(under, cases=MORE)
    assert found.upright == len(MORE), str(found)
    assert found.passed >= len(MORE) - 1, str(found)
