"""Bounds of the variables, from the limits of the problem."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amble.synthesis.layout import DomainLayout, Layout
from amble.synthesis.problem import GaitProblem

Bounds = tuple[NDArray[np.float64], NDArray[np.float64]]

COEFFICIENT_RANGE = 10.0
"""Bezier coefficients are angles; this only keeps the solver from running away, rad."""


MARGIN = 0.01
"""Share of the speed, torque and friction limits that the problem keeps free: it holds them at the nodes only. Between
the nodes of ASTRo's amble (15 intervals a domain) a joint speed was 0.3 % above its value at the nodes."""


POSITION_MARGIN = 2e-3
"""What positions keep free of their bounds at the nodes where a problem asks for that, m and rad. Between the nodes of
solved gaits of seven quadrupeds (15 intervals a domain) positions were up to 1.7e-3 beyond them."""

LARGEST_MARGIN = 0.1
"""Share of a range of positions that the margin takes at each end at most."""


def variable_bounds(problem: GaitProblem, layout: Layout) -> Bounds:
    """Return lower and upper bounds of the unscaled variables, (n_x,) each."""
    lower, upper = np.full(layout.size, -np.inf), np.full(layout.size, np.inf)
    for number, domain in enumerate(layout.domains):
        _bound_domain(problem, domain, lower, upper)
        if number == 0:
            # Ground that is the same everywhere along an axis leaves the place open; a mirror fixes the lateral one.
            along = problem.pattern.ground.translations
            pinned = [0] if problem.pattern.mirrored or "y" not in along else [0, 1]
            lower[domain.q[0][pinned]] = upper[domain.q[0][pinned]] = 0.0
    durations = [problem.limits.durations[domain.stance.name] for domain in layout.domains]
    lower[layout.period], upper[layout.period] = sum(d[0] for d in durations), sum(d[1] for d in durations)
    return lower, upper


def _bound_domain(
    problem: GaitProblem, domain: DomainLayout, lower: NDArray[np.float64], upper: NDArray[np.float64]
) -> None:
    robot, limits = problem.pattern.robot, problem.limits
    joints = robot.size - len(robot.joints)
    lower[domain.duration], upper[domain.duration] = limits.durations[domain.stance.name]
    lower[domain.coefficients], upper[domain.coefficients] = -COEFFICIENT_RANGE, COEFFICIENT_RANGE
    contacts = problem.pattern.contacts(domain.stance)
    for name, (low, high) in limits.positions.items():
        if name == "z" and not contacts.ground.level:
            continue  # above the ground under the base: a row of the nodes
        place = domain.q[:, robot.coordinate_names.index(name)]
        margin = min(POSITION_MARGIN, LARGEST_MARGIN * (high - low)) if problem.node_margins else 0.0
        lower[place], upper[place] = low + margin, high - margin
    for name, high in limits.speeds.items():
        place = domain.v[:, joints + robot.joint_names.index(name)]
        lower[place], upper[place] = -(1.0 - MARGIN) * high, (1.0 - MARGIN) * high
    for name, high in limits.torques.items():
        place = domain.u[:, robot.joint_names.index(name)]
        lower[place], upper[place] = -(1.0 - MARGIN) * high, (1.0 - MARGIN) * high
    acceleration = (1.0 - MARGIN) * limits.acceleration if problem.node_margins else limits.acceleration
    lower[domain.a], upper[domain.a] = -acceleration, acceleration
    if not contacts.ground.level:
        return  # the normal force is no variable there
    for foot in contacts.feet:
        lower[domain.force[:, contacts.normal_index(foot)]] = limits.normal_force
    for foot in domain.switch.leaving:
        upper[domain.force[-1, contacts.normal_index(foot)]] = limits.normal_force
