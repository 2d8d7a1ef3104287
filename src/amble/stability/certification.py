"""Certification of a gait, or of the periodic orbit of any hybrid system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import overload

from amble.control import AllocationLaw
from amble.errors import CertificateError, InputError
from amble.gait import Gait
from amble.hybrid import HybridSystem
from amble.progress import Progress
from amble.residual import Residual
from amble.stability.certificate import TOLERANCES, Certificate, assess
from amble.stability.disturbance import disturb
from amble.stability.gait_certificate import certified_orbit
from amble.stability.landing_orders import LandingOrders, in_order, landing_orders
from amble.stability.poincare import TIME_LIMIT
from amble.types import Vector


@overload
def certify(
    subject: Gait,
    *,
    conditions: Sequence[Residual] = (),
    tolerances: Sequence[float] = TOLERANCES,
    time_limit: float = TIME_LIMIT,
    allow_absurd_limits: bool = False,
    law: AllocationLaw | None = None,
    progress: Progress | None = None,
    max_step: float | None = None,
) -> Certificate: ...


@overload
def certify(
    subject: HybridSystem,
    state: Vector,
    conditions: Sequence[Residual] = (),
    tolerances: Sequence[float] = TOLERANCES,
    time_limit: float = TIME_LIMIT,
    *,
    progress: Progress | None = None,
    cycles: int = 1,
    max_step: float | None = None,
) -> Certificate: ...


def certify(
    subject: Gait | HybridSystem,
    state: Vector | None = None,
    conditions: Sequence[Residual] = (),
    tolerances: Sequence[float] = TOLERANCES,
    time_limit: float = TIME_LIMIT,
    *,
    allow_absurd_limits: bool = False,
    law: AllocationLaw | None = None,
    progress: Progress | None = None,
    cycles: int = 1,
    max_step: float | None = None,
) -> Certificate:
    """Certify, to the accuracy of the numerics, that an orbit is exponentially stable.

    Of a gait it is the orbit of its closed loop over a full cycle, and everything is computed again from the gait.
    Before the closed loop: the robot can be built, the limits are sensible, the record is a motion of that robot under
    the outputs of the gait problem. On the closed loop's own orbit: it is the recorded one, its feet meet the ground.
    A certified gait is disturbed (``Certificate.disturbance``); what that shows is told, and refuses nothing.

    Args:
        subject: a gait; or a system, whose guard that is zero at the entry of the first domain needs
            ``Transition.dead_time``.
        state: of a system, the fixed point at the entry of the first domain, (n_x,); a gait's is computed.
        conditions: what else must hold on the orbit, as rows.
        tolerances: of the integrator; the last, tightest one counts, the sweep goes into the error bar.
        time_limit: the longest that one domain may last, s.
        allow_absurd_limits: of a gait, certify against limits and gravity that nobody would mean
            (``gait.limits.sensible_rows``).
        law: of a gait, the allocation law of the closed loop where it is not the gait's. Under input-output
            linearisation it changes neither orbit nor multipliers; under another control law it may change these.
        progress: called with what is being computed.
        cycles: of the orbit of a system; of one that closes after several cycles the map is that of all of them.
        max_step: the longest time between two event samples, s (``simulate``).

    Raises:
        CertificateError: where the radius plus its error bar is not below 1, the two Jacobians disagree, the state is
            not a fixed point, a symmetry does not hold, a simulation contracts otherwise than the leading multiplier
            says, or a condition is violated; the message lists the rows.
        FallError: where the motion does not come back.
        InputError: a gait with a state, a system without one, or a dead time is missing (``Transition.dead_time``).
        NotSolvedError: the closed loop of a gait has no fixed point near it.
        WorkError: the outputs of a gait lose their rank along the recorded motion.
    """
    if isinstance(subject, Gait):
        _require_of_gait(state, cycles)
        system, state, of_gait = certified_orbit(subject, allow_absurd_limits, progress, law)
        conditions = (*of_gait, *conditions)
    else:
        system, state = subject, _of_system(state, allow_absurd_limits, law)
    landing, assessed = _in_order(subject, system, state, tolerances, progress, law)
    certificate = assess(assessed, state, tolerances, time_limit, progress, cycles, max_step)
    certificate = replace(certificate, conditions=tuple(conditions), landing=landing)
    if any(row.violation > 0 for row in certificate.rows()):
        raise CertificateError(certificate.rows())
    if not isinstance(subject, Gait):
        return certificate
    disturbance = disturb(subject, system, state, certificate.spectrum, progress, time_limit, max_step)
    return replace(certificate, disturbance=disturbance)


def _of_system(state: Vector | None, allow_absurd_limits: bool, law: AllocationLaw | None) -> Vector:
    """Return the fixed point of a system; nothing that belongs to gaits may be given with it."""
    if state is None:
        raise InputError("a hybrid system is certified at a fixed point, which `amble.fixed_point` finds")
    if allow_absurd_limits:
        raise InputError("only a gait has limits that can be absurd")
    if law is not None:
        raise InputError("only a gait takes another allocation law")
    return state


def _in_order(
    subject: Gait | HybridSystem,
    system: HybridSystem,
    state: Vector,
    tolerances: Sequence[float],
    notify: Progress | None,
    law: AllocationLaw | None,
) -> tuple[LandingOrders | None, HybridSystem]:
    """Return the orders of landing, and the system in that of the orbit, smooth where another comes first."""
    landing = landing_orders(subject, state, tolerances, notify, law) if isinstance(subject, Gait) else None
    if landing is None or not isinstance(subject, Gait):
        return None, system
    return landing, in_order(subject, landing.taken.feet, law)


def _require_of_gait(state: Vector | None, cycles: int) -> None:
    """A gait has its own state and number of cycles."""
    if state is not None:
        raise InputError("a gait is certified at the fixed point of its closed loop; it takes no state")
    if cycles != 1:
        raise InputError("a gait is certified over its one cycle")
