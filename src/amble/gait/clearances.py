"""How far knees and base keep from the ground and legs from each other, and what a motor gives at its speed."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import casadi as ca

from amble.errors import InputError
from amble.hybrid.ground import Ground
from amble.robot import Robot, kinematics

LARGEST = 1e6
"""Of a length, m."""


@dataclass(frozen=True, kw_only=True)
class Clearances:
    """Least distances, m; what is None is not asked for.

    Attributes:
        knees: of the joints of all legs from the ground, along its normal, but for those that hang on the base.
        corners: of the four lower corners of ``box`` from the ground.
        box: lengths along x, y and z of a box on the base, its middle the base's origin.
        legs: of a left foot from its right twin along the base's y axis, and of their joints that do not hang on the
            base; left stays left.

    Raises:
        InputError: a length is no finite number above 0, or there are corners without a box or a box without.
    """

    knees: float | None = None
    corners: float | None = None
    box: tuple[float, float, float] | None = None
    legs: float | None = None

    def __post_init__(self) -> None:
        """Refuse what is no length."""
        sizes = {"knees": self.knees, "corners": self.corners, "legs": self.legs}
        sizes |= {f"box along {axis}": size for axis, size in zip("xyz", self.box or (), strict=self.box is not None)}
        for what, size in sizes.items():
            if size is not None and not 0.0 < size < LARGEST:
                raise InputError(f"the clearance '{what}' is {size} m; it must be a positive length")
        if (self.corners is None) != (self.box is None):
            raise InputError("clearances of the base need both 'corners', a height, and 'box', the lengths of its box")


@dataclass(frozen=True, kw_only=True)
class Motor:
    """The line of a motor's largest torque over its speed: |torque / stall_torque + speed / no_load_speed| <= 1.

    A motor on a supply of one voltage gives its stall torque at rest and none at its no-load speed; while it brakes it
    gives more. Limits of torque (its current) and speed hold beside this one.

    Attributes:
        stall_torque: at the joint, N m.
        no_load_speed: of the joint, rad/s.

    Raises:
        InputError: one of them is not positive.
    """

    stall_torque: float
    no_load_speed: float

    def __post_init__(self) -> None:
        """Refuse what is no motor."""
        for what, value in (("stall torque", self.stall_torque), ("no-load speed", self.no_load_speed)):
            if not 0.0 < value < inf:
                raise InputError(f"the {what} of a motor is {value}; it must be finite and positive")

    def used(self, torque: ca.SX, speed: ca.SX) -> ca.SX:
        """Return torque / stall_torque + speed / no_load_speed, between -1 and 1 where the motor can do it."""
        return torque / self.stall_torque + speed / self.no_load_speed


def check_clearances(robot: Robot, clearances: Clearances | None) -> None:
    """Refuse clearances that a robot cannot have.

    Raises:
        InputError: legs are to stay apart, and the robot has no twins or moves in a plane.
    """
    if clearances is None or clearances.legs is None:
        return
    if not robot.base.in_space:
        raise InputError(f"'{robot.name}' moves in a plane, where legs pass each other: no clearance 'legs'")
    if not robot.twins:
        raise InputError(f"clearance 'legs' is that of left from right twins, and '{robot.name}' has none: give twins")


def heights(robot: Robot, ground: Ground, clearances: Clearances, q: ca.SX) -> dict[str, tuple[ca.SX, float]]:
    """Write the distances of knees and base corners from the ground: name -> distance and its least value, m.

    Args:
        robot: the robot.
        ground: the ground.
        clearances: what is asked for.
        q: coordinates, (n_q,).
    """
    s = robot.base.spatial(q)
    rotation, found = kinematics.base_rotation(s), dict[str, tuple[ca.SX, float]]()
    if clearances.knees is not None:
        poses = kinematics.link_poses(robot, s)
        for joint in hanging(robot, robot.foot_names):
            origin = poses[robot.joints[robot.joint_index(joint)].child][1]
            found[f"height of joint {joint}"] = ground.gap(s[:3] + rotation @ origin), clearances.knees
    if clearances.corners is not None and clearances.box is not None:
        long, wide, high = (0.5 * size for size in clearances.box)
        signs = ((1, 1), (1, -1), (-1, 1), (-1, -1)) if robot.base.in_space else ((1, 0), (-1, 0))
        for place, (ahead, aside) in zip(CORNERS if robot.base.in_space else PLANAR_CORNERS, signs, strict=True):
            corner = s[:3] + rotation @ ca.DM([ahead * long, aside * wide, -high])
            found[f"height of base corner {place}"] = ground.gap(corner), clearances.corners
    return found


CORNERS = ("front left", "front right", "rear left", "rear right")
PLANAR_CORNERS = ("front", "rear")


def gaps_between_legs(robot: Robot, clearances: Clearances, q: ca.SX) -> dict[str, tuple[ca.SX, float]]:
    """Write how far left parts are to the left of their right twins: name -> distance and its least value, m."""
    if clearances.legs is None:
        return {}
    s, found = robot.base.spatial(q), dict[str, tuple[ca.SX, float]]()
    poses = kinematics.link_poses(robot, s)
    for left, right in robot.twins:
        feet = [robot.foot(name) for name in (left, right)]
        ends = [poses[foot.link][1] + poses[foot.link][0] @ ca.DM(foot.offset) for foot in feet]
        found[f"{left} left of {right}"] = ends[0][1] - ends[1][1], clearances.legs
        for one, other in zip(hanging(robot, [left]), hanging(robot, [right]), strict=False):
            origins = [poses[robot.joints[robot.joint_index(joint)].child][1] for joint in (one, other)]
            found[f"{one} left of {other}"] = origins[0][1] - origins[1][1], clearances.legs
    return found


def hanging(robot: Robot, feet: tuple[str, ...] | list[str]) -> tuple[str, ...]:
    """Return the joints of legs that do not hang on the base, each once, from the base to the feet."""
    known = dict.fromkeys(joint for foot in feet for joint in robot.legs[foot])
    return tuple(joint for joint in known if robot.joints[robot.joint_index(joint)].parent != 0)
