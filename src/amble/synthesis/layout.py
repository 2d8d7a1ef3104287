"""Where every variable of the gait problem stands in the solver's vector, and between which bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.control.landing import legs_in_the_air
from amble.hybrid import Stance, Switch
from amble.hybrid.landing import landed_stances
from amble.numerics.collocation import node_positions
from amble.robot.coordinate_units import load_units, unit_of, units
from amble.robot.natural_units import RobotUnits
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
"""Size of one unit of the scaled variables, in units of the robot (docs/theory/transcription.md, eq. 14)."""

Bounds = tuple[NDArray[np.float64], NDArray[np.float64]]

COEFFICIENT_RANGE = 10.0
"""Of Bezier coefficients, scaled, which are angles; this only keeps the solver from running away."""


MARGIN = 0.01
"""Share of the speed, torque and friction limits that the problem keeps free: it holds them at the nodes only. Between
the nodes of ASTRo's amble (15 intervals a domain) a joint speed was 0.3 % above its value at the nodes."""


POSITION_MARGIN = 2e-3
"""What positions keep free of their bounds at the nodes where a problem asks for that, in units of the robot and rad.
Between the nodes of solved gaits of seven quadrupeds (15 intervals a domain) they were up to 1.7e-3 beyond them."""

NORMAL_FORCE_MARGIN = 0.005
"""What normal forces keep above their least at the nodes where a problem asks for that, as a share of the weight. At
the end of a pronk, where four feet leave at their least force, they fell 0.004 of it below between the last nodes."""

LARGEST_MARGIN = 0.1
"""Share of a range of positions that the margin takes at each end at most."""


@dataclass(frozen=True, kw_only=True)
class LandingLayout:
    """Indices of the variables of one stance between landings, where all feet land at once.

    Attributes:
        stance: the feet that have landed, and those that stay.
        free: coordinates but those of the joints of legs in the air.
        v: rates behind the impact on these feet, (n_q,).
        impulse: of that impact, (n_f,).
        a: accelerations of the free coordinates, (n_r,); those of the others are 0.
        force: contact forces, (n_f,).
    """

    stance: Stance
    free: tuple[int, ...]
    v: Index
    impulse: Index
    a: Index
    force: Index

    @property
    def index(self) -> Index:
        """All of them."""
        return np.concatenate([self.v, self.impulse, self.a, self.force])


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
        landings: of feet that land one by one, the stances between the landings of the switch.
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
    landings: tuple[LandingLayout, ...] = ()

    @property
    def nodes(self) -> int:
        """Number of collocation nodes."""
        return int(self.q.shape[0])

    def place(self, node: int) -> str:
        """Name of a node in row names."""
        return f"{self.stance.name} node {node}"


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Indices of all variables, and the scale of each.

    Attributes:
        domains: the solved domains.
        period: index of the summed duration of the solved domains, (1,).
        scale: (n_x,).
        units: those of the robot, which scales, rows and cost are multiples of.
    """

    domains: tuple[DomainLayout, ...]
    period: Index
    scale: NDArray[np.float64]
    units: RobotUnits

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.scale.size)


class _Counter:
    """Hands out consecutive indices; lives only while a layout is built."""

    def __init__(self, units: RobotUnits) -> None:
        self.scales: list[float] = []
        self._units, self._sizes = units, dict[str, float]()

    def take(self, kind: str, units: Sequence[str]) -> Index:
        """Number variables of a kind, one a unit."""
        start = len(self.scales)
        for unit in units:
            if unit not in self._sizes:
                self._sizes[unit] = self._units.size(unit)
            self.scales.append(SCALES[kind] * self._sizes[unit])
        return np.arange(start, len(self.scales))


def build_layout(problem: GaitProblem) -> Layout:
    """Order the variables along time: node by node, then the domain's own."""
    robot_units = RobotUnits.of(problem.pattern.robot)
    counter = _Counter(robot_units)
    pairs = zip(problem.pattern.solved, problem.pattern.switches, strict=True)
    domains = tuple(_domain(problem, stance, switch, counter) for stance, switch in pairs)
    period = counter.take("duration", ["s"])
    return Layout(domains=domains, period=period, scale=np.array(counter.scales), units=robot_units)


def _domain(problem: GaitProblem, stance: Stance, switch: Switch, counter: _Counter) -> DomainLayout:
    robot = problem.pattern.robot
    phases = node_positions(problem.collocation, problem.intervals)
    names, foot = robot.coordinate_names, problem.pattern.contact
    of_nodes = {
        "q": units(robot, names),
        "v": units(robot, names, "/s"),
        "a": units(robot, names, "/s^2"),
        "u": load_units(robot, robot.joint_names),
        "force": foot.component_units("N", "N m") * len(stance.feet),
    }
    rows: dict[str, list[Index]] = {kind: [] for kind in of_nodes}
    duration = counter.take("duration", ["s"])
    outputs = units(robot, problem.outputs.of(stance.name).coordinates)
    coefficients = counter.take("coefficients", outputs * (problem.outputs.order + 1))
    phase_numbers = counter.take("phase", [number.unit for number in problem.outputs.phase.numbers])
    for _ in phases:
        for kind, each in of_nodes.items():
            rows[kind].append(counter.take(kind, each))
    landed = len(switch.target.feet) if switch.landing else 0
    impulse = counter.take("impulse", foot.component_units("N s", "N m s") * landed)
    stacked = {kind: np.array(index) for kind, index in rows.items()}
    return DomainLayout(
        stance=stance,
        switch=switch,
        phases=phases,
        duration=duration,
        coefficients=coefficients,
        phase_numbers=phase_numbers,
        impulse=impulse,
        landings=_landings(problem, switch, counter),
        **stacked,
    )


