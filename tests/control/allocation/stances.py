"""Random states of robots that stand, with all torques that realise their motion: material for the law tests."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from amble.control import AllocationLaw, Redundancy
from amble.hybrid import Contacts, constrained_dynamics
from amble.robot import Robot
from amble.robot.proposal import nominal_posture
from amble.types import Matrix, Vector
from tests import robots

FEET = {2: ("fl", "rr"), 3: ("fl", "fr", "rr"), 4: ("fl", "fr", "rl", "rr")}
FRICTION, NORMAL = 0.6, 5.0
_KNEE = {"astro": (0.5, 0.38, 1.16), "go2": (0.0, 0.8, -1.6), "anymal_b": (0.0, 0.5, -1.0), "solo12": (0.0, 0.8, -1.6)}
NAMES = ("astro", "go2", "anymal_b")
FOREIGN = [each for each in robots.FOREIGN_QUADRUPEDS if each.values[0] != "solo8"]
"""Robots of twelve joints for `make slow`."""
PARTS = ("torques", "torque_basis", "forces", "force_basis", "speeds")


@dataclass(frozen=True)
class Sample:
    """One motion: u_p, N, lambda_p, W and joint speeds."""

    torques: Vector
    torque_basis: Matrix
    forces: Vector
    force_basis: Matrix
    speeds: Vector

    def parts(self) -> dict[str, np.ndarray]:
        """Field by field, in the order of the functions' arguments."""
        return {name: getattr(self, name) for name in PARTS}


def stance_feet(of: Robot, count: int) -> tuple[str, ...]:
    """Feet of a stance in the robot's order."""
    return tuple(foot for foot in of.foot_names if foot in FEET[count])


@lru_cache(maxsize=16)
def dynamics(name: str, count: int) -> ca.Function:
    """(q, v) -> f0, G, lambda_0, d lambda / d u, N, W."""
    robot = robots.robot(name)
    q, v = ca.SX.sym("q", robot.size), ca.SX.sym("v", robot.size)
    contacts = Contacts(robot, stance_feet(robot, count))
    motion = constrained_dynamics(contacts, q, v)
    null, force_basis = contacts.torque_null_space(q)
    parts = [motion.free_acceleration, motion.input_map, motion.free_force, motion.force_map, null, force_basis]
    return ca.Function("dynamics", [q, v], parts)


@lru_cache(maxsize=32)
def chooser(name: str, count: int, law: AllocationLaw) -> ca.Function:
    """(u_p, N, lambda_p, W, speeds) -> s and the law's diagnostics."""
    robot, pattern = robots.robot(name), dynamics(name, count)
    symbols = [
        ca.SX.sym("u", 12),
        ca.SX.sym("N", pattern.sparsity_out(4)),
        ca.SX.sym("lambda", 3 * count),
        ca.SX.sym("W", pattern.sparsity_out(5)),
        ca.SX.sym("speeds", 12),
    ]
    parts = dict(zip(PARTS, symbols, strict=True))
    redundancy = Redundancy(contacts=Contacts(robot, stance_feet(robot, count)), points=ca.SX(3 * count, 1), **parts)
    s = law.allocate(redundancy)
    return ca.Function("allocate", symbols, [s, *law.diagnostics(redundancy, s).values()])


def allocate(name: str, count: int, law: AllocationLaw, sample: Sample) -> list[Vector]:
    """Evaluate a law at one sample: s, then its diagnostics."""
    found = chooser(name, count, law).call([ca.DM(part) for part in sample.parts().values()])
    return [np.asarray(part.full()).ravel() for part in found]


def random_postures(name: str, count: int, seed: int) -> tuple[Matrix, Matrix]:
    """Coordinates and rates about a walking posture, (count, n_q) each; feet near, not on, a common level."""
    robot = robots.robot(name)
    generator = np.random.default_rng(seed)
    q = generator.normal(0.0, 0.15, (count, robot.size))
    if name not in _KNEE:
        return q + nominal_posture(robot).coordinates(robot), generator.normal(0.0, 1.0, (count, robot.size))
    for leg, joints in robot.legs.items():
        mirrored = 1.0 if name != "astro" or leg in ("fl", "rr") else -1.0
        angles = _KNEE[name] if name != "anymal_b" or leg[0] == "f" else tuple(-a for a in _KNEE[name])
        for angle, joint, sign in zip(angles, joints, (mirrored, 1.0, 1.0), strict=True):
            q[:, 6 + robot.joint_index(joint)] += sign * angle
    return q, generator.normal(0.0, 1.0, (count, robot.size))


def samples(name: str, count: int, number: int, seed: int = 0, spread: float = 0.25) -> list[Sample]:
    """Motions of a robot that carries itself about evenly on its feet, disturbed by random torques.

    Args:
        name: robot of ``tests.robots``.
        count: stance feet.
        number: how many samples.
        seed: of the generator.
        spread: size of the disturbance relative to the effort limits and to the weight.
    """
    robot, function = robots.robot(name), dynamics(name, count)
    generator = np.random.default_rng(seed + 1)
    effort = np.array([min(joint.effort, robot.mass * robot.gravity * robot.leg_length) for joint in robot.joints])
    if name in _KNEE:
        effort = np.array([joint.effort for joint in robot.joints])
    found = []
    for q, v in zip(*random_postures(name, number, seed), strict=True):
        _, _, free, slope, null, force_basis = (np.asarray(part.full()) for part in function(q, v))
        share = robot.mass * robot.gravity / count
        wanted = np.tile([0.0, 0.0, share], count) + generator.normal(0.0, spread * share, 3 * count)
        torques = np.linalg.lstsq(slope, wanted - free[:, 0], rcond=1e-8)[0]
        torques += generator.normal(0.0, spread, 12) * effort * generator.uniform(0.0, 1.0)
        found.append(Sample(torques, null, free[:, 0] + slope @ torques, force_basis, v[6:]))
    return found
