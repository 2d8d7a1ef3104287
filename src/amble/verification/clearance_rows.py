"""Clearances and motors of a domain, from frames that are multiplied out along the tree in numpy."""

from __future__ import annotations

import numpy as np

from amble.gait.clearances import CORNERS, PLANAR_CORNERS, hanging
from amble.residual import Residual
from amble.robot import Robot
from amble.types import Matrix, NodeValues, Vector
from amble.verification.domain_rows import SampledDomain
from amble.verification.residuals import limit, sizes


def clearance_residuals(domain: SampledDomain, slack: float) -> list[Residual]:
    """Return the rows of what the limits of the gait ask for; nothing by default.

    Args:
        domain: the domain on its grid.
        slack: what a limit may miss, as a share of the leg length, or of the motor's line.
    """
    robot, asked, times = domain.gait.robot, domain.gait.limits.clearances, domain.times
    length, found = sizes(robot).length, list[Residual]()
    if asked is not None:
        frames = Frames.of(robot, domain.positions)
        values = {f"height of joint {j}": (frames.height(domain, frames.origin(j)), asked.knees) for j in frames.knees}
        if asked.box is not None:
            values |= {
                f"height of base corner {name}": (frames.height(domain, corner), asked.corners)
                for name, corner in frames.corners(asked.box).items()
            }
        values |= {name: (gap, asked.legs) for name, gap in frames.apart().items()}
        for name, (distance, least) in values.items():
            if least is not None:
                row = f"{domain.name} {name}"
                found.append(limit("clearances", row, distance, times, (least, np.inf), slack * length))
    for joint, motor in domain.gait.limits.motors.items():
        place = robot.joint_index(joint)
        speed = domain.velocities[:, robot.base.size + place]
        used = domain.motion.torques[:, place] / motor.stall_torque + speed / motor.no_load_speed
        found.append(limit("motor", f"{domain.name} torque over speed {joint}", used, times, (-1.0, 1.0), slack))
    return found


class Frames:
    """Frames of all links in base axes along a motion, and of the base in the world."""

    def __init__(self, robot: Robot, spatial: Matrix) -> None:
        self._robot, self._q = robot, spatial
        points = len(spatial)
        self._base = _about(np.eye(3)[0], spatial[:, 3]) @ _about(np.eye(3)[1], spatial[:, 4])
        self._base = self._base @ _about(np.eye(3)[2], spatial[:, 5])
        self._rotations = [np.tile(np.eye(3), (points, 1, 1)) for _ in robot.links]
        self._origins = [np.zeros((points, 3)) for _ in robot.links]
        for j in robot.ordered_joints:
            joint = robot.joints[j]
            above, place = self._rotations[joint.parent], self._origins[joint.parent]
            moved, values = above @ joint.rotation, spatial[:, 6 + j]
            self._origins[joint.child] = place + above @ joint.translation
            if joint.prismatic:
                self._origins[joint.child] += (moved @ joint.axis) * values[:, None]
            else:
                moved = moved @ _about(joint.axis, values)
            self._rotations[joint.child] = moved

    @classmethod
    def of(cls, robot: Robot, positions: Matrix) -> Frames:
        """Take the coordinates of a robot, (points, n_q)."""
        return cls(robot, np.asarray(robot.base.spatial(positions)))

    @property
    def knees(self) -> tuple[str, ...]:
        """Joints of legs that do not hang on the base."""
        return hanging(self._robot, self._robot.foot_names)

    def origin(self, joint: str) -> NodeValues:
        """Origin of a joint in base axes, (points, 3)."""
        return self._origins[self._robot.joints[self._robot.joint_index(joint)].child]

    def height(self, domain: SampledDomain, place: NodeValues) -> Vector:
        """Distance of points in base axes from the ground, (points,)."""
        world = self._q[:, :3] + np.einsum("pij,pj->pi", self._base, np.broadcast_to(place, (len(self._q), 3)))
        return np.asarray(domain.contacts.ground.gap(world))

    def corners(self, box: tuple[float, float, float]) -> dict[str, NodeValues]:
        """Lower corners of a box about the base's origin."""
        x, y, z = (0.5 * size for size in box)
        if not self._robot.base.in_space:
            return dict(zip(PLANAR_CORNERS, np.array([[x, 0.0, -z], [-x, 0.0, -z]]), strict=True))
        return dict(zip(CORNERS, np.array([[x, y, -z], [x, -y, -z], [-x, y, -z], [-x, -y, -z]]), strict=True))

    def apart(self) -> dict[str, Vector]:
        """How far feet and joints are to the left of their right twins along the base's y axis."""
        found, robot = dict[str, Vector](), self._robot
        for left, right in robot.twins:
            ends = []
            for foot in (robot.foot(left), robot.foot(right)):
                ends.append((self._origins[foot.link] + self._rotations[foot.link] @ foot.offset)[:, 1])
            found[f"{left} left of {right}"] = ends[0] - ends[1]
            for one, other in zip(hanging(robot, [left]), hanging(robot, [right]), strict=False):
                found[f"{one} left of {other}"] = self.origin(one)[:, 1] - self.origin(other)[:, 1]
        return found


def _about(axis: Vector, angles: Vector) -> NodeValues:
    """Rotations about an axis by Rodrigues' formula, (points, 3, 3)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross)
