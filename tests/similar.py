"""The same gait for a robot of another size: every number scaled by its dimension, gravity kept.

Lengths scale by ``length``, masses by ``mass`` and time by sqrt(length); the two motions are one in units of leg
length, weight and sqrt(l / g), so whatever is said of one must hold of the other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amble.gait import DomainTrajectory, Feedback, Gait, Limits
from amble.robot import Joint, Robot
from amble.robot.coordinate_units import is_length
from amble.types import frozen


def similar_robot(robot: Robot, mass: float, length: float) -> Robot:
    """Scale a robot."""
    return replace(
        robot,
        links=tuple(
            replace(
                link,
                mass=mass * link.mass,
                center=frozen(length * link.center),
                inertia=frozen(mass * length**2 * link.inertia),
            )
            for link in robot.links
        ),
        joints=tuple(_joint(joint, mass, length) for joint in robot.joints),
        feet=tuple(replace(foot, offset=frozen(length * foot.offset)) for foot in robot.feet),
    )


def _joint(joint: Joint, mass: float, length: float) -> Joint:
    unit = length if joint.prismatic else 1.0
    torque, time = mass * length / unit, np.sqrt(length)
    return replace(
        joint,
        translation=frozen(length * joint.translation),
        lower=unit * joint.lower,
        upper=unit * joint.upper,
        effort=torque * joint.effort,
        velocity=unit / time * joint.velocity,
        rotor_inertia=torque * time**2 / unit * joint.rotor_inertia,
        damping=torque * time / unit * joint.damping,
        dry_friction=torque * joint.dry_friction,
        friction_width=unit / time * joint.friction_width,
    )


def similar(gait: Gait, mass: float, length: float) -> Gait:
    """Scale a gait with its robot, limits and feedback."""
    time, force = float(np.sqrt(length)), mass
    robot = similar_robot(gait.robot, mass, length)
    unit = np.where([is_length(robot, name) for name in robot.coordinate_names], length, 1.0)
    joints = unit[robot.base.size :]

    def trajectory(part: DomainTrajectory) -> DomainTrajectory:
        return replace(
            part,
            duration=time * part.duration,
            times=frozen(time * part.times),
            positions=frozen(unit * part.positions),
            velocities=frozen(unit / time * part.velocities),
            accelerations=frozen(unit / time**2 * part.accelerations),
            torques=frozen(force * length / joints * part.torques),
            forces=frozen(force * part.forces),
            impulse=frozen(force * time * part.impulse),
        )

    def feedback(part: Feedback) -> Feedback:
        return replace(
            part,
            durations={name: time * value for name, value in part.durations.items()},
            start=frozen(np.concatenate([unit, unit / time]) * part.start),
        )

    return replace(
        gait,
        pattern=replace(gait.pattern, robot=robot),
        speed=length / time * gait.speed,
        gains=(gait.gains[0] / time**2, gait.gains[1] / time),
        limits=_limits(gait.limits, robot, mass, length),
        domains=tuple(trajectory(part) for part in gait.domains),
        solver=replace(gait.solver, objective=(force * length) ** 2 * gait.solver.objective),
        feedback=None if gait.feedback is None else feedback(gait.feedback),
        multipliers=None,
    )


def _limits(limits: Limits, robot: Robot, mass: float, length: float) -> Limits:
    time = np.sqrt(length)

    def unit(name: str) -> float:
        return length if is_length(robot, name) else 1.0

    def scaled(pair: tuple[float, float], by: float) -> tuple[float, float]:
        return (float(by * pair[0]), float(by * pair[1]))

    x, y, z = (scaled(pair, length / time) for pair in limits.touchdown_velocity)
    return replace(
        limits,
        durations={name: scaled(pair, time) for name, pair in limits.durations.items()},
        positions={name: scaled(pair, unit(name)) for name, pair in limits.positions.items()},
        speeds={name: unit(name) * value / time for name, value in limits.speeds.items()},
        torques={name: mass * length / unit(name) * value for name, value in limits.torques.items()},
        acceleration=limits.acceleration / length,
        touchdown_velocity=(x, y, z),
        normal_force=mass * limits.normal_force,
        clearance=length * limits.clearance,
    )
