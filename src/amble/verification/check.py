"""The check of a gait: everything it claims is computed again, between its nodes too, by other means than made it."""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.defaults import GRID
from amble.errors import InputError
from amble.gait.cost import TORQUE_SQUARED, Instant
from amble.gait.record import Gait
from amble.numerics.collocation import HERMITE_SIMPSON, STAGES, collocation_scheme, node_weights
from amble.progress import Progress, ProgressReport, silent
from amble.residual import Residual
from amble.types import NodeValues, Vector
from amble.verification.domain_rows import SampledDomain, domain_residuals, motion_residuals, sampled
from amble.verification.feedback_rows import feedback_residuals
from amble.verification.limit_rows import limit_residuals
from amble.verification.output_dynamics import Effort
from amble.verification.residuals import CheckReport, residuals, sizes
from amble.verification.switch_rows import switch_residuals

TOLERANCE = 1e-5
"""Bound of every scaled residual."""

SLACK = 1e-3
"""What a limit that is imposed at the nodes of the gait problem may miss between them, as a share of its size."""


def check(
    gait: Gait,
    grid: int = GRID,
    tolerance: float = TOLERANCE,
    slack: float = SLACK,
    *,
    progress: Progress | None = None,
) -> CheckReport:
    """Recompute dynamics, contacts, outputs, law, impacts, periodicity, limits and cost of a gait along a fine grid.

    Nothing of the transcription is used. Between the nodes q and v follow Hermite curves through the recorded q, v, a;
    accelerations, torques and forces are the solution of one dense system of the equations of motion, contacts, output
    dynamics and minimum norm at those states, moved by the law. Residuals are at most ``tolerance`` in size. They are
    divided by what is recorded at its largest, and never less than a share of the robot's natural unit
    (``residuals``: leg length l, sqrt(g l), weight):

    - motion: the curves less the closed loop integrated from the recorded entry (DOP853), up to where they part.
    - acceleration, torque, force: recorded at the nodes less the dense solution.
    - dynamics: D a + h - B u - J^T lambda at the nodes.
    - contact: ground height and drift of stance feet, by l; their velocity and acceleration.
    - output: y (rad), y' and y'' + K_d y' + K_p y.
    - law: the rows of the allocation law at the nodes, as torques.
    - guard, impact, continuity, periodicity: lengths by l, rad, velocities, momentum and impulse.
    - cost: its mean by Simpson's rule on the grid less the solver's; of the squared torques the root.
    - feedback: where the gait is stabilised, the fixed point, the durations and the touchdowns of its closed loop.

    Limits have the bounds of the gait problem; friction is the true cone. They may be missed by ``slack`` of their
    size (positions: rad and l), since the problem imposes them at its nodes only and a motion may run along one. A
    swing foot never goes below the ground by more than ``tolerance`` l.

    Args:
        gait: the gait.
        grid: points in every spacing of nodes, from 1 to 1000.
        tolerance: bound of the scaled residuals.
        slack: what a limit may miss, as a share of its size.
        progress: called before every domain.

    Raises:
        InputError: the grid is out of range, or the tolerance or slack is.
        WorkError: the outputs lose their rank along the motion, or the stabilised loop cannot be integrated.
    """
    if not (tolerance > 0.0 and slack >= 0.0):
        raise InputError(f"the tolerance {tolerance:g} must be positive and the slack {slack:g} not negative")
    notify = progress or silent
    notify(ProgressReport(what="sampling"))
    domains = [sampled(gait, number, grid) for number in range(len(gait.domains))]
    rows: list[Residual] = []
    effort = Effort.of(len(domains))
    for number, domain in enumerate(domains):
        notify(ProgressReport(what="domain", done=number + 1, of=len(domains)))
        following = domains[(number + 1) % len(domains)]
        rows += domain_residuals(domain, tolerance)
        rows += motion_residuals(domain, tolerance, effort)
        rows += switch_residuals(gait, domain, following, tolerance)
        rows += limit_residuals(domain, tolerance, slack)
    rows += _cost(gait, domains, tolerance)
    rows += feedback_residuals(gait, tolerance)
    return CheckReport(tuple(rows), sum(len(domain.times) for domain in domains), tolerance)


