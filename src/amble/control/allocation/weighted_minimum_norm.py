"""The smallest torques in the least-squares sense (the paper's law), or weighted, such as the least heat of motors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca

from amble.control.allocation.law import AllocationLaw, Redundancy, finite
from amble.errors import InputError, UnknownNameError, shown
from amble.numerics.linear_algebra import SymmetricFactor


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


@dataclass(frozen=True)
class WeightedMinimumNorm(AllocationLaw):
    """Minimise sum_j m_j u_j^2: s = -(N^T M N)^-1 N^T M u_p (docs/theory/allocation.md, eq. 7).

    Attributes:
        weights: joint -> m_j > 0, for instance R / (N K_t)^2 of its actuator, W/(N m)^2; joints not named weigh 1.

    Raises:
        InputError: where a weight is not finite and positive.
    """

    units: ClassVar[Mapping[str, str]] = {"weights": "1"}

    weights: Mapping[str, float]

    def __post_init__(self) -> None:
        """Refuse weights without a minimum."""
        if not isinstance(self.weights, Mapping):
            raise InputError(f"the weights are {shown(self.weights)}, not a number for every joint")
        for joint, weight in self.weights.items():
            if not finite(f"weight of joint '{shown(joint)}'", weight) > 0.0:
                raise InputError(f"the weight of joint '{shown(joint)}' is {weight}; it must be finite and positive")

    def __hash__(self) -> int:
        """Laws key what is built for them; a mapping has no hash of its own."""
        return hash(frozenset(self.weights.items()))

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "weighted"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The weights."""
        return {"weights": dict(self.weights)}

    def optimality_conditions(self, redundancy: Redundancy) -> ca.SX:
        """N^T M u = 0: smooth, without a matrix inverse."""
        return (self._weighted(redundancy)).T @ redundancy.torques

    def allocate(self, redundancy: Redundancy) -> ca.SX:
        """Solve N^T M (u + N s) = 0."""
        if not redundancy.size:
            return ca.SX(0, 1)
        weighted = self._weighted(redundancy)
        return SymmetricFactor.of(redundancy.torque_basis.T @ weighted).solve(-weighted.T @ redundancy.torques)

    def _weighted(self, redundancy: Redundancy) -> ca.SX:
        """M N.

        Raises:
            UnknownNameError: where a weight names a joint that the robot does not have.
        """
        names = redundancy.robot.joint_names
        for joint in self.weights:
            if joint not in names:
                raise UnknownNameError("joint", joint, names)
        weights = ca.DM([float(self.weights.get(joint, 1.0)) for joint in names])
        # a product of matrices, for casadi multiplies no entries of a basis without columns
        return ca.mtimes(ca.SX(ca.diag(weights)), redundancy.torque_basis)
