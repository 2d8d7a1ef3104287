"""The bounds of a gait in its file, without those of the ground."""

from __future__ import annotations

from amble.gait.clearances import Clearances, Motor
from amble.gait.limits import Limits
from amble.hybrid import GaitPattern
from amble.hybrid.contact import AXES
from amble.io.codec import ByName, Optional, Record
from amble.io.quantities import Array, Interval, Number
from amble.robot import Robot
from amble.robot.coordinate_units import load_unit, unit_of
from amble.types import Json

CLEARANCES = Record(
    lambda box, **lengths: Clearances(box=None if box is None else (box[0], box[1], box[2]), **lengths),
    {"knees": Optional(Number("m")), "corners": Optional(Number("m")), "box": Optional(Array("m", 3)),
     "legs": Optional(Number("m"))},
)  # fmt: skip


def _motor(robot: Robot, joint: str) -> Record:
    load, speed = load_unit(robot, joint), unit_of(robot, joint, "/s")
    return Record(Motor, {"stall_torque": Number(load), "no_load_speed": Number(speed)})


def limits_codec(pattern: GaitPattern) -> Record:
    """Describe the bounds, without those of the ground."""
    robot = pattern.robot
    joint_speeds = {name: Number(unit_of(robot, name, "/s"), infinite=True) for name in robot.joint_names}
    torques = {name: Number(load_unit(robot, name), infinite=True) for name in robot.joint_names}
    positions = {name: Interval(unit_of(robot, name), infinite=True) for name in robot.coordinate_names}
    durations = {stance.name: Interval("s", infinite=True) for stance in pattern.solved}
    landing = dict.fromkeys(AXES, Interval("m/s", infinite=True))
    return Record(
        lambda motors, **bounds: Limits(motors=motors or {}, **bounds),
        {
            "durations": ByName("domain", durations),
            "positions": ByName("coordinate", positions),
            "speeds": ByName("joint", joint_speeds),
            "torques": ByName("joint", torques),
            "acceleration": Number("m/s^2, rad/s^2", infinite=True),
            "touchdown_velocity": Record(lambda **along: tuple(along[axis] for axis in AXES), landing, _along_axes),
            "normal_force": Number("N", infinite=True),
            "clearance": Number("m", infinite=True),
            "standing_force": Optional(Number("N", infinite=True)),
            "clearances": Optional(CLEARANCES),
            "motors": Optional(ByName("joint", {name: _motor(robot, name) for name in robot.joint_names})),
        },
        take=lambda limits: {**vars(limits), "motors": limits.motors or None},
    )


def _along_axes(intervals: tuple[tuple[float, float], ...]) -> Json:
    return dict(zip(AXES, intervals, strict=True))
