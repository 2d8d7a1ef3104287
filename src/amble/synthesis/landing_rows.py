"""Rows behind landings: released feet go up; feet that land one by one may do so in every order, and hold meanwhile.

On the gait all feet of a switch land at once, so the stances between two landings last no time. What they need are the
rates behind the impact on their feet, and there the accelerations and forces of docs/theory/hybrid-model.md, eq. 22.
Both are variables: eliminated, the second derivatives of these few rows were fifty times those of all others of a
switch.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.control.landing import landing_motion
from amble.gait import Gait
from amble.hybrid import Contacts, GaitPattern, Stance, Switch, impact
from amble.hybrid.constrained_dynamics import selection
from amble.hybrid.ground import into_frame
from amble.hybrid.landing import steps
from amble.names import identifier
from amble.robot import dynamics, kinematics
from amble.robot.coordinate_units import load_units
from amble.robot.natural_units import velocity_unit
from amble.synthesis.block import Block, Label
from amble.synthesis.layout import MARGIN, LandingLayout, Layout
from amble.synthesis.node_block import ProgramParameters
from amble.synthesis.problem import RELEASE, GaitProblem
from amble.synthesis.rows import RowGroup, RowKind
from amble.types import Vector

SLOW_RELEASE = 1e-5
"""The same where no gait has been found (``synthesize``). A released foot rested: what it has behind a landing comes
from this impact alone, and of the speed of the foot that lands little more than 0.001 reaches it."""

DEPTH = 0.01
"""Least depth below the ground that a landing foot would go on to, as a share of the leg length. ANYmal C's walk had
0.0003, and starts changed by 1e-4 missed the ground; most gaits have 0.02 and more without the row."""


def order_rows(problem: GaitProblem, switch: Switch, stance: Stance, q: ca.SX, v: ca.SX, impulse: ca.SX) -> RowGroup:
    """Return rows that say that a landing is possible.

    Behind the impact the feet on the ground have pushed, those that were released go up, and those that have still to
    land go on down.

    Args:
        problem: the gait problem.
        switch: at which several feet land one by one.
        stance: the feet on the ground behind a landing.
        q: coordinates there, (n_q,).
        v: their rates behind the impact on these feet, (n_q,).
        impulse: of that impact, (n_f,).
    """
    contacts = problem.pattern.contacts(stance)
    where = _behind(switch, stance)
    rows: list[ca.SX] = []
    labels: list[Label] = []
    lower: list[float] = []
    for foot, push in zip(stance.feet, contacts.local(impulse, contacts.points(q)), strict=True):
        rows.append(contacts.contact.normal_force(push))
        labels += RowKind.LANDING_ORDER.labels([f"{where}: impulse {foot}"], "N s")
        lower.append(0.0)
    for foot in _late(switch, stance):
        rows.append(-_upwards(problem, foot, q, v))
        labels += RowKind.LANDING_ORDER.labels([f"{where}: velocity down {foot}"], "m/s")
        lower.append(RELEASE * velocity_unit(problem.pattern.robot))
    released = release_rows(problem, switch, q, v, where)
    rows, labels, lower = rows + released.rows, labels + released.labels, lower + released.lower
    return RowGroup(rows=rows, labels=labels, lower=lower, upper=[np.inf] * len(rows))


def release_rows(problem: GaitProblem, switch: Switch, q: ca.SX, v: ca.SX, where: str) -> RowGroup:
    """Return rows that say that the feet which a landing releases go up behind it.

    One that went down would be in the ground at once, and where it is the next to land, its guard would fire.

    Args:
        problem: the gait problem.
        switch: at which feet land and lift.
        q: coordinates there, (n_q,).
        v: their rates behind the impact, (n_q,).
        where: which impact, for the labels.
    """
    least = problem.release * velocity_unit(problem.pattern.robot)
    labels = RowKind.LANDING_ORDER.labels((f"{where}: velocity up {foot}" for foot in switch.lifting), "m/s")
    rows = [_upwards(problem, foot, q, v) for foot in switch.lifting]
    return RowGroup(rows=rows, labels=labels, lower=[least] * len(rows), upper=[np.inf] * len(rows))


def releases(pattern: GaitPattern) -> bool:
    """Whether a landing of the solved domains releases feet."""
    return any(switch.landing and switch.lifting for switch in pattern.switches)


def released_slowly(problem: GaitProblem, gait: Gait) -> bool:
    """Whether a gait was found with ``SLOW_RELEASE``: its slowest foot that a landing releases is between the two.

    Half of both, since a start may be of another mesh or a neighbouring problem.
    """
    pattern, robot, speeds = problem.pattern, problem.pattern.robot, list[float]()
    for switch, trajectory in zip(pattern.switches, gait.domains, strict=True):
        if not (switch.landing and switch.lifting):
            continue
        q, v = ca.DM(trajectory.positions[-1]), ca.DM(trajectory.velocities[-1])
        for stance in dict.fromkeys(step.target for step in steps(switch, pattern.landing_rule, robot.foot_names)):
            after = impact(pattern.contacts(stance), q, v)[0]
            speeds += [float(_upwards(problem, foot, q, after)) for foot in switch.lifting]
    slowest = min(speeds, default=np.inf) / velocity_unit(robot)
    return bool(0.5 * SLOW_RELEASE <= slowest < 0.5 * problem.release)


def depth_rows(problem: GaitProblem, switch: Switch, q: ca.SX, v: ca.SX, a: ca.SX) -> RowGroup:
    """Return rows that say that landing feet would go on into the ground, by ``DEPTH``, were it not there.

    A foot that slows down as it lands, at v with a upwards, goes v^2 / 2 a deep; from a start beside the orbit one that
    hardly reaches the ground misses it.

    Args:
        problem: the gait problem.
        switch: at which feet land.
        q: coordinates there, (n_q,).
        v: their rates before the impact, (n_q,).
        a: their accelerations before the impact, (n_q,).
    """
    robot, ground = problem.pattern.robot, problem.pattern.ground
    rows = []
    for foot in switch.landing:
        frame = ground.frame(kinematics.foot_position(robot, foot, q))
        J = kinematics.foot_jacobian(robot, foot, q)
        speed = into_frame(J @ v, frame)[2] / velocity_unit(robot)
        up = into_frame(J @ a + kinematics.foot_bias(robot, foot, q, v), frame)[2] / robot.gravity
        rows.append(speed**2 - 2.0 * DEPTH * up)
    labels = RowKind.TOUCHDOWN.labels((f"touchdown depth {foot} (v^2 / g l)" for foot in switch.landing), "1")
    return RowGroup(rows=rows, labels=labels, lower=[0.0] * len(rows), upper=[np.inf] * len(rows))


def landing_blocks(problem: GaitProblem, layout: Layout, number: int) -> list[Block]:
    """Build the rows of every stance between the landings of the switch that ends a domain.

    The torques are those of the next domain's first node, mirrored where half a cycle is solved.
    """
    pattern, domain = problem.pattern, layout.domains[number]
    last = number == len(layout.domains) - 1
    following = layout.domains[0 if last else number + 1]
    blocks = []
    for landing in domain.landings:
        parameters, symbols = ProgramParameters.symbols(), _LandingSymbols.of(problem, landing)
        u = pattern.robot.mirror.torque(symbols.torques) if last and pattern.mirrored else symbols.torques
        groups = [
            _impact(problem, domain.switch, landing, symbols),
            order_rows(problem, domain.switch, landing.stance, symbols.q, symbols.after, symbols.impulse),
            _motion(problem, domain.switch, landing, symbols, u),
            _forces(problem, domain.switch, landing.stance, symbols, parameters.friction),
        ]
        columns = [domain.q[-1], domain.v[-1], landing.index, following.u[0]]
        blocks.append(
            Block(
                name=f"landing_{identifier(domain.stance.name)}_{identifier(landing.stance.name)}",
                variables=symbols.packed,
                constants=ca.SX(0, 1),
                parameters=parameters.packed(),
                rows=ca.vertcat(*(row for group in groups for row in group.rows)),
                cost=ca.SX(1, 1),
                labels=tuple(label for group in groups for label in group.labels),
                columns=np.concatenate(columns)[None, :],
                values=np.zeros((1, 0)),
                places=(domain.switch.name,),
                lower=np.array([[bound for group in groups for bound in group.lower]]),
                upper=np.array([[bound for group in groups for bound in group.upper]]),
            )
        )
    return blocks


class _LandingSymbols:
    """Symbols of one stance between landings: before the impact, behind it, and the next stance's torques."""

    def __init__(self, size: int, free: tuple[int, ...], forces: int, joints: int) -> None:
        self.q, self.before, self.after = (ca.SX.sym(name, size) for name in ("q", "v_minus", "v"))
        self.impulse, self.force = ca.SX.sym("impulse", forces), ca.SX.sym("force", forces)
        moved, self.torques = ca.SX.sym("a", len(free)), ca.SX.sym("u", joints)
        self.packed = ca.vertcat(self.q, self.before, self.after, self.impulse, moved, self.force, self.torques)
        self.acceleration = ca.SX(size, 1)
        self.acceleration[list(free)] = moved

    @classmethod
    def of(cls, problem: GaitProblem, landing: LandingLayout) -> _LandingSymbols:
        robot = problem.pattern.robot
        return cls(robot.size, landing.free, landing.force.size, len(robot.joints))


