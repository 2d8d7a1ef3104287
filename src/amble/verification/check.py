"""The check of a gait: everything it claims is computed again, between its nodes too, by other means than made it."""

from __future__ import annotations

import numpy as np

from amble.defaults import GRID
from amble.errors import InputError
from amble.gait.record import Gait
from amble.progress import Progress, ProgressReport, silent
from amble.residual import Residual
from amble.verification.domain_rows import SampledDomain, domain_findings, motion_findings, sampled
from amble.verification.feedback_rows import feedback_findings
from amble.verification.findings import CheckReport, residuals
from amble.verification.limit_rows import limit_findings
from amble.verification.switch_rows import switch_findings

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
    dynamics and minimum norm at those states, moved by the law. Residuals, each at most ``tolerance`` in size:

    - motion: the curves less the closed loop integrated from the recorded entry (DOP853); q in m and rad, v divided
      by 1 + the largest recorded |v|.
    - acceleration, torque, force: recorded at the nodes less the dense solution, divided by 1 + the largest recorded.
    - dynamics: D a + h - B u - J^T lambda at the nodes, divided by 1 + the larger of largest |u| and |lambda|.
    - contact: ground height and drift of stance feet (m); their velocity and acceleration, divided as v and a.
    - output: y (rad), y' and y'' + K_d y' + K_p y, divided as v and a.
    - law: the rows of the allocation law at the nodes, divided by 1 + the largest |u|.
    - guard, impact, continuity, periodicity: m, rad, m/s; momentum, impulse and v divided by 1 + their largest.
    - cost: root mean square of |u| by Simpson's rule on the grid less the solver's, divided by 1 + the solver's.
    - feedback: where the gait is stabilised, the fixed point, the durations and the touchdowns of its closed loop.

    Limits have the bounds of the gait problem; friction is the true cone. They may be missed by ``slack`` of their
    size (positions: rad and m), since the problem imposes them at its nodes only and a motion may run along one. A
    swing foot never goes below the ground by more than ``tolerance``.

    Args:
        gait: the gait.
        grid: points in every spacing of nodes, at least 1.
        tolerance: bound of the scaled residuals.
        slack: what a limit may miss, as a share of its size.
        progress: called before every domain.

    Raises:
        InputError: the grid is not positive.
        WorkError: the outputs lose their rank along the motion, or the stabilised loop cannot be integrated.
    """
    if not (tolerance > 0.0 and slack >= 0.0):
        raise InputError(f"the tolerance {tolerance:g} must be positive and the slack {slack:g} not negative")
    tell = progress or silent
    tell(ProgressReport(what="sampling"))
    domains = [sampled(gait, number, grid) for number in range(len(gait.domains))]
    findings: list[Residual] = []
    for number, domain in enumerate(domains):
        tell(ProgressReport(what="domain", done=number + 1, of=len(domains)))
        following = domains[(number + 1) % len(domains)]
        findings += domain_findings(domain, tolerance)
        findings += motion_findings(domain, tolerance)
        findings += switch_findings(gait, domain, following, tolerance)
        findings += limit_findings(domain, tolerance, slack)
    findings += _cost(gait, domains, tolerance)
    findings += feedback_findings(gait, tolerance)
    return CheckReport(tuple(findings), sum(len(domain.times) for domain in domains), tolerance)


def record_findings(gait: Gait, tolerance: float) -> CheckReport:
    """Return the residuals of what is recorded, at its nodes: whether it is a motion of the robot under these outputs.

    No limit is looked at. The motion in time is integrated only where everything else holds, since an integration from
    numbers that are no motion may take for ever.

    Args:
        gait: the gait.
        tolerance: bound of the scaled residuals.

    Raises:
        WorkError: the outputs lose their rank along the motion.
    """
    domains = [sampled(gait, number, 1) for number in range(len(gait.domains))]
    findings: list[Residual] = []
    for number, domain in enumerate(domains):
        findings += domain_findings(domain, tolerance)
        switch = switch_findings(gait, domain, domains[(number + 1) % len(domains)], tolerance)
        findings += [finding for finding in switch if finding.kind != "touchdown"]
    if all(finding.passed for finding in findings):
        for domain in domains:
            findings += motion_findings(domain, tolerance)
    return CheckReport(tuple(findings), sum(len(domain.times) for domain in domains), tolerance)


def _cost(gait: Gait, domains: list[SampledDomain], tolerance: float) -> list[Residual]:
    """Root mean square torque of the closed loop, by Simpson's rule over neighbouring pairs of grid spacings."""
    from scipy.integrate import simpson

    work = sum(float(simpson(np.sum(domain.motion.torques**2, axis=1), x=domain.times)) for domain in domains)
    found = np.sqrt(work / sum(domain.trajectory.duration for domain in domains))
    stated = np.sqrt(gait.solver.objective) if gait.solver.objective >= 0.0 else np.nan
    name = "root mean square of the torques less the solver's"
    return residuals("cost", [name], np.array([found - stated]), np.array([np.nan]), tolerance, 1.0 + stated)
