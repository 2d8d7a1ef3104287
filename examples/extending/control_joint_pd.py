"""A feedback law of one's own: joint impedance about the recorded motion. One class, one registration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.control_law import CONTROL_LAWS, TorqueLaw
from amble.hybrid import Contacts, Stance
from amble.numerics.bezier import bernstein, bezier
from amble.types import Matrix, Vector, frozen

ORDER = 9
"""Of the Bezier curves through the recorded joint angles and torques."""


@dataclass(frozen=True)
class JointImpedance(TorqueLaw):
    """u = u_d(t) + K (q_d(t) - q_j) + D (q_d'(t) - q_j'): no model of the robot, no feedback of the base.

    u_d and q_d are Bezier curves of t / T, fitted to the motion of the gait problem; after T they keep their end.

    Attributes:
        stiffness: K of every joint, N m/rad.
        damping: D of every joint, N m s/rad.

    Raises:
        InputError: a gain is negative.
    """

    units: ClassVar[Mapping[str, str]] = {"stiffness": "N m/rad", "damping": "N m s/rad"}

    stiffness: float = 400.0
    damping: float = 10.0

    def __post_init__(self) -> None:
        """Refuse feedback that drives away."""
        if not (self.stiffness >= 0.0 and self.damping >= 0.0):
            raise InputError(f"stiffness {self.stiffness:g} and damping {self.damping:g} must not be negative")

    @property
    def name(self) -> str:
        """Name on the command line."""
        return "joint impedance"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Both gains."""
        return {"stiffness": self.stiffness, "damping": self.damping}

    def packed(self, gait: Gait, domain: str) -> Vector:
        """Pack duration, gains and the coefficients of both curves."""
        motion = next(part for part in gait.domains if part.name == domain)
        phase, joints = motion.times / motion.duration, len(gait.robot.joints)
        curves = [_fitted(values, phase) for values in (motion.positions[:, -joints:], motion.torques)]
        gains = np.array([motion.duration, self.stiffness, self.damping])
        return frozen(np.concatenate([gains, *(curve.ravel(order="F") for curve in curves)]))

    def breakpoints(self, gait: Gait, stance: Stance) -> tuple[float, ...]:
        """The end of the curves."""
        return (float(self.packed(gait, stance.name)[0]),)

    def gains(self, gait: Gait, domain: str) -> Mapping[str, int]:
        """Both gains, the same in every domain: where they stand in ``packed``."""
        del gait, domain
        return {"stiffness": 1, "damping": 2}

    def with_gains(self, values: Mapping[str, float]) -> JointImpedance:
        """Return the law that stabilisation chose."""
        return JointImpedance(values["stiffness"], values["damping"])

    def torques(self, contacts: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        """Write the law."""
        # shorthand
        joints = len(contacts.robot.joints)
        T, K, D = p[0], p[1], p[2]
        angles, torques = (ca.reshape(part, joints, ORDER + 1) for part in ca.vertsplit(p[3:], joints * (ORDER + 1)))

        inside = ca.fmin(t / T, 1.0)
        angle, slope, _ = bezier(angles, inside)
        feedforward, _, _ = bezier(torques, inside)
        rate = ca.if_else(t < T, slope / T, 0.0)
        return feedforward + K * (angle - q[-joints:]) + D * (rate - v[-joints:])


def _fitted(values: Matrix, phase: Vector) -> Matrix:
    """Coefficients of the curves nearest to samples (n, width), (width, order + 1)."""
    basis = np.array([bernstein(ORDER, float(at)) for at in phase])
    return frozen(np.linalg.lstsq(basis, values, rcond=None)[0].T)


CONTROL_LAWS.register("joint impedance", JointImpedance)
