"""The closed loop of a gait: compiled code against dense solves, the mirror, the symmetries, the optimised motion."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from examples.extending.phase_configuration import ConfigurationPhase

from amble.control.outputs import selection_matrix
from amble.control.phase import DomainPhase, TimePhase
from amble.control.stance_functions import fall_margin
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.constraints import loop_parameters
from amble.gait.linearising_law import keeps_phase
from amble.hybrid import FLAT, Contacts, Domain, HybridSystem, Plane, Stance, Symmetry
from amble.robot import Robot
from amble.simulation import simulate
from amble.types import Matrix, Vector
from amble.verification.output_dynamics import OutputDynamics
from amble.verification.stance_model import allocated, terms
from tests.phases import on_phase


@pytest.fixture(scope="module")
def full(walking_gait: Gait) -> HybridSystem:
    return closed_loop(walking_gait)


@pytest.fixture(scope="module")
def half(walking_gait: Gait) -> HybridSystem:
    return closed_loop(walking_gait, half=True)


def states(gait: Gait, name: str, count: int = 5) -> tuple[Vector, Matrix]:
    """Clocks and states near the optimised motion of a domain, mirrored for the second half of the cycle."""
    number = [stance.name for stance in gait.pattern.stances].index(name)
    solved = len(gait.domains)
    trajectory = gait.domains[number % solved]
    nodes = np.linspace(0, trajectory.times.size - 1, count).astype(int)
    x = np.hstack([trajectory.positions[nodes], trajectory.velocities[nodes]])
    if number >= solved:
        x = np.array([gait.robot.mirror.state(row) for row in x])
    return trajectory.times[nodes], x + np.random.default_rng(number).normal(0.0, 1e-2, x.shape)


def dense(gait: Gait, name: str, times: Vector, x: Matrix) -> tuple[Matrix, Matrix, Matrix]:
    """Accelerations, torques and forces of a stance by numpy, its outputs mirrored for the second half of the cycle."""
    robot, stances = gait.robot, gait.pattern.stances
    number = [stance.name for stance in stances].index(name)
    trajectory = gait.domains[number % len(gait.domains)]
    weights = selection_matrix(robot, gait.outputs.of(trajectory.name))
    references = weights.T @ trajectory.coefficients
    if number >= len(gait.domains):
        swap = robot.mirror.coordinates.matrix[3:, 3:]
        weights, references = weights @ swap.T, swap @ references
    q, v = x[:, : robot.size], x[:, robot.size :]
    loop = OutputDynamics(
        weights=weights,
        references=references,
        duration=trajectory.duration,
        gains=gait.gains,
        domain=DomainPhase(phase=gait.outputs.phase, robot=robot, stance=stances[number]),
        phase_numbers=trajectory.phase_numbers,
    )
    at = terms(gait.pattern.contacts(stances[number]), q, v)
    motion = allocated(at, loop.solve(at, times, q, v), gait.law)
    return motion.accelerations, motion.torques, motion.forces


def evaluated(function: ca.Function, domain: Domain, times: Vector, x: Matrix) -> list[Matrix]:
    """Every output of a function at all states, (states, width) each."""
    rows = [function(t, state, domain.parameters) for t, state in zip(times, x, strict=True)]
    rows = [row if isinstance(row, tuple) else (row,) for row in rows]
    return [np.array([np.asarray(row[k]).ravel() for row in rows]) for k in range(function.n_out())]


@pytest.mark.parametrize("name", ["D1", "D2", "D3", "D4"])
def test_every_domain_moves_as_numpy_says(walking_gait: Gait, full: HybridSystem, name: str) -> None:
    domain, robot = full.domain(name), walking_gait.robot
    times, x = states(walking_gait, name)
    accelerations, torques, forces = dense(walking_gait, name, times, x)
    (rate,) = evaluated(domain.field, domain, times, x)
    np.testing.assert_array_equal(rate[:, : robot.size], x[:, robot.size :])
    # condition of the contact equations times rounding; the references are written in a higher order, exact to 1e-14
    np.testing.assert_allclose(rate[:, robot.size :], accelerations, atol=1e-8 * np.abs(accelerations).max())
    assert domain.signals is not None
    recorded = dict(zip(domain.signals.name_out(), evaluated(domain.signals, domain, times, x), strict=True))
    np.testing.assert_allclose(recorded["torque"], torques, atol=1e-8 * np.abs(torques).max())
    feet = walking_gait.pattern.stance(name).feet
    for place, foot in enumerate(robot.foot_names):
        ours = recorded["force"][:, 3 * place : 3 * place + 3]
        stands = feet.index(foot) if foot in feet else None
        theirs = np.zeros_like(ours) if stands is None else forces[:, 3 * stands : 3 * stands + 3]
        np.testing.assert_allclose(ours, theirs, atol=1e-8 * np.abs(forces).max())
    at = terms(walking_gait.pattern.contacts(walking_gait.pattern.stance(name)), x[:, : robot.size], x[:, robot.size :])
    np.testing.assert_allclose(recorded["foot"], at.positions, atol=1e-12)
    np.testing.assert_allclose(recorded["foot_velocity"], at.rates, atol=1e-11)
    assert recorded["pivot"].min() > 1e-3


@pytest.mark.parametrize("name", ["D1", "D2", "D3", "D4"])
def test_the_jacobian_equals_central_differences(walking_gait: Gait, full: HybridSystem, name: str) -> None:
    domain, step = full.domain(name), 1e-5
    times, x = states(walking_gait, name, 1)
    assert domain.jacobian is not None
    ours = np.asarray(domain.jacobian(times[0], x[0], domain.parameters))
    moved = step * np.eye(x.shape[1])
    sides = [evaluated(domain.field, domain, np.repeat(times, len(moved)), x + sign * moved)[0] for sign in (1, -1)]
    differences = (sides[0] - sides[1]).T / (2.0 * step)
    # truncation step^2, rounding 1e-13 / step
    np.testing.assert_allclose(ours, differences, atol=1e-6 * np.abs(ours).max())


def test_the_cycle_has_four_domains_and_its_half_two(full: HybridSystem, half: HybridSystem) -> None:
    assert [domain.name for domain, _ in full.cycle()] == ["D1", "D2", "D3", "D4"]
    assert [domain.name for domain, _ in half.cycle()] == ["D1", "D2"]
    assert full.state_names[:4] == ("x", "y", "z", "roll")
    assert full.state_names[18] == "rate of x"


def test_a_whole_cycle_is_two_half_cycles(walking_gait: Gait, full: HybridSystem, half: HybridSystem) -> None:
    """Also from a perturbed start, where the two halves differ."""
    start = np.array(start_state(walking_gait))
    start[2:] += np.random.default_rng(0).normal(0.0, 1e-4, start.size - 2)
    whole, halves = simulate(full, start, 1, 1e-11), simulate(half, start, 2, 1e-11)
    assert whole.completed, whole.ended
    assert halves.completed, halves.ended
    np.testing.assert_allclose(
        [event.time for event in whole.events], [event.time for event in halves.events], atol=1e-8
    )
    np.testing.assert_allclose(whole.section[1], halves.section[2], atol=1e-7)
    third = whole.state[whole.domain == 2]
    mirrored = np.array([walking_gait.robot.mirror.state(row) for row in halves.state[halves.cycle == 1]])
    np.testing.assert_allclose(third, mirrored[: len(third)], atol=1e-7)


def test_the_first_cycle_follows_the_optimised_motion(walking_gait: Gait, full: HybridSystem) -> None:
    trace = simulate(full, start_state(walking_gait), 1, 1e-10)
    assert trace.completed, trace.ended
    for number, trajectory in enumerate(walking_gait.domains):
        here = trace.domain == number
        for joint in range(6, walking_gait.robot.size):
            planned = np.interp(trace.clock[here], trajectory.times, trajectory.positions[:, joint])
            # the promise of the project; the transcription's own error is 1e-5, linear interpolation adds 1e-3
            assert np.abs(trace.state[here, joint] - planned).max() < 2e-3
        assert trace.clock[here][-1] == pytest.approx(trajectory.duration, abs=1e-3)


def test_symmetries_are_symmetries_of_the_vector_field(walking_gait: Gait, full: HybridSystem) -> None:
    """The Lie bracket of field and generator vanishes in every domain: Df xi = Dxi f."""
    assert [symmetry.name for symmetry in full.symmetries] == ["x", "y", "yaw"]
    for symmetry in full.symmetries:
        symbol = ca.SX.sym("x", full.state_size)
        slope = ca.Function("slope", [symbol], [ca.densify(ca.jacobian(symmetry.generator(symbol), symbol))])
        for domain in full.domains:
            times, x = states(walking_gait, domain.name)
            for t, state in zip(times, x, strict=True):
                assert domain.jacobian is not None
                jacobian = np.asarray(domain.jacobian(t, state, domain.parameters))
                generator = np.asarray(symmetry.generator(state)).ravel()
                field = np.asarray(domain.field(t, state, domain.parameters)).ravel()
                bracket = jacobian @ generator - np.asarray(slope(state)) @ field
                # cancellation of terms of the Jacobian's size
                np.testing.assert_allclose(bracket, 0.0, atol=1e-10 * np.abs(jacobian).max())


def test_weights_on_the_orientation_break_the_yaw_symmetry(stabilised_gait: Gait) -> None:
    assert [symmetry.name for symmetry in closed_loop(stabilised_gait, half=True).symmetries] == ["x", "y"]


def test_a_stabilised_gait_starts_at_its_own_fixed_point(stabilised_gait: Gait) -> None:
    feedback = stabilised_gait.feedback
    assert feedback is not None
    np.testing.assert_array_equal(start_state(stabilised_gait), feedback.start)
    packed = loop_parameters(stabilised_gait, "D1")
    assert packed[0] == feedback.durations["D1"]
    assert tuple(packed[1:3]) == stabilised_gait.gains
    null_space = packed[-4 * 15 :].reshape((15, 4), order="F")
    assert np.linalg.matrix_rank(null_space) == 4
    np.testing.assert_allclose(feedback.weights["D1"] @ null_space, 0.0, atol=1e-12)  # rounding of weights of order 1
    trace = simulate(closed_loop(stabilised_gait, half=True), feedback.start, 1, 1e-11)
    advance = trace.section[1] - feedback.start
    # x advances and y is free; the fixed point was found at a tolerance of 1e-10
    np.testing.assert_allclose(advance[2:], 0.0, atol=1e-8)


def test_gains_come_from_the_gait(walking_gait: Gait) -> None:
    stiffer = replace(walking_gait, gains=(200.0, 30.0))
    assert tuple(loop_parameters(stiffer, "D2")[:3]) == (walking_gait.domains[1].duration, 200.0, 30.0)


def test_the_margin_to_a_fall_counts_from_the_ground(walking_gait: Gait) -> None:
    """The same pose on a slope, turned and raised with it, has the same margin; below 6 % of a leg it has fallen."""
    robot, slope = walking_gait.robot, Plane(slope=0.3)
    margins = {}
    for ground in (FLAT, slope):
        contacts = Contacts(robot, ("fr", "rl"), ground=ground)
        q = ca.SX.sym("q", robot.size)
        margins[ground] = ca.Function("margin", [q], [fall_margin(contacts, q)])
    q = np.zeros(robot.size)
    for pitch in (0.0, 0.4, 1.2, 1.4):
        q[:3], q[4] = [0.3, -0.1, 0.5], pitch
        upright = float(margins[FLAT](q))
        q[2] += float(slope.height(q[0], q[1]))
        q[4] = pitch - 0.3  # the slope rises along x: nose up
        assert float(margins[slope](q)) == pytest.approx(upright, abs=1e-12)
    q[:] = 0.0
    for height, sign in ((0.059, -1.0), (0.061, 1.0)):
        q[2] = height * robot.leg_length
        assert np.sign(float(margins[FLAT](q))) == sign


def test_a_gait_without_the_numbers_of_its_phase_is_refused(walking_gait: Gait) -> None:
    outputs = replace(walking_gait.outputs, phase=ConfigurationPhase({"D1": {"y": -1.0}}))
    with pytest.raises(InputError, match="domain 'D1' has 0 numbers for phase 'configuration', not 2"):
        replace(walking_gait, outputs=outputs)


def test_numbers_at_which_the_phase_has_no_value_are_refused(walking_gait: Gait) -> None:
    """A range of nothing divides by zero; in a domain that runs on time it is not looked at."""
    gait = on_phase(walking_gait, {"D1": {"y": -1.0}})
    still = [replace(domain, phase_numbers=np.array([0.25, 0.25])) for domain in gait.domains]
    with pytest.raises(InputError, match=r"of domain 'D1' is not finite with theta_start = 0\.25"):
        replace(gait, domains=(still[0], gait.domains[1]))
    assert replace(gait, domains=(gait.domains[0], still[1])).domains[1] is still[1]


class SwitchedPhase(TimePhase):
    """The clock's phase, with a step where the base turns to the other side: no slope shows it."""

    def value(self, robot: Robot, stance: Stance, share: ca.SX, q: ca.SX, numbers: ca.SX) -> ca.SX:
        """Add it."""
        return super().value(robot, stance, share, q, numbers) + 1e-3 * ca.sign(q[robot.coordinate_index("yaw")])


def test_what_changes_the_phase_is_no_symmetry(walking_gait: Gait) -> None:
    """The base over its feet along y keeps still where the robot is moved, not where it turns."""
    size = walking_gait.robot.size
    x = ca.SX.sym("x", 2 * size)
    step, turn = ca.SX(2 * size, 1), ca.SX(2 * size, 1)
    step[1], turn[5] = 1.0, 1.0
    along_y = Symmetry("y", ca.Function("y", [x], [ca.densify(step)]))
    along_yaw = Symmetry("yaw", ca.Function("yaw", [x], [ca.densify(turn)]))
    swaying, turning = (on_phase(walking_gait, {"D1": {name: 1.0}}) for name in ("y", "yaw"))
    assert keeps_phase(walking_gait, along_yaw)
    assert keeps_phase(swaying, along_y)
    assert not keeps_phase(swaying, along_yaw)
    assert keeps_phase(turning, along_y)
    assert not keeps_phase(turning, along_yaw)
    switched = replace(walking_gait, outputs=replace(walking_gait.outputs, phase=SwitchedPhase()))
    assert keeps_phase(switched, along_y)
    assert not keeps_phase(switched, along_yaw)
