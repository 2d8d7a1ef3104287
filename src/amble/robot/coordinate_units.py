"""Units of a robot's coordinates and of what acts along them; forces of prismatic joints as torques."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import casadi as ca

from amble.types import Vector

if TYPE_CHECKING:
    from amble.robot.model import Robot

POSITION = ("x", "y", "z")
"""Coordinates of the base in m."""


def is_length(robot: Robot, name: str) -> bool:
    """Whether a coordinate is in m: the base's position, or a prismatic joint. All others are in rad."""
    return name in POSITION or (name in robot.joint_names and robot.joint(name).prismatic)


def unit_of(robot: Robot, name: str, per_second: str = "") -> str:
    """Return the unit of a coordinate, or of its derivative."""
    return ("m" if is_length(robot, name) else "rad") + per_second


def units(robot: Robot, names: Sequence[str], per_second: str = "") -> list[str]:
    """Return the unit of every coordinate, or of its derivative."""
    return [unit_of(robot, name, per_second) for name in names]


def as_torques(robot: Robot, loads: Any) -> Any:
    """Return what acts on the joints as torques: forces of prismatic joints times the leg length, (n_joints, m).

    Squares and sums of both kinds are N m; loads of a robot whose joints all turn come back as they are.
    """
    return _scaled(robot, loads, robot.torque_arms)


def from_torques(robot: Robot, torques: Any) -> Any:
    """Return what acts on the joints where ``as_torques`` gives these; also rates of joints as those of the arms."""
    return _scaled(robot, torques, 1.0 / robot.torque_arms)


def _scaled(robot: Robot, values: Any, factors: Vector) -> Any:
    if not any(joint.prismatic for joint in robot.joints):
        return values
    # a product of matrices, for casadi multiplies no entries of values without columns
    return ca.mtimes(ca.sparsify(ca.diag(ca.DM(factors))), values)


def load_unit(robot: Robot, name: str, times: str = "") -> str:
    """Return the unit of what acts along a coordinate: N or N m, or times something, such as a second."""
    return ("N" if is_length(robot, name) else "N m") + times


def load_units(robot: Robot, names: Sequence[str], times: str = "") -> list[str]:
    """Return the unit of what acts along every coordinate."""
    return [load_unit(robot, name, times) for name in names]
