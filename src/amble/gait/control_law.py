"""What a feedback law is: how it closes the loop of a gait, stance by stance."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import casadi as ca

from amble.control import AllocationLaw
from amble.control.closed_loop import Flow, StanceLoop
from amble.control.driven_loop import driven_flow, driven_loops
from amble.control.loop_equations import LoopEquations, driven_equations
from amble.errors import InputError
from amble.hybrid import Contacts, Stance, Symmetry
from amble.io.registry import Registry
from amble.numerics.unseen import unseen
from amble.types import Vector

if TYPE_CHECKING:
    from amble.gait.record import Gait


@dataclass(frozen=True, kw_only=True)
class Numbers:
    """What a feedback law is in one solved domain of a gait.

    Attributes:
        parameters: p of the compiled functions.
        breakpoints: clocks at which the law is not smooth, ascending, s.
    """

    parameters: Vector
    breakpoints: tuple[float, ...] = ()


class ControlLaw(ABC):
    """A feedback law for any gait; immutable and hashable.

    Attributes:
        units: parameter -> unit, of those that are written with one.
        lift_offs: shares of its plan (``planned``) between which the controller ends a stance by feet that lift, none
            landing; where there are none it ends whenever they are up. Unilateral ground has it under any law, exported
            code under ``Impedance`` and its schedules alone: code that reads the whole state has no window. The closed
            loop has none, for close to the orbit, of which certificates and proofs speak, it does not matter.
    """

    units: ClassVar[Mapping[str, str]] = {}
    lift_offs: tuple[float, float] | None = None

    @property
    @abstractmethod
    def name(self) -> str:
        """Short name, as used in files and on the command line."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Parameters as plain JSON values; with the name they rebuild the law."""
        return {}

    @abstractmethod
    def numbers(self, gait: Gait, allocation: AllocationLaw | None) -> tuple[Numbers, ...]:
        """Return what the law is in every solved domain.

        Args:
            gait: the gait.
            allocation: another allocation law than the gait's.

        Raises:
            InputError: an allocation law is given, and this law does not allocate; or the law does not fit the gait.
        """

    def landing_numbers(self, gait: Gait, allocation: AllocationLaw | None) -> Mapping[str, Numbers]:
        """Return what the law is between the landings of feet that land one by one: stance -> numbers.

        None: the torques of the next stance at its entry, behind the impact of all its feet, with the legs that have
        still to land going on at their joints' rates (docs/theory/hybrid-model.md, eq. 21 and 22).
        """
        del gait, allocation
        return {}

    def planned(self, gait: Gait, stance: Stance, p: ca.MX) -> ca.MX | float:
        """Write the planned duration of a stance of the cycle, s, of which ``lift_offs`` are shares: the gait's.

        Args:
            gait: the gait.
            stance: one of its stances, also a mirrored one.
            p: the parameters of the stance; a law of another plan than the gait's reads it there.
        """
        del p
        place = gait.pattern.stances.index(stance) % len(gait.domains)
        domain = gait.domains[place]
        return domain.duration if gait.feedback is None else gait.feedback.durations[domain.name]

    @abstractmethod
    def loops(
        self, gait: Gait, allocation: AllocationLaw | None, numbers: tuple[Numbers, ...]
    ) -> tuple[StanceLoop, ...]:
        """Compile the closed loops of the solved stances, functions of (t, x, p); ``numbers`` are the law's."""

    def smooth(self, gait: Gait, numbers: Numbers) -> tuple[Numbers, ...]:
        """Cut a domain into stretches along each of which the law is smooth, for proofs.

        Returns:
            For every stretch, from the end of the one before, the parameters p of ``equations`` and its end as the only
            breakpoint; the last has none where it goes on for ever. As many parameters for all.
        """
        del gait
        return (replace(numbers, breakpoints=numbers.breakpoints[:1]),)

    def equations(self, gait: Gait, stance: Stance, size: int) -> tuple[list[ca.SX], LoopEquations]:
        """Write a solved stance's closed loop along a stretch as linear equations over symbols (t, x, p), for proofs.

        Args:
            gait: the gait.
            stance: one of its solved stances.
            size: number of parameters of the stretch (``smooth``).

        Raises:
            InputError: the loop is no solution of linear equations.
        """
        del gait, stance, size
        raise InputError(f"control law '{self.name}' does not write its loop as linear equations: no proof of it")

    @abstractmethod
    def keeps(self, gait: Gait, symmetry: Symmetry) -> bool:
        """Whether the law does not see a symmetry of the ground: a translation, or "yaw" about the vertical.

        Stability is judged modulo what is kept: a law that moves the orbit along it and says that it keeps it is called
        stable where it is not.
        """


