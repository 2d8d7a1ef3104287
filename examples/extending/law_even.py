"""An allocation law of one's own: every motor works equally hard. One class, one registration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca

from amble.control import LAWS, AllocationLaw, Redundancy
from amble.control.allocation.law import effort_limits, finite, steered_joints
from amble.errors import InputError
from amble.numerics.linear_algebra import SymmetricFactor


@dataclass(frozen=True)
class EvenTorques(AllocationLaw):
    """Minimise sum_j r_j^2 + k sum_j (r_j - mean r)^2 over the stance legs' joints, r_j = u_j / its limit.

    With L the diagonal of the torque limits that is u^T L^-1 Q L^-1 u, Q = 1 + k (1 - e e^T / n): quadratic, so its
    conditions are smooth and close a gait problem, and the controller solves one small linear system.

    Attributes:
        evenness: k, how much the spread counts beside the size.

    Raises:
        InputError: the evenness is negative or not a number.
    """

    units: ClassVar[Mapping[str, str]] = {"evenness": "1"}

    evenness: float = 10.0

    def __post_init__(self) -> None:
        """Refuse a spread that would be sought."""
        if finite("evenness", self.evenness) < 0.0:
            raise InputError(f"the evenness is {self.evenness:g}; it must not be negative")

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "even"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """What a file holds, besides the name."""
        return {"evenness": self.evenness}

    def optimality_conditions(self, redundancy: Redundancy) -> ca.SX:
        """N^T L^-1 Q L^-1 u = 0."""
        joints = steered_joints(redundancy)
        return self._weighted(redundancy, joints).T @ redundancy.torques[joints]

    def allocate(self, redundancy: Redundancy) -> ca.SX:
        """Solve the conditions for u + N s."""
        if not redundancy.size:
            return ca.SX(0, 1)
        joints = steered_joints(redundancy)
        weighted = self._weighted(redundancy, joints)
        return SymmetricFactor.of(redundancy.torque_basis[joints, :].T @ weighted).solve(
            -weighted.T @ redundancy.torques[joints]
        )

    def _weighted(self, redundancy: Redundancy, joints: list[int]) -> ca.SX:
        """L^-1 Q L^-1 N in units of the mean limit, so that the conditions stay torques."""
        # shorthand
        count, limits = len(joints), effort_limits(redundancy, joints)
        scale = ca.sum1(limits) / count / limits

        N = redundancy.torque_basis[joints, :] * ca.repmat(scale, 1, redundancy.size)
        spread = N - ca.repmat(ca.sum1(N) / count, count, 1)
        return (N + self.evenness * spread) * ca.repmat(scale, 1, redundancy.size)


LAWS.register("even", EvenTorques)
