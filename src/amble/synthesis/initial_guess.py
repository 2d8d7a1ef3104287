"""Where the solver starts: a walk that kinematics and the rows of the base can draw.

The base advances evenly at the wanted speed and sways as gravity and the contacts make it (``base_motion``); the feet
follow their footholds; inverse kinematics gives the joints; one curve of the outputs' order a coordinate gives values
and rates that fit together. From a standing robot the solver needs far more iterations (docs/performance.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from amble.gait.command import Command
from amble.hybrid import Contacts, GaitPattern
from amble.numerics.bezier import evaluate, fit
from amble.robot import Robot, dynamics, kinematics
from amble.robot.base import SPATIAL
from amble.robot.natural_units import RobotUnits
from amble.synthesis.base_trajectory import LevelWalk, base_trajectory
from amble.synthesis.landing_rows import fill_landings
from amble.synthesis.layout import DomainLayout, Layout
from amble.synthesis.node_block import domain_phase, output_indices
from amble.synthesis.problem import GaitProblem
from amble.types import Matrix, NodeValues, Vector

INTERIOR = 0.1
"""Share of a coordinate's range by which the pose keeps off its bounds: an interior-point method crawls along them."""

SWING_FACTOR = 1.5
"""Top of a swing foot's parabola over the clearance that is asked for."""

DAMPING = 0.03
"""Of a step of the inverse kinematics, in units of the robot a unit of a joint. A leg's foot is met to 1e-10 all the
same, but one that passes under a vertical hip axis does not turn the leg around: that of ASTRo's crawl went to 7.6 rad.
"""

CRAWL_STANDING, CRAWL_SWINGING = 0.15, 0.8
"""Shares of their ranges at which domains of a crawl begin: the optima of seven robots stand on all feet as briefly as
they may and swing as long as they may."""

KINEMATIC_STEPS = 8


@dataclass(frozen=True)
class Walk:
    """How the base goes, evenly, and how high the feet swing, m."""

    command: Command
    height: float

    def carried(self, point: Vector, times: Vector) -> Matrix:
        """Return where a point of the base is over the ground, (times, 2), m; at time 0 it is where it is given."""
        x, y, angle = self._way(times)
        cosine, sine = np.cos(angle), np.sin(angle)
        return np.column_stack([x + cosine * point[0] - sine * point[1], y + sine * point[0] + cosine * point[1]])

    def headings(self, times: Vector) -> Vector:
        """Return the heading, (times,), rad."""
        return self._way(times)[2]

    def _way(self, times: Vector) -> tuple[Vector, Vector, Vector]:
        if self.command.straight:
            return self.command.way(times)
        moved = [self.command.way(time) if time != 0.0 else (0.0, 0.0, 0.0) for time in times]
        x, y, angle = np.array(moved).T
        return x, y, angle


def foot_path(
    pattern: GaitPattern,
    durations: Mapping[str, float],
    foot: str,
    home: Vector,
    walk: Walk,
    times: Vector,
) -> Matrix:
    """Return the positions of a foot while the base advances evenly, (times, 3), m.

    A stance foot rests where its home is in the middle of its stance, so a gait whose two halves mirror each other
    has paths that do; a swing foot crosses to its next foothold on a parabola.

    Args:
        pattern: which feet stand when, and on what ground.
        durations: solved domain -> duration, s.
        foot: the foot.
        home: where the foot stands at time 0 in the robot's posture, (3,), m.
        walk: how the base goes, and height of the parabola.
        times: s, from the entry of the first domain.
    """
    height = walk.height
    path = np.tile(home, (times.size, 1))
    spans = stance_span(pattern, durations, foot)
    if spans is None:
        # A foot that never lands hangs in the air; one that never lifts can only drag along.
        path[:, :2] = walk.carried(home, times)
        lift = 0.0 if foot in pattern.stances[0].feet else height
        path[:, 2] = pattern.ground.height(path[:, 0], path[:, 1]) + lift
        return path
    landing, stance, cycle = spans
    laps, phase = np.divmod(times - landing + 1e-9 * cycle, cycle)
    progress = np.clip((phase - stance) / (cycle - stance), 0.0, 1.0)
    foothold = landing + 0.5 * stance + laps * cycle
    share = progress**2 * (3.0 - 2.0 * progress)
    if walk.command.straight:
        path[:, :2] = walk.carried(home, foothold + cycle * share)
    else:
        here, there = walk.carried(home, foothold), walk.carried(home, foothold + cycle)
        path[:, :2] = here + share[:, None] * (there - here)
    path[:, 2] = pattern.ground.height(path[:, 0], path[:, 1]) + height * 4.0 * progress * (1.0 - progress)
    return path


