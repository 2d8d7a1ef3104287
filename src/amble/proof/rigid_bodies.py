"""The motion of a robot by the decimal numbers of its record, at a point, in balls.

This shares nothing with the expressions of ``amble.robot``: motion and wrenches of all links are in the world's axes,
moments about the world's origin, no inertial parameters are regrouped and no frames moved, and every number of the
record is the decimal number that a gait file holds of it, not the double next to it.

Source: Newton's and Euler's equations, link by link (Featherstone, Rigid Body Dynamics Algorithms, 2008, section 5.3).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import arb, arb_mat

from amble.proof.arithmetic import column, identity
from amble.robot import Robot
from amble.robot.base import SPATIAL
from amble.robot.parts import Joint
from amble.types import Matrix

Column: TypeAlias = arb_mat
"""Three balls."""
AXES = [column([arb(int(i == k)) for i in range(3)]) for k in range(3)]


@dataclass(frozen=True, kw_only=True)
class Moving:
    """A link in the world's axes.

    Attributes:
        rotation: orientation.
        origin: of its frame, m.
        spin: angular velocity, rad/s.
        turning: angular acceleration, rad/s^2.
        velocity: of the origin, m/s.
        acceleration: of the origin, m/s^2.
    """

    rotation: arb_mat
    origin: Column
    spin: Column
    turning: Column
    velocity: Column
    acceleration: Column

    def point(self, offset: Column) -> tuple[Column, Column, Column]:
        """Return place, velocity and acceleration of a point of the link, given in its frame."""
        arm = self.rotation * offset
        swept = cross(self.spin, arm)
        return (
            self.origin + arm,
            self.velocity + swept,
            self.acceleration + cross(self.turning, arm) + cross(self.spin, swept),
        )

    def turned(self, axis: Column, angle: arb, rate: arb, change: arb) -> Moving:
        """Return what a revolute joint at the origin moves, its axis given in this frame."""
        along = self.rotation * axis
        return Moving(
            rotation=self.rotation * rotation_about(axis, angle),
            origin=self.origin,
            spin=self.spin + along * rate,
            turning=self.turning + along * change + cross(self.spin, along) * rate,
            velocity=self.velocity,
            acceleration=self.acceleration,
        )

    def slid(self, axis: Column, place: arb, rate: arb, change: arb) -> Moving:
        """Return what a prismatic joint at the origin moves, its axis given in this frame: it turns as this does."""
        along = self.rotation * axis
        crossing = cross(self.spin, along)
        _, velocity, acceleration = self.point(axis * place)
        return Moving(
            rotation=self.rotation,
            origin=self.origin + along * place,
            spin=self.spin,
            turning=self.turning,
            velocity=velocity + along * rate,
            acceleration=acceleration + along * change + crossing * (2 * rate),
        )


@dataclass(frozen=True, kw_only=True)
class Motion:
    """All links, and the axes about or along which coordinates move them.

    Attributes:
        links: of the robot, in order.
        axes: of roll, pitch, yaw and the joints, in the world.
    """

    links: list[Moving]
    axes: list[Column]


def motion(robot: Robot, q: Sequence[arb], v: Sequence[arb], a: Sequence[arb]) -> Motion:
    """Return how all links move; arguments are spatial coordinates (``Base.spatial``) and their derivatives."""
    base = Moving(
        rotation=identity(3),
        origin=column(q[:3]),
        spin=column([arb(0)] * 3),
        turning=column([arb(0)] * 3),
        velocity=column(v[:3]),
        acceleration=column(a[:3]),
    )
    axes = []
    for place, axis in enumerate(AXES, start=3):
        axes.append(base.rotation * axis)
        base = base.turned(axis, q[place], v[place], a[place])
    links, turned = [base] * len(robot.links), dict[int, Column]()
    for number in robot.ordered_joints:
        joint, place = robot.joints[number], SPATIAL + number
        there, axis = _hinge(links[joint.parent], joint), vector(joint.axis)
        turned[number] = there.rotation * axis
        moved = there.slid if joint.prismatic else there.turned
        links[joint.child] = moved(axis, q[place], v[place], a[place])
    return Motion(links=links, axes=[*axes, *(turned[number] for number in range(len(robot.joints)))])


def _hinge(parent: Moving, joint: Joint) -> Moving:
    """Return the frame of a joint at zero, as the parent link moves it."""
    place, velocity, acceleration = parent.point(vector(joint.translation))
    return Moving(
        rotation=parent.rotation * matrix(joint.rotation),
        origin=place,
        spin=parent.spin,
        turning=parent.turning,
        velocity=velocity,
        acceleration=acceleration,
    )


def needed_forces(
    robot: Robot, moving: Motion, pushes: Mapping[int, Iterable[tuple[Column, Column]]], gravity: arb
) -> list[arb]:
    """Return the generalised forces that a motion needs beside forces on links; drives of the joints are left out.

    Args:
        robot: the robot.
        moving: the motion.
        pushes: link -> place and force of each, N.
        gravity: m/s^2.

    Returns:
        One a spatial coordinate, N or N m.
    """
    forces, moments = [], []
    for number, (link, here) in enumerate(zip(robot.links, moving.links, strict=True)):
        place, _, acceleration = here.point(vector(link.center))
        inertia = here.rotation * matrix(link.inertia) * here.rotation.transpose()
        force = (acceleration + AXES[2] * gravity) * decimal(link.mass)
        moment = inertia * here.turning + cross(here.spin, inertia * here.spin) + cross(place, force)
        for at, push in pushes.get(number, ()):
            force, moment = force - push, moment - cross(at, push)
        forces.append(force)
        moments.append(moment)
    for number in reversed(robot.ordered_joints):
        joint = robot.joints[number]
        forces[joint.parent] = forces[joint.parent] + forces[joint.child]
        moments[joint.parent] = moments[joint.parent] + moments[joint.child]
    moved = [(0, False)] * 3 + [(joint.child, joint.prismatic) for joint in robot.joints]
    along = [
        dot(axis, forces[link] if slides else moments[link] - cross(moving.links[link].origin, forces[link]))
        for axis, (link, slides) in zip(moving.axes, moved, strict=True)
    ]
    return [*forces[0].entries(), *along]


def drive(joint: Joint, rate: arb, change: arb) -> arb:
    """Return the torque that rotor, damping and dry friction of a joint take, N m, or the force, N."""
    taken = decimal(joint.rotor_inertia) * change + decimal(joint.damping) * rate
    if joint.dry_friction:
        taken += decimal(joint.dry_friction) * (rate / decimal(joint.friction_width)).tanh()
    return taken


def rotation_about(axis: Column, angle: arb) -> arb_mat:
    """Return the rotation matrix about a unit vector, (3, 3)."""
    outer, (x, y, z) = axis * axis.transpose(), axis.entries()
    crossing = arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return outer + (identity(3) - outer) * angle.cos() + crossing * angle.sin()


def cross(a: Column, b: Column) -> Column:
    """Return a x b."""
    (p, q, r), (x, y, z) = a.entries(), b.entries()
    return column([q * z - r * y, r * x - p * z, p * y - q * x])


def dot(a: Column, b: Column) -> arb:
    """Return the inner product."""
    return sum((x * y for x, y in zip(a.entries(), b.entries(), strict=True)), start=arb(0))


def decimal(value: float) -> arb:
    """Return a ball that holds the shortest decimal number that names a double: what files have of it."""
    return arb(repr(float(value)))


def vector(values: Matrix) -> Column:
    """Return three numbers of a record."""
    return column([decimal(value) for value in values])


def matrix(values: Matrix) -> arb_mat:
    """Return a matrix of numbers of a record."""
    rows, columns = values.shape
    return arb_mat(rows, columns, [decimal(value) for value in values.reshape(-1)])
