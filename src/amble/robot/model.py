"""The robot record: a floating base with a tree of joints and point feet, as numbers with names."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from amble.errors import UnknownNameError
from amble.names import LONGEST_FILE, check_name
from amble.robot.base import SPACE, Base, check_plane
from amble.robot.parts import DRIVE, Foot, Joint, Link, Payload
from amble.robot.validation import check_bodies, check_frames, check_names, check_numbers, check_tree
from amble.types import Json, Matrix, Vector, frozen

if TYPE_CHECKING:
    from collections.abc import Mapping

    from amble.robot.mirror import Mirror


@dataclass(frozen=True, eq=False, kw_only=True)
class Robot:
    """A floating-base robot with revolute and prismatic joints and point feet.

    Two robots are equal where their hash is: the content that matters to a motion, not the name or the file.

    Attributes:
        name: what the robot is called.
        source: catalogue name, or file name of the URDF.
        links: the base first; link i + 1 is the child of joint i.
        joints: actuated joints in file order.
        feet: point feet in the order in which the user gave them.
        gravity: m/s^2, along -z of the world.
        twins: pairs of feet that mirror each other left to right.
        symmetry_tolerance: largest relative asymmetry under which ``mirror`` accepts the robot.
        unused: a sentence for everything that its file says of the motion and that is not used.
        locked_joints: joints of the file that are held at an angle, rad, or a place, m; they are no joints here.
        payload: what is carried.
        base: how the base moves: in space, or in the plane of x and z.
    """

    name: str
    source: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    feet: tuple[Foot, ...]
    gravity: float
    twins: tuple[tuple[str, str], ...] = ()
    symmetry_tolerance: float = 1e-9
    unused: tuple[str, ...] = ()
    locked_joints: Mapping[str, float] = field(default_factory=dict)
    payload: Payload | None = None
    base: Base = SPACE

    def __post_init__(self) -> None:
        """Check everything that equations of motion take for granted but the mass matrix (``plausibility``).

        Raises:
            UnknownNameError: a twin is no foot.
            InputError: a name cannot be one, or occurs twice; the joints are no tree; a number is not one of a robot.
        """
        check_name("robot", self.name)
        check_name("robot's file", self.source, LONGEST_FILE)
        check_numbers(self.name, self.gravity, self.symmetry_tolerance)
        check_names(self.links, self.joints, self.feet, self.twins)
        check_tree(self.name, self.links, self.joints, self.feet)
        check_frames(self.joints)
        check_bodies(self.links)
        if not self.base.in_space:
            check_plane(self)

    def __eq__(self, other: object) -> bool:
        """Compare the content that matters."""
        return isinstance(other, Robot) and self.hash == other.hash

    def __hash__(self) -> int:
        """Hash the content that matters."""
        return hash(self.hash)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joint names in file order."""
        return tuple(joint.name for joint in self.joints)

    @property
    def foot_names(self) -> tuple[str, ...]:
        """The user's foot labels in the order given."""
        return tuple(foot.name for foot in self.feet)

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of the entries of q: x, y, z, roll, pitch, yaw (in the plane x, z, pitch), then the joints."""
        return (*self.base.coordinates, *self.joint_names)

    @property
    def size(self) -> int:
        """Number of coordinates n_q."""
        return self.base.size + len(self.joints)

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return float(sum(link.mass for link in self.links))

    @cached_property
    def leg_length(self) -> float:
        """Length of the longest leg, stretched joint by joint, m: what deviations of positions are measured by.

        Prismatic joints are at the end of their range that is further out, at zero where they have none.
        """
        reaches = [
            sum(_reach(self.joints[j]) for j in self.chain(foot.link)) + float(np.linalg.norm(foot.offset))
            for foot in self.feet
        ]
        return max(reaches, default=0.0)

    @cached_property
    def torque_arms(self) -> Vector:
        """Arms at which what acts on the joints counts as a torque: 1 of a torque, the leg length of a force, (n,).

        Squares, norms and means over joints of both kinds are those of torques, N m.
        """
        length = self.leg_length or 1.0  # a robot without feet
        return frozen([length if joint.prismatic else 1.0 for joint in self.joints])

    @cached_property
    def legs(self) -> Mapping[str, tuple[str, ...]]:
        """Foot label -> names of the joints between base and foot, base side first."""
        return {foot.name: tuple(self.joints[j].name for j in self.chain(foot.link)) for foot in self.feet}

    @cached_property
    def mirror(self) -> Mirror:
        """The left-right mirror.

        Raises:
            InputError: where feet have no twins or the robot is not symmetric.
        """
        from amble.robot.mirror import find_mirror

        return find_mirror(self)

    @cached_property
    def hash(self) -> str:
        """SHA-256 of kinematics, inertias, limits, feet, gravity and mirror; the same in every run."""
        return hashlib.sha256(json.dumps(_content(self), sort_keys=True).encode()).hexdigest()

    @cached_property
    def ordered_joints(self) -> tuple[int, ...]:
        """Joint indices, every joint after the one that moves its parent link."""
        below: dict[int, list[int]] = {}
        for j, joint in enumerate(self.joints):
            below.setdefault(joint.parent, []).append(j)
        order: list[int] = []
        layer = below.get(0, [])
        while layer:
            order += layer
            layer = sorted(j for above in layer for j in below.get(self.joints[above].child, ()))
        return tuple(order)

    def chain(self, link: int) -> tuple[int, ...]:
        """Return the indices of the joints between the base and a link, base side first."""
        joints: list[int] = []
        while link != 0:
            joints.append(link - 1)
            link = self.joints[link - 1].parent
        return tuple(reversed(joints))

    def foot(self, name: str) -> Foot:
        """Look a foot up by the user's label."""
        for candidate in self.feet:
            if candidate.name == name:
                return candidate
        raise UnknownNameError("foot", name, self.foot_names)

    def joint(self, name: str) -> Joint:
        """Look a joint up by name."""
        return self.joints[self.joint_index(name)]

    def joint_index(self, name: str) -> int:
        """Position of a joint among the joints."""
        if name not in self.joint_names:
            raise UnknownNameError("joint", name, self.joint_names)
        return self.joint_names.index(name)

    def coordinate_index(self, name: str) -> int:
        """Position of a coordinate in q."""
        if name not in self.coordinate_names:
            raise UnknownNameError("coordinate", name, self.coordinate_names)
        return self.coordinate_names.index(name)


