"""The paper's law: the smallest torques, in the least-squares sense, that realise the motion."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation.law import AllocationLaw, Redundancy


@dataclass(frozen=True)
class PseudoInverse(AllocationLaw):
    """u = A^+ r (paper, eq. 8): u is orthogonal to every torque that causes no acceleration."""

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "pinv"

    def optimality_conditions(self, redundancy: Redundancy) -> ca.SX:
        """N^T u = 0: smooth, without a matrix inverse."""
        return redundancy.torque_basis.T @ redundancy.torques

    def allocate(self, redundancy: Redundancy) -> ca.SX:
        """Stay at the minimum-norm member."""
        return ca.SX.zeros(redundancy.size)
