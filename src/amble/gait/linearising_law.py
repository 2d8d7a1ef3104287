"""The feedback law of the paper as a control law: input-output linearisation of a gait's virtual constraints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from amble.control import AllocationLaw
from amble.control.closed_loop import StanceLoop, stance_equations, stance_loops
from amble.control.loop_equations import LoopEquations
from amble.control.outputs import controllable
from amble.control.phase import DomainPhase
from amble.gait.constraints import REFERENCE_ORDER, loop_parameters
from amble.gait.control_law import CONTROL_LAWS, ControlLaw, Numbers
from amble.gait.record import Gait
from amble.hybrid import Stance, Symmetry
from amble.numerics.unseen import switches
from amble.types import Vector

LINEARISATION = "input-output linearisation"

PROBES, PRESERVED = 3, 1e-9
"""Configurations at which a symmetry is held against the phase, and the slope, relative, that counts as none."""


@dataclass(frozen=True)
class InputOutputLinearisation(ControlLaw):
    """Torques that make the outputs obey y'' + K_d y' + K_p y = 0 (paper, eq. 7 and 8).

    Attributes:
        position_gain: K_p, 1/s^2.
        velocity_gain: K_d, 1/s.
    """

    units: ClassVar[Mapping[str, str]] = {"position_gain": "1/s^2", "velocity_gain": "1/s"}

    position_gain: float
    velocity_gain: float

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return LINEARISATION

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The gains."""
        return {"position_gain": self.position_gain, "velocity_gain": self.velocity_gain}

    def numbers(self, gait: Gait, allocation: AllocationLaw | None) -> tuple[Numbers, ...]:
        """Pack the virtual constraints with these gains; the breakpoints are those of the phase."""
        del allocation
        found = []
        for stance in gait.pattern.solved:
            p = self.packed(gait, stance.name)
            found.append(Numbers(parameters=p, breakpoints=gait.outputs.phase.breakpoints(stance, float(p[0]))))
        return tuple(found)

    def loops(
        self, gait: Gait, allocation: AllocationLaw | None, numbers: tuple[Numbers, ...]
    ) -> tuple[StanceLoop, ...]:
        """Compile the loops; the gains are among the parameters, so that loops of all gains share their code."""
        del numbers
        return stance_loops(
            gait.pattern,
            allocation or gait.law,
            [len(gait.outputs.of(stance.name).coordinates) for stance in gait.pattern.solved],
            REFERENCE_ORDER,
            gait.outputs.phase,
            gait.limits.normal_force,
        )

    def equations(self, gait: Gait, stance: Stance, size: int) -> tuple[list[ca.SX], LoopEquations]:
        """Write the dynamics, the outputs' and the allocation law's conditions."""
        del size
        count, contacts = len(gait.outputs.of(stance.name).coordinates), gait.pattern.contacts(stance)
        return stance_equations(contacts, gait.law, stance, count, REFERENCE_ORDER, gait.outputs.phase)

    def packed(self, gait: Gait, domain: str) -> Vector:
        """Pack the virtual constraints of a solved domain with these gains."""
        return loop_parameters(self._of(gait), domain)

    def keeps(self, gait: Gait, symmetry: Symmetry) -> bool:
        """Whether no output sees a turn, and the phase none of the symmetries."""
        return (symmetry.name != "yaw" or not _sees_orientation(gait)) and keeps_phase(gait, symmetry)

    def _of(self, gait: Gait) -> Gait:
        return replace(gait, gains=(self.position_gain, self.velocity_gain))


CONTROL_LAWS.register(LINEARISATION, InputOutputLinearisation)


def control_of(gait: Gait) -> ControlLaw:
    """Return a gait's own feedback law: input-output linearisation with its gains where it names no other."""
    return gait.control or InputOutputLinearisation(*gait.gains)


def keeps_phase(gait: Gait, symmetry: Symmetry) -> bool:
    """Whether neither the phase of every domain nor a switch in it has a slope along a symmetry.

    At random configurations: a phase may be written with what the symmetry moves, and not change.
    """
    size = gait.robot.size
    q, numbers = ca.SX.sym("q", size), ca.SX.sym("numbers", len(gait.outputs.phase.numbers))
    states = np.random.default_rng(0).normal(0.0, 0.5, (PROBES, 2 * size))
    for stance in gait.pattern.solved:
        domain = DomainPhase(phase=gait.outputs.phase, robot=gait.robot, stance=stance)
        value = domain.rates(ca.SX(1, 1), ca.SX(1.0), q, ca.SX(size, 1), numbers).value
        slopes = ca.jacobian(ca.vertcat(value, switches(value)), q)
        function = ca.Function("slopes", [q, numbers], [ca.densify(slopes)])
        for state in states:
            rows = np.asarray(function(state[:size], domain.measured(state[:size], state[size:])))
            direction = np.asarray(symmetry.generator(state))[:size].ravel()
            scale = PRESERVED * np.linalg.norm(rows, axis=1) * np.linalg.norm(direction)
            if not np.all(np.abs(rows @ direction) <= scale):
                return False
    return True


def _sees_orientation(gait: Gait) -> bool:
    """Whether any output depends on roll, pitch or yaw, the first coordinates of y_a."""
    angles = len(controllable(gait.robot)) - len(gait.robot.joints)
    if gait.feedback is not None:
        return any(bool(np.any(weights[:, :angles])) for weights in gait.feedback.weights.values())
    return any(name in ("roll", "pitch", "yaw") for domain in gait.outputs.domains for name in domain.coordinates)
