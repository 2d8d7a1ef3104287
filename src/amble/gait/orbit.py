"""The closed loop's own orbit of a stabilised gait as curves of time, with the torques of any allocation law along it.

Under input-output linearisation the orbit starts at ``Feedback.start`` and lasts ``Feedback.durations``. No allocation
law changes it, so its states are integrated once, and torques and contact forces follow from them for every law.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.control import AllocationLaw
from amble.control.closed_loop import StanceLoop, stance_loops
from amble.control.phase import LATEST_PHASE
from amble.errors import InputError, WorkError
from amble.gait.constraints import REFERENCE_ORDER, loop_parameters
from amble.gait.record import Gait
from amble.numerics.pieces import SAMPLES, Pieces, fitted, piece
from amble.types import Matrix, Vector, frozen

TOLERANCE = 1e-13
"""Of the integrator."""

PANELS = 3
"""Polynomial pieces that the states of a domain are written in; three meet the rates of ASTRo's amble to 1e-10."""

ACCURACY = 1e-10
"""Of torques, as a share of the orbit's largest."""


@dataclass(frozen=True, kw_only=True)
class OrbitArc:
    """The orbit in one solved domain, from its entry to a little after its planned end.

    Attributes:
        domain: its name.
        duration: planned end, s; the curves go on to 1.05 of it, where the references do.
        states: (q, v) over the clock, 2 n_q rows.
        torques: the allocation law's over the clock, n_joints rows, N m; cut where it has corners, and where
            ``states`` are.
    """

    domain: str
    duration: float
    states: Pieces
    torques: Pieces

    @property
    def joints(self) -> Pieces:
        """Joint angles, n_joints rows, rad, cut as ``torques`` are."""
        count, size = self.torques.coefficients.shape[1], self.states.coefficients.shape[1] // 2
        angles = Pieces(breaks=self.states.breaks, coefficients=self.states.coefficients[:, size - count : size])
        return angles.cut(self.torques.breaks)


def orbit_arcs(gait: Gait, law: AllocationLaw) -> tuple[OrbitArc, ...]:
    """Integrate the closed loop's own orbit through the solved domains and allocate the torques along it.

    Args:
        gait: a stabilised gait, or one with the feedback of its own orbit.
        law: the allocation law; where its torques have corners, the pieces end there.

    Raises:
        InputError: the gait has no feedback, so that its own orbit is not known.
        WorkError: the integration fails, or a torque is not finite.
    """
    if gait.feedback is None:
        raise InputError(
            "this gait does not hold its closed loop's own orbit, which the control law follows; stabilise it first "
            "(`amble stabilize GAIT`, `amble.stabilize(gait)`)"
        )
    pattern = gait.pattern
    counts = [len(gait.outputs.of(stance.name).coordinates) for stance in pattern.solved]
    loops = stance_loops(pattern, law, counts, REFERENCE_ORDER, gait.outputs.phase, gait.limits.normal_force)
    entry, found = np.asarray(gait.feedback.start, dtype=np.float64), list[OrbitArc]()
    for stance, loop in zip(pattern.solved, loops, strict=True):
        duration, p = gait.feedback.durations[stance.name], loop_parameters(gait, stance.name)
        states = _states(loop, entry, duration, p)
        found.append(
            OrbitArc(domain=stance.name, duration=duration, states=states, torques=_torques(loop, states, duration, p))
        )
        before = states(np.array([duration]))[0][0]
        entry = np.asarray(loop.reset(duration, before, p)).ravel()
    return tuple(found)


def _states(loop: StanceLoop, entry: Vector, duration: float, p: Vector) -> Pieces:
    """Integrate one domain and write its motion in pieces."""
    from scipy.integrate import solve_ivp

    end = LATEST_PHASE * duration
    clock = np.concatenate([0.5 * end / PANELS * (2 * panel + 1 + SAMPLES) for panel in range(PANELS)])
    times, places = np.unique(np.clip(clock, 0.0, end), return_inverse=True)

    def rate(t: float, x: Vector) -> Vector:
        return np.asarray(loop.field(t, x, p)).ravel()

    motion = solve_ivp(
        rate, (0.0, end), entry, "DOP853", times, rtol=TOLERANCE, atol=TOLERANCE, max_step=0.25 * end / PANELS
    )
    if not motion.success:
        raise WorkError(f"the closed loop's own orbit cannot be integrated: {motion.message}")
    values = motion.y.T[places]
    panels = values.reshape(PANELS, SAMPLES.size, entry.size)
    coefficients = np.array([piece(panel)[0] for panel in panels])
    return Pieces(breaks=frozen(np.linspace(0.0, end, PANELS + 1)), coefficients=frozen(coefficients))


def _torques(loop: StanceLoop, states: Pieces, duration: float, p: Vector) -> Pieces:
    """Allocate along the motion of a domain."""
    arguments = [ca.MX.sym(name, loop.signals.numel_in(place)) for place, name in enumerate("txp")]
    torque = ca.Function("torque", arguments, [loop.signals(*arguments)[loop.signals.name_out().index("torque")]])
    everywhere = torque.map(SAMPLES.size)

    def along(times: Vector) -> Matrix:
        at = states(times)[0]
        return np.asarray(everywhere(times[None], at.T, np.tile(p[:, None], len(times)))).T

    end = LATEST_PHASE * duration
    size = float(np.abs(along(np.linspace(0.0, end, SAMPLES.size))).max())
    return fitted(along, 0.0, end, ACCURACY * max(size, np.finfo(np.float64).tiny)).cut(states.breaks)