def _reach(joint: Joint) -> float:
    """How far a joint's frame is from its parent's at most, m."""
    if not joint.prismatic:
        return float(np.linalg.norm(joint.translation))
    ends = [end for end in (joint.lower, joint.upper) if np.isfinite(end)] or [0.0]
    return max(float(np.linalg.norm(joint.translation + joint.rotation @ joint.axis * end)) for end in ends)


def _content(robot: Robot) -> Json:
    """Everything that changes a motion, as plain data; repr of a float is exact."""
    return {
        "links": [
            [link.name, repr(float(link.mass)), _exact(link.center), _exact(link.inertia)] for link in robot.links
        ],
        "joints": [
            [joint.name, joint.parent, joint.child, _exact(joint.rotation), _exact(joint.translation)]
            + [_exact(joint.axis)]
            + [repr(float(limit)) for limit in (joint.lower, joint.upper, joint.effort, joint.velocity)]
            + ["prismatic"] * joint.prismatic
            for joint in robot.joints
        ],
        "feet": [[foot.name, foot.link, _exact(foot.offset)] for foot in robot.feet],
        "gravity": repr(float(robot.gravity)),
        "twins": [list(pair) for pair in robot.twins],
        "symmetry_tolerance": repr(float(robot.symmetry_tolerance)),
        "overlays": _overlays(robot),
        **({} if robot.base.in_space else {"base": robot.base.name}),
    }


def _overlays(robot: Robot) -> Json:
    """What is laid over links and joints; empty places where nothing is, so that such a robot keeps its hash."""
    carried = robot.payload
    return {
        "locked_joints": {name: repr(float(value)) for name, value in robot.locked_joints.items()},
        "rotors": {
            joint.name: [repr(float(getattr(joint, what))) for what in DRIVE]
            for joint in robot.joints
            if not joint.driven_freely
        },
        "payload": {}
        if carried is None
        else {"mass": repr(float(carried.mass)), "position": _exact(carried.position), "link": carried.link},
    }


def _exact(values: Matrix) -> list[str]:
    # adding zero turns -0.0 into 0.0, which means the same motion
    return [repr(float(value) + 0.0) for value in values.reshape(-1)]
