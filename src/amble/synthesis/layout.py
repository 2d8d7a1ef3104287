"""Where every variable of the gait problem stands in the solver's vector, and between which bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.hybrid import Stance, Switch
from amble.numerics.runge_kutta import HERMITE_SIMPSON, node_positions
from amble.synthesis.problem import GaitProblem
from amble.types import NodeValues, Vector

Index = NDArray[np.int64]

SCALES = {
    "q": 1.0,
    "v": 1.0,
    "a": 20.0,
    "u": 10.0,
    "force": 50.0,
    "duration": 0.1,
    "coefficients": 1.0,
    "phase": 1.0,
    "impulse": 1.0,
}
"""Size of one unit of the scaled variables (docs/theory/transcription.md, eq. 14)."""

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


@dataclass(frozen=True, kw_only=True)
class DomainLayout:
    """Indices of one domain's variables.

    Attributes:
        stance: the stance.
        switch: the switch that ends it.
        phases: node positions in [0, 1], (n,).
        q: (n, n_q).
        v: (n, n_q).
        a: (n, n_q).
        u: (n, n_joints).
        force: (n, n_f).
        duration: (1,).
        coefficients: (n_y (order + 1),), column by column.
        phase_numbers: what the phase needs beside the duration, (k,).
        impulse: (n_f of the next stance,), empty without landing.
    """

    stance: Stance
    switch: Switch
    phases: NDArray[np.float64]
    q: Index
    v: Index
    a: Index
    u: Index
    force: Index
    duration: Index
    coefficients: Index
    phase_numbers: Index
    impulse: Index

    @property
    def nodes(self) -> int:
        """Number of collocation nodes."""
        return int(self.q.shape[0])

    def place(self, node: int) -> str:
        """Name of a node in row names."""
        return f"{self.stance.name} node {node}"


@dataclass(frozen=True)
class Layout:
    """Indices of all variables, and the scale of each.

    Attributes:
        domains: the solved domains.
        period: index of the summed duration of the solved domains, (1,).
        scale: (n_x,).
    """

    domains: tuple[DomainLayout, ...]
    period: Index
    scale: NDArray[np.float64]

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.scale.size)


class _Counter:
    """Hands out consecutive indices; lives only while a layout is built."""

    def __init__(self) -> None:
        self.scales: list[float] = []

    def take(self, kind: str, count: int) -> Index:
        start = len(self.scales)
        self.scales.extend([SCALES[kind]] * count)
        return np.arange(start, start + count)


def build_layout(problem: GaitProblem) -> Layout:
    """Order the variables along time: node by node, then the domain's own."""
    counter = _Counter()
    pairs = zip(problem.pattern.solved, problem.pattern.switches, strict=True)
    domains = tuple(_domain(problem, stance, switch, counter) for stance, switch in pairs)
    period = counter.take("duration", 1)
    return Layout(domains, period, np.array(counter.scales))


def _domain(problem: GaitProblem, stance: Stance, switch: Switch, counter: _Counter) -> DomainLayout:
    robot = problem.pattern.robot
    phases = node_positions(HERMITE_SIMPSON, problem.intervals)
    sizes = {
        "q": robot.size,
        "v": robot.size,
        "a": robot.size,
        "u": len(robot.joints),
        "force": problem.pattern.contacts(stance).size,
    }
    rows: dict[str, list[Index]] = {kind: [] for kind in sizes}
    duration = counter.take("duration", 1)
    outputs = len(problem.outputs.of(stance.name).coordinates)
    coefficients = counter.take("coefficients", outputs * (problem.outputs.order + 1))
    phase_numbers = counter.take("phase", len(problem.outputs.phase.numbers))
    for _ in phases:
        for kind, size in sizes.items():
            rows[kind].append(counter.take(kind, size))
    impulse = counter.take("impulse", problem.pattern.contacts(switch.target).size if switch.landing else 0)
    stacked = {kind: np.array(index) for kind, index in rows.items()}
    return DomainLayout(
        stance=stance,
        switch=switch,
        phases=phases,
        duration=duration,
        coefficients=coefficients,
        phase_numbers=phase_numbers,
        impulse=impulse,
        **stacked,
    )


def resampled(samples: NodeValues, phases: Vector, wanted: Vector) -> NodeValues:
    """Interpolate samples linearly from some phases to others, (wanted, width)."""
    columns = [np.interp(wanted, phases, column) for column in samples.T]
    return np.array(columns).T.reshape(wanted.size, -1)


def variable_bounds(problem: GaitProblem, layout: Layout) -> Bounds:
    """Return lower and upper bounds of the unscaled variables, (n_x,) each."""
    lower, upper = np.full(layout.size, -np.inf), np.full(layout.size, np.inf)
    for number, domain in enumerate(layout.domains):
        _bound_domain(problem, domain, lower, upper)
        if number == 0:
            # Ground that is the same everywhere along an axis leaves the place open; a mirror fixes the lateral one.
            along = problem.pattern.ground.translations
            pinned = [0] if problem.pattern.mirrored or "y" not in along else [0, 1]
            if problem.command.in_place and not problem.pattern.mirrored and problem.pattern.ground.level:
                pinned.append(problem.pattern.robot.coordinate_index("yaw"))  # no way tells the heading
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
