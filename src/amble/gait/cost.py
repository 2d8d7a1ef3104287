"""What a gait problem minimises: the mean over the motion of a running cost, one expression at every instant."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca

from amble.hybrid import Contacts
from amble.io.registry import Registry
from amble.robot import Robot
from amble.robot.coordinate_units import as_torques


@dataclass(frozen=True, kw_only=True)
class Instant:
    """One instant of a motion, as symbols that a running cost is written in.

    Attributes:
        contacts: the stance feet on the ground, with the robot.
        positions: q, (n_q,), m and rad.
        velocities: v, (n_q,).
        accelerations: a, (n_q,).
        torques: u, (n_joints,), N m, or N of prismatic joints.
        forces: contact forces of the stance feet, world frame, (n_f,), N.
        duration: T of the domain, s.
    """

    contacts: Contacts
    positions: ca.SX
    velocities: ca.SX
    accelerations: ca.SX
    torques: ca.SX
    forces: ca.SX
    duration: ca.SX

    @property
    def joint_speeds(self) -> ca.SX:
        """Rates of the joints, (n_joints,), rad/s or m/s."""
        return self.velocities[self.velocities.shape[0] - self.torques.shape[0] :]


class Cost(ABC):
    """A running cost L; the gait problem minimises 1/T sum of the integrals of L over its domains, T their duration.

    A cost may also have a part for every landing and a weight on the rates of the torques; both count under the sum.

    A cost is immutable and hashable, has two derivatives everywhere, and in a mirrored gait is the same for a motion
    and its mirror image, since only half of the gait is solved.

    Attributes:
        units: parameter -> unit, of those that files hold with one.
    """

    units: ClassVar[Mapping[str, str]] = {}

    @property
    @abstractmethod
    def name(self) -> str:
        """Short name, as used in files."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Parameters as plain JSON values; with the name they rebuild the cost."""
        return {}

    @property
    @abstractmethod
    def unit(self) -> str:
        """Unit of L and so of the objective."""

    @abstractmethod
    def running(self, instant: Instant) -> ca.SX:
        """Write L, a scalar."""

    def landing(self, contacts: Contacts, feet: tuple[str, ...], q: ca.SX, v: ca.SX) -> ca.SX:
        """Write what a landing costs, a scalar, in the unit of L times s; nothing by default.

        Args:
            contacts: the stance feet on the ground before it, with the robot.
            feet: the feet that land.
            q: coordinates there, (n_q,).
            v: their rates just before the impact, (n_q,).
        """
        del contacts, feet, q, v
        return ca.SX(1, 1)

    def torque_rate(self, robot: Robot) -> float:
        """Return the weight of |du/dt|^2 in L, 1 / (N m)^2 s^2 times its unit, forces as torques; zero by default."""
        del robot
        return 0.0


@dataclass(frozen=True)
class TorqueSquared(Cost):
    """L = u^T u, whose mean is the objective (paper, eq. 6); forces of prismatic joints times the leg length."""

    @property
    def name(self) -> str:
        """Name in files."""
        return "torque squared"

    @property
    def unit(self) -> str:
        """(N m)^2."""
        return "N^2 m^2"

    def running(self, instant: Instant) -> ca.SX:
        """Sum the squares."""
        return ca.sumsqr(as_torques(instant.contacts.robot, instant.torques))


TORQUE_SQUARED = TorqueSquared()
"""The cost of a problem that names none; files hold only others."""

COSTS: Registry[Cost] = Registry("cost")
"""The costs that files and specifications can name."""

COSTS.register("torque squared", TorqueSquared)
