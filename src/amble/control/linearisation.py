"""Input-output linearisation of one stance: torques that make y'' + K_d y' + K_p y = 0 (paper, eq. 7 and 8).

A phase variable that depends on the configuration answers to the motion that it drives. The reference's acceleration
holds B' s'' with s'' = J_s a + bias, so s'' is one more unknown beside the accelerations. The equations of motion are
linear: with a_1 their answer to w = B', and a_0 the one to everything else,

    a = a_0 + a_1 d,  d = J_s a  =>  d = J_s a_0 / (1 - J_s a_1).                                              (1)

The factored equations stay those of the output weights alone, and where the phase is time nothing is added.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation import AllocationLaw, Redundancy
from amble.control.motion_equations import MotionEquations
from amble.control.phase import PhaseRates
from amble.control.virtual_constraints import VirtualConstraints, commanded_acceleration, reference_slope
from amble.hybrid import Contacts
from amble.robot import dynamics


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


@dataclass(frozen=True, kw_only=True)
class Linearised:
    """The closed loop of one stance.

    Attributes:
        acceleration: q'', (n_q,).
        torques: u, (n_joints,), N m.
        forces: contact forces of the stance feet, world frame, (n_f,), N.
        redundancy: the free directions at this state, with the minimum-norm torques.
        equations: the factored equations of motion; their pivots tell when the outputs cannot be decoupled.
        phase: the phase variable.
        closure: how the motion answers through the phase, None where the phase is a matter of time alone.
    """

    acceleration: ca.SX
    torques: ca.SX
    forces: ca.SX
    redundancy: Redundancy
    equations: MotionEquations
    phase: PhaseRates
    closure: PhaseClosure | None

    @property
    def pivot(self) -> ca.SX:
        """Smallest pivot of the equations: its distance from lost rank."""
        pivots = self.equations.pivots
        return ca.mmin(pivots if self.closure is None else ca.vertcat(pivots, self.closure.pivot))


def linearise(
    contacts: Contacts,
    law: AllocationLaw,
    q: ca.SX,
    v: ca.SX,
    phase: PhaseRates,
    constraints: VirtualConstraints,
    pushed: ca.SX | None = None,
) -> Linearised:
    """Write the closed loop of a stance as expressions.

    Of all torques that realise the motion, N^T u = 0 with N spanning those that cause no acceleration picks the
    minimum-norm solution A^+ r of the paper's eq. 8 (docs/theory/allocation.md, eq. 6); the law then moves along N.

    Args:
        contacts: the stance feet on their ground.
        law: the allocation law.
        q: coordinates, (n_q,).
        v: their rates, (n_q,).
        phase: the phase variable there.
        constraints: gains, references and output null space.
        pushed: what is added to the commanded accelerations w, to see what answers, (n_a,).

    Raises:
        InputError: where the stance does not allow exactly as many outputs.
    """
    # shorthand
    h = dynamics.bias(contacts.robot, q, v)
    J = (equations := MotionEquations.of(contacts, q, constraints.null_space)).jacobian

    commanded = commanded_acceleration(q, v, phase, constraints, phase.bias)
    commanded = commanded if pushed is None else commanded + pushed
    # with u = (D a + h - J^T lambda)_joints, N^T u = 0 is a row for a and lambda, next to the base's
    a, smallest = equations.solve(commanded, -contacts.bias(q, v), -equations.rows @ h)
    closure = PhaseClosure.of(equations, phase, reference_slope(phase, constraints)) if phase.by_state else None
    if closure is not None:
        a, smallest = closure.answered(a, smallest)
    u = (equations.mass @ a + h - J.T @ smallest)[contacts.robot.base.size :]
    redundancy = Redundancy.at(contacts, (q, v), (u, smallest), (equations.torque_basis, equations.force_basis))
    chosen = redundancy.moved(law.allocate(redundancy))
    return Linearised(
        acceleration=a,
        torques=chosen.loads,
        forces=chosen.forces,
        redundancy=redundancy,
        equations=equations,
        phase=phase,
        closure=closure,
    )
