"""Rows between nodes and between domains: collocation defects, impacts, periodicity."""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.hybrid.contact import AXES
from amble.hybrid.ground import into_frame
from amble.names import identifier
from amble.numerics.collocation import HERMITE_SIMPSON
from amble.robot import dynamics, kinematics
from amble.robot.parts import RATE
from amble.synthesis.assembly import Block, Label
from amble.synthesis.landing_rows import landing_rows
from amble.synthesis.layout import DomainLayout, Layout
from amble.synthesis.lift_off_rows import RISE, lift_off_rows
from amble.synthesis.node_block import FORCE_UNIT, ProgramParameters, output_indices
from amble.synthesis.problem import GaitProblem
from amble.synthesis.rows import RowKind

NO_COST = ca.SX(1, 1)


def defect_block(problem: GaitProblem, domain: DomainLayout) -> Block:
    """Collocation: every inner and end node of an interval follows from its rates (``HERMITE_SIMPSON``).

    Coordinates under control lie on their curves and need no rows here.
    """
    controlled = output_indices(problem, domain)
    free = [k for k in range(problem.pattern.robot.size) if k not in controlled]
    names = [problem.pattern.robot.coordinate_names[k] for k in free]
    size, stages = len(names), HERMITE_SIMPSON.nodes.size
    q, v, a = (ca.SX.sym(letter, size, stages) for letter in "qva")
    T, part = ca.SX.sym("T"), ca.SX.sym("part")
    rows: list[ca.SX] = []
    labels: list[Label] = []
    for stage in range(1, stages):
        weights = ca.DM(HERMITE_SIMPSON.integration[stage])
        rows += [q[:, 0] + T * part * (v @ weights) - q[:, stage], v[:, 0] + T * part * (a @ weights) - v[:, stage]]
        labels += RowKind.DEFECT.labels(
            *(f"defect {kind}{name} stage {stage}" for kind in ("", RATE) for name in names)
        )
    starts = np.arange(problem.intervals) * (stages - 1)
    steps = [(starts + stage) for stage in range(stages)]
    columns = [kind[step][:, free] for kind in (domain.q, domain.v, domain.a) for step in steps]
    count = problem.intervals
    zeros = np.zeros((count, len(labels)))
    return Block(
        name=f"defect_{identifier(domain.stance.name)}",
        variables=ca.vertcat(ca.vec(q), ca.vec(v), ca.vec(a), T),
        constants=part,
        parameters=ProgramParameters.symbols().packed(),
        rows=ca.vertcat(*rows),
        cost=NO_COST,
        labels=tuple(labels),
        columns=np.hstack([*columns, np.tile(domain.duration, (count, 1))]),
        values=np.full((count, 1), 1.0 / count),
        places=tuple(f"{domain.stance.name} interval {k}" for k in range(count)),
        lower=zeros,
        upper=zeros,
    )


