"""Parts of a landing: the motion on some feet under given torques, the impact that stops feet, a foot's gap."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from amble.codegen import compile_all
from amble.hybrid import Contacts, constrained_dynamics, impact
from amble.robot import kinematics


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
