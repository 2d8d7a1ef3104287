"""What stands between a joint's torque and its motion: the motor's rotor, damping and dry friction.

A rotor of inertia I behind a gear of ratio N turns N times as fast as the joint, which feels N^2 I on the diagonal of
the mass matrix; what its own spin adds to the base's angular momentum, N times less, is left out, as in MuJoCo's
armature. Damping d and dry friction c take d w + c tanh(w / width) of the torque at the rate w. Of a prismatic joint
these are a mass, N s/m, N and m/s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import sqrt
from typing import TYPE_CHECKING, Any

import casadi as ca

from amble.errors import InputError

if TYPE_CHECKING:
    from amble.robot.model import Robot

FRICTION_WIDTH = 0.05
"""Rate over which dry friction changes its sign, in sqrt(g / l), l the leg length: 0.25 rad/s of a leg of 0.4 m. Of
prismatic joints times l."""


def rotor_inertia(robot: Robot) -> ca.DM:
    """Return what the rotors add to the mass matrix, (n_q, n_q), zeros structural."""
    base = robot.size - len(robot.joints)
    return ca.sparsify(ca.diag(ca.DM([0.0] * base + [joint.rotor_inertia for joint in robot.joints])))


def resistance(robot: Robot, v: Any) -> Any:
    """Return the generalised forces that damping and dry friction take at velocities v, (n_q,), N m or N."""
    base = robot.size - len(robot.joints)
    taken = ca.SX(robot.size, 1)
    for j, joint in enumerate(robot.joints, start=base):
        if joint.damping:
            taken[j] += joint.damping * v[j]
        if joint.dry_friction:
            taken[j] += joint.dry_friction * ca.tanh(v[j] / joint.friction_width)
    return taken


def rotor_energy(robot: Robot, v: Any) -> Any:
    """Return the kinetic energy of the rotors, J."""
    return 0.5 * ca.bilin(ca.SX(rotor_inertia(robot)), v, v)


def with_friction(robot: Robot, friction: Mapping[str, float], width: float | None) -> Robot:
    """Return the robot with dry friction in some joints.

    Args:
        robot: the robot, without.
        friction: joint -> N m, or N of a prismatic joint.
        width: rate over which it changes its sign, rad/s, times the leg length of prismatic joints; by default
            ``FRICTION_WIDTH`` of the robot's size, and as many rad/s where it has no feet or no gravity.

    Raises:
        InputError: the width is not positive.
    """
    if width is None:
        known = robot.leg_length > 0.0 and robot.gravity != 0.0
        width = FRICTION_WIDTH * (sqrt(robot.gravity / robot.leg_length) if known else 1.0)
    if not width > 0.0:
        raise InputError(f"the width of the dry friction is {width:g} rad/s; it must be positive: friction_width")
    joints = (
        replace(joint, dry_friction=friction[joint.name], friction_width=width * arm)
        if joint.name in friction
        else joint
        for joint, arm in zip(robot.joints, robot.torque_arms, strict=True)
    )
    return replace(robot, joints=tuple(joints))
