"""What an allocation law is: the choice among all torques of one motion (docs/theory/allocation.md, section 1)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from numbers import Real
from typing import Any, ClassVar

import casadi as ca

from amble.amounts import LARGEST_NUMBER
from amble.errors import InputError, shown
from amble.hybrid import Contacts
from amble.robot import Joint, Robot
from amble.robot.coordinate_units import as_torques, from_torques


@dataclass(frozen=True, kw_only=True)
class Redundancy:
    """All torques that realise one motion: u(s) = torques + torque_basis @ s, forces(s) = forces + force_basis @ s.

    In the controller ``torques`` is the minimum-norm member; in the gait problem it is the variable itself. Forces of
    prismatic joints are torques at an arm of the leg length here, and their speeds turn it (``Robot.torque_arms``).

    Attributes:
        contacts: the stance feet on the ground, with the robot for names and limits.
        points: positions of the stance feet, world frame, (3 n_c,), m.
        torques: one particular torque, (n_joints,), N m.
        torque_basis: basis of the torques that cause no acceleration, (n_joints, k), N m.
        forces: contact forces that go with ``torques``, world frame, (n_f,), N.
        force_basis: internal contact forces that go with ``torque_basis``, (n_f, k), N.
        speeds: joint velocities, (n_joints,), rad/s.
    """

    contacts: Contacts
    points: ca.SX
    torques: ca.SX
    torque_basis: ca.SX
    forces: ca.SX
    force_basis: ca.SX
    speeds: ca.SX

    @classmethod
    def at(
        cls,
        contacts: Contacts,
        state: tuple[ca.SX, ca.SX],
        particular: tuple[ca.SX, ca.SX],
        null_space: tuple[ca.SX, ca.SX] | None = None,
    ) -> Redundancy:
        """Collect all torques that realise the motion of one of them.

        Args:
            contacts: the stance feet on the ground.
            state: coordinates and their rates, (n_q,) each.
            particular: one torque, (n_joints,), N m or N, and the contact forces that go with it, (n_f,), N.
            null_space: what ``Contacts.torque_null_space`` returns there, where it is at hand already.
        """
        q, v = state
        torque_basis, force_basis = contacts.torque_null_space(q) if null_space is None else null_space
        return cls(
            contacts=contacts,
            points=contacts.points(q),
            torques=as_torques(contacts.robot, particular[0]),
            torque_basis=as_torques(contacts.robot, torque_basis),
            forces=particular[1],
            force_basis=force_basis,
            speeds=from_torques(contacts.robot, v[contacts.robot.size - len(contacts.robot.joints) :]),
        )

    def moved(self, s: ca.SX) -> Redundancy:
        """Return the same torques, seen from the member u(s)."""
        return replace(self, torques=self.torques + self.torque_basis @ s, forces=self.forces + self.force_basis @ s)

    @property
    def loads(self) -> ca.SX:
        """The torques as the joints have them, N m, or N of prismatic ones, (n_joints,)."""
        return from_torques(self.robot, self.torques)

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.contacts.robot

    @property
    def feet(self) -> tuple[str, ...]:
        """The stance feet, in the robot's foot order."""
        return self.contacts.feet

    @property
    def size(self) -> int:
        """Number k of free directions: 0, 1, 3, 6 for 1, 2, 3, 4 point feet."""
        return int(self.torque_basis.shape[1])

    def local(self, forces: ca.SX) -> list[ca.SX]:
        """Split contact forces by foot and turn them into the ground's frame, (size, n) each."""
        return self.contacts.local(forces, self.points)


