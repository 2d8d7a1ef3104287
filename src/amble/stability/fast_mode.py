"""The fastest mode of the velocity loop, feet pinned and one of them lost, and the delay that it bears.

With K = du/dv the rate feedback of a control law and the feet of a set held, rates obey v' = N B K v beside slower
terms, N the inverse mass among motions that the held feet leave free. A control law that is made for pinned feet keeps
its feedback where a foot slips or bounces, on the bare inertia of a leg: its loop is then as fast as an eigenvalue of
that N B K, and a late command makes a mode of rate omega swing up from a delay of pi / (2 omega) on.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import casadi as ca
import numpy as np

from amble.hybrid import Contacts, Domain
from amble.hybrid.constrained_dynamics import selection
from amble.robot import dynamics
from amble.simulation import simulate
from amble.simulation.bound import bind
from amble.stability.input_gains import CycleMap
from amble.types import Json, Matrix, Vector

NODES = 7
"""States of every stance that are looked at."""

STEP = 1e-5
"""Of the differences in the rates, in sqrt(g / l)."""


@dataclass(frozen=True, kw_only=True)
class FastMode:
    """The fastest mode over a gait cycle.

    Attributes:
        pinned: rate with all stance feet held, 1/s.
        lost: largest rate where one stance foot is not held, 1/s.
        flight: rate with no foot held, 1/s.
        growth: largest real part of any of these modes, 1/s: positive where one grows without delay.
    """

    pinned: float
    lost: float
    flight: float
    growth: float

    @property
    def delay_limits(self) -> tuple[float, float]:
        """Delays that the fastest mode bears, s: with the feet pinned, and where one is lost."""
        pinned, lost = (pi / (2.0 * rate) if rate > 0.0 else inf for rate in (self.pinned, max(self.lost, self.flight)))
        return pinned, lost

    def to_dict(self) -> Json:
        """Return it as a dictionary for a JSON file."""
        pinned, lost = self.delay_limits
        return {**vars(self), "delay_limit_pinned_s": pinned, "delay_limit_contact_lost_s": lost}


def fast_mode(cycle: CycleMap) -> FastMode:
    """Look for the fastest modes along the orbit of a gait."""
    gait, size = cycle.gait, cycle.gait.robot.size
    trace = simulate(cycle.loop, cycle.state, 1, 1e-8, samples=NODES)
    found, step = np.zeros(4), STEP * float(np.sqrt(gait.robot.gravity / gait.robot.leg_length))
    for stance in gait.pattern.solved:
        domain, number = cycle.loop.domain(stance.name), [d.name for d in cycle.loop.domains].index(stance.name)
        terms = _terms(gait.pattern.all_contacts)
        rows = np.flatnonzero(trace.domain == number)
        for clock, state in zip(trace.clock[rows], trace.state[rows], strict=True):
            feedback = _feedback(domain, float(clock), state, step)
            D, J = (np.asarray(part) for part in terms(state[:size]))
            drive = np.asarray(ca.DM(selection(gait.robot))) @ feedback
            all_rows = {foot: gait.pattern.all_contacts.slice(foot) for foot in gait.robot.foot_names}
            held = [J[all_rows[foot]] for foot in stance.feet]
            sets = [held, *(held[:k] + held[k + 1 :] for k in range(len(held))), []]
            modes = [np.linalg.eigvals(_mobility(D, each) @ drive) for each in sets]
            rates = [float(np.abs(values).max()) for values in modes]
            growth = max(float(values.real.max()) for values in modes)
            found = np.maximum(found, [rates[0], max(rates[1:-1], default=0.0), rates[-1], growth])
    pinned, lost, flight, growth = map(float, found)
    return FastMode(pinned=pinned, lost=lost, flight=flight, growth=growth)


def _feedback(domain: Domain, clock: float, state: Vector, step: float) -> Matrix:
    """du/dv by central differences, (n_joints, n_q)."""
    signals, size = domain.signals, state.size // 2
    if signals is None:
        return np.zeros((0, size))
    place, bound = signals.name_out().index("torque"), bind(signals, domain.parameters)
    columns = []
    for k in range(size):
        change = np.zeros(2 * size)
        change[size + k] = step
        ahead, behind = (bound(clock, state + sign * change)[place] for sign in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * step))
    return np.asarray(np.column_stack(columns), dtype=np.float64)


def _terms(contacts: Contacts) -> ca.Function:
    q = ca.SX.sym("q", contacts.robot.size)
    return ca.Function("terms", [q], [ca.densify(dynamics.mass_matrix(contacts.robot, q)), contacts.jacobian(q)])


def _mobility(D: Matrix, held: list[Matrix]) -> Matrix:
    """Inverse mass among the motions that held feet leave free, (n_q, n_q)."""
    inverse = np.asarray(np.linalg.inv(D), dtype=np.float64)
    if not held:
        return inverse
    J = np.vstack(held)
    moved = inverse @ J.T
    return np.asarray(inverse - moved @ np.linalg.solve(J @ moved, moved.T))