def _landings(problem: GaitProblem, switch: Switch, counter: _Counter) -> tuple[LandingLayout, ...]:
    pattern, robot, foot = problem.pattern, problem.pattern.robot, problem.pattern.contact
    names, found = robot.coordinate_names, list[LandingLayout]()
    for stance in landed_stances(switch, pattern.landing_rule, robot.foot_names)[:-1]:
        late = [name for name in switch.landing if name not in stance.feet]
        held = legs_in_the_air(robot, late, stance.feet)
        free, count = tuple(k for k in range(robot.size) if k not in held), len(stance.feet)
        found.append(
            LandingLayout(
                stance=stance,
                free=free,
                v=counter.take("v", units(robot, names, "/s")),
                impulse=counter.take("impulse", foot.component_units("N s", "N m s") * count),
                a=counter.take("a", units(robot, [names[k] for k in free], "/s^2")),
                force=counter.take("force", foot.component_units("N", "N m") * count),
            )
        )
    return tuple(found)


def resampled(samples: NodeValues, phases: Vector, wanted: Vector) -> NodeValues:
    """Interpolate samples linearly from some phases to others, (wanted, width)."""
    columns = [np.interp(wanted, phases, column) for column in samples.T]
    return np.array(columns).T.reshape(wanted.size, -1)


def variable_bounds(problem: GaitProblem, layout: Layout) -> Bounds:
    """Return lower and upper bounds of the unscaled variables, (n_x,) each."""
    lower, upper = np.full(layout.size, -np.inf), np.full(layout.size, np.inf)
    for number, domain in enumerate(layout.domains):
        _bound_domain(problem, layout, domain, lower, upper)
        if number == 0:
            # Ground that is the same everywhere along an axis leaves the place open; a mirror fixes the lateral one.
            along = problem.pattern.ground.translations
            robot = problem.pattern.robot
            sideways = not problem.pattern.mirrored and "y" in along and robot.base.in_space
            pinned = [0, 1] if sideways else [0]
            if problem.command.in_place and sideways and problem.pattern.ground.level:
                pinned.append(robot.coordinate_index("yaw"))  # no way tells the heading
            lower[domain.q[0][pinned]] = upper[domain.q[0][pinned]] = 0.0
    durations = [problem.limits.durations[domain.stance.name] for domain in layout.domains]
    lower[layout.period], upper[layout.period] = sum(d[0] for d in durations), sum(d[1] for d in durations)
    return lower, upper


def _bound_domain(
    problem: GaitProblem, layout: Layout, domain: DomainLayout, lower: NDArray[np.float64], upper: NDArray[np.float64]
) -> None:
    robot, limits = problem.pattern.robot, problem.limits
    joints = robot.size - len(robot.joints)
    lower[domain.duration], upper[domain.duration] = limits.durations[domain.stance.name]
    most = COEFFICIENT_RANGE * layout.scale[domain.coefficients]
    lower[domain.coefficients], upper[domain.coefficients] = -most, most
    contacts = problem.pattern.contacts(domain.stance)
    for name, (low, high) in limits.positions.items():
        if name == "z" and not contacts.ground.level:
            continue  # above the ground under the base: a row of the nodes
        margin = min(POSITION_MARGIN * layout.units.size(unit_of(robot, name)), LARGEST_MARGIN * (high - low))
        _within(lower, upper, domain.q[:, robot.coordinate_index(name)], (low, high), margin * problem.node_margins)
    for places, most_of in (
        (domain.v[:, joints:], limits.speeds),
        (domain.u, limits.torques),
    ):
        for name, high in most_of.items():
            _within(lower, upper, places[:, robot.joint_index(name)], (-high, high), MARGIN * high)
    for place, high in enumerate(limits.accelerations(robot).values()):
        _within(lower, upper, domain.a[:, place], (-high, high), MARGIN * high * problem.node_margins)
    if not contacts.ground.level:
        return  # the normal force is no variable there
    for foot in contacts.feet:
        lower[domain.force[:, contacts.normal_index(foot)]] = least_normal_force(problem, domain, foot)
    for foot in domain.switch.leaving:
        end = domain.force[-1, contacts.normal_index(foot)]
        lower[end] = upper[end] = limits.normal_force


def least_normal_force(problem: GaitProblem, domain: DomainLayout, foot: str) -> Vector:
    """Return the smallest normal force of a stance foot at every node but the last of one that leaves, (n,), N."""
    robot = problem.pattern.robot
    least = problem.limits.least_normal_force(foot in domain.switch.leaving, domain.phases)
    return least + NORMAL_FORCE_MARGIN * robot.mass * robot.gravity * problem.node_margins


def _within(lower: Vector, upper: Vector, places: Index, bounds: tuple[float, float], margin: float) -> None:
    """Bound variables, with a margin at both ends."""
    lower[places], upper[places] = bounds[0] + margin, bounds[1] - margin
