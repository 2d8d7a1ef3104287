"""Input-output linearisation of one stance: torques that make y'' + K_d y' + K_p y = 0 (paper, eq. 7 and 8)."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation import AllocationLaw, Redundancy
from amble.control.motion_equations import BASE_SIZE, MotionEquations
from amble.control.phase import PhaseRates
from amble.control.phase_closure import PhaseClosure
from amble.control.virtual_constraints import VirtualConstraints, commanded_acceleration, reference_slope
from amble.hybrid import Contacts
from amble.robot import dynamics


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

    Raises:
        InputError: where the stance does not allow exactly as many outputs.
    """
    # shorthand
    h = dynamics.bias(contacts.robot, q, v)
    J = (equations := MotionEquations.of(contacts, q, constraints.null_space)).jacobian

    commanded = commanded_acceleration(q, v, phase, constraints, phase.bias)
    # with u = (D a + h - J^T lambda)_joints, N^T u = 0 is a row for a and lambda, next to the base's six
    a, smallest = equations.solve(commanded, -contacts.bias(q, v), -equations.rows @ h)
    closure = PhaseClosure.of(equations, phase, reference_slope(phase, constraints)) if phase.by_state else None
    if closure is not None:
        a, smallest = closure.answered(a, smallest)
    u = (equations.mass @ a + h - J.T @ smallest)[BASE_SIZE:]
    redundancy = Redundancy.at(contacts, (q, v), (u, smallest), (equations.torque_basis, equations.force_basis))
    chosen = redundancy.moved(law.allocate(redundancy))
    return Linearised(
        acceleration=a,
        torques=chosen.torques,
        forces=chosen.forces,
        redundancy=redundancy,
        equations=equations,
        phase=phase,
        closure=closure,
    )
