"""The least electrical power, moment by moment: the integrand of the paper's own cost of transport."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from amble.control.actuator import ACTUATORS, Actuator, actuator_from
from amble.control.allocation.law import LawWithBreakpoints, Redundancy, steered_joints
from amble.control.allocation.line import lowest_with_breakpoints
from amble.numerics.interior_point import QuadraticProgram, minimise


@dataclass(frozen=True)
class MinimumPower(LawWithBreakpoints):
    """Minimise sum_j max(u_j w_j, 0) + r_j u_j^2, r_j = R / (N K_t)^2 of its motor (docs/theory/allocation.md, eq. 8).

    Attributes:
        actuator: the actuator model, or the name of one of ``amble.control.actuator.ACTUATORS``, or its fields by name
            as a file holds them.

    Raises:
        UnknownNameError: there is no actuator model of that name.
        InputError: what is given is no actuator model.
    """

    actuator: Actuator | str | Mapping[str, Any] = "paper"

    def __post_init__(self) -> None:
        """Refuse a model that does not exist; laws with the same model are equal, however it was given."""
        object.__setattr__(self, "actuator", _model(self.actuator))

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "power"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The actuator model: by name where amble knows it, else by its numbers."""
        model = _model(self.actuator)
        return {"actuator": model.name if model in ACTUATORS.entries else model.fields}

    def on_line(self, redundancy: Redundancy) -> ca.SX:
        """Minimise in closed form (eq. 9)."""
        return _on_line(redundancy, _model(self.actuator))

    def in_space(self, redundancy: Redundancy) -> ca.SX:
        """Minimise as a quadratic program (eq. 18)."""
        return _in_space(redundancy, _model(self.actuator))


def _model(given: Actuator | str | Mapping[str, Any]) -> Actuator:
    if not isinstance(given, Actuator | Mapping):  # a word of a file or of the command line
        return ACTUATORS[str(given)]
    return actuator_from(given, "allocation law 'power'")


def _heat(redundancy: Redundancy, model: Actuator, joints: Sequence[int]) -> ca.SX:
    """Return r of some joints, (n,)."""
    return ca.SX(ca.DM(model.heat_coefficients(redundancy.robot.joint_names)[joints]))


def _on_line(redundancy: Redundancy, model: Actuator) -> ca.SX:
    """One free direction: a parabola with one breakpoint a joint, max(x, 0) being (x + |x|) / 2."""
    # shorthand
    joints = steered_joints(redundancy)
    r = _heat(redundancy, model, joints)
    u, n, w = redundancy.torques[joints], redundancy.torque_basis[joints, 0], redundancy.speeds[joints]

    breakpoints = [-u[j] / ca.if_else(n[j] == 0, 1.0, n[j]) for j in range(len(joints))]
    weights = [0.5 * ca.fabs(n[j] * w[j]) for j in range(len(joints))]
    return lowest_with_breakpoints(
        2.0 * ca.dot(r * n, n), 2.0 * ca.dot(r * n, u) + 0.5 * ca.dot(n, w), breakpoints, weights
    )


def _in_space(redundancy: Redundancy, model: Actuator) -> ca.SX:
    """Three or six free directions: one bound a joint on its positive power, p >= u w and p >= 0.

    The variables are (p, s), s scaled so that a unit changes the torques by one newton metre.
    """
    # shorthand
    joints = steered_joints(redundancy)
    heat = _heat(redundancy, model, joints)
    r = ca.sum1(heat) / len(joints)
    count, k = len(joints), redundancy.size
    u, w = redundancy.torques[joints], redundancy.speeds[joints]
    unit = ca.sqrt(ca.sum1(redundancy.torque_basis**2)).T
    N = redundancy.torque_basis[joints, :] / ca.repmat(unit.T, count, 1)

    # power in units of its typical size: heat of the torques at hand plus their mechanical power
    size = r * ca.dot(u, u) + ca.norm_1(u * w) + r
    length = ca.sqrt(size / r)
    power = (w * N) * length / size
    program = QuadraticProgram(
        hessian=ca.diagcat(ca.SX(count, count), 2.0 * (N.T @ (heat / r * N))),
        cost=ca.vertcat(ca.SX.ones(count), 2.0 * length / size * (N.T @ (heat * u))),
        rows=ca.blockcat([[-ca.SX.eye(count), ca.SX(count, k)], [-ca.SX.eye(count), power]]),
        limits=ca.vertcat(ca.SX.zeros(count), -u * w / size),
    )
    start = ca.vertcat(ca.fmax(u * w / size, 0.0) + 1.0 / count, ca.SX.zeros(k))
    return minimise(program, start)[count:] * length / unit
