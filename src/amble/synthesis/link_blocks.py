"""Rows between nodes and between domains: collocation defects, impacts, periodicity."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.gait.command import Command
from amble.hybrid import Switch
from amble.hybrid.contact import AXES
from amble.hybrid.ground import into_frame
from amble.names import identifier
from amble.numerics.collocation import rate_products
from amble.robot import dynamics, kinematics
from amble.robot.coordinate_units import as_torques, load_units, units
from amble.robot.parts import RATE
from amble.robot.turn import turn_error, turned_velocity
from amble.synthesis.block import Block, Label
from amble.synthesis.landing_rows import depth_rows, order_rows, release_rows
from amble.synthesis.layout import DomainLayout, Layout
from amble.synthesis.lift_off_rows import RISE, lift_off_rows
from amble.synthesis.node_block import ProgramParameters, output_indices
from amble.synthesis.problem import GaitProblem
from amble.synthesis.rows import RowGroup, RowKind

NO_COST = ca.SX(1, 1)


def defect_block(problem: GaitProblem, layout: Layout, domain: DomainLayout) -> Block:
    """Collocation: every inner and end node of an interval follows from its rates.

    Coordinates under control lie on their curves and need no rows here. The rates of the torques cost what the cost
    says: those of the polynomial through the nodes of an interval, f^T P f / h with P its ``rate_products``.
    """
    controlled = output_indices(problem, domain)
    robot = problem.pattern.robot
    free = [k for k in range(robot.size) if k not in controlled]
    names = [robot.coordinate_names[k] for k in free]
    size, scheme = len(names), problem.collocation
    stages = scheme.stages
    q, v, a = (ca.SX.sym(letter, size, stages) for letter in "qva")
    T, part = ca.SX.sym("T"), ca.SX.sym("part")
    rows: list[ca.SX] = []
    labels: list[Label] = []
    for stage in range(1, stages):
        weights = ca.DM(scheme.integration[stage])
        rows += [q[:, 0] + T * part * (v @ weights) - q[:, stage], v[:, 0] + T * part * (a @ weights) - v[:, stage]]
        for kind, per in (("", ""), (RATE, "/s")):
            labels += RowKind.DEFECT.labels(
                (f"defect {kind}{name} stage {stage}" for name in names), units(robot, names, per)
            )
    starts = np.arange(problem.intervals) * (stages - 1)
    steps = [(starts + stage) for stage in range(stages)]
    columns = [kind[step][:, free] for kind in (domain.q, domain.v, domain.a) for step in steps]
    count = problem.intervals
    zeros = np.zeros((count, len(labels)))
    columns.append(np.tile(domain.duration, (count, 1)))
    variables, cost = [ca.vec(q), ca.vec(v), ca.vec(a), T], NO_COST
    weight = problem.cost.torque_rate(problem.pattern.robot)
    if weight:
        u, period = ca.SX.sym("u", domain.u.shape[1], stages), ca.SX.sym("period")
        rated = as_torques(robot, u)
        cost = weight * ca.trace(rated @ ca.DM(rate_products(scheme.name)) @ rated.T) / (T * part * period)
        variables += [ca.vec(u), period]
        columns += [*(domain.u[step] for step in steps), np.tile(layout.period, (count, 1))]
    return Block(
        name=f"defect_{identifier(domain.stance.name)}",
        variables=ca.vertcat(*variables),
        constants=part,
        parameters=ProgramParameters.symbols().packed(),
        rows=ca.vertcat(*rows),
        cost=cost,
        labels=tuple(labels),
        columns=np.hstack(columns),
        values=np.full((count, 1), 1.0 / count),
        places=tuple(f"{domain.stance.name} interval {k}" for k in range(count)),
        lower=zeros,
        upper=zeros,
    )


@dataclass(frozen=True, kw_only=True)
class _SwitchSymbols:
    """Variables of the rows of a switch: coordinates and rates before it, after it, and what joins them.

    The state after the switch is that of the next domain's first node, mirrored where half a cycle is solved, turned
    where the gait turns. The way is where the cycle closes: along x and y, m, and the turn, rad.
    """

    q_minus: ca.SX
    v_minus: ca.SX
    q_plus: ca.SX
    v_plus: ca.SX
    q_next: ca.SX
    v_next: ca.SX
    impulse: ca.SX
    period: ca.SX
    way: tuple[ca.SX, ca.SX, ca.SX] | None

    @classmethod
    def of(cls, problem: GaitProblem, parameters: ProgramParameters, impulses: int, last: bool) -> _SwitchSymbols:
        """Create the symbols; those after the switch are mirrored where it is the last of half a cycle."""
        robot = problem.pattern.robot
        qm, vm, qp, vp = (ca.SX.sym(name, robot.size) for name in ("q_minus", "v_minus", "q_plus", "v_plus"))
        mirrored, period = last and problem.pattern.mirrored, ca.SX.sym("period")
        way = _command(problem, parameters).way(period) if last else None
        v_next = robot.mirror.position(vp) if mirrored else vp
        if way is not None and not problem.command.straight:
            v_next = turned_velocity(qp, vp, qm, way[2])
        return cls(
            q_minus=qm,
            v_minus=vm,
            q_plus=qp,
            v_plus=vp,
            q_next=robot.mirror.position(qp) if mirrored else qp,
            v_next=v_next,
            impulse=ca.SX.sym("impulse", impulses),
            period=period,
            way=way,
        )


def switch_block(problem: GaitProblem, layout: Layout, number: int) -> Block:
    """The reset into the next domain: impact, mirror and periodicity, guard, touchdown velocity."""
    pattern = problem.pattern
    domain = layout.domains[number]
    last = number == len(layout.domains) - 1
    following = layout.domains[0 if last else number + 1]
    switch = domain.switch
    parameters = ProgramParameters.symbols()
    symbols = _SwitchSymbols.of(problem, parameters, domain.impulse.size, last)
    before, after = (symbols.q_minus, symbols.v_minus), (symbols.q_plus, symbols.v_plus)
    groups = [_continuity_rows(problem, symbols)]
    if switch.landing:
        groups += [_impact_rows(problem, switch, symbols), _touchdown_rows(problem, switch, symbols)]
        if domain.landings:
            groups.append(order_rows(problem, switch, switch.target, before[0], symbols.v_next, symbols.impulse))
        else:
            groups.append(release_rows(problem, switch, before[0], symbols.v_next, "behind the impact"))
    else:
        names = pattern.robot.coordinate_names
        labels = RowKind.CONTINUITY.labels(
            (f"continuity {RATE}{name}" for name in names), units(pattern.robot, names, "/s")
        )
        groups.append(RowGroup.equalities([symbols.v_next - symbols.v_minus], labels))
    columns = [domain.q[-1], domain.v[-1], following.q[0], following.v[0], domain.impulse, layout.period]
    force, a_minus, a_plus = ca.SX(0, 1), ca.SX(0, 1), ca.SX(0, 1)
    if switch.landing:
        a_minus = ca.SX.sym("a_minus", pattern.robot.size)
        columns.append(domain.a[-1])
        groups.append(depth_rows(problem, switch, *before, a_minus))
    if switch.leaving:
        a_plus = ca.SX.sym("a_plus", pattern.robot.size)
        columns.append(following.a[0])
        turning = last and not problem.command.straight  # what a foot does along the vertical is the same after a turn
        at = (symbols.q_plus, symbols.v_plus) if turning else (symbols.q_minus, symbols.v_minus)
        a_next = pattern.robot.mirror.position(a_plus) if last and pattern.mirrored else a_plus
        rising, labels = lift_off_rows(problem, switch, *at, a_next)
        endless = [np.inf] * len(rising)
        groups.append(RowGroup(rows=rising, labels=labels, lower=[RISE] * len(rising), upper=endless))
    if switch.leaving and not pattern.ground.level:
        # on level ground the normal force is a variable, whose bounds say the same
        force = ca.SX.sym("force", pattern.contacts(switch.source).size)
        groups.append(_lift_off_rows(problem, switch, symbols.q_minus, force))
        columns.append(domain.force[-1])
    return Block(
        name=f"switch_{identifier(domain.stance.name)}",
        variables=ca.vertcat(*before, *after, symbols.impulse, symbols.period, a_minus, a_plus, force),
        constants=ca.SX(0, 1),
        parameters=parameters.packed(),
        rows=ca.vertcat(*(row for group in groups for row in group.rows)),
        cost=problem.cost.landing(pattern.contacts(switch.source), switch.landing, *before) / symbols.period
        if switch.landing
        else NO_COST,
        labels=tuple(label for group in groups for label in group.labels),
        columns=np.concatenate(columns)[None, :],
        values=np.zeros((1, 0)),
        places=(switch.name,),
        lower=np.array([[bound for group in groups for bound in group.lower]]),
        upper=np.array([[bound for group in groups for bound in group.upper]]),
    )


def _continuity_rows(problem: GaitProblem, symbols: _SwitchSymbols) -> RowGroup:
    """The place stays the same, but for the way walked and the turn where the cycle closes."""
    robot, ground = problem.pattern.robot, problem.pattern.ground
    rows = symbols.q_next - symbols.q_minus
    if symbols.way is not None:
        axes = list(robot.base.axes)
        for part, axis in zip(symbols.way[:2], "xy", strict=True):
            if axis in ground.translations and axis in robot.base.coordinates:
                along = ground.translations[axis][axes]
                rows[: len(axes)] += ca.vertcat(*[share * part for share in along])
        if not problem.command.straight:
            rows[3:6] = turn_error(symbols.q_plus, symbols.q_minus, symbols.way[2])
    names = robot.coordinate_names
    labels = RowKind.CONTINUITY.labels((f"continuity {name}" for name in names), units(robot, names))
    return RowGroup.equalities([rows], labels)


def _impact_rows(problem: GaitProblem, switch: Switch, symbols: _SwitchSymbols) -> RowGroup:
    """The plastic impact that stops all feet of the next stance."""
    robot, landed = problem.pattern.robot, problem.pattern.contacts(switch.target)
    J, mass = landed.jacobian(symbols.q_minus), dynamics.mass_matrix(robot, symbols.q_minus)
    rows = [mass @ (symbols.v_next - symbols.v_minus) - J.T @ symbols.impulse, J @ symbols.v_next]
    labels = RowKind.IMPACT.labels(
        (f"impact {name}" for name in (*robot.coordinate_names, *landed.labels)),
        load_units(robot, robot.coordinate_names, " s")
        + landed.contact.component_units("m/s", "rad/s") * len(landed.feet),
    )
    return RowGroup.equalities(rows, labels)


def _touchdown_rows(problem: GaitProblem, switch: Switch, symbols: _SwitchSymbols) -> RowGroup:
    """Every landing foot is on the ground, with a velocity within the limits."""
    robot, ground, limits = problem.pattern.robot, problem.pattern.ground, problem.limits.touchdown_velocity
    rows: list[ca.SX] = []
    labels: list[Label] = []
    axes = robot.base.axes
    for foot in switch.landing:
        point = kinematics.foot_position(robot, foot, symbols.q_minus)
        velocity = kinematics.foot_jacobian(robot, foot, symbols.q_minus) @ symbols.v_minus
        rows += [ground.gap(point), into_frame(velocity, ground.frame(point))[list(axes)]]
        names = (f"touchdown velocity {foot} {AXES[axis]}" for axis in axes)
        labels += RowKind.TOUCHDOWN.labels([f"touchdown height {foot}"], "m") + RowKind.TOUCHDOWN.labels(names, "m/s")
    lower, upper = ([0.0, *(limits[axis][end] for axis in axes)] * len(switch.landing) for end in (0, 1))
    return RowGroup(rows=rows, labels=labels, lower=lower, upper=upper)


def _lift_off_rows(problem: GaitProblem, switch: Switch, q: ca.SX, force: ca.SX) -> RowGroup:
    """Feet leave the ground where their normal force has fallen to its least."""
    contacts = problem.pattern.contacts(switch.source)
    local = contacts.local(force, contacts.points(q))
    rows = [contacts.contact.normal_force(local[contacts.feet.index(foot)]) for foot in switch.leaving]
    labels = RowKind.LIFT_OFF.labels((f"lift-off force {foot}" for foot in switch.leaving), "N")
    least = [problem.limits.normal_force] * len(switch.leaving)
    return RowGroup(rows=rows, labels=labels, lower=least, upper=least)


def _command(problem: GaitProblem, parameters: ProgramParameters) -> Command:
    """The velocities as symbols; what is zero by structure stays a number."""
    asked = problem.command
    return Command(
        forward=parameters.speed,
        lateral=0.0 if problem.pattern.mirrored else parameters.lateral_speed,
        yaw_rate=0.0 if asked.straight else parameters.yaw_rate,
    )


def phase_block(problem: GaitProblem, domain: DomainLayout) -> Block:
    """The numbers of the phase are those of the motion's ends."""
    size, numbers = problem.pattern.robot.size, problem.outputs.phase.numbers
    first, last, values = ca.SX.sym("first", size), ca.SX.sym("last", size), ca.SX.sym("numbers", len(numbers))
    measured = problem.outputs.phase.measured(problem.pattern.robot, domain.stance, first, last)
    zeros = np.zeros((1, len(numbers)))
    return Block(
        name=f"phase_{identifier(domain.stance.name)}",
        variables=ca.vertcat(first, last, values),
        constants=ca.SX(0, 1),
        parameters=ProgramParameters.symbols().packed(),
        rows=values - measured,
        cost=NO_COST,
        labels=tuple(RowKind.PHASE.labels((known.name for known in numbers), (known.unit for known in numbers))),
        columns=np.concatenate([domain.q[0], domain.q[-1], domain.phase_numbers])[None, :],
        values=np.zeros((1, 0)),
        places=(f"{domain.stance.name} phase",),
        lower=zeros,
        upper=zeros,
    )


def period_block(layout: Layout) -> Block:
    """The period is the sum of the durations."""
    durations, period = ca.SX.sym("durations", len(layout.domains)), ca.SX.sym("period")
    columns = np.concatenate([*(domain.duration for domain in layout.domains), layout.period])
    return Block(
        name="period",
        variables=ca.vertcat(durations, period),
        constants=ca.SX(0, 1),
        parameters=ProgramParameters.symbols().packed(),
        rows=period - ca.sum1(durations),
        cost=NO_COST,
        labels=tuple(RowKind.PERIOD.labels(["sum of durations"], "s")),
        columns=columns[None, :],
        values=np.zeros((1, 0)),
        places=("period",),
        lower=np.zeros((1, 1)),
        upper=np.zeros((1, 1)),
    )