def _impact(problem: GaitProblem, switch: Switch, landing: LandingLayout, at: _LandingSymbols) -> RowGroup:
    """The plastic impact on the feet that have landed so far."""
    robot, contacts = problem.pattern.robot, problem.pattern.contacts(landing.stance)
    J, mass = contacts.jacobian(at.q), dynamics.mass_matrix(robot, at.q)
    where = _behind(switch, landing.stance)
    labels = RowKind.IMPACT.labels(
        (f"{where}: impact {name}" for name in (*robot.coordinate_names, *contacts.labels)),
        load_units(robot, robot.coordinate_names, " s")
        + contacts.contact.component_units("m/s", "rad/s") * len(contacts.feet),
    )
    return RowGroup.equalities([mass @ (at.after - at.before) - J.T @ at.impulse, J @ at.after], labels)


def _motion(problem: GaitProblem, switch: Switch, landing: LandingLayout, at: _LandingSymbols, u: ca.SX) -> RowGroup:
    """Equation 22: the free coordinates move under the torques, the feet on the ground stay."""
    robot, contacts = problem.pattern.robot, problem.pattern.contacts(landing.stance)
    J, free = contacts.jacobian(at.q), list(landing.free)
    loads = dynamics.inverse_dynamics(robot, at.q, at.after, at.acceleration) - selection(robot) @ u - J.T @ at.force
    names = [robot.coordinate_names[k] for k in free]
    where = _behind(switch, landing.stance)
    labels = RowKind.LANDING_FORCE.labels(
        (f"{where}: dynamics {name}" for name in (*names, *contacts.labels)),
        load_units(robot, names) + contacts.contact.component_units("m/s^2", "rad/s^2") * len(contacts.feet),
    )
    return RowGroup.equalities([loads[free], J @ at.acceleration + contacts.bias(at.q, at.after)], labels)


