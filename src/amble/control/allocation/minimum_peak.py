"""The smallest peak of the torques relative to what each joint can give."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation.law import LawWithBreakpoints, Redundancy, effort_limits, steered_joints
from amble.control.allocation.line import lowest_peak
from amble.numerics.interior_point import QuadraticProgram, minimise

TIE = 1e-9
"""Curvature that picks one of several torques with the same peak, relative to the peak."""


@dataclass(frozen=True)
class MinimumPeak(LawWithBreakpoints):
    """Minimise max_j |u_j| / u_max,j over the stance legs' joints (docs/theory/allocation.md, eq. 10).

    u_max,j is the effort limit of the robot's description.
    """

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "peak"

    def on_line(self, redundancy: Redundancy) -> ca.SX:
        """Minimise in closed form (eq. 11).

        Raises:
            InputError: where a joint has no effort limit.
        """
        u, N = _relative(redundancy)
        return lowest_peak(ca.vertsplit(u), ca.vertsplit(N))

    def in_space(self, redundancy: Redundancy) -> ca.SX:
        """Minimise as a linear program (eq. 19).

        Raises:
            InputError: where a joint has no effort limit.
        """
        return _in_space(*_relative(redundancy))


def _relative(redundancy: Redundancy) -> tuple[ca.SX, ca.SX]:
    """Torques of the joints that can be steered, and the free directions, relative to the joints' limits."""
    joints = steered_joints(redundancy)
    limit = effort_limits(redundancy, joints)
    return redundancy.torques[joints] / limit, redundancy.torque_basis[joints, :] / limit


def _in_space(u: ca.SX, N: ca.SX) -> ca.SX:
    """Three or six free directions: minimise t with |u + N s| <= t; the variables are (s, t), scaled to size one."""
    count, k = N.shape
    size = ca.norm_inf(u) + 1e-3
    unit = ca.sqrt(ca.sum1(N**2)).T / size
    N = N / ca.repmat(unit.T, count, 1) / size
    ones = ca.SX.ones(count)
    program = QuadraticProgram(
        hessian=ca.diagcat(TIE * ca.SX.eye(k), ca.SX(1, 1)),
        cost=ca.vertcat(ca.SX.zeros(k), 1.0),
        rows=ca.blockcat([[N, -ones], [-N, -ones]]),
        limits=ca.vertcat(-u, u) / size,
    )
    return minimise(program, ca.vertcat(ca.SX.zeros(k), 2.0))[:k] / unit
