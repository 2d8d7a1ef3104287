"""What the exported controller evaluates in one stance: torques, contact forces, rank and margin as one function."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.control import AllocationLaw, ContactLimits, margins
from amble.control.linearisation import linearise
from amble.control.virtual_constraints import VirtualConstraints
from amble.gait import Gait
from amble.gait.constraints import REFERENCE_ORDER, loop_parameters
from amble.hybrid import Stance
from amble.names import identifier
from amble.types import Vector

FREE = 1e30
"""Torque limit of a joint that has none, N m."""


@dataclass(frozen=True)
class StanceLaw:
    """The law of one solved stance.

    Attributes:
        stance: the stance.
        function: (clock, x, p) -> torques, forces of all feet, smallest pivot, smallest margin to a contact limit.
        parameters: p.
        duration: planned duration, s.
    """

    stance: Stance
    function: ca.Function
    parameters: Vector
    duration: float


def stance_law(gait: Gait, law: AllocationLaw, stance: Stance) -> StanceLaw:
    """Write the law of a solved stance as an expression."""
    robot, contacts = gait.robot, gait.pattern.contacts(stance)
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 2 * robot.size)
    q, v = x[: robot.size], x[robot.size :]
    outputs = len(gait.outputs.of(stance.name).coordinates)
    constraints = VirtualConstraints.symbols(outputs, robot.size - 3, REFERENCE_ORDER, gait.outputs.phase)
    loop = linearise(contacts, law, q, v, constraints.phase_rates(robot, stance, t, q, v), constraints)
    limits = ContactLimits(contacts.ground.friction, gait.limits.normal_force)
    margin = ca.mmin(margins(contacts, contacts.points(q), loop.forces, limits))
    function = ca.Function(
        f"amble_law_{identifier(stance.name)}",
        [t, x, constraints.packed()],
        [ca.densify(loop.torques), ca.densify(contacts.on_every_foot(loop.forces)), loop.pivot, margin],
        ["t", "x", "p"],
        ["torque", "force", "pivot", "margin"],
    )
    parameters = loop_parameters(gait, stance.name)
    return StanceLaw(stance, function, parameters, float(parameters[0]))


def torque_limits(gait: Gait) -> Vector:
    """Return what the saturation keeps: the smaller of the robot's and the gait's torque limits, (n_joints,), N m."""
    robot = gait.robot
    found = [min(joint.effort, gait.limits.torques.get(joint.name, np.inf), FREE) for joint in robot.joints]
    return np.array(found, dtype=np.float64)
