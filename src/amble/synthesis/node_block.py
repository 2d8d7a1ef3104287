"""Rows at every collocation node: dynamics, contacts, output dynamics, allocation law, friction, swing height, cost."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.control import Redundancy
from amble.control.phase import DomainPhase, PhaseRates
from amble.errors import InputError
from amble.gait.cost import Instant
from amble.hybrid import Contacts, selection
from amble.names import identifier
from amble.numerics.bezier import bezier
from amble.numerics.collocation import node_weights
from amble.robot import dynamics, kinematics
from amble.robot.coordinate_units import as_torques, load_units, units
from amble.robot.parts import ACCELERATION, RATE
from amble.synthesis.block import Block, Label
from amble.synthesis.clearance_rows import clearance_rows
from amble.synthesis.layout import MARGIN, DomainLayout, Layout, least_normal_force
from amble.synthesis.problem import GaitProblem
from amble.synthesis.rows import RowKind

SLOWEST = 0.05
"""Least rate of a phase that the configuration moves, as a share of its mean; curves over it need one that grows."""


@dataclass(frozen=True)
class ProgramParameters:
    """Symbols of the numbers that may change without compiling again: the velocities asked for, friction."""

    speed: ca.SX
    lateral_speed: ca.SX
    yaw_rate: ca.SX
    friction: ca.SX

    @classmethod
    def symbols(cls) -> ProgramParameters:
        """Create the symbols."""
        return cls(*(ca.SX.sym(name) for name in ("speed", "lateral_speed", "yaw_rate", "friction")))

    def packed(self) -> ca.SX:
        """One column."""
        return ca.vertcat(self.speed, self.lateral_speed, self.yaw_rate, self.friction)


def parameter_values(problem: GaitProblem) -> np.ndarray:
    """Return the values in the order of ``ProgramParameters.packed``."""
    return np.array([problem.speed, problem.lateral_speed, problem.yaw_rate, problem.pattern.ground.friction])


def output_indices(problem: GaitProblem, domain: DomainLayout) -> list[int]:
    """Return the places of the controlled coordinates in q."""
    names = problem.pattern.robot.coordinate_names
    return [names.index(name) for name in problem.outputs.of(domain.stance.name).coordinates]


def domain_phase(problem: GaitProblem, domain: DomainLayout) -> DomainPhase:
    """Return the phase of the outputs in a domain."""
    return DomainPhase(phase=problem.outputs.phase, robot=problem.pattern.robot, stance=domain.stance)


def node_block(problem: GaitProblem, layout: Layout, domain: DomainLayout) -> Block:
    """Build the rows of all nodes of a domain."""
    contacts = problem.pattern.contacts(domain.stance)
    robot, feet, foot = contacts.robot, contacts.feet, contacts.contact
    # shorthand
    q, v, a = (ca.SX.sym(letter, robot.size) for letter in "qva")
    u, lam = ca.SX.sym("u", len(robot.joints)), ca.SX.sym("lambda", contacts.size)
    T, period = ca.SX.sym("T"), ca.SX.sym("period")
    alpha = ca.SX.sym("alpha", len(output_indices(problem, domain)), problem.outputs.order + 1)
    numbers = ca.SX.sym("phase_numbers", domain.phase_numbers.size)
    share, weight = ca.SX.sym("share"), ca.SX.sym("weight")
    parameters = ProgramParameters.symbols()

    J = contacts.jacobian(q)
    motion = dynamics.inverse_dynamics(robot, q, v, a) - selection(robot) @ u - J.T @ lam
    contact = J @ a + contacts.bias(q, v)
    phase = domain_phase(problem, domain).rates(share, T, q, v, numbers)
    outputs = _output_rows(problem, domain, (q, v, a), alpha, phase)
    growth = T * phase.rate if phase.by_state else ca.SX(0, 1)
    law = _law_rows(problem, contacts, q, v, u, lam)
    local = contacts.local(lam, contacts.points(q))
    cones = ca.vertcat(*[foot.pyramid(f, (1.0 - MARGIN) * parameters.friction) for f in local], ca.SX(0, 1))
    swing = [name for name in robot.foot_names if name not in feet]
    gaps = [contacts.ground.gap(kinematics.foot_position(robot, name, q)) for name in swing]
    tilted, tilted_labels = _tilted_rows(contacts, q, local)
    asked = clearance_rows(problem, contacts, q, v, u)
    labels = (
        _equality_labels(problem, domain, contacts, law.shape[0])
        + RowKind.FRICTION.labels((f"friction {name} {side}" for name in feet for side in foot.sides), "N")
        + RowKind.HEIGHT.labels((f"height {name}" for name in swing), "m")
        + tilted_labels
        + RowKind.PHASE_RATE.labels(["rate of the phase"] * growth.shape[0], "1")
        + asked.labels
    )
    equalities = robot.size + contact.shape[0] + outputs.shape[0] + law.shape[0]
    lower, upper = _bounds(problem, domain, equalities, swing)
    least, most = [SLOWEST] * growth.shape[0] + asked.lower, [np.inf] * growth.shape[0] + asked.upper
    lower, upper = (
        np.hstack([bounds, np.tile(np.array(further, dtype=np.float64), (domain.nodes, 1))])
        for bounds, further in ((lower, least), (upper, most))
    )
    instant = Instant(contacts=contacts, positions=q, velocities=v, accelerations=a, torques=u, forces=lam, duration=T)
    variables = ca.vertcat(q, v, a, u, lam, T, ca.vec(alpha), numbers, period)
    common = np.concatenate([domain.duration, domain.coefficients, domain.phase_numbers, layout.period])
    columns = np.hstack([domain.q, domain.v, domain.a, domain.u, domain.force, np.tile(common, (domain.nodes, 1))])
    return Block(
        name=f"node_{identifier(domain.stance.name)}",
        variables=variables,
        constants=ca.vertcat(share, weight),
        parameters=parameters.packed(),
        rows=ca.vertcat(motion, contact, outputs, law, cones, *gaps, *tilted, growth, *asked.rows),
        cost=weight * T / period * problem.cost.running(instant),  # its mean, with the scheme's own quadrature weights
        labels=tuple(labels),
        columns=columns,
        values=np.column_stack([domain.phases, node_weights(problem.collocation, problem.intervals)]),
        places=tuple(domain.place(node) for node in range(domain.nodes)),
        lower=lower,
        upper=upper,
    )


def _equality_labels(problem: GaitProblem, domain: DomainLayout, contacts: Contacts, laws: int) -> list[Label]:
    """Label the rows that are zero: dynamics, contacts, outputs with their rates, allocation law."""
    coordinates, robot = problem.outputs.of(domain.stance.name).coordinates, contacts.robot
    joints = robot.coordinate_names
    accelerations = contacts.contact.component_units("m/s^2", "rad/s^2") * len(contacts.feet)
    return (
        RowKind.DYNAMICS.labels((f"dynamics {name}" for name in joints), load_units(robot, joints))
        + RowKind.CONTACT.labels((f"contact {label}" for label in contacts.labels), accelerations)
        + RowKind.OUTPUT.labels((f"output {name}" for name in coordinates), units(robot, coordinates))
        + RowKind.OUTPUT_RATE.labels((f"output {RATE}{name}" for name in coordinates), units(robot, coordinates, "/s"))
        + RowKind.OUTPUT_ACCELERATION.labels(
            (f"output {ACCELERATION}{name}" for name in coordinates), units(robot, coordinates, "/s^2")
        )
        + RowKind.LAW.labels((f"law {problem.law.name} {i}" for i in range(laws)), "N m")
    )


def _output_rows(
    problem: GaitProblem, domain: DomainLayout, state: tuple[ca.SX, ca.SX, ca.SX], alpha: ca.SX, phase: PhaseRates
) -> ca.SX:
    """The controlled coordinates lie on their curves over the phase, with their rates: y = y' = y'' = 0.

    The output dynamics y'' + K_d y' + K_p y = 0 from y = y' = 0 say the same, but through collocation rows that tie
    every controlled coordinate of a node to its neighbours; without them the solver's matrices have a quarter of the
    work (docs/performance.md).
    """
    controlled = output_indices(problem, domain)
    q, v, a = (part[controlled] for part in state)
    value, slope, curvature = bezier(alpha, phase.value)
    second = curvature * phase.rate**2 + slope * phase.second(state[2])
    return ca.vertcat(q - value, v - slope * phase.rate, a - second)


def _law_rows(problem: GaitProblem, contacts: Contacts, q: ca.SX, v: ca.SX, u: ca.SX, lam: ca.SX) -> ca.SX:
    """Rows of the allocation law, built on the controller's null space as a share of its size at the posture.

    Its columns are then of size one whatever their length, so that conditions on torques are torques.
    """
    torques, forces = contacts.torque_null_space(q)
    at = ca.SX.sym("q", contacts.robot.size)
    basis = as_torques(contacts.robot, contacts.torque_null_space(at)[0])
    sizes = ca.Function("sizes", [at], [ca.sqrt(ca.sum1(basis**2)).T])
    per = 1.0 / sizes(problem.posture.coordinates(contacts.robot))
    null_space = (torques @ ca.diag(per), forces @ ca.diag(per)) if per.numel() else (torques, forces)
    return ca.densify(problem.law.optimality_conditions(Redundancy.at(contacts, (q, v), (u, lam), null_space)))


def _tilted_rows(contacts: Contacts, q: ca.SX, local: list[ca.SX]) -> tuple[list[ca.SX], list[Label]]:
    """What bounds of variables say on level ground: normal force of every stance foot, height of the base."""
    if contacts.ground.level:
        return [], []
    forces = [contacts.contact.normal_force(f) for f in local]
    x, y, z = ca.vertsplit(contacts.robot.base.spatial(q)[:3])
    base = z - contacts.ground.height(x, y)
    labels = RowKind.NORMAL_FORCE.labels((f"normal force {foot}" for foot in contacts.feet), "N")
    return [*forces, base], labels + RowKind.BASE_HEIGHT.labels(["base above the ground"], "m")


def _bounds(
    problem: GaitProblem, domain: DomainLayout, equalities: int, swing: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Equalities are zero, cones not negative, swing feet above a curve over their whole swing.

    The curve, clearance (4 s (1 - s))^2, begins and ends flat: a foot at rest cannot follow a slope at once, so below
    a parabola the first node would ask for accelerations that grow with the number of nodes.
    """
    contacts = problem.pattern.contacts(domain.stance)
    sides = len(contacts.contact.sides)
    cones, tilted = sides * len(contacts.feet), not contacts.ground.level
    normal = equalities + cones + len(swing)
    lower = np.zeros((domain.nodes, normal + (len(contacts.feet) + 1 if tilted else 0)))
    upper = np.zeros_like(lower)
    upper[:, equalities:] = np.inf
    for row, foot in enumerate(swing, start=equalities + cones):
        first, last = swing_span(problem, domain, foot)
        progress = first + (last - first) * domain.phases
        lower[:, row] = problem.limits.clearance * (4.0 * progress * (1.0 - progress)) ** 2
        # At lift-off the foot is on the ground by continuity and at touchdown by the guard: a row there would repeat.
        lower[progress < 1e-9, row] = -np.inf
        lower[progress > 1.0 - 1e-9, row] = -np.inf
    if tilted:
        for place, foot in enumerate(contacts.feet, start=normal):
            lower[:, place] = least_normal_force(problem, domain, foot)
        lower[:, -1], upper[:, -1] = problem.limits.positions.get("z", (-np.inf, np.inf))
    for foot in domain.switch.leaving if tilted else ():
        lower[-1, normal + domain.stance.feet.index(foot)] = -np.inf  # a row of the switch says what it is
    return lower, upper


def swing_span(problem: GaitProblem, domain: DomainLayout, foot: str) -> tuple[float, float]:
    """Return the parts of a foot's swing at which this domain begins and ends, counting domains."""
    stances = problem.pattern.stances
    here = [stance.name for stance in stances].index(domain.stance.name)
    around = range(len(stances))
    before = next((k for k in around if foot in stances[here - k - 1].feet), None)
    after = next((k for k in around if foot in stances[(here + k + 1) % len(stances)].feet), None)
    if before is None or after is None:
        raise InputError(f"foot '{foot}' never stands in this gait")
    total = before + after + 1
    return before / total, (before + 1) / total