def check_record(gait: Gait, tolerance: float) -> CheckReport:
    """Return the residuals of what is recorded, at its nodes: whether it is a motion of the robot under these outputs.

    No limit is looked at; the cost stated must be that of the torques. The motion in time is integrated only where
    everything else holds, since an integration from numbers that are no motion may take for ever.

    Args:
        gait: the gait.
        tolerance: bound of the scaled residuals.

    Raises:
        WorkError: the outputs lose their rank along the motion.
    """
    domains = [sampled(gait, number, 1) for number in range(len(gait.domains))]
    rows: list[Residual] = []
    for number, domain in enumerate(domains):
        rows += domain_residuals(domain, tolerance)
        switch = switch_residuals(gait, domain, domains[(number + 1) % len(domains)], tolerance)
        rows += [row for row in switch if row.kind != "touchdown"]
    rows += _cost(gait, domains, tolerance)
    if all(row.passed for row in rows):
        effort = Effort.of(len(domains))
        for domain in domains:
            rows += motion_residuals(domain, tolerance, effort)
    return CheckReport(tuple(rows), sum(len(domain.times) for domain in domains), tolerance)


def _cost(gait: Gait, domains: list[SampledDomain], tolerance: float) -> list[Residual]:
    """The mean cost of the closed loop; of the squared torques the root is compared, which is a torque."""
    if gait.cost != TORQUE_SQUARED:
        total = sum(_integral(domain, _running(gait, domain)) for domain in domains)
        total += sum(_landing(gait, domain) + _torque_rates(gait, domain) for domain in domains)
        difference = total / sum(domain.trajectory.duration for domain in domains) - gait.solver.objective
        name, scale = f"mean of the cost '{gait.cost.name}' less the solver's", 1.0 + abs(gait.solver.objective)
        return residuals("cost", [name], np.array([difference]), np.array([np.nan]), tolerance, scale)
    arms = gait.robot.torque_arms
    work = sum(_integral(domain, np.sum((arms * domain.motion.torques) ** 2, axis=1)) for domain in domains)
    found = np.sqrt(work / sum(domain.trajectory.duration for domain in domains))
    stated = np.sqrt(gait.solver.objective) if gait.solver.objective >= 0.0 else np.nan
    name = "root mean square of the torques less the solver's"
    return residuals(
        "cost", [name], np.array([found - stated]), np.array([np.nan]), tolerance, sizes(gait.robot).torque + stated
    )


def _integral(domain: SampledDomain, values: Vector) -> float:
    """By Simpson's rule over pairs of grid spacings; at uneven nodes alone by the weights of their scheme."""
    from scipy.integrate import simpson

    motion = domain.trajectory
    if len(values) > len(motion.times) or motion.scheme == HERMITE_SIMPSON:
        return float(simpson(values, x=domain.times))
    return motion.duration * float(node_weights(collocation_scheme(motion.scheme), motion.intervals) @ values)


def _running(gait: Gait, domain: SampledDomain) -> NodeValues:
    """The gait's running cost along a domain, (points,), evaluated at the motion of the dense solution."""
    motion, size = domain.motion, gait.robot.size
    counts = (size, size, size, len(gait.robot.joints), domain.contacts.size, 1)
    symbols = [ca.SX.sym(letter, count) for letter, count in zip("qvaufT", counts, strict=True)]
    q, v, a, u, lam, duration = symbols
    instant = Instant(
        contacts=domain.contacts, positions=q, velocities=v, accelerations=a, torques=u, forces=lam, duration=duration
    )
    running = ca.Function("running", symbols, [gait.cost.running(instant)])
    durations = np.full((len(domain.times), 1), domain.trajectory.duration)
    columns = (domain.positions, domain.velocities, motion.accelerations, motion.torques, motion.forces, durations)
    return np.asarray(running.map(len(domain.times))(*[values.T for values in columns])).ravel()


def _landing(gait: Gait, domain: SampledDomain) -> float:
    """What the landing that ends a domain costs."""
    if not domain.switch.landing:
        return 0.0
    q, v = ca.SX.sym("q", gait.robot.size), ca.SX.sym("v", gait.robot.size)
    cost = gait.cost.landing(domain.contacts, domain.switch.landing, q, v)
    return float(ca.Function("landing", [q, v], [cost])(domain.positions[-1], domain.velocities[-1]))


def _torque_rates(gait: Gait, domain: SampledDomain) -> float:
    """What the rates of the torques cost: of the polynomial through the nodes of every interval."""
    weight, total = gait.cost.torque_rate(gait.robot), 0.0
    if not weight:
        return total
    torques, times = gait.robot.torque_arms * domain.motion.torques[domain.nodes], domain.trajectory.times
    inner = STAGES[domain.trajectory.scheme] - 1
    points, shares = np.polynomial.legendre.leggauss(inner)
    for first in range(0, len(times) - 1, inner):
        t, u = times[first : first + inner + 1], torques[first : first + inner + 1]
        half = 0.5 * (t[-1] - t[0])
        curves = np.polynomial.polynomial.polyfit((t - t[0]) / half - 1.0, u, inner)
        rates = np.polynomial.polynomial.polyval(points, np.polynomial.polynomial.polyder(curves)) / half
        total += half * float(shares @ np.sum(rates**2, axis=0))
    return weight * total