def switch_block(problem: GaitProblem, layout: Layout, number: int) -> Block:
    """The reset into the next domain: impact, mirror and periodicity, guard, touchdown velocity."""
    pattern = problem.pattern
    robot, ground = pattern.robot, pattern.ground
    domain = layout.domains[number]
    last = number == len(layout.domains) - 1
    following = layout.domains[0 if last else number + 1]
    switch = domain.switch
    # shorthand
    qm, vm, qp, vp = (ca.SX.sym(name, robot.size) for name in ("q_minus", "v_minus", "q_plus", "v_plus"))
    impulse, period = ca.SX.sym("impulse", domain.impulse.size), ca.SX.sym("period")
    parameters = ProgramParameters.symbols()

    mirrored = last and problem.pattern.mirrored
    q_next = robot.mirror.position(qp) if mirrored else qp
    v_next = robot.mirror.position(vp) if mirrored else vp
    distance = parameters.speed * period if last else ca.SX(0.0)
    advance = ca.vertcat(*[part * distance for part in ground.translations["x"]], ca.SX.zeros(robot.size - 3))
    continuity = q_next + advance - qm
    names = robot.coordinate_names
    rows, upper, lower = [continuity], [0.0] * robot.size, [0.0] * robot.size
    labels = RowKind.CONTINUITY.labels(*(f"continuity {name}" for name in names))
    if switch.landing:
        landed = pattern.contacts(switch.target)
        J = landed.jacobian(qm)
        mass = dynamics.mass_matrix(robot, qm)
        rows += [(mass @ (v_next - vm) - J.T @ impulse), J @ v_next]
        labels += RowKind.IMPACT.labels(*(f"impact {name}" for name in (*names, *landed.labels)))
        lower += [0.0] * (robot.size + J.shape[0])
        upper += [0.0] * (robot.size + J.shape[0])
        for foot in switch.landing:
            point, velocity = kinematics.foot_position(robot, foot, qm), kinematics.foot_jacobian(robot, foot, qm) @ vm
            rows += [ground.gap(point), into_frame(velocity, ground.frame(point))]
            axes = (f"touchdown velocity {foot} {axis}" for axis in AXES)
            labels += RowKind.TOUCHDOWN.labels(f"touchdown height {foot}", *axes)
            lower += [0.0, *(interval[0] for interval in problem.limits.touchdown_velocity)]
            upper += [0.0, *(interval[1] for interval in problem.limits.touchdown_velocity)]
        orders, names_of_orders, least_of_orders = landing_rows(problem, switch, qm, vm)
        rows += orders
        labels += names_of_orders
        lower += least_of_orders
        upper += [np.inf] * len(orders)
    else:
        rows.append(v_next - vm)
        labels += RowKind.CONTINUITY.labels(*(f"continuity {RATE}{name}" for name in names))
        lower += [0.0] * robot.size
        upper += [0.0] * robot.size
    columns = [domain.q[-1], domain.v[-1], following.q[0], following.v[0], domain.impulse, layout.period]
    force, ap = ca.SX(0, 1), ca.SX(0, 1)
    if switch.leaving:
        ap = ca.SX.sym("a_plus", robot.size)
        columns.append(following.a[0])
        rising, names_of_rising = lift_off_rows(problem, switch, qm, vm, robot.mirror.position(ap) if mirrored else ap)
        rows += rising
        labels += names_of_rising
        lower += [RISE] * len(rising)
        upper += [np.inf] * len(rising)
    if switch.leaving and not ground.level:
        # on level ground the normal force is a variable, whose bounds say the same
        contacts = pattern.contacts(switch.source)
        force = ca.SX.sym("force", contacts.size)
        local = contacts.local(force, contacts.points(qm))
        for foot in switch.leaving:
            rows.append(contacts.contact.normal_force(local[contacts.feet.index(foot)]) / FORCE_UNIT)
            labels += RowKind.LIFT_OFF.labels(f"lift-off force {foot} (10 N)")
        least = [problem.limits.normal_force / FORCE_UNIT] * len(switch.leaving)
        lower, upper = [*lower, *least], [*upper, *least]
        columns.append(domain.force[-1])
    return Block(
        name=f"switch_{identifier(domain.stance.name)}",
        variables=ca.vertcat(qm, vm, qp, vp, impulse, period, ap, force),
        constants=ca.SX(0, 1),
        parameters=parameters.packed(),
        rows=ca.vertcat(*rows),
        cost=NO_COST,
        labels=tuple(labels),
        columns=np.concatenate(columns)[None, :],
        values=np.zeros((1, 0)),
        places=(switch.name,),
        lower=np.array([lower]),
        upper=np.array([upper]),
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
        labels=tuple(RowKind.PHASE.labels(*(number.name for number in numbers))),
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
        labels=tuple(RowKind.PERIOD.labels("sum of durations")),
        columns=columns[None, :],
        values=np.zeros((1, 0)),
        places=("period",),
        lower=np.zeros((1, 1)),
        upper=np.zeros((1, 1)),
    )
