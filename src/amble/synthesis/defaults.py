"""The gait problem of a robot, with bounds and posture that fit it where nothing is said."""

from __future__ import annotations

from math import isfinite, sqrt

from amble.control import AllocationLaw, Outputs, PseudoInverse, joint_outputs
from amble.errors import InputError
from amble.gait import Limits
from amble.gait.cost import TORQUE_SQUARED, Cost
from amble.gait.limits import SLOWEST_LANDING, Interval
from amble.hybrid import FLAT, POINT, GaitPattern, Ground
from amble.hybrid.gaits import GAITS
from amble.robot import Robot, catalogue
from amble.robot.catalogue import GaitBounds, Posture
from amble.robot.proposal import nominal_posture
from amble.synthesis.problem import GaitProblem
from amble.synthesis.symmetric import on_symmetric


def gait_problem(
    robot: Robot,
    gait: str | GaitPattern,
    *,
    speed: float,
    ground: Ground | None = None,
    outputs: Outputs | None = None,
    law: AllocationLaw | None = None,
    limits: Limits | None = None,
    posture: Posture | None = None,
    intervals: int = 15,
    cost: Cost = TORQUE_SQUARED,
) -> GaitProblem:
    """Pose the gait problem of a robot.

    Args:
        robot: the robot.
        gait: the name of a gait (amble, trot, or one that was registered) or a pattern of stances of the robot.
        speed: mean forward velocity, m/s.
        ground: what a gait given by name walks on; level, with a friction of 0.6, by default. A pattern has its own.
        outputs: the controlled coordinates; by default those of ``joint_outputs``.
        law: the allocation law; by default the pseudo-inverse.
        limits: the bounds; by default those of ``default_limits``.
        posture: where the solver starts; by default that of the catalogue, else ``standing_posture``.
        intervals: collocation intervals in every domain.
        cost: what is minimised; by default the squared torques.

    Raises:
        UnknownNameError: there is no gait of that name, or it names feet that the robot does not have.
        InputError: the pattern is of another robot, the robot is less symmetric than a gait given by name can mend
            (see ``amble.symmetrized``; up to 5 % are averaged with a notice), or no posture is known by default.
    """
    pattern = _pattern(robot, gait, ground)
    stands = posture or nominal_posture(pattern.robot)
    return GaitProblem(
        pattern=pattern,
        outputs=joint_outputs(pattern, posture=stands) if outputs is None else outputs,
        law=law or PseudoInverse(),
        speed=speed,
        limits=default_limits(pattern, stands) if limits is None else limits,
        posture=stands,
        intervals=intervals,
        cost=cost,
        node_margins=not catalogue.holds(pattern.robot),
    )


def default_limits(pattern: GaitPattern, posture: Posture | None = None) -> Limits:
    """Return limits that fit a robot, to change by ``dataclasses.replace``.

    For a robot of the catalogue they are its builders' own, with 5 N of normal force and 20 mm of clearance. For any
    other, joint limits come from its description, and the rest follows from size and weight, with l the leg length, m
    the mass and g gravity: durations from 0.05 to 0.75 sqrt(l / g), accelerations up to 9 g / l, a touchdown slower
    than 0.15 sqrt(g l) forward, 0.05 sideways and 1 downward, there faster than 0.02, normal forces from 2.4 % of m g,
    swing feet above 2.5 % of l.

    Args:
        pattern: the gait pattern, with the robot.
        posture: how the robot stands; by default as in ``gait_problem``.
    """
    robot = pattern.robot
    if catalogue.holds(robot):
        bounds, normal_force, clearance = catalogue.bounds(robot.name), 5.0, 0.02
        torques = dict.fromkeys(robot.joint_names, bounds.torque)
        speeds = dict.fromkeys(robot.joint_names, bounds.speed)
    else:
        bounds = _scaled(robot, posture or nominal_posture(robot))
        normal_force, clearance = 0.024 * robot.mass * robot.gravity, 0.025 * robot.leg_length
        torques = {joint.name: joint.effort for joint in robot.joints if isfinite(joint.effort)}
        speeds = {joint.name: joint.velocity for joint in robot.joints if isfinite(joint.velocity)}
    return Limits(
        durations={stance.name: bounds.duration for stance in pattern.solved},
        positions=bounds.positions,
        speeds=speeds,
        torques=torques,
        acceleration=bounds.acceleration,
        touchdown_velocity=bounds.touchdown_velocity,
        normal_force=normal_force,
        clearance=clearance,
    )


def _pattern(robot: Robot, gait: str | GaitPattern, ground: Ground | None) -> GaitPattern:
    if isinstance(gait, GaitPattern):
        if ground is not None and ground != gait.ground:
            raise InputError(f"the gait pattern '{gait.name}' has a ground of its own; give it another one there")
        if gait.robot != robot:
            raise InputError(f"the gait pattern '{gait.name}' is of robot '{gait.robot.name}', not of this one")
        return gait
    return on_symmetric(robot, lambda walker: GAITS[gait](walker, ground or FLAT, POINT))


def _scaled(robot: Robot, posture: Posture) -> GaitBounds:
    """Bounds by dimension: times in sqrt(l / g), velocities in sqrt(g l); ASTRo's own are of this size."""
    # shorthand
    length, g, z = robot.leg_length, robot.gravity, posture.height
    time, velocity = sqrt(length / g), sqrt(g * length)

    def within(lower: float, upper: float, size: float) -> Interval:
        return (lower * size, upper * size)

    return GaitBounds(
        duration=within(0.05, 0.75, time),
        torque=float("inf"),
        speed=float("inf"),
        acceleration=9.0 * g / length,
        positions={
            "z": within(0.6, 1.4, z),
            "roll": (-0.2, 0.2),
            "pitch": (-0.2, 0.2),
            "yaw": (-0.3, 0.3),
            **{joint.name: (joint.lower, joint.upper) for joint in robot.joints},
        },
        touchdown_velocity=(
            within(-0.15, 0.15, velocity),
            within(-0.05, 0.05, velocity),
            within(-1.0, -SLOWEST_LANDING, velocity),
        ),
    )
