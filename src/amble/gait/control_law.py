"""What a feedback law is: how it closes the loop of a gait, stance by stance."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import casadi as ca

from amble.control import AllocationLaw
from amble.control.closed_loop import StanceLoop, driven_loops
from amble.errors import InputError
from amble.gait.record import Gait
from amble.hybrid import Contacts, Stance, Symmetry
from amble.io.registry import Registry
from amble.types import Vector


class ControlLaw(ABC):
    """A feedback law for any gait; immutable.

    Attributes:
        units: parameter -> unit, of those that are written with one.
    """

    units: ClassVar[Mapping[str, str]] = {}

    @property
    @abstractmethod
    def name(self) -> str:
        """Short name, as used on the command line."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Parameters as plain JSON values; with the name they rebuild the law."""
        return {}

    @abstractmethod
    def loops(self, gait: Gait, allocation: AllocationLaw | None) -> tuple[StanceLoop, ...]:
        """Compile the closed loops of the solved stances, functions of (t, x, p).

        Raises:
            InputError: an allocation law is given, and this law does not allocate.
        """

    @abstractmethod
    def packed(self, gait: Gait, domain: str) -> Vector:
        """Return the parameters p of a solved domain."""

    def breakpoints(self, gait: Gait, stance: Stance) -> tuple[float, ...]:
        """Return the clocks at which the law is not smooth, s."""
        del gait, stance
        return ()

    def keeps(self, gait: Gait, symmetry: Symmetry) -> bool:
        """Whether the law does not see a symmetry of the ground: a translation, or "yaw" about the vertical."""
        del gait, symmetry
        return True


class TorqueLaw(ControlLaw):
    """A feedback law that is a function of the state: accelerations and forces follow from its torques."""

    @abstractmethod
    def torques(self, contacts: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        """Write the joint torques of a stance, (n_joints,), N m.

        Args:
            contacts: the stance feet on the ground, with the robot.
            t: time since the entry of the domain, s.
            q: coordinates, (n_q,).
            v: their rates, (n_q,).
            p: the parameters of ``packed``.
        """

    def loops(self, gait: Gait, allocation: AllocationLaw | None) -> tuple[StanceLoop, ...]:
        """Compile the loops; their slopes come by automatic differentiation."""
        if allocation is not None:
            raise InputError(f"control law '{self.name}' gives the torques itself; it takes no allocation law")
        sizes = [self.packed(gait, stance.name).size for stance in gait.pattern.solved]
        return driven_loops(gait.pattern, self.torques, sizes, gait.limits.normal_force)


CONTROL_LAWS: Registry[ControlLaw] = Registry("control law")
"""The feedback laws that the command line can name."""
