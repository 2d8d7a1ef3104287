"""Joint impedance about the orbit: torques and slopes as written, an orbit that no allocation law moves."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from amble.analysis import every_law
from amble.control import PseudoInverse
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.control_law import Numbers
from amble.gait.impedance import HOLD, Impedance
from amble.gait.orbit import orbit_arcs
from amble.hybrid import HybridSystem
from amble.stability.closed_loop_orbit import closed_loop_fixed_point

LAW = Impedance(stance_stiffness=90.0, swing_damping=1.2, stiffness={"D1 fl_knee": 55.0})


@pytest.fixture(scope="module")
def system(stabilised_gait: Gait) -> HybridSystem:
    return closed_loop(replace(stabilised_gait, control=LAW), half=True)


def test_the_arcs_are_the_closed_loops_motion(stabilised_gait: Gait) -> None:
    """Rates are the slopes of positions, and the torques those of the linearising loop at the states.

    An interpolation error of 1e-13 rad in a piece of half length 0.02 s has a slope of up to 121 / 0.02 times that.
    """
    loop = closed_loop(stabilised_gait, half=True)
    for arc, domain in zip(orbit_arcs(stabilised_gait, PseudoInverse()), loop.domains, strict=True):
        times = np.linspace(0.0, arc.duration, 50)
        states, slopes = arc.states(times)
        np.testing.assert_allclose(slopes[:, :18], states[:, 18:], atol=1e-8)
        np.testing.assert_allclose(arc.joints(times)[0], states[:, 6:18], atol=1e-12)
        for time, state, torque in zip(times, states, arc.torques(times)[0], strict=True):
            expected = np.asarray(domain.signals(time, state, domain.parameters)[0]).ravel()
            np.testing.assert_allclose(torque, expected, atol=1e-9)


def test_torques_and_slopes_are_as_written(stabilised_gait: Gait, system: HybridSystem) -> None:
    """Equation (1) by numpy from the arcs, with gains by the rule of stance, swing and knee; slopes by differences."""
    generator, robot = np.random.default_rng(1), stabilised_gait.robot
    arcs = orbit_arcs(stabilised_gait, stabilised_gait.law)
    for domain, arc, stance in zip(system.domains, arcs, stabilised_gait.pattern.solved, strict=True):
        standing = [joint in {j for foot in stance.feet for j in robot.legs[foot]} for joint in robot.joint_names]
        knee = [joint.endswith("knee") for joint in robot.joint_names]
        P, D = np.where(standing, 90.0, np.where(knee, 80.02, 120.1)), np.where(standing, 7.0, 1.2)
        if stance.name == "D1":
            P[robot.joint_index("fl_knee")] = 55.0
        for clock in (0.0, 0.37 * arc.duration, 1.02 * arc.duration):
            state = arc.states(np.array([clock]))[0][0] + generator.normal(0.0, 0.02, 36)
            angle, rate = (part[0] for part in arc.joints(np.array([clock])))
            expected = arc.torques(np.array([clock]))[0][0] - P * (state[6:18] - angle) - D * (state[24:] - rate)
            torque = np.asarray(domain.signals(clock, state, domain.parameters)[0]).ravel()
            # the defaults are rounded to a thousandth, and so are torques that nearly cancel
            np.testing.assert_allclose(torque, expected, rtol=1e-3, atol=1e-3)
            direction, step = generator.normal(0.0, 1.0, 36), 1e-6
            ahead, behind = (
                np.asarray(domain.field(clock, state + sign * step * direction, domain.parameters)).ravel()
                for sign in (1.0, -1.0)
            )
            slope = np.asarray(domain.jacobian(clock, state, domain.parameters)) @ direction
            np.testing.assert_allclose(slope, (ahead - behind) / (2.0 * step), atol=1e-6 * np.abs(slope).max())


def test_stretches_are_the_law_between_its_breakpoints(stabilised_gait: Gait, system: HybridSystem) -> None:
    """To rounding, also at both ends of a stretch from inside; the last ends with the references."""
    gait, draws = replace(stabilised_gait, control=LAW), np.random.default_rng(2)
    half, joints = gait.robot.size, len(gait.robot.joints)
    for domain, stance in zip(system.domains, gait.pattern.solved, strict=True):
        contacts = gait.pattern.contacts(stance)
        stretches = LAW.smooth(gait, Numbers(parameters=domain.parameters, breakpoints=domain.breakpoints))
        ends = [stretch.breakpoints[0] for stretch in stretches]
        assert (*ends, domain.breakpoints[-1]) == domain.breakpoints
        assert len(ends) > 2
        sizes = domain.parameters.size, stretches[0].parameters.size
        laws = []
        for size, law in zip(sizes, (LAW.torques, LAW.smooth_torques), strict=True):
            t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2 * half), ca.SX.sym("p", size)
            laws.append(ca.Function("torque", [t, x, p], [law(contacts, t, x[:half], x[half:], p)]))
        for begin, stretch, end in zip([0.0, *ends], stretches, ends, strict=False):
            for clock in (begin, *draws.uniform(begin, end, 3), np.nextafter(end, 0.0)):
                state = draws.normal(0.0, 0.3, 2 * half)
                whole = np.asarray(laws[0](clock, state, domain.parameters)).ravel()
                alone = np.asarray(laws[1](clock, state, stretch.parameters)).ravel()
                assert whole.shape == (joints,)
                np.testing.assert_allclose(alone, whole, rtol=1e-13, atol=1e-11)


def test_late_references_go_on_and_then_stand_still(stabilised_gait: Gait, system: HybridSystem) -> None:
    arc = orbit_arcs(stabilised_gait, stabilised_gait.law)[0]
    domain, end, state = system.domains[0], 1.05 * arc.duration, np.array(start_state(stabilised_gait))
    angle, rate = (part[0] for part in arc.joints(np.array([end])))
    torque = arc.torques(np.array([end]))[0][0]
    P, D = LAW.joint_gains(stabilised_gait.robot, stabilised_gait.pattern.solved[0])
    for share, moving in ((1.3, True), (1.6, False), (5.0, False)):
        gone = (min(share, HOLD) - 1.05) * arc.duration
        expected = torque - P * (state[6:18] - angle - gone * rate) - D * (state[24:] - moving * rate)
        found = np.asarray(domain.signals(share * arc.duration, state, domain.parameters)[0]).ravel()
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def assert_unmoved(gait: Gait, label: str) -> None:
    law = every_law(gait).laws[label]
    _, found = closed_loop_fixed_point(replace(gait, control=Impedance()), law=law)
    assert np.abs(found.state - start_state(gait))[2:].max() < 1e-8
    half = np.sort(np.abs(np.linalg.eigvals(found.monodromy.matrix)))[::-1]
    np.testing.assert_allclose(half[:3], 1.0, atol=1e-6)  # x, y, yaw
    assert half[3] ** 2 < 0.9


def test_the_orbit_stays_and_attracts(stabilised_gait: Gait) -> None:
    """Measured: 1e-11, and a radius of the full cycle of 0.813."""
    assert_unmoved(stabilised_gait, "pinv")


@pytest.mark.slow
@pytest.mark.parametrize("label", ["drop", "power (paper)", "power (datasheet)", "peak", "bounded"])
def test_the_orbit_stays_under_every_allocation_law(stabilised_gait: Gait, label: str) -> None:
    assert_unmoved(stabilised_gait, label)


def test_wrong_gains_are_refused(stabilised_gait: Gait, walking_gait: Gait) -> None:
    with pytest.raises(InputError, match="swing damping is -1; it must not be negative"):
        Impedance(swing_damping=-1.0)
    with pytest.raises(InputError, match=r"stance stiffness is 1e\+300; parameters of laws go up to"):
        Impedance(stance_stiffness=1e300)
    with pytest.raises(InputError, match="stiffness is 3, not a number for every joint"):
        Impedance(stiffness=3)  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match="unknown domain with a gain of its own 'D7'"):
        Impedance(damping={"D7 fl_knee": 1.0}).numbers(stabilised_gait, None)
    with pytest.raises(UnknownNameError, match="unknown joint with a damping of its own 'tail'"):
        Impedance(damping={"D1 tail": 1.0}).numbers(stabilised_gait, None)
    with pytest.raises(InputError, match="does not hold its closed loop's own orbit"):
        closed_loop(walking_gait, control=Impedance())
