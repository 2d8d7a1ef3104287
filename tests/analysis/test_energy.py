"""Metrics of torque against hand computation and scaling laws."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad, simpson

from amble.analysis import samples_of_gait
from amble.analysis.energy import torque_metrics
from amble.analysis.motion import Motion
from amble.analysis.reallocation import reallocate
from amble.control.actuator import ACTUATORS, DATASHEET, PAPER, Actuator
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.robot import Adaptation, load_robot
from amble.robot.dynamics import mass_matrix
from amble.synthesis import gait_problem, synthesize
from tests.robots import PLANAR, path

Builder = Callable[..., Motion]


@pytest.mark.parametrize("speed", [1.5, -1.5])
def test_constant_torque_by_hand(speed: float, constant_motion: Builder) -> None:
    found = torque_metrics(constant_motion(1.74, speed), "pinv", PAPER)
    # 12 joints, 0.55 W of heat each (one ampere), 2.61 W of work where the joint gives any, 2 s, m g d = 84.366 J
    power = 12.0 * (0.55 + max(1.74 * speed, 0.0))
    assert found.cot == pytest.approx(power * 2.0 / (21.5 * 9.81 * 0.4), rel=1e-12)
    assert found.peak_torque == pytest.approx(1.74)
    assert found.rms_torque == pytest.approx(1.74, rel=1e-12)
    assert found.cot_error < 1e-12
    assert (found.motion, found.law, found.actuator) == ("nominal", "pinv", "paper")


@pytest.mark.parametrize(("rms", "heat"), [(7.932, 137.2), (9.659, 203.4)])
def test_heat_of_the_papers_table(rms: float, heat: float, constant_motion: Builder) -> None:
    """The paper's RMS torques give the heat of docs/theory/energy.md, eq. 7 (four digits published)."""
    assert torque_metrics(constant_motion(rms, 0.0), "pinv", PAPER).heat_power == pytest.approx(heat, rel=5e-4)


@pytest.mark.parametrize("actuator", ACTUATORS.entries, ids=lambda model: model.name)
@pytest.mark.parametrize("law", ["drop", "pinv"])
def test_heat_identity(actuator: Actuator, law: str, oscillating_motion: Builder) -> None:
    """Heat = 12 R RMS^2 / (N K_t)^2, whatever the motion."""
    found = torque_metrics(oscillating_motion(16), law, actuator)
    coefficient = actuator.resistance / (actuator.gear_ratio * actuator.torque_constant) ** 2
    assert found.heat_power == pytest.approx(12.0 * coefficient * found.rms_torque**2, rel=1e-12)


def test_heat_of_several_motors_is_the_sum_over_their_joints(oscillating_motion: Builder) -> None:
    motion = oscillating_motion(16)
    model = dataclasses.replace(
        PAPER, joints={"fl_knee": DATASHEET, "rr_yaw": Actuator("own", 0.1, 0.2, 9.0, "a test")}
    )
    found = torque_metrics(motion, "pinv", model)
    heat = 0.0
    for column, joint in enumerate(motion.joints):
        alone = np.zeros_like(motion.torques["pinv"])
        alone[:, column] = motion.torques["pinv"][:, column]
        part = dataclasses.replace(motion, torques={"pinv": alone})
        heat += torque_metrics(part, "pinv", model.joints.get(joint, PAPER)).heat_power
    assert found.heat_power == pytest.approx(heat, rel=1e-12)
    assert found.rms_torque == torque_metrics(motion, "pinv", PAPER).rms_torque
    with pytest.raises(UnknownNameError, match="joint 'tail'"):
        torque_metrics(motion, "pinv", dataclasses.replace(PAPER, joints={"tail": PAPER}))


