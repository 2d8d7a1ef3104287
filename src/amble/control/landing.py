"""Parts of a landing: the motion until the last feet land, the impact that stops feet, a foot's gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca

from amble.codegen import compile_all
from amble.hybrid import Contacts, constrained_dynamics, impact
from amble.numerics.linear_algebra import SymmetricFactor
from amble.robot import Robot, dynamics, kinematics


@lru_cache(maxsize=32)
def plant(contacts: Contacts) -> ca.Function:
    """Write the motion on some feet as a function: (x, u) -> dx/dt, contact forces of all feet in the world frame.

    Args:
        contacts: the feet on the ground.
    """
    robot = contacts.robot
    x, u = ca.SX.sym("x", 2 * robot.size), ca.SX.sym("u", len(robot.joints))
    q, v = x[: robot.size], x[robot.size :]
    motion = constrained_dynamics(contacts, q, v)
    acceleration = motion.free_acceleration + motion.input_map @ u
    forces = contacts.on_every_foot(motion.free_force + motion.force_map @ u)
    rate = ca.densify(ca.vertcat(v, acceleration))
    return ca.Function("plant", [x, u], ca.cse([rate, ca.densify(forces)]), ["x", "u"], ["rate", "force"])


@dataclass(frozen=True, kw_only=True)
class LandingMotion:
    """The motion of a robot on the feet that have landed so far.

    Attributes:
        acceleration: q'', (n_q,).
        torques: (n_joints,), N m: those given, but of the legs in the air.
        forces: contact forces of the feet on the ground, world frame, (n_f,), N.
    """

    acceleration: ca.SX
    torques: ca.SX
    forces: ca.SX


def legs_in_the_air(robot: Robot, feet: Sequence[str], down: Sequence[str]) -> tuple[int, ...]:
    """Return the coordinates of the joints that move one of some feet and none of those on the ground.

    Args:
        robot: the robot.
        feet: feet in the air.
        down: feet on the ground.
    """
    standing = {joint for foot in down for joint in robot.legs[foot]}
    moved = {joint for foot in feet for joint in robot.legs[foot]} - standing
    return tuple(robot.coordinate_index(name) for name in robot.joint_names if name in moved)


def landing_motion(contacts: Contacts, late: Sequence[str], q: ca.SX, v: ca.SX, u: ca.SX) -> LandingMotion:
    """Write the motion until the next foot lands (docs/theory/hybrid-model.md, eq. 22).

    The legs of the feet that have still to land go on at their joints' rates: a stance's torques would throw a leg that
    carries nothing. All other joints have the torques given. With c the coordinates of those legs' joints, whose
    accelerations are 0, and r the others: D_rr a_r = (B u - h)_r + J_r^T lambda, J_r a_r = -Jdot v.

    Args:
        contacts: the feet on the ground.
        late: the feet that have still to land.
        q: coordinates, (n_q,).
        v: their rates, (n_q,).
        u: torques, (n_joints,), N m.
    """
    # shorthand
    robot, c = contacts.robot, legs_in_the_air(contacts.robot, late, contacts.feet)
    r = [k for k in range(robot.size) if k not in c]
    D, h, J = dynamics.mass_matrix(robot, q), dynamics.bias(robot, q, v), contacts.jacobian(q)
    base = robot.size - len(robot.joints)

    mass = SymmetricFactor.of(D[r, r], list(range(len(r) - 1, -1, -1)))  # from the feet upwards: without fill
    moved = mass.solve(J[:, r].T)
    free = mass.solve((ca.vertcat(ca.SX(base, 1), u) - h)[r])
    forces = SymmetricFactor.of(J[:, r] @ moved).solve(-contacts.bias(q, v) - J[:, r] @ free)
    a = ca.SX(robot.size, 1)
    a[r] = free + moved @ forces
    torques = ca.SX(u)
    for k in c:
        torques[k - base] = D[k, :] @ a + h[k] - J[:, k].T @ forces
    return LandingMotion(acceleration=a, torques=torques, forces=forces)


@lru_cache(maxsize=32)
def landing_plant(contacts: Contacts, late: tuple[str, ...]) -> ca.Function:
    """Write ``landing_motion`` as a function: (x, u) -> dx/dt, contact forces of all feet (world frame), torques.

    Args:
        contacts: the feet on the ground.
        late: the feet that have still to land.
    """
    robot = contacts.robot
    x, u = ca.SX.sym("x", 2 * robot.size), ca.SX.sym("u", len(robot.joints))
    q, v = x[: robot.size], x[robot.size :]
    motion = landing_motion(contacts, late, q, v, u)
    results = [ca.vertcat(v, motion.acceleration), contacts.on_every_foot(motion.forces), motion.torques]
    return ca.Function(
        "landing_plant", [x, u], ca.cse([ca.densify(part) for part in results]), ["x", "u"], ["rate", "force", "torque"]
    )


@lru_cache(maxsize=32)
def stopping(contacts: Contacts) -> ca.Function:
    """Write the impact that stops some feet as a function: x -> the state after it.

    Args:
        contacts: the feet.
    """
    robot = contacts.robot
    x = ca.SX.sym("x", 2 * robot.size)
    q, v = x[: robot.size], x[robot.size :]
    after = ca.densify(ca.vertcat(q, impact(contacts, q, v)[0]))
    return ca.Function("stopped", [x], ca.cse([after]), ["x"], ["after"])


def compiled_plant(contacts: Contacts) -> ca.Function:
    """Compile ``plant``."""
    return compile_all({"plant": [plant(contacts)]})["plant"]["plant"]


def compiled_landing_plant(contacts: Contacts, late: tuple[str, ...]) -> ca.Function:
    """Compile ``landing_plant``."""
    return compile_all({"landing_plant": [landing_plant(contacts, late)]})["landing_plant"]["landing_plant"]


def compiled_stopping(contacts: Contacts) -> ca.Function:
    """Compile ``stopping`` with its slope."""
    return compile_all({"landing": [stopping(contacts)]}, {"landing": ("jac",)})["landing"]["stopped"]


def compiled_gap(contacts: Contacts, foot: str) -> ca.Function:
    """Compile the distance of a foot from the ground, x -> m, with its slope."""
    robot = contacts.robot
    x = ca.SX.sym("x", 2 * robot.size)
    gap = contacts.ground.gap(kinematics.foot_position(robot, foot, x[: robot.size]))
    function = ca.Function("gap", [x], [gap], ["x"], ["gap"])
    return compile_all({"gap": [function]}, {"gap": ("jac",)})["gap"]["gap"]
