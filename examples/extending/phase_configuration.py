"""A phase variable of the configuration: a linear form of the coordinates, from its value at the entry to the end.

One file and one registration. Import it before a gait file or a specification that names the phase is read::

    import amble
    from phase_configuration import ConfigurationPhase

    phase = ConfigurationPhase({"D1": {"y": -1.0}})
    outputs = amble.joint_outputs(pattern, phase=phase)

What the outputs do not control must move the phase: virtual constraints that hold the phase itself leave nothing to
drive it. Where nothing grows all through a domain, the domain is left out, and runs on time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca

from amble.control.phase import PHASES, Phase, PhaseNumber, TimePhase
from amble.errors import InputError
from amble.hybrid import Stance
from amble.robot import Robot, kinematics

Forms = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class ConfigurationPhase(Phase):
    """s = (theta(q) - theta_start) / (theta_end - theta_start) with theta(q) = sum_k c_k q_k; time where none is given.

    Attributes:
        coefficients: domain -> coordinate -> c_k; coordinates in m and rad, x and y from the middle of the stance feet,
            so that theta is the same wherever the robot walks.

    Raises:
        InputError: a domain has no coefficients.
    """

    name: ClassVar[str] = "configuration"
    coefficients: Forms

    def __post_init__(self) -> None:
        """Refuse forms that are empty."""
        for domain, form in self.coefficients.items():
            if not form:
                raise InputError(f"the phase of domain '{domain}' has no coordinate")

    def __hash__(self) -> int:
        """Phases key what is built for them; a mapping has no hash of its own."""
        return hash(tuple(sorted((name, tuple(sorted(form.items()))) for name, form in self.coefficients.items())))

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The coefficients."""
        return {"coefficients": {name: dict(form) for name, form in self.coefficients.items()}}

    @property
    def numbers(self) -> tuple[PhaseNumber, ...]:
        """Where theta begins and ends."""
        return PhaseNumber("theta_start", "1"), PhaseNumber("theta_end", "1")

    def value(self, robot: Robot, stance: Stance, share: ca.SX, q: ca.SX, numbers: ca.SX) -> ca.SX:
        """Return s; of a domain without a form the share of its duration."""
        if stance.name not in self.coefficients:
            return share
        return (self._theta(robot, stance, q) - numbers[0]) / (numbers[1] - numbers[0])

    def measured(self, robot: Robot, stance: Stance, first: ca.SX, last: ca.SX) -> ca.SX:
        """Return theta at both ends."""
        return ca.vertcat(self._theta(robot, stance, first), self._theta(robot, stance, last))

    def breakpoints(self, stance: Stance, duration: float) -> tuple[float, ...]:
        """Those of time where time drives the domain."""
        return () if stance.name in self.coefficients else TimePhase().breakpoints(stance, duration)

    def _theta(self, robot: Robot, stance: Stance, q: ca.SX) -> ca.SX:
        middle = ca.SX(3, 1)
        for foot in stance.feet:
            middle += kinematics.foot_position(robot, foot, q) / len(stance.feet)
        theta = ca.SX(0)
        for name, coefficient in self.coefficients.get(stance.name, {}).items():
            place = robot.coordinate_index(name)
            theta += coefficient * (q[place] - middle[place] if name in ("x", "y") else q[place])
        return theta


PHASES.register(ConfigurationPhase.name, ConfigurationPhase)
