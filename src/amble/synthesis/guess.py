"""Where the solver starts: a walk that kinematics alone can draw.

The base advances level at the wanted speed, the feet follow their footholds, inverse kinematics gives the joints, and
one curve of the outputs' order a coordinate gives values and rates that fit together. From a standing robot the solver
needs two to three times the iterations (docs/performance.md).
"""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from amble.hybrid import stance_jacobian
from amble.maths.bezier import evaluate, fit
from amble.robot import Robot, dynamics, kinematics
from amble.synthesis.footholds import foot_path
from amble.synthesis.layout import DomainLayout, Layout
from amble.synthesis.node_block import output_indices
from amble.synthesis.problem import GaitProblem
from amble.types import Matrix, NodeValues, Vector

INTERIOR = 0.1
"""Share of a coordinate's range by which the pose keeps off its bounds: an interior-point method crawls along them."""

SWING_FACTOR = 1.5
"""Top of a swing foot's parabola over the clearance that is asked for."""

DAMPING = 1e-3
"""Of the inverse kinematics, m/rad; small against a leg, so that the feet are met where they can be."""

KINEMATIC_STEPS = 8


def walking(problem: GaitProblem, layout: Layout) -> Vector:
    """Return unscaled variables of a kinematic walk, (n_x,)."""
    pattern, guess = problem.pattern, np.zeros(layout.size)
    durations = middle_durations(problem)
    pose, homes = grounded_posture(problem)
    walk = (problem.speed, SWING_FACTOR * problem.limits.clearance)
    began = 0.0
    for domain in layout.domains:
        T = durations[domain.stance.name]
        times = began + T * domain.phases
        base = np.tile(pose[:6], (times.size, 1))
        base[:, 0] += problem.speed * times
        feet = zip(pattern.robot.foot_names, homes, strict=True)
        paths = np.hstack([foot_path(pattern, durations, foot, home, walk, times) for foot, home in feet])
        motion = inverse_kinematics(pattern.robot, base, pose[6:], paths)
        _fill(problem, domain, guess, T, motion)
        began += T
    guess[layout.period] = began
    return guess


def middle_durations(problem: GaitProblem) -> dict[str, float]:
    """Return the middle of the allowed durations of the solved domains, s."""
    return {name: 0.5 * (low + high) for name, (low, high) in problem.limits.durations.items()}


def grounded_posture(problem: GaitProblem) -> tuple[Vector, Matrix]:
    """Return the posture inside its bounds, (n_q,), and where its feet are, projected onto the ground, (feet, 3)."""
    robot = problem.pattern.robot
    pose = problem.posture.coordinates(robot)
    for name, (low, high) in problem.limits.positions.items():
        place = robot.coordinate_names.index(name)
        edge = INTERIOR * (high - low) if np.isfinite(high - low) else 0.0
        pose[place] = np.clip(pose[place], low + edge, high - edge)
    homes = np.array([np.asarray(kinematics.foot_position(robot, foot, pose)).ravel() for foot in robot.foot_names])
    homes[:, 2] = 0.0
    return pose, homes


def inverse_kinematics(robot: Robot, base: NodeValues, joints: Vector, feet: NodeValues) -> NodeValues:
    """Return coordinates with the given base whose feet come as near as they can to the given points, (n, n_q).

    Damped least squares from the same joint angles at every node, so that neighbouring nodes get neighbouring poses.

    Args:
        robot: the robot.
        base: base coordinates, (n, 6).
        joints: angles to start from, (n_joints,).
        feet: wanted positions in the robot's foot order, (n, 3 n_feet), m.
    """
    nodes = base.shape[0]
    q = ca.SX.sym("q", robot.size)
    positions = ca.vertcat(*[kinematics.foot_position(robot, foot, q) for foot in robot.foot_names])
    jacobian = ca.densify(stance_jacobian(robot, robot.foot_names, q))[:, 6:]
    function = ca.Function("feet", [q], [positions, jacobian]).map(nodes)
    motion = np.hstack([base, np.tile(joints, (nodes, 1))])
    for _ in range(KINEMATIC_STEPS):
        where, slopes = (np.asarray(part) for part in function(motion.T))
        J = slopes.reshape((-1, nodes, joints.size)).transpose(1, 0, 2)
        normal = J.transpose(0, 2, 1) @ J + DAMPING**2 * np.eye(joints.size)
        step = np.linalg.solve(normal, J.transpose(0, 2, 1) @ (feet - where.T)[:, :, None])
        motion[:, 6:] += step[:, :, 0]
    return motion


def standing(problem: GaitProblem, layout: Layout) -> Vector:
    """Return unscaled variables of a robot that stands in its posture while time passes, (n_x,)."""
    guess = np.zeros(layout.size)
    pose = problem.posture.coordinates(problem.pattern.robot)
    durations = middle_durations(problem)
    for domain in layout.domains:
        _fill(problem, domain, guess, durations[domain.stance.name], np.tile(pose, (domain.nodes, 1)))
    guess[layout.period] = sum(durations[domain.stance.name] for domain in layout.domains)
    return guess


def _fill(problem: GaitProblem, domain: DomainLayout, guess: Vector, T: float, motion: NodeValues) -> None:
    """Write a domain's variables: curves through the motion, and efforts of its statics."""
    rates = np.gradient(motion, domain.phases, axis=0, edge_order=2)
    curves = fit(motion, rates, domain.phases, problem.outputs.order)
    q, slope, curvature = evaluate(curves, domain.phases)
    guess[domain.duration] = T
    guess[domain.coefficients] = curves[output_indices(problem, domain)].ravel(order="F")
    guess[domain.q], guess[domain.v], guess[domain.a] = q, slope / T, curvature / T**2
    guess[domain.u], guess[domain.force] = _efforts(problem, domain, guess)


def _efforts(problem: GaitProblem, domain: DomainLayout, guess: Vector) -> tuple[NodeValues, NodeValues]:
    """Vertical forces that share the weight, and the joint torques that move the joints against them."""
    robot, feet = problem.pattern.robot, domain.stance.feet
    share = robot.mass * robot.gravity / max(len(feet), 1)
    force = np.tile([0.0, 0.0, share], len(feet))
    symbols: Mapping[str, ca.SX] = {letter: ca.SX.sym(letter, robot.size) for letter in "qva"}
    load = dynamics.inverse_dynamics(robot, *symbols.values()) - stance_jacobian(robot, feet, symbols["q"]).T @ force
    function = ca.Function("efforts", list(symbols.values()), [load[robot.size - len(robot.joints) :]])
    torque = np.asarray(function.map(domain.nodes)(*(guess[getattr(domain, letter)].T for letter in "qva"))).T
    return torque, np.tile(force, (domain.nodes, 1))
