"""Dynamics D(q) a + h(q, v) = generalised forces, as casadi expressions.

Coordinates and velocities are those of `kinematics`: v = dq/dt, not a body twist. Every function takes casadi SX, MX,
DM or numpy and returns the matching casadi type. Expressions built from several calls share sines and cosines only
after `casadi.cse`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import casadi as ca

from amble.robot.composite import composite_rigid_body
from amble.robot.joint_frames import aligned_joint_frames
from amble.robot.kinematics import base_rotation, link_poses
from amble.robot.newton_euler import energy_and_momentum, newton_euler
from amble.robot.rotation import constant

if TYPE_CHECKING:
    from amble.robot.model import Robot


def mass_matrix(robot: Robot, q: Any) -> Any:
    """Return D, (n_q, n_q), symmetric; entries between different legs are structurally zero."""
    return _mass_matrix(robot)(q)


def bias(robot: Robot, q: Any, v: Any) -> Any:
    """Return h = Coriolis, centrifugal and gravity forces, (n_q,), N or N m."""
    return _bias(robot)(q, v)


def inverse_dynamics(robot: Robot, q: Any, v: Any, a: Any) -> Any:
    """Return D a + h, the generalised forces without contact, (n_q,), N or N m."""
    return _inverse_dynamics(robot)(q, v, a)


def kinetic_energy(robot: Robot, q: Any, v: Any) -> Any:
    """Return the kinetic energy, J."""
    return _energy_and_momentum(robot)(q, v)[0]


def potential_energy(robot: Robot, q: Any) -> Any:
    """Return the potential energy above z = 0, J."""
    return _potential_energy(robot)(q)


def momentum(robot: Robot, q: Any, v: Any) -> tuple[Any, Any]:
    """Return linear momentum, (3,), N s, and angular momentum about the world origin, (3,), N m s; world axes."""
    _, linear, angular = _energy_and_momentum(robot)(q, v)
    return linear, angular


def _function(name: str, robot: Robot, letters: str, build: Callable[..., Sequence[ca.SX]]) -> ca.Function:
    symbols = [ca.SX.sym(letter, robot.size) for letter in letters]
    return ca.Function(name, symbols, ca.cse(list(build(*symbols))))


@lru_cache(maxsize=64)
def _mass_matrix(robot: Robot) -> ca.Function:
    return _function("mass_matrix", robot, "q", lambda q: [composite_rigid_body(aligned_joint_frames(robot), q)])


@lru_cache(maxsize=64)
def _bias(robot: Robot) -> ca.Function:
    still = ca.SX(robot.size, 1)
    return _function("bias", robot, "qv", lambda q, v: [newton_euler(aligned_joint_frames(robot), q, v, still)])


@lru_cache(maxsize=64)
def _inverse_dynamics(robot: Robot) -> ca.Function:
    return _function(
        "inverse_dynamics", robot, "qva", lambda q, v, a: [newton_euler(aligned_joint_frames(robot), q, v, a)]
    )


@lru_cache(maxsize=64)
def _energy_and_momentum(robot: Robot) -> ca.Function:
    return _function(
        "energy_and_momentum", robot, "qv", lambda q, v: energy_and_momentum(aligned_joint_frames(robot), q, v)
    )


@lru_cache(maxsize=64)
def _potential_energy(robot: Robot) -> ca.Function:
    def build(q: ca.SX) -> list[ca.SX]:
        moments = [
            link.mass * (origin + rotation @ constant(link.center))
            for link, (rotation, origin) in zip(robot.links, link_poses(robot, q), strict=True)
        ]
        rise = base_rotation(q)[2, :] @ sum(moments, ca.SX(3, 1))
        return [robot.gravity * (robot.mass * q[2] + rise)]

    return _function("potential_energy", robot, "q", build)
