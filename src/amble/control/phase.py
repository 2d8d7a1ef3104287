"""The phase variable that virtual constraints run on: the clock of a domain, or a function of the configuration."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from amble.errors import InputError
from amble.hybrid import Stance
from amble.io.registry import Registry
from amble.robot import Robot
from amble.types import NodeValues, Vector

EARLIEST_PHASE, LATEST_PHASE = -0.05, 1.05
"""Phases between which the reference polynomials are followed: a little outside [0, 1], so that the closed loop is
analytic around an orbit whose touchdown comes at phase 1 in either direction; not far outside, where a polynomial of
high order grows. Beyond, the curves go on with their last second derivative."""


@dataclass(frozen=True)
class PhaseNumber:
    """A number that a phase needs in every domain beside the duration: its name and unit."""

    name: str
    unit: str


@dataclass(frozen=True)
class PhaseRates:
    """The phase variable s at a state, with its first two time derivatives; s'' is affine in the accelerations.

    Attributes:
        value: s, scalar.
        rate: s', 1/s.
        gradient: J_s = ds/dq, (1, n_q); without nonzeros where the configuration does not enter.
        bias: s'' - J_s a, 1/s^2.
    """

    value: ca.SX
    rate: ca.SX
    gradient: ca.SX
    bias: ca.SX

    @property
    def by_state(self) -> bool:
        """Whether the configuration enters, so that s'' depends on the accelerations."""
        return bool(self.gradient.nnz())

    def second(self, a: ca.SX) -> ca.SX:
        """Return s'' at accelerations a, (n_q,)."""
        return self.gradient @ a + self.bias


class Phase(ABC):
    """A phase variable: 0 at the entry of a domain, 1 at its end, growing in between.

    It may read the share t / T of the domain's duration that has passed, and the configuration. What it needs beside
    T are ``numbers`` of every domain: parameters of the closed loop, variables of the gait problem, part of the gait.

    A phase is immutable and hashable: what is built for one is built once. A new one is a subclass and a call of
    ``PHASES.register``.
    """

    name: ClassVar[str]
    """Short name, as used in files."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Its parameters as plain JSON values; with the name they rebuild the phase."""
        return {}

    @property
    def numbers(self) -> tuple[PhaseNumber, ...]:
        """What it needs to know in every domain beside the duration."""
        return ()

    @property
    def earliest(self) -> float:
        """Phase below which the curves go on with their first second derivative."""
        return EARLIEST_PHASE

    @abstractmethod
    def value(self, robot: Robot, stance: Stance, share: ca.SX, q: ca.SX, numbers: ca.SX) -> ca.SX:
        """Return s.

        Args:
            robot: the robot.
            stance: the domain.
            share: t / T.
            q: the configuration, (n_q,).
            numbers: of this domain, in the order of ``numbers``.

        Raises:
            InputError: the phase does not fit the robot or the stance.
        """

    def measured(self, robot: Robot, stance: Stance, first: ca.SX, last: ca.SX) -> ca.SX:
        """Return the numbers of a motion through a domain, from its first and last configuration.

        They make s = 0 and s = 1 there; the gait problem holds its variables to them.
        """
        del robot, stance, first, last
        return ca.SX(0, 1)

    def breakpoints(self, stance: Stance, duration: float) -> tuple[float, ...]:
        """Return clocks at which the references are less smooth, ascending, s; none where the clock does not tell."""
        del stance, duration
        return ()


@dataclass(frozen=True)
class TimePhase(Phase):
    """s = t / T: time since the entry of the domain, over its planned duration."""

    name: ClassVar[str] = "time"

    @property
    def earliest(self) -> float:
        """The clock never lies before the entry."""
        return -inf

    def value(self, robot: Robot, stance: Stance, share: ca.SX, q: ca.SX, numbers: ca.SX) -> ca.SX:
        """Return the share itself."""
        del robot, stance, q, numbers
        return share

    def breakpoints(self, stance: Stance, duration: float) -> tuple[float, ...]:
        """The end of the polynomials."""
        del stance
        return (LATEST_PHASE * duration,)


@dataclass(frozen=True, kw_only=True)
class DomainPhase:
    """A phase in one domain of a robot.

    Attributes:
        phase: the phase.
        robot: the robot.
        stance: the domain.
    """

    phase: Phase
    robot: Robot
    stance: Stance

    def rates(self, share: ca.SX, duration: ca.SX, q: ca.SX, v: ca.SX, numbers: ca.SX) -> PhaseRates:
        """Differentiate the phase along a motion.

        With z = (t / T, q) and z' = (1 / T, v): s' = s_z z', s'' = J_s a + (s_z z')_z z'.
        """
        # shorthand
        z = ca.vertcat(tau := ca.SX.sym("share"), at := ca.SX.sym("q", self.robot.size))
        dz = ca.vertcat(pace := ca.SX.sym("pace"), along := ca.SX.sym("v", self.robot.size))
        given = ca.SX.sym("numbers", len(self.phase.numbers))

        s = ca.SX(self.phase.value(self.robot, self.stance, tau, at, given))
        slope = ca.jacobian(s, z)
        rate = slope @ dz
        parts = [s, rate, slope[:, 1:], ca.jacobian(rate, z) @ dz]
        function = ca.Function("phase", [tau, at, pace, along, given], parts)
        return PhaseRates(*function(share, q, 1.0 / duration, v, numbers))

    def along(
        self, times: Vector, duration: float, q: NodeValues, v: NodeValues, numbers: Vector
    ) -> tuple[Vector, Vector]:
        """Return s and s' along a motion, (n,) each.

        Args:
            times: clock, (n,), s.
            duration: T, s.
            q: coordinates, (n, n_q).
            v: their rates, (n, n_q).
            numbers: of this domain, (k,).

        Raises:
            InputError: the phase does not grow all along.
        """
        value, rate = self.sampled(times, duration, q, v, numbers)
        if not np.all(rate > 0.0):
            raise InputError(
                f"phase '{self.phase.name}' does not grow all along domain '{self.stance.name}': "
                f"its rate falls to {np.min(rate):.3g} 1/s"
            )
        return value, rate

    def sampled(
        self, times: Vector, duration: float, q: NodeValues, v: NodeValues, numbers: Vector
    ) -> tuple[Vector, Vector]:
        """Return s and s' as ``along`` does, whether the phase grows or not."""
        size = self.robot.size
        share, at, moving = ca.SX.sym("share"), ca.SX.sym("q", size), ca.SX.sym("v", size)
        rates = self.rates(share, ca.SX(duration), at, moving, ca.SX(ca.DM(numbers)))
        function = ca.Function("sampled", [share, at, moving], [ca.densify(rates.value), ca.densify(rates.rate)])
        value, rate = (np.asarray(part)[0] for part in function.map(len(times))(times[None] / duration, q.T, v.T))
        return value, rate

    def measured(self, first: Vector, last: Vector) -> Vector:
        """Return the numbers of a motion from its first to its last configuration, (k,)."""
        ends = [ca.SX(ca.DM(end)) for end in (first, last)]
        found = ca.evalf(self.phase.measured(self.robot, self.stance, *ends))
        return found.full().reshape(-1)


PHASES: Registry[Phase] = Registry("phase")
"""The phases that files and specifications can name."""

PHASES.register(TimePhase.name, TimePhase)
