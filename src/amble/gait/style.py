"""The style of a motion as a cost: torques, power, touchdown, base, posture, swing and effort rate, each with a weight.

Every term is a square, zero at best, measured by the robot: torques by m g l, times by sqrt(l / g), lengths by the leg
length l. Of prismatic joints forces count times l and displacements over l. So a weight means the same for
every robot, and a larger one makes its own term smaller.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import isfinite
from typing import Any

import casadi as ca

from amble.errors import InputError, UnknownNameError
from amble.gait.cost import COSTS, Cost, Instant
from amble.hybrid import Contacts
from amble.robot import Robot, kinematics
from amble.robot.coordinate_units import as_torques, from_torques
from amble.robot.proposal import nominal_posture

ANGLES = ("roll", "pitch")


@dataclass(frozen=True, kw_only=True)
class Style(Cost):
    """A weighted sum of squares, (N m)^2 like the torques'; u, w torques and rates of the joints, tau = m g l.

    With ``torques`` alone, which is 1 by default, it is the cost of squared torques. The objective is the mean over the
    motion: 1/T of the integral of all terms, and of the touchdowns, which have no duration, of their sum.

    Attributes:
        torques: on |u|^2.
        power: on sum (u_j w_j)^2 l / g: the power of each joint, whichever way it flows.
        touchdown_speed: on tau^2 |v|^2 / (g l) sqrt(l / g) of every landing foot, v its velocity just before.
        attitude: on tau^2 (roll^2 + pitch^2) of the base.
        posture: on tau^2 |q - q*|^2 of the joints.
        swing_height: on tau^2 sum (height / l)^2 of the feet in the air, above the ground.
        effort_rate: on |du/dt|^2 l / g, where u goes through an interval's nodes as one polynomial.
        angles: q*, joint -> rad, or m; those of the robot's nominal posture where a joint is not named.

    Raises:
        InputError: a weight is not finite and not negative, or all are zero.
    """

    torques: float = 1.0
    power: float = 0.0
    touchdown_speed: float = 0.0
    attitude: float = 0.0
    posture: float = 0.0
    swing_height: float = 0.0
    effort_rate: float = 0.0
    angles: Mapping[str, float] | tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        """Check the weights; the angles are kept so that the cost is hashable."""
        angles = tuple(sorted(dict(self.angles).items()))
        object.__setattr__(self, "angles", angles)
        for name in WEIGHTS:
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value < float("inf"):
                raise InputError(f"the weight '{name}' of the style is {value!r}; it must be finite and not negative")
        if not any(getattr(self, name) for name in WEIGHTS):
            raise InputError("all weights of the style are zero, so nothing is minimised")
        for joint, angle in angles:
            if isinstance(angle, bool) or not isinstance(angle, int | float) or not isfinite(angle):
                raise InputError(f"the angle of '{joint}' in the style is {angle!r}, not a finite number")

    @property
    def name(self) -> str:
        """Name in files."""
        return "style"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Every weight, and the angles that are named."""
        weights = {name: float(getattr(self, name)) for name in WEIGHTS}
        return {**weights, "angles": dict(self.angles)} if self.angles else weights

    @property
    def unit(self) -> str:
        """(N m)^2."""
        return "N^2 m^2"

    def running(self, instant: Instant) -> ca.SX:
        """Sum the terms that an instant has."""
        # shorthand
        contacts, robot = instant.contacts, instant.contacts.robot
        q, u, w = instant.positions, instant.torques, instant.joint_speeds
        g, l = robot.gravity, robot.leg_length  # noqa: E741

        found = self.torques * ca.sumsqr(as_torques(robot, u))
        if self.power:
            found += self.power * ca.sumsqr(u * w) * l / g
        places = [robot.coordinate_index(name) for name in ANGLES if name in robot.base.coordinates]
        moved = self.attitude * ca.sumsqr(q[places])
        if self.posture:
            away = q[q.shape[0] - u.shape[0] :] - ca.DM(self._reference(robot))
            moved += self.posture * ca.sumsqr(from_torques(robot, away))
        if self.swing_height:
            moved += self.swing_height * sum((_gap(contacts, foot, q) / l) ** 2 for foot in _in_the_air(contacts))
        return found + _torque(robot) ** 2 * moved

    def landing(self, contacts: Contacts, feet: tuple[str, ...], q: ca.SX, v: ca.SX) -> ca.SX:
        """Write the term of some landing feet."""
        robot = contacts.robot
        g, l = robot.gravity, robot.leg_length  # noqa: E741
        speeds = [kinematics.foot_jacobian(robot, foot, q) @ v for foot in feet]
        share = sum((ca.sumsqr(speed) for speed in speeds), ca.SX(1, 1)) / (g * l)
        return self.touchdown_speed * _torque(robot) ** 2 * (l / g) ** 0.5 * share

    def torque_rate(self, robot: Robot) -> float:
        """Return the weight of |du/dt|^2, s^2."""
        return self.effort_rate * robot.leg_length / robot.gravity

    def _reference(self, robot: Robot) -> list[float]:
        named = dict(self.angles)
        for joint in named:
            if joint not in robot.joint_names:
                raise UnknownNameError("joint (angles of the style)", joint, robot.joint_names)
        nominal = {} if len(named) == len(robot.joints) else nominal_posture(robot).angles
        return [{**nominal, **named}[joint] for joint in robot.joint_names]


WEIGHTS = tuple(field.name for field in fields(Style) if field.name != "angles")
"""The weights, in order."""

COSTS.register("style", Style)


def _torque(robot: Robot) -> float:
    return robot.mass * robot.gravity * robot.leg_length


def _in_the_air(contacts: Contacts) -> list[str]:
    return [foot for foot in contacts.robot.foot_names if foot not in contacts.feet]


def _gap(contacts: Contacts, foot: str, q: ca.SX) -> ca.SX:
    return contacts.ground.gap(kinematics.foot_position(contacts.robot, foot, q))
