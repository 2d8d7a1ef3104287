"""Where the solver starts: the robot stands in its posture while time passes."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.hybrid import stance_jacobian
from amble.robot import dynamics
from amble.synthesis.layout import DomainLayout, Layout
from amble.synthesis.node_block import output_indices
from amble.synthesis.problem import GaitProblem


def standing(problem: GaitProblem, layout: Layout) -> NDArray[np.float64]:
    """Return unscaled variables of a robot that stands, its weight shared by the stance feet, (n_x,)."""
    robot = problem.pattern.robot
    guess = np.zeros(layout.size)
    pose = problem.posture.coordinates(robot)
    for domain in layout.domains:
        low, high = problem.limits.durations[domain.stance.name]
        guess[domain.duration] = 0.5 * (low + high)
        guess[domain.q] = pose
        controlled = pose[output_indices(problem, domain)]
        guess[domain.coefficients] = np.tile(controlled, problem.outputs.order + 1)
        torques, forces = _statics(problem, domain, pose)
        guess[domain.u], guess[domain.force] = torques, forces
    guess[layout.period] = sum(guess[domain.duration].sum() for domain in layout.domains)
    return guess


def _statics(
    problem: GaitProblem, domain: DomainLayout, pose: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Vertical forces that share the weight, and the joint torques that go with them."""
    robot, feet = problem.pattern.robot, domain.stance.feet
    q = ca.SX.sym("q", robot.size)
    rest = ca.SX.zeros(robot.size)
    function = ca.Function("statics", [q], [dynamics.bias(robot, q, rest), stance_jacobian(robot, feet, q)])
    gravity, jacobian = (np.array(part) for part in function(pose))
    forces = np.tile([0.0, 0.0, robot.mass * robot.gravity / max(len(feet), 1)], len(feet))
    balance = gravity.ravel() - jacobian.T @ forces
    return balance[robot.size - len(robot.joints) :], forces