def stance_span(pattern: GaitPattern, durations: Mapping[str, float], foot: str) -> tuple[float, float, float] | None:
    """Return when a foot lands, how long it stands, and the period, s; None where it never lands or never lifts."""
    stances, solved = pattern.stances, pattern.solved
    lengths = np.array([durations[solved[k % len(solved)].name] for k in range(len(stances))])
    down = [foot in stance.feet for stance in stances]
    if all(down) or not any(down):
        return None
    first = next(k for k in range(len(down)) if down[k] and not down[k - 1])
    stance, k = 0.0, first
    while down[k % len(down)]:
        stance += float(lengths[k % len(down)])
        k += 1
    return float(lengths[:first].sum()), stance, float(lengths.sum())


def initial_guess(problem: GaitProblem, layout: Layout) -> Vector:
    """Return unscaled variables of a walk whose base sways as the contact forces ask, (n_x,)."""
    guess = np.zeros(layout.size)
    durations = starting_durations(problem)
    robot, (pose, homes) = problem.pattern.robot, grounded_posture(problem)
    bases, paths = _level(problem, layout, durations, pose, homes)
    walks = []
    for domain, base, path in zip(layout.domains, bases, paths, strict=True):
        T = durations[domain.stance.name]
        _, q, v, a = _smooth(problem, domain, T, inverse_kinematics(robot, base, pose[robot.base.size :], path))
        contacts, scheme = problem.pattern.contacts(domain.stance), problem.collocation
        walks.append(LevelWalk(contacts=contacts, duration=T, scheme=scheme, q=q, v=v, a=a))
    turn = float(problem.command.way(sum(walk.duration for walk in walks))[2])
    shifts, forces = base_trajectory(problem.pattern, walks, turn)
    for domain, walk, base, path, shift, force in zip(layout.domains, walks, bases, paths, shifts, forces, strict=True):
        motion = inverse_kinematics(robot, base + shift, pose[robot.base.size :], path)
        _fill(problem, domain, guess, walk.duration, motion, force)
    guess[layout.period] = sum(walk.duration for walk in walks)
    fill_landings(problem, layout, guess)
    return guess


def _level(
    problem: GaitProblem, layout: Layout, durations: Mapping[str, float], pose: Vector, homes: Matrix
) -> tuple[list[NodeValues], list[NodeValues]]:
    """Base coordinates that advance evenly and the paths of the feet, domain by domain."""
    pattern, began = problem.pattern, 0.0
    walk = Walk(problem.command, SWING_FACTOR * problem.limits.clearance)
    standing = pattern.robot.base.spatial(pose)[:SPATIAL]
    bases, paths = [], []
    for domain in layout.domains:
        T = durations[domain.stance.name]
        times = began + T * domain.phases
        base = np.tile(standing, (times.size, 1))
        base[:, :2] = walk.carried(standing[:2], times)
        base[:, 5] += walk.headings(times)
        base[:, 2] += pattern.ground.height(base[:, 0], base[:, 1])
        feet = zip(pattern.robot.foot_names, homes, strict=True)
        bases.append(base[:, list(pattern.robot.base.places)])
        paths.append(np.hstack([foot_path(pattern, durations, foot, home, walk, times) for foot, home in feet]))
        began += T
    return bases, paths


def starting_durations(problem: GaitProblem) -> dict[str, float]:
    """Return durations of the solved domains, s: the middle of what is allowed, but in a crawl.

    Where one foot at a time swings, between stances on all feet, it has a short share of the cycle for a whole stride;
    even durations ask for more than its joints may accelerate.
    """
    solved, feet = problem.pattern.solved, len(problem.pattern.robot.foot_names)
    standing = {domain.name: len(domain.feet) for domain in solved}
    crawls = feet > 2 and set(standing.values()) == {feet - 1, feet}
    shares = {feet: CRAWL_STANDING, feet - 1: CRAWL_SWINGING} if crawls else {}
    allowed = problem.limits.durations.items()
    return {name: low + shares.get(standing[name], 0.5) * (high - low) for name, (low, high) in allowed}


def grounded_posture(problem: GaitProblem) -> tuple[Vector, Matrix]:
    """Return the posture inside its bounds, (n_q,), and where its feet are, projected onto the ground, (feet, 3).

    The base is level, its height that above the ground under it.
    """
    robot = problem.pattern.robot
    pose = problem.posture.coordinates(robot)
    for name, (low, high) in problem.limits.positions.items():
        place = robot.coordinate_names.index(name)
        edge = INTERIOR * (high - low) if np.isfinite(high - low) else 0.0
        pose[place] = np.clip(pose[place], low + edge, high - edge)
    homes = np.array([np.asarray(kinematics.foot_position(robot, foot, pose)).ravel() for foot in robot.foot_names])
    homes[:, 2] = problem.pattern.ground.height(homes[:, 0], homes[:, 1])
    return pose, homes