def exact_cot(actuator: Actuator, period: float = 0.4) -> float:
    """Adaptive quadrature of the power itself, split where its terms have breakpoints."""
    energy = 0.0
    for scale in np.linspace(0.5, 1.5, 12):
        for start, offset in ((0.0, 0.0), (0.5, 3.0)):

            def power(phase: float, scale: float = scale, offset: float = offset) -> float:
                torque = 10.0 * scale * np.sin(2.0 * np.pi * phase) + offset
                return float(actuator.power(torque, 2.0 * scale * np.cos(2.0 * np.pi * phase)))

            zero = np.arcsin(offset / (10.0 * scale)) / (2.0 * np.pi)
            breakpoints = [start + 0.25, start + zero, start + 0.5 - zero]
            inside = [breakpoint for breakpoint in breakpoints if start < breakpoint < start + 0.5]
            energy += period * quad(power, start, start + 0.5, points=inside, epsabs=1e-12)[0]
    return energy / (21.5 * 9.81 * 0.2 * period)


@pytest.mark.parametrize("actuator", ACTUATORS.entries, ids=lambda model: model.name)
def test_cot_converges_with_order_four_to_adaptive_quadrature(actuator: Actuator, oscillating_motion: Builder) -> None:
    exact = exact_cot(actuator)
    counts = np.array([9, 17, 33, 65])
    found = [torque_metrics(oscillating_motion(count), "pinv", actuator) for count in counts]
    errors = np.abs([entry.cot - exact for entry in found])
    assert -np.polyfit(np.log(counts - 1.0), np.log(errors), 1)[0] > 3.5
    # 31 nodes a domain are what a gait of 15 intervals has: five digits of the paper's four
    assert errors[2] < 1e-5 * exact
    # the recorded error bounds the true one, and is not idle
    assert all(error <= entry.cot_error < 1000.0 * error for error, entry in zip(errors, found, strict=True))


def test_scaling_laws(oscillating_motion: Builder) -> None:
    motion = oscillating_motion(31)
    base = torque_metrics(motion, "pinv", DATASHEET)
    far = torque_metrics(dataclasses.replace(motion, distance=2.0 * motion.distance), "pinv", DATASHEET)
    assert far.cot == pytest.approx(0.5 * base.cot, rel=1e-13)
    heavy = torque_metrics(dataclasses.replace(motion, mass=2.0 * motion.mass), "pinv", DATASHEET)
    assert heavy.cot == pytest.approx(0.5 * base.cot, rel=1e-13)
    # twice as fast: the same work in half the time, half the heat energy
    quick = dataclasses.replace(motion, times=0.5 * motion.times, speeds=2.0 * motion.speeds)
    fast = torque_metrics(quick, "pinv", DATASHEET)
    assert fast.mechanical_power == pytest.approx(2.0 * base.mechanical_power, rel=1e-12)
    assert fast.heat_power == pytest.approx(base.heat_power, rel=1e-12)
    strong = torque_metrics(
        dataclasses.replace(motion, torques={"pinv": 3.0 * motion.torques["pinv"]}), "pinv", DATASHEET
    )
    assert strong.rms_torque == pytest.approx(3.0 * base.rms_torque, rel=1e-13)
    assert strong.peak_torque == pytest.approx(3.0 * base.peak_torque, rel=1e-13)
    assert strong.heat_power == pytest.approx(9.0 * base.heat_power, rel=1e-13)


def test_peak_knows_joint_and_time(constant_motion: Builder) -> None:
    motion = constant_motion(1.0, 0.0)
    torque = motion.torques["pinv"].copy()
    torque[7, 4] = -20.0
    found = torque_metrics(dataclasses.replace(motion, torques={"pinv": torque}), "pinv", PAPER)
    assert (found.peak_torque, found.peak_joint, found.peak_time) == (20.0, "rl_pitch", motion.times[7])


def test_half_of_a_symmetric_cycle_has_the_metrics_of_the_whole(oscillating_motion: Builder) -> None:
    """Two equal halves: ratios do not change when one of them is left out."""
    motion = oscillating_motion(25)
    twice = dataclasses.replace(
        motion,
        times=np.concatenate([motion.times, motion.times + 0.4]),
        segments=np.concatenate([motion.segments, motion.segments + 2]),
        speeds=np.tile(motion.speeds, (2, 1)),
        torques={"pinv": np.tile(motion.torques["pinv"], (2, 1))},
        distance=2.0 * motion.distance,
    )
    half, whole = (torque_metrics(each, "pinv", PAPER) for each in (motion, twice))
    assert whole.cot == pytest.approx(half.cot, rel=1e-12)
    assert whole.rms_torque == pytest.approx(half.rms_torque, rel=1e-12)
    assert whole.peak_torque == half.peak_torque


