"""How a motion answers through a phase variable that depends on the configuration.

The reference's acceleration holds B' s'' with s'' = J_s a + bias, so s'' is one more unknown beside the accelerations.
The equations of motion are linear: with a_1 their answer to w = B', and a_0 the one to everything else,

    a = a_0 + a_1 d,  d = J_s a  =>  d = J_s a_0 / (1 - J_s a_1).                                              (1)

The factored equations stay those of the output weights alone, and where the phase is time nothing is added.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.motion_equations import MotionEquations
from amble.control.phase import PhaseRates


@dataclass(frozen=True, kw_only=True)
class PhaseClosure:
    """The answer of equation (1).

    Attributes:
        gradient: J_s, (1, n_q).
        slope: B', (n_a,).
        acceleration: a_1, (n_q,).
        forces: contact forces that go with it, (3 n_c,).
        gain: 1 - J_s a_1; zero where the outputs hold the phase itself, so that nothing drives it.
    """

    gradient: ca.SX
    slope: ca.SX
    acceleration: ca.SX
    forces: ca.SX
    gain: ca.SX

    @classmethod
    def of(cls, equations: MotionEquations, phase: PhaseRates, slope: ca.SX) -> PhaseClosure:
        """Solve for the answer to w = B'."""
        contact, load = ca.SX(equations.jacobian.shape[0], 1), ca.SX(equations.rows.shape[0], 1)
        acceleration, forces = equations.solve(slope, contact, load)
        gain = 1.0 - phase.gradient @ acceleration
        return cls(gradient=phase.gradient, slope=slope, acceleration=acceleration, forces=forces, gain=gain)

    @property
    def pivot(self) -> ca.SX:
        """Size of the gain, at most about 1: its distance from lost rank, as the pivots of the equations are."""
        return ca.fabs(self.gain) / ca.sqrt(1.0 + (1.0 - self.gain) ** 2)

    def second(self, acceleration: ca.SX, known: ca.SX | float = 0.0) -> ca.SX:
        """Return what is missing of s'' when a_0 alone is known, (1, m), one column a case.

        Args:
            acceleration: a_0, (n_q, m).
            known: part of s'' that is no product of J_s and accelerations, (1, m).
        """
        return (self.gradient @ acceleration + known) / self.gain

    def answered(self, acceleration: ca.SX, forces: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return accelerations and contact forces with the answer, from those without it, one column a case."""
        second = self.second(acceleration)
        return acceleration + self.acceleration @ second, forces + self.forces @ second