def inverse_kinematics(robot: Robot, base: NodeValues, joints: Vector, feet: NodeValues) -> NodeValues:
    """Return coordinates with the given base whose feet come as near as they can to the given points, (n, n_q).

    Damped least squares from the same joint angles at every node, so that neighbouring nodes get neighbouring poses.

    Args:
        robot: the robot.
        base: base coordinates, (n, n_b).
        joints: angles to start from, (n_joints,).
        feet: wanted positions in the robot's foot order, (n, 3 n_feet), m.
    """
    nodes = base.shape[0]
    function = _feet(robot).map(nodes)
    motion = np.hstack([base, np.tile(joints, (nodes, 1))])
    sizes = RobotUnits.of(robot)
    units, damping = np.array([sizes.size(joint.unit) for joint in robot.joints]), DAMPING * sizes.length
    for _ in range(KINEMATIC_STEPS):
        where, slopes = (np.asarray(part) for part in function(motion.T))
        J = slopes.reshape((-1, nodes, joints.size)).transpose(1, 0, 2) * units  # rounded alike at every size
        normal = J.transpose(0, 2, 1) @ J + damping**2 * np.eye(joints.size)
        step = np.linalg.solve(normal, J.transpose(0, 2, 1) @ (feet - where.T)[:, :, None])
        motion[:, robot.base.size :] += units * step[:, :, 0]
    return motion


@lru_cache(maxsize=16)
def _feet(robot: Robot) -> ca.Function:
    """Q -> positions of all feet, and their derivatives in the joints."""
    q = ca.SX.sym("q", robot.size)
    positions = ca.vertcat(*[kinematics.foot_position(robot, foot, q) for foot in robot.foot_names])
    jacobian = ca.densify(ca.vertcat(*[kinematics.foot_jacobian(robot, foot, q) for foot in robot.foot_names]))
    return ca.Function("feet", [q], [positions, jacobian[:, robot.base.size :]])


def _smooth(problem: GaitProblem, domain: DomainLayout, T: float, motion: NodeValues) -> tuple[Matrix, ...]:
    """Curves of the outputs' order through a motion: coefficients, and q, v, a at the nodes."""
    rates = np.gradient(motion, domain.phases, axis=0, edge_order=2)
    curves = fit(motion, rates, domain.phases, problem.outputs.order)
    q, slope, curvature = evaluate(curves, domain.phases)
    return curves, q, slope / T, curvature / T**2


def _fill(
    problem: GaitProblem, domain: DomainLayout, guess: Vector, T: float, motion: NodeValues, force: NodeValues
) -> None:
    """Write a domain's variables; the torques move the joints against the given contact forces."""
    _, q, v, a = _smooth(problem, domain, T, motion)
    guess[domain.duration] = T
    guess[domain.phase_numbers], curves = phase_curves(problem, domain, T, q, v)
    guess[domain.coefficients] = curves.ravel(order="F")
    guess[domain.q], guess[domain.v], guess[domain.a] = q, v, a
    guess[domain.force] = force
    guess[domain.u] = _torques(problem.pattern.contacts(domain.stance), domain, guess)


def phase_curves(
    problem: GaitProblem, domain: DomainLayout, T: float, q: NodeValues, v: NodeValues
) -> tuple[Vector, Matrix]:
    """Return numbers of the phase and output curves over it of a motion given at the nodes, (k,) and (n_y, order + 1).

    Raises:
        InputError: the phase does not grow all along the motion.
    """
    phase, outputs = domain_phase(problem, domain), output_indices(problem, domain)
    numbers = phase.measured(q[0], q[-1])
    value, pace = phase.along(T * domain.phases, T, q, v, numbers)
    return numbers, fit(q[:, outputs], v[:, outputs] / pace[:, None], value, problem.outputs.order)


def _torques(contacts: Contacts, domain: DomainLayout, guess: Vector) -> NodeValues:
    robot = contacts.robot
    symbols = [ca.SX.sym(letter, robot.size) for letter in "qva"]
    lam = ca.SX.sym("lambda", contacts.size)
    load = dynamics.inverse_dynamics(robot, *symbols) - contacts.jacobian(symbols[0]).T @ lam
    function = ca.Function("torques", [*symbols, lam], [load[robot.base.size :]]).map(domain.nodes)
    known = (domain.q, domain.v, domain.a, domain.force)
    return np.asarray(function(*(guess[part].T for part in known))).T
