"""What every closed loop of a stance is made of, whatever closes it: signals, fall, guard and reset, as expressions."""

from __future__ import annotations

from typing import Protocol

import casadi as ca

from amble.hybrid import Contacts, Switch, impact
from amble.robot import kinematics

LOWEST_BASE = 0.06
"""A base lower than this above the ground under it has fallen, in lengths of the longest leg."""

STEEPEST = 0.3
"""A base whose vertical axis has a smaller component along the ground's normal under it has fallen over."""

ARGUMENTS = ["t", "x", "p"]


class StanceMotion(Protocol):
    """A closed loop at one state: torques, contact forces, rank of the decoupling equations."""

    @property
    def torques(self) -> ca.SX:
        """u, (n_joints,), N m."""

    @property
    def forces(self) -> ca.SX:
        """World frame, (n_f,), N."""

    @property
    def pivot(self) -> ca.SX | float:
        """Smallest pivot of the decoupling equations."""


def function(name: str, symbols: list[ca.SX], results: dict[str, ca.SX]) -> ca.Function:
    """Write a function of t, x and p without common subexpressions."""
    return ca.Function(name, symbols, ca.cse(list(results.values())), ARGUMENTS, list(results))


def fall_margin(contacts: Contacts, q: ca.SX) -> ca.SX:
    """Return the margin to a fall: height of the base above the ground under it, and how upright it is there."""
    q = contacts.robot.base.spatial(q)
    ground, rotation = contacts.ground, kinematics.base_rotation(q)
    height = q[2] - ground.height(q[0], q[1])
    upright = rotation[2, 2] if ground.level else ca.dot(ground.normal(q[:3]), rotation[:, 2])
    return ca.fmin(height - LOWEST_BASE * contacts.robot.leg_length, upright - STEEPEST)


def signals(contacts: Contacts, q: ca.SX, v: ca.SX, loop: StanceMotion) -> dict[str, ca.SX]:
    """What a simulation records: world frame, all feet in the robot's order, zero force at swing feet."""
    robot = contacts.robot
    return {
        "torque": ca.densify(loop.torques),
        "force": contacts.on_every_foot(loop.forces),
        "foot": ca.vertcat(*[kinematics.foot_position(robot, foot, q) for foot in robot.foot_names]),
        "foot_velocity": ca.vertcat(*[kinematics.foot_jacobian(robot, foot, q) @ v for foot in robot.foot_names]),
        "pivot": loop.pivot,
    }


def guard(contacts: Contacts, switch: Switch, q: ca.SX, loop: StanceMotion, lift_off: float) -> ca.SX:
    """Gap of the first landing foot; without landing the mean normal force of the lifting feet less that of lift-off.

    The mean is smooth where two forces reach it at once; the smallest of them would not be.
    """
    if switch.landing:
        return contacts.ground.gap(kinematics.foot_position(contacts.robot, switch.landing[0], q))
    local = contacts.local(loop.forces, contacts.points(q))
    forces = [contacts.contact.normal_force(local[contacts.feet.index(foot)]) for foot in switch.leaving]
    return sum(forces[1:], forces[0]) / len(forces) - lift_off


def reset(landed: Contacts, switch: Switch, q: ca.SX, v: ca.SX) -> ca.SX:
    """Plastic impact that stops all feet of the next stance; the identity at a lift-off."""
    if not switch.landing:
        return ca.vertcat(q, v)
    velocity, _ = impact(landed, q, v)
    return ca.densify(ca.vertcat(q, velocity))
