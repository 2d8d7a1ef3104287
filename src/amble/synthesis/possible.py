"""What no gait of a problem can do is said before a solver spends minutes on it."""

from __future__ import annotations

import logging

import numpy as np

from amble.errors import InputError, listed, printable
from amble.robot.kinematics import foot_position
from amble.robot.plausibility import doubts
from amble.synthesis.problem import GaitProblem

logger = logging.getLogger("amble")

OFF_GROUND = 0.25
"""Distance of a foot from the ground at the posture, as a share of the leg length, from which no solver starts."""


def require_possible(problem: GaitProblem) -> None:
    """Refuse a problem that cannot have a solution or a start; log what is odd about its robot and posture.

    Raises:
        InputError: the base must keep higher than legs are long, feet are far off the ground at the posture, or the
            legs cannot move the feet of a stance against each other.
    """
    robot, limits = problem.pattern.robot, problem.limits
    lowest = limits.positions.get("z", (-np.inf, np.inf))[0]
    if lowest - float(problem.pattern.ground.height(0.0, 0.0)) > robot.leg_length:
        raise InputError(
            f"the base must keep above {lowest:g} m (limits of z), but no leg of robot '{robot.name}' is longer than "
            f"{robot.leg_length:.3g} m"
        )
    _require_feet_near_ground(problem)
    _require_free_legs(problem)
    for doubt in (*doubts(robot), *_outside(problem)):
        logger.warning("%s", printable(doubt))


def _require_feet_near_ground(problem: GaitProblem) -> None:
    robot, ground = problem.pattern.robot, problem.pattern.ground
    q = problem.posture.coordinates(robot)
    places = [np.asarray(foot_position(robot, foot, q)).ravel() for foot in robot.foot_names]
    base = float(ground.height(0.0, 0.0))
    heights = {
        foot: float(place[2] + base - ground.height(place[0], place[1]))
        for foot, place in zip(robot.foot_names, places, strict=True)
    }
    foot = max(heights, key=lambda name: abs(heights[name]))
    if abs(heights[foot]) > OFF_GROUND * robot.leg_length:
        fitting = problem.posture.height - float(np.median(list(heights.values())))
        raise InputError(
            f"at the posture foot '{foot}' is {heights[foot]:.3g} m above the ground; with these angles the height of "
            f"the posture would be about {fitting:.3g} m"
        )


def _require_free_legs(problem: GaitProblem) -> None:
    """Refuse a stance in which contacts depend on each other: no torque determines the forces along such directions."""
    pattern = problem.pattern
    q = problem.posture.coordinates(pattern.robot)
    for stance in pattern.solved:
        tied = pattern.contacts(stance).dependent(tuple(map(float, q)))
        if tied:
            raise InputError(
                f"robot '{pattern.robot.name}' cannot stand on {', '.join(stance.feet)} (stance '{stance.name}'): its "
                f"legs have no joints that move these feet against each other, so that {listed(tied)} "
                "depend on each other and no torque determines the forces there; choose a gait on other feet"
            )


def _outside(problem: GaitProblem) -> list[str]:
    """What of the posture lies outside its bounds: the solver starts inside them."""
    robot, found = problem.pattern.robot, []
    q = problem.posture.coordinates(robot)
    for name, (low, high) in problem.limits.positions.items():
        value = float(q[robot.coordinate_index(name)])
        if not low <= value <= high:
            found.append(f"the posture has {name} at {value:.4g}, outside {low:.4g} to {high:.4g}; it is moved inside")
    return found
