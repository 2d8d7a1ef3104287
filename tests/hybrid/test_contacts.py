"""Feet on a ground: a slope is a tilted gravity, many feet have their internal forces, labels and mirrors fit."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from amble.control import PseudoInverse
from amble.control.linearisation import linearise
from amble.control.phase import DomainPhase, TimePhase
from amble.control.virtual_constraints import VirtualConstraints, pack
from amble.hybrid import Contacts, Plane, Stance, constrained_dynamics, impact
from amble.robot import Robot, dynamics, kinematics
from amble.types import Matrix, Vector, frozen
from amble.verification.output_dynamics import OutputDynamics
from amble.verification.stance_model import terms
from tests.control.allocation.stances import random_postures
from tests.robots import hexapod, robot

SLOPE = Plane(slope=0.3, heading=0.8)

# Rounding times the condition of the contact equations, as in test_constrained_dynamics.
TOLERANCE = 1e-10


def numeric(function: ca.Function, *arguments: Vector) -> list[Matrix]:
    return [np.asarray(part.full()) for part in function.call(list(arguments))]


def tilted(of: Robot, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """The same state seen from the slope's frame: the world that the slope calls level turned onto the slope."""
    frame = np.asarray(SLOPE.frame(np.zeros(3)))
    image, rates = q.copy(), v.copy()
    turned = frame @ np.asarray(ca.DM(kinematics.base_rotation(q)))
    # R = Rx(roll) Ry(pitch) Rz(yaw)
    image[3:6] = (
        np.arctan2(-turned[1, 2], turned[2, 2]),
        np.arcsin(turned[0, 2]),
        np.arctan2(-turned[0, 1], turned[0, 0]),
    )
    image[:3], rates[:3] = frame @ q[:3], frame @ v[:3]
    rates[3:6] = np.linalg.solve(axes(of, image), frame @ axes(of, q) @ v[3:6])
    return image, rates


def axes(of: Robot, q: Vector) -> Matrix:
    """Angular velocity of the base over the rates of roll, pitch and yaw, world axes."""
    return np.asarray(ca.DM(kinematics.foot_rotation_jacobian(of, of.foot_names[0], q)).full())[:, 3:6]


def spin_bias(of: Robot, q: Vector, v: Vector, step: float = 1e-6) -> Vector:
    """d(axes)/dt times the rates, by central differences."""
    return (axes(of, q + step * v) - axes(of, q - step * v)) @ v[3:6] / (2.0 * step)