class AllocationLaw(ABC):
    """One rule, used three ways: rows of the gait problem, closed form in the controller, entry of a comparison.

    A law is immutable and hashable: what is built for one is built once.

    Attributes:
        units: parameter -> unit, of those that are numbers or have a number for every joint; files hold them.
    """

    units: ClassVar[Mapping[str, str]] = {}

    @property
    @abstractmethod
    def name(self) -> str:
        """Short name, as used in files and on the command line."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The law's parameters as plain JSON values; with the name they rebuild the law."""
        return {}

    def optimality_conditions(self, redundancy: Redundancy) -> ca.SX:
        """Return k expressions that vanish exactly where the torques obey the law; they close the gait problem.

        A law whose torques have breakpoints has no such rows and leaves this method as it is.

        Raises:
            InputError: where the law is not smooth.
        """
        del redundancy
        raise InputError(
            f"allocation law '{self.name}' is not smooth, so no gait can be optimised under it; optimise with pinv or "
            "weighted and use it in the controller: the motion stays the same"
        )

    @abstractmethod
    def allocate(self, redundancy: Redundancy) -> ca.SX:
        """Return s, (k,): the closed form of the law in the controller, from the minimum-norm torques."""

    def diagnostics(self, redundancy: Redundancy, s: ca.SX) -> Mapping[str, ca.SX]:
        """Return what the law can tell about its own choice, by name; a law without limits has nothing to tell.

        Args:
            redundancy: what was chosen from.
            s: what ``allocate`` returned, (k,).
        """
        del redundancy, s
        return {}


def finite(what: str, value: Any) -> float:
    """Return a parameter of a law that must be a finite number, for its ``__post_init__``.

    Raises:
        InputError: it is something else, as files and words on the command line may hold, or above ``LARGEST_NUMBER``.
    """
    try:
        if isinstance(value, Real) and not isinstance(value, bool) and isfinite(value):
            if abs(float(value)) > LARGEST_NUMBER:
                raise InputError(f"the {what} is {value:g}; parameters of laws go up to {LARGEST_NUMBER:g}")
            return float(value)
    except OverflowError:  # a whole number of hundreds of digits
        pass
    raise InputError(f"the {what} is {shown(value)}; it must be a finite number")


class LawWithBreakpoints(AllocationLaw):
    """A law that minimises something whose slope jumps: in closed form along one free direction, else as a program."""

    def allocate(self, redundancy: Redundancy) -> ca.SX:
        """Minimise exactly; without free directions there is nothing to choose."""
        if not redundancy.size:
            return ca.SX(0, 1)
        return self.on_line(redundancy) if redundancy.size == 1 else self.in_space(redundancy)

    @abstractmethod
    def on_line(self, redundancy: Redundancy) -> ca.SX:
        """Return s, (1,), along one free direction, such as that of two point feet."""

    @abstractmethod
    def in_space(self, redundancy: Redundancy) -> ca.SX:
        """Return s, (k,), among several free directions, such as those of three and four point feet."""


def steered_joints(redundancy: Redundancy) -> list[int]:
    """Joints whose torque the free directions can change: those of the stance legs."""
    return sorted(set(redundancy.torque_basis.sparsity().row()))


def effort_limits(redundancy: Redundancy, joints: Sequence[int]) -> ca.DM:
    """Largest |torque| of some joints as the robot's description states it, N m; forces as ``Redundancy`` has them.

    Raises:
        InputError: where a joint has no such limit.
    """
    records, arms = [redundancy.robot.joints[j] for j in joints], redundancy.robot.torque_arms
    for record in records:
        _require_effort(record)
    return ca.DM([record.effort * float(arms[j]) for j, record in zip(joints, records, strict=True)])


def require_effort_limits(robot: Robot, feet: Sequence[str]) -> None:
    """Refuse a robot some of whose legs have a joint without a torque limit.

    Raises:
        InputError: in one sentence, where a joint of a leg of one of the feet has none.
    """
    for foot in feet:
        for name in robot.legs[foot]:
            _require_effort(robot.joint(name))


def _require_effort(joint: Joint) -> None:
    if not (isfinite(joint.effort) and joint.effort > 0.0):
        raise InputError(f"joint '{joint.name}' has no torque limit, which this allocation law needs")
