"""Other laws along a motion: same generalised forces, the law's own property, and back again."""

import dataclasses

import casadi as ca
import numpy as np
import pytest

from amble.analysis import Samples, samples_of_gait
from amble.analysis.reallocation import reallocate
from amble.control import DropActuator, PseudoInverse
from amble.control.linearisation import linearise
from amble.control.virtual_constraints import VirtualConstraints, pack
from amble.errors import InputError
from amble.robot import catalogue, kinematics
from tests.synthetic import STANCES, amble_pattern, synthetic_gait

DROPPED = DropActuator(("rl_hip_pitch", "rr_hip_pitch"))


@pytest.fixture(scope="module")
def samples() -> Samples:
    return samples_of_gait(synthetic_gait(9))


def leg_forces(samples: Samples, row: int, torques: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """B u + J^T lambda of all feet at one sample, (18,)."""
    robot, q = samples.robot, samples.positions[row]
    found = np.concatenate([np.zeros(6), torques[row]])
    for foot, force in zip(robot.foot_names, forces[row].reshape(4, 3), strict=True):
        found += np.asarray(kinematics.foot_jacobian(robot, foot, q)).T @ force
    return found


@pytest.mark.parametrize("law", [PseudoInverse(), DROPPED], ids=["pinv", "drop"])
def test_no_law_changes_the_generalised_forces(samples: Samples, law: PseudoInverse | DropActuator) -> None:
    """Equal B u + J^T lambda means equal accelerations, whatever the dynamics."""
    found = reallocate(samples, [law])[law.name]
    assert not np.allclose(found.torques, samples.torques)
    for row in range(len(samples.times)):
        before = leg_forces(samples, row, samples.torques, samples.forces)
        after = leg_forces(samples, row, found.torques, found.forces)
        # forces of 1e2 N through well-conditioned 1 x 1 systems
        assert np.allclose(after, before, atol=1e-10)
        swing = [foot not in STANCES[samples.stances[row]] for foot in samples.robot.foot_names]
        assert np.all(found.forces[row].reshape(4, 3)[swing] == 0.0)


def test_each_law_keeps_its_promise(samples: Samples) -> None:
    found = reallocate(samples, [DROPPED, PseudoInverse()])
    drop, pinv = found["drop"].torques, found["pinv"].torques
    joints = samples.robot.joint_names
    for row, stance in enumerate(samples.stances):
        rear = next(foot for foot in STANCES[stance] if foot.startswith("r"))
        assert abs(drop[row, joints.index(f"{rear}_hip_pitch")]) < 1e-11
        # the difference of two realisations is a null torque, and the smallest one is orthogonal to it
        assert abs(pinv[row] @ (drop[row] - pinv[row])) < 1e-8
    assert np.all(np.linalg.norm(pinv, axis=1) <= np.linalg.norm(drop, axis=1) + 1e-12)
    assert np.max(np.linalg.norm(drop, axis=1) - np.linalg.norm(pinv, axis=1)) > 1.0


def test_where_one_starts_does_not_matter(samples: Samples) -> None:
    """From the dropped actuator's torques one gets to the pseudo-inverse's as from the recorded ones."""
    found = reallocate(samples, [DROPPED, PseudoInverse()])
    dropped = dataclasses.replace(samples, torques=found["drop"].torques, forces=found["drop"].forces)
    again = reallocate(dropped, [PseudoInverse()])["pinv"]
    assert np.allclose(again.torques, found["pinv"].torques, atol=1e-10)
    assert np.allclose(again.forces, found["pinv"].forces, atol=1e-9)


def test_normal_forces_do_not_change_on_level_feet(samples: Samples) -> None:
    """The force_basis runs along the line between the feet: its vertical part is that line's slope."""
    found = reallocate(samples, [PseudoInverse()])["pinv"]
    change = (found.forces - samples.forces).reshape(-1, 4, 3)
    for row, stance in enumerate(samples.stances):
        first, second = (samples.robot.foot_names.index(foot) for foot in STANCES[stance])
        assert np.allclose(change[row, first], -change[row, second], atol=1e-10)
        feet = [
            np.asarray(kinematics.foot_position(samples.robot, foot, samples.positions[row])).ravel()
            for foot in STANCES[stance]
        ]
        assert np.allclose(np.cross(change[row, first], feet[1] - feet[0]), 0.0, atol=1e-9)


def test_two_laws_of_one_name_are_refused(samples: Samples) -> None:
    with pytest.raises(InputError, match="same name: pinv, pinv"):
        reallocate(samples, [PseudoInverse(), PseudoInverse()])


@pytest.mark.parametrize("stance", [0, 1])
def test_the_controller_itself_agrees(stance: int) -> None:
    """The closed loop with the dropped actuator applies what reallocation finds from the pseudo-inverse's torques."""
    pattern = amble_pattern()
    robot, feet = pattern.robot, pattern.stances[stance].feet
    clock, x = ca.SX.sym("t"), ca.SX.sym("x", 2 * robot.size)
    q, v = x[: robot.size], x[robot.size :]
    constraints = VirtualConstraints.symbols(11, robot.size - 3, 4)
    phase = constraints.phase_rates(robot, pattern.stances[stance], clock, q, v)
    loops = {
        law.name: ca.Function("loop", [clock, x, constraints.packed()], [loop.torques, loop.forces])
        for law in (PseudoInverse(), DROPPED)
        for loop in (linearise(pattern.contacts(pattern.stances[stance]), law, q, v, phase, constraints),)
    }
    random = np.random.default_rng(stance)
    standing = catalogue.posture("astro").coordinates(robot)
    states = np.concatenate([standing, np.zeros(robot.size)]) + 0.1 * random.normal(size=(20, 2 * robot.size))
    free = [joint for joint in DROPPED.joints if joint.startswith(tuple(feet))]
    outputs = [index for index, name in enumerate(robot.coordinate_names[3:]) if name in robot.joint_names]
    outputs.remove(robot.coordinate_index(free[0]) - 3)
    weights = np.eye(robot.size - 3)[outputs]
    references = standing[3:, None] + 0.05 * random.normal(size=(robot.size - 3, 5))
    parameters = pack(0.2, (100.0, 20.0), references, weights)
    applied = {name: [np.asarray(value).T for value in loop(0.1, states.T, parameters)] for name, loop in loops.items()}
    columns = [3 * robot.foot_names.index(foot) + axis for foot in feet for axis in range(3)]
    forces = np.zeros((len(states), 12))
    forces[:, columns] = applied["pinv"][1]
    number = np.zeros(len(states), dtype=np.int64)
    samples = Samples(
        label="random",
        pattern=pattern,
        times=np.arange(len(states), dtype=np.float64),
        segments=number,
        stances=number + stance,
        cycles=number,
        positions=states[:, : robot.size],
        velocities=states[:, robot.size :],
        torques=applied["pinv"][0],
        forces=forces,
    )
    found = reallocate(samples, [DROPPED])["drop"]
    # torques and forces of up to a few 1e2, through a solve of a 12 x 12 matrix in the controller
    assert np.allclose(found.torques, applied["drop"][0], rtol=1e-9, atol=1e-8)
    assert np.allclose(found.forces[:, columns], applied["drop"][1], rtol=1e-9, atol=1e-8)
    assert np.max(np.abs(applied["drop"][0] - applied["pinv"][0])) > 1.0