def level_dynamics(of: Robot, contacts: Contacts, q: Vector, v: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Acceleration and forces on level ground under a gravity that leans as it does on the slope, dense."""
    gravity = np.asarray(SLOPE.frame(np.zeros(3))).T @ [0.0, 0.0, -of.gravity]
    symbol = ca.SX.sym("q", of.size)
    poses = [kinematics.link_pose(of, k, symbol) for k in range(len(of.links))]
    potential = -sum(
        link.mass * ca.dot(ca.DM(gravity), origin + rotation @ ca.DM(link.center))
        for link, (rotation, origin) in zip(of.links, poses, strict=True)
    )
    pull = np.asarray(ca.Function("pull", [symbol], [ca.gradient(potential, symbol)])(q)).ravel()
    weightless = replace(of, gravity=1e-300)
    D = np.asarray(ca.DM(dynamics.mass_matrix(of, q)))
    h = np.asarray(ca.DM(dynamics.bias(weightless, q, v))).ravel() + pull
    J, bias = (np.asarray(ca.DM(part).full()) for part in (contacts.jacobian(q), contacts.bias(q, v)))
    n, c = of.size, contacts.size
    system = np.block([[D, -J.T], [J, np.zeros((c, c))]])
    right = np.concatenate([np.concatenate([np.zeros(6), u]) - h, -bias.ravel()])
    solution = np.linalg.solve(system, right)
    return solution[:n], solution[n:]


@pytest.mark.parametrize("count", [2, 3, 4])
def test_a_slope_is_level_ground_under_a_gravity_that_leans(count: int) -> None:
    of = robot("astro")
    feet = {2: ("fl", "rr"), 3: ("fl", "fr", "rr"), 4: of.foot_names}[count]
    contacts = Contacts(of, tuple(f for f in of.foot_names if f in feet), ground=SLOPE)
    level = replace(contacts, ground=Plane())
    frame = np.asarray(SLOPE.frame(np.zeros(3)))
    q, v, u = ca.SX.sym("q", of.size), ca.SX.sym("v", of.size), ca.SX.sym("u", 12)
    motion = constrained_dynamics(contacts, q, v)
    force = motion.free_force + motion.force_map @ u
    local = ca.vertcat(*contacts.local(force, contacts.points(q)))
    after, impulse = impact(contacts, q, v)
    parts = [motion.free_acceleration + motion.input_map @ u, force, local, after, impulse]
    function = ca.Function("slope", [q, v, u], [ca.densify(part) for part in parts])
    flat_impact = ca.Function("level", [q, v], [ca.densify(part) for part in impact(level, q, v)])
    bases = [ca.Function("W", [q], [ca.densify(c.internal_forces(c.points(q)))]) for c in (level, contacts)]
    generator = np.random.default_rng(count)
    for pose, rate in zip(*random_postures("astro", 5, seed=count), strict=True):
        torque = generator.normal(0.0, 10.0, 12)
        image, image_rate = tilted(of, pose, rate)
        acceleration, found, along, stopped, push = (
            part.ravel() for part in numeric(function, image, image_rate, torque)
        )
        expected, forces = level_dynamics(of, level, pose, rate, torque)
        size = np.abs(expected).max()
        np.testing.assert_allclose(acceleration[6:], expected[6:], atol=TOLERANCE * size)
        np.testing.assert_allclose(acceleration[:3], frame @ expected[:3], atol=TOLERANCE * size)
        spin = axes(of, image) @ acceleration[3:6] + spin_bias(of, image, image_rate)
        level_spin = axes(of, pose) @ expected[3:6] + spin_bias(of, pose, rate)
        np.testing.assert_allclose(spin, frame @ level_spin, atol=1e-7 * size)  # the differences in spin_bias
        turned = (forces.reshape(-1, 3) @ frame.T).ravel()
        np.testing.assert_allclose(found, turned, atol=TOLERANCE * np.abs(turned).max())
        np.testing.assert_allclose(along, forces, atol=TOLERANCE * np.abs(forces).max())
        level_stop, level_push = (part.ravel() for part in numeric(flat_impact, pose, rate))
        np.testing.assert_allclose(stopped[6:], level_stop[6:], atol=TOLERANCE * np.abs(level_stop).max())
        turned = (level_push.reshape(-1, 3) @ frame.T).ravel()
        np.testing.assert_allclose(push, turned, atol=TOLERANCE * np.abs(turned).max())
        one, two = numeric(bases[0], pose)[0], numeric(bases[1], image)[0]
        one = np.kron(np.eye(count), frame) @ one
        one, two = (np.linalg.qr(basis)[0] for basis in (one, two))  # the same span
        np.testing.assert_allclose(one @ (one.T @ two), two, atol=TOLERANCE)
        for foot in of.foot_names:
            height = np.asarray(kinematics.foot_position(of, foot, pose)).ravel()[2]
            gap = SLOPE.gap(np.asarray(kinematics.foot_position(of, foot, image)).ravel())
            assert gap == pytest.approx(height, abs=1e-14)


@pytest.mark.parametrize("feet", [("fl", "fr", "rl", "ml", "mr"), hexapod().foot_names])
def test_internal_forces_of_five_and_six_feet(feet: tuple[str, ...]) -> None:
    of = hexapod()
    contacts = Contacts(of, tuple(foot for foot in of.foot_names if foot in feet))
    free = 3 * len(feet) - 6
    assert contacts.internal_force_count == free
    q, v = ca.SX.sym("q", of.size), ca.SX.sym("v", of.size)
    motion, (N, W) = constrained_dynamics(contacts, q, v), contacts.torque_null_space(q)
    parts = [motion.input_map, motion.force_map, N, W]
    function = ca.Function("hexapod", [q, v], [ca.densify(part) for part in parts])
    for pose, rate in standing(of, 5):
        G, slope, null, basis = numeric(function, pose, rate)
        np.testing.assert_allclose(basis.T @ basis, np.eye(free), atol=1e-12)
        assert np.linalg.matrix_rank(null) == free
        assert np.abs(G @ null).max() < TOLERANCE * np.abs(G).max() * np.abs(null).max()
        np.testing.assert_allclose(slope @ null, basis, atol=1e-8)  # condition of the contact equations


@pytest.mark.parametrize("feet", [("fl", "fr", "rl", "ml", "mr"), hexapod().foot_names])
def test_the_closed_loop_of_a_hexapod_moves_as_numpy_says(feet: tuple[str, ...]) -> None:
    of = hexapod()
    contacts = Contacts(of, tuple(foot for foot in of.foot_names if foot in feet))
    outputs = len(of.joints) - contacts.internal_force_count
    q, v, t = ca.SX.sym("q", of.size), ca.SX.sym("v", of.size), ca.SX.sym("t")
    constraints = VirtualConstraints.symbols(outputs, of.size - 3, 4)
    stance = Stance("S", contacts.feet)
    loop = linearise(contacts, PseudoInverse(), q, v, constraints.phase_rates(of, stance, t, q, v), constraints)
    parts = [loop.acceleration, loop.torques, loop.forces]
    function = ca.Function("loop", [q, v, t, constraints.packed()], [ca.densify(part) for part in parts])
    generator = np.random.default_rng(3)
    weights = generator.normal(size=(outputs, of.size - 3))
    for pose, rate in standing(of, 3):
        references = pose[3:, None] + generator.normal(0.0, 0.1, (of.size - 3, 5))
        ours = [
            part.ravel() for part in numeric(function, pose, rate, 0.1, pack(0.2, (100.0, 20.0), references, weights))
        ]
        dense = OutputDynamics(
            weights=weights,
            references=references,
            duration=0.2,
            gains=(100.0, 20.0),
            domain=DomainPhase(phase=TimePhase(), robot=of, stance=stance),
            phase_numbers=frozen([]),
        )
        motion = dense.solve(terms(contacts, pose[None], rate[None]), np.array([0.1]), pose[None], rate[None])
        for mine, theirs in zip(ours, (motion.accelerations, motion.torques, motion.forces), strict=True):
            np.testing.assert_allclose(mine, theirs[0], atol=1e-8 * np.abs(theirs).max())


def standing(of: Robot, count: int) -> list[tuple[Vector, Vector]]:
    """Random states about a posture with bent knees."""
    generator = np.random.default_rng(7)
    base, _ = random_postures("astro", 1, 0)
    found = []
    for _ in range(count):
        legs = {name: base[0, 6 + robot("astro").joint_index(name)] for name in robot("astro").joint_names}
        legs |= {name.replace("f", "m", 1): angle for name, angle in legs.items() if name.startswith("f")}
        pose = np.concatenate([np.zeros(6), [legs[name] for name in of.joint_names]])
        found.append((pose + generator.normal(0.0, 0.15, of.size), generator.normal(0.0, 1.0, of.size)))
    return found


def test_places_and_labels_fit() -> None:
    of = robot("astro")
    contacts = Contacts(of, ("fr", "rl"))
    assert contacts.labels == ("fr x", "fr y", "fr z", "rl x", "rl y", "rl z")
    assert contacts.slice("rl") == slice(3, 6)
    assert contacts.labels[contacts.normal_index("rl")] == "rl z"
    whole = contacts.every_foot.labels
    assert tuple(whole[column] for column in contacts.columns) == contacts.labels
    forces = ca.SX.sym("f", 6)
    spread = np.asarray(ca.Function("spread", [forces], [contacts.on_every_foot(forces)])(np.arange(1.0, 7.0))).ravel()
    assert spread[contacts.columns].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert np.count_nonzero(spread) == 6


def test_the_mirror_of_point_forces_is_that_of_points_at_the_feet() -> None:
    of = robot("astro")
    found = Contacts(of, ()).mirror
    assert found.index.tolist() == of.mirror.forces.index.tolist()
    assert found.sign.tolist() == of.mirror.forces.sign.tolist()


def test_the_rotation_jacobian_gives_the_angular_velocity() -> None:
    """R(t)' R^T of the foot's link, by differences."""
    of = robot("astro")
    for q, v in zip(*random_postures("astro", 5, seed=9), strict=True):
        for foot in of.feet:
            step = 1e-6
            ends = [np.asarray(kinematics.link_pose(of, foot.link, q + s * v)[0]) for s in (-step, step)]
            here = np.asarray(kinematics.link_pose(of, foot.link, q)[0])
            skew = (ends[1] - ends[0]) / (2.0 * step) @ here.T
            omega = np.asarray(ca.DM(kinematics.foot_rotation_jacobian(of, foot.name, q)).full()) @ v
            np.testing.assert_allclose(omega, [skew[2, 1], skew[0, 2], skew[1, 0]], atol=1e-7)
