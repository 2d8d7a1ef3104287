"""A gait problem for a robot of the catalogue, with its builders' bounds."""

from __future__ import annotations

from amble.control import AllocationLaw, Outputs, PseudoInverse
from amble.errors import InputError
from amble.gait import Limits
from amble.gait.limits import Interval
from amble.hybrid import GaitPattern
from amble.robot import catalogue
from amble.synthesis.problem import GaitProblem


def gait_problem(
    pattern: GaitPattern,
    outputs: Outputs,
    speed: float,
    law: AllocationLaw | None = None,
    duration: Interval = (0.01, 0.2),
    normal_force: float = 5.0,
    clearance: float = 0.02,
    intervals: int = 15,
) -> GaitProblem:
    """Pose the gait problem of a robot of the catalogue.

    Args:
        pattern: the gait pattern, with the ground and its friction.
        outputs: the controlled coordinates.
        speed: mean forward velocity, m/s.
        law: the allocation law; by default the pseudo-inverse.
        duration: bounds of the duration of every domain, s.
        normal_force: smallest normal force of a stance foot, N.
        clearance: height of a swing foot above the ground at the middle of its swing, m.
        intervals: collocation intervals in every domain.

    Raises:
        InputError: the robot is not of the catalogue; give ``GaitProblem`` its ``Limits`` and ``Posture`` then.
    """
    robot = pattern.robot
    if robot.name not in catalogue.names() or robot != catalogue.load(robot.name):
        raise InputError(
            f"robot '{robot.name}' is not of the catalogue ({', '.join(catalogue.names())}): "
            "build a GaitProblem with its Limits and Posture"
        )
    bounds = catalogue.bounds(robot.name)
    limits = Limits(
        durations={stance.name: duration for stance in pattern.solved},
        positions=bounds.positions,
        speeds=dict.fromkeys(robot.joint_names, bounds.speed),
        torques=dict.fromkeys(robot.joint_names, bounds.torque),
        acceleration=bounds.acceleration,
        touchdown_velocity=bounds.touchdown_velocity,
        normal_force=normal_force,
        clearance=clearance,
    )
    posture = catalogue.posture(robot.name)
    return GaitProblem(
        pattern=pattern,
        outputs=outputs,
        law=law or PseudoInverse(),
        speed=speed,
        limits=limits,
        posture=posture,
        intervals=intervals,
    )
