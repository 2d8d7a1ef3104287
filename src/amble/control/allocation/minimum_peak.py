"""The smallest peak of the torques relative to what each joint can give."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation.law import AllocationLaw, Redundancy, effort_limits, steered_joints
from amble.control.allocation.line import lowest_peak
from amble.numerics.interior_point import QuadraticProgram, minimise

TIE = 1e-9
"""Curvature that picks one of several torques with the same peak, relative to the peak."""


@dataclass(frozen=True)
class MinimumPeak(AllocationLaw):
    """Minimise max_j |u_j| / u_max,j over the stance legs' joints (docs/theory/allocation.md, eq. 10).

    u_max,j is the effort limit of the robot's description.
    """

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "peak"

    def allocate(self, redundancy: Redundancy) -> ca.SX:
        """Minimise exactly: on a line in closed form (eq. 11), else as a linear program (eq. 19).

        Raises:
            InputError: where a joint has no effort limit.
        """
        if not redundancy.size:
            return ca.SX(0, 1)
        joints = steered_joints(redundancy)
        limit = effort_limits(redundancy, joints)
        u, N = redundancy.torques[joints] / limit, redundancy.torque_basis[joints, :] / limit
        if redundancy.size == 1:
            return lowest_peak([u[j] for j in range(len(joints))], [N[j, 0] for j in range(len(joints))])
        return _in_space(u, N)


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