class TorqueLaw(ControlLaw):
    """A feedback law that is a function of the state: accelerations and forces follow from its torques.

    With ``torques`` and ``packed`` alone it walks, is certified, exported and written to gait files; with ``gains`` and
    ``with_gains`` it is also stabilised.
    """

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

    @abstractmethod
    def packed(self, gait: Gait, domain: str) -> Vector:
        """Return the parameters p of a solved domain."""

    def keeps(self, gait: Gait, symmetry: Symmetry) -> bool:
        """Whether the torques, as they are written, do not change along it: they read nothing that it moves.

        Neither their slopes nor switches in them (``numerics.unseen``): of sign(yaw) every slope is 0.

        A law whose slope vanishes all the same, such as one that reads the direction of gravity in the base, says so.
        """
        half = gait.robot.size
        x = ca.SX.sym("x", 2 * half)
        for stance in gait.pattern.solved:
            t, p = ca.SX.sym("t"), ca.SX.sym("p", self.packed(gait, stance.name).size)
            written = self.torques(gait.pattern.contacts(stance), t, x[:half], x[half:], p)
            if not unseen(written, x, symmetry.generator(x)):
                return False
        return True

    def breakpoints(self, gait: Gait, stance: Stance) -> tuple[float, ...]:
        """Return the clocks at which the law is not smooth, s."""
        del gait, stance
        return ()

    def gains(self, gait: Gait, domain: str) -> Mapping[str, int]:
        """Return which parameters stabilisation may choose: label -> place in p, of positive numbers.

        Their torques vanish on the orbit whatever they are, as those of feedback do. One label in several domains is
        one number.
        """
        del gait, domain
        return {}

    def with_gains(self, values: Mapping[str, float]) -> TorqueLaw:
        """Return the law with other gains, label -> value.

        Raises:
            InputError: the law has none.
        """
        del values
        raise InputError(f"control law '{self.name}' has no gains that could be chosen")

    def landing_flow(self, contacts: Contacts, numbers: Numbers) -> Flow:
        """Compile the motion between two landings under ``landing_numbers``, on the feet that have landed."""
        return driven_flow(contacts, self.torques, numbers.parameters.size)

    def numbers(self, gait: Gait, allocation: AllocationLaw | None) -> tuple[Numbers, ...]:
        """Return ``packed`` and ``breakpoints``."""
        if allocation is not None:
            raise InputError(f"control law '{self.name}' gives the torques itself; it takes no allocation law")
        return tuple(
            Numbers(parameters=self.packed(gait, stance.name), breakpoints=self.breakpoints(gait, stance))
            for stance in gait.pattern.solved
        )

    def loops(
        self, gait: Gait, allocation: AllocationLaw | None, numbers: tuple[Numbers, ...]
    ) -> tuple[StanceLoop, ...]:
        """Compile the loops; their slopes come by automatic differentiation."""
        del allocation
        sizes = [entry.parameters.size for entry in numbers]
        return driven_loops(gait.pattern, self.torques, sizes, gait.limits.normal_force)

    def smooth_torques(self, contacts: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        """Write the torques along one stretch of ``smooth``; arguments as in ``torques``, p those of the stretch."""
        return self.torques(contacts, t, q, v, p)

    def equations(self, gait: Gait, stance: Stance, size: int) -> tuple[list[ca.SX], LoopEquations]:
        """Write the dynamics with the torques as one more equation."""
        contacts, half = gait.pattern.contacts(stance), gait.robot.size
        t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2 * half), ca.SX.sym("p", size)
        q, v = x[:half], x[half:]
        return [t, x, p], driven_equations(contacts, self.smooth_torques(contacts, t, q, v, p), (q, v))


CONTROL_LAWS: Registry[ControlLaw] = Registry("control law")
"""The feedback laws that files and the command line can name."""