def test_unknown_law_names_the_known(oscillating_motion: Builder) -> None:
    with pytest.raises(UnknownNameError, match="known: drop, pinv"):
        torque_metrics(oscillating_motion(5), "qp", PAPER)


def test_where_no_distance_is_walked_power_over_weight_is_what_is_left(oscillating_motion: Builder) -> None:
    motion = oscillating_motion(13)
    there = torque_metrics(motion, "pinv", DATASHEET)
    assert there.specific_power == pytest.approx(there.cot * motion.speed, rel=1e-12)
    here = torque_metrics(dataclasses.replace(motion, distance=0.0), "pinv", DATASHEET)
    assert (here.cot, here.cot_error) == (math.inf, math.inf)
    assert here.specific_power == there.specific_power


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"distance": -1.0}, "distance"),
        ({"mass": float("nan")}, "mass"),
        ({"segments": np.zeros(3)}, "segments"),
        ({"speeds": np.full((26, 12), np.nan)}, "not finite"),
        ({"torques": {"pinv": np.zeros((26, 11))}}, "torques of 'pinv'"),
    ],
)
def test_unusable_motions_are_refused(change: dict, message: str, oscillating_motion: Builder) -> None:
    with pytest.raises(InputError, match=message):
        dataclasses.replace(oscillating_motion(13), **change)


def test_work_of_the_motors_is_what_impacts_and_friction_take() -> None:
    """The same of a robot with rotors, damping and dry friction: its costs hold what they take."""
    drives = Adaptation(rotor_inertia={"*": 0.02}, damping={"*": 0.3}, dry_friction={"*": 0.8}, friction_width=0.5)
    walker = load_robot(path(PLANAR), {"l": "l_foot", "r": "r_foot"}, twins=[("l", "r")], adaptation=drives)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")  # solving once is shorter than compiling
        gait = synthesize(gait_problem(walker, "walk", speed=0.4))
    (domain,) = gait.domains
    speeds = domain.velocities[:, 3:]
    work = float(simpson(np.sum(domain.torques * speeds, axis=1), x=domain.times))
    taken = float(simpson(np.sum(0.3 * speeds**2 + 0.8 * speeds * np.tanh(speeds / 0.5), axis=1), x=domain.times))
    jump = walker.mirror.position(domain.velocities[0]) - domain.velocities[-1]
    lost = 0.5 * float(jump @ np.asarray(mass_matrix(walker, domain.positions[-1])) @ jump)
    assert taken > 0.2 * lost
    assert work == pytest.approx(lost + taken, rel=1e-4)
    motion = samples_of_gait(gait)
    motion = motion.motion({"own": motion.torques})
    least = (lost + taken) / (walker.mass * walker.gravity * gait.speed * domain.duration)
    assert torque_metrics(motion, "own", DATASHEET).cot > least


def test_net_work_of_a_gait_is_what_its_impacts_lose(walking_gait: Gait) -> None:
    """docs/theory/energy.md, eq. 10 and 11, by Simpson's rule on the nodes: its error falls with the fourth power."""
    robot, domains = walking_gait.robot, walking_gait.domains
    work = lost = 0.0
    for domain, following in zip(domains, (*domains[1:], domains[0]), strict=True):
        power = np.sum(domain.torques * domain.velocities[:, 6:], axis=1)
        work += float(simpson(power, x=domain.times))
        after = following.velocities[0]
        if domain is domains[-1]:
            after = robot.mirror.position(after)
        jump = after - domain.velocities[-1]
        lost += 0.5 * float(jump @ np.asarray(mass_matrix(robot, domain.positions[-1])) @ jump)
    assert lost > 0.0
    assert work == pytest.approx(lost, rel=1e-4)
    least = lost / (robot.mass * robot.gravity * walking_gait.speed * walking_gait.period / 2.0)
    motion = samples_of_gait(walking_gait)
    law = walking_gait.law.name
    torques = reallocate(motion, [walking_gait.law])[law].torques
    for actuator in ACTUATORS.entries:
        assert torque_metrics(motion.motion({law: torques}), law, actuator).cot > least