def _forces(problem: GaitProblem, switch: Switch, stance: Stance, at: _LandingSymbols, friction: ca.SX) -> RowGroup:
    """The feet on the ground push as hard as every stance foot has to, within their cones."""
    contacts, where = problem.pattern.contacts(stance), _behind(switch, stance)
    sides = contacts.contact.sides
    rows: list[ca.SX] = []
    labels: list[Label] = []
    lower: list[float] = []
    for foot, local in zip(stance.feet, contacts.local(at.force, contacts.points(at.q)), strict=True):
        rows.append(contacts.contact.normal_force(local))
        rows.append(contacts.contact.pyramid(local, (1.0 - MARGIN) * friction))
        names = [f"{where}: normal force {foot}", *(f"{where}: friction {foot} {side}" for side in sides)]
        labels += RowKind.LANDING_FORCE.labels(names, "N")
        lower += [problem.limits.normal_force, *(0.0 for _ in sides)]
    return RowGroup(rows=rows, labels=labels, lower=lower, upper=[np.inf] * len(lower))


def fill_landings(problem: GaitProblem, layout: Layout, natural: Vector) -> None:
    """Set the variables between landings to what the others make of them.

    Args:
        problem: the gait problem.
        layout: of its variables.
        natural: unscaled variables, (n_x,), changed in place.
    """
    pattern, robot = problem.pattern, problem.pattern.robot
    for number, domain in enumerate(layout.domains):
        last = number == len(layout.domains) - 1
        q, v = natural[domain.q[-1]], natural[domain.v[-1]]
        u = natural[layout.domains[0 if last else number + 1].u[0]]
        u = robot.mirror.torque(u) if last and pattern.mirrored else u
        for landing in domain.landings:
            contacts = pattern.contacts(landing.stance)
            values = _between(contacts, _late(domain.switch, landing.stance), q, v, u)
            for index, value in zip((landing.v, landing.impulse, landing.force), values, strict=False):
                natural[index] = value
            natural[landing.a] = values[3][list(landing.free)]


def _between(contacts: Contacts, late: list[str], q: Vector, v: Vector, u: Vector) -> tuple[Vector, ...]:
    """Rates, impulse, forces and accelerations between landings."""
    size = contacts.robot.size
    at, rate, torque = ca.SX.sym("q", size), ca.SX.sym("v", size), ca.SX.sym("u", u.size)
    motion = landing_motion(contacts, late, at, rate, torque)
    stopped = ca.Function("stopped", [at, rate], impact(contacts, at, rate), {"cse": True})
    moved = ca.Function("moved", [at, rate, torque], [motion.forces, motion.acceleration], {"cse": True})
    after, impulse = stopped(q, v)
    return tuple(np.asarray(part).ravel() for part in (after, impulse, *moved(q, after, u)))


def _late(switch: Switch, stance: Stance) -> list[str]:
    return [foot for foot in switch.landing if foot not in stance.feet]


def _behind(switch: Switch, stance: Stance) -> str:
    return "after " + ", ".join(foot for foot in stance.feet if foot in switch.landing)


def _upwards(problem: GaitProblem, foot: str, q: ca.SX, v: ca.SX) -> ca.SX:
    robot, ground = problem.pattern.robot, problem.pattern.ground
    velocity = kinematics.foot_jacobian(robot, foot, q) @ v
    return into_frame(velocity, ground.frame(kinematics.foot_position(robot, foot, q)))[2]
