"""The parts of a robot as numbers with names: links, joints, point feet; and what such numbers may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.amounts import LARGEST_NUMBER
from amble.errors import InputError
from amble.names import check_name
from amble.types import Matrix, Vector

BASE_COORDINATES = ("x", "y", "z", "roll", "pitch", "yaw")
"""The base as a serial chain: prismatic along world x, y, z, then revolute about X, Y', Z''; R = Rx Ry Rz."""

RATE, ACCELERATION = "rate of ", "acceleration of "
"""Before the name of a coordinate: the name of its derivative among states and rows."""


def check_bounded(what: str, *values: float | Matrix) -> None:
    """Refuse numbers that are not finite, or larger than any robot has.

    Raises:
        InputError: in one sentence, with the number.
    """
    for value in values:
        array = np.asarray(value, dtype=np.float64)
        bad = ~(np.abs(array) <= LARGEST_NUMBER)
        if np.any(bad):
            raise InputError(
                f"the {what} holds {array[bad][0]:g}; numbers of a robot are finite, up to {LARGEST_NUMBER:g}"
            )


DRIVE = ("rotor_inertia", "damping", "dry_friction", "friction_width")
"""What a joint has between its torque and its motion: attributes of ``Joint``."""


@dataclass(frozen=True)
class Link:
    """A rigid body, fixed links merged into it.

    Attributes:
        name: name of the link that moves.
        mass: kg.
        center: centre of mass in the link's frame, (3,), m.
        inertia: rotational inertia about the centre of mass, link axes, (3, 3), kg m^2.
    """

    name: str
    mass: float
    center: Vector
    inertia: Matrix

    def __post_init__(self) -> None:
        """Check the name and the size of the numbers."""
        check_name("link", self.name)
        check_bounded(f"link '{self.name}'", self.mass, self.center, self.inertia)


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A revolute or prismatic joint; the frame of its child link is the joint frame.

    Of a prismatic joint angles are displacements, rad stands for m, torques are forces: N m stands for N, kg m^2 for
    kg, N m s/rad for N s/m.

    Attributes:
        name: name in the file.
        parent: index of the link it hangs on.
        child: index of the link it moves.
        rotation: orientation of the joint frame in the parent link at angle zero, (3, 3).
        translation: origin of the joint frame in the parent link, at displacement zero, (3,), m.
        axis: unit vector in the joint frame, (3,).
        lower: smallest angle, rad; minus infinity where the file gives none.
        upper: largest angle, rad; infinity where the file gives none.
        effort: largest |torque|, N m; infinity where the file gives none.
        velocity: largest |rate|, rad/s; infinity where the file gives none.
        rotor_inertia: of the motor's rotor as the joint feels it, gear ratio squared times its own, kg m^2.
        damping: torque against the rate, by the rate, N m s/rad.
        dry_friction: torque against the motion, N m; smooth: times tanh(rate / friction_width).
        friction_width: rate, rad/s; positive where there is dry friction, zero where there is none.
        prismatic: whether the joint slides along its axis instead of turning about it.
    """

    name: str
    parent: int
    child: int
    rotation: Matrix
    translation: Vector
    axis: Vector
    lower: float
    upper: float
    effort: float
    velocity: float
    rotor_inertia: float = 0.0
    damping: float = 0.0
    dry_friction: float = 0.0
    friction_width: float = 0.0
    prismatic: bool = False

    def __post_init__(self) -> None:
        """Check name and numbers: a joint is a coordinate, beside those of the base and the derivatives of all."""
        check_name("joint", self.name)
        if self.name in BASE_COORDINATES or self.name.startswith((RATE, ACCELERATION)):
            raise InputError(f"a joint is called '{self.name}', which is the name of another coordinate or derivative")
        check_bounded(f"joint '{self.name}'", self.rotation, self.translation, self.axis)
        for what in DRIVE:
            value = getattr(self, what)
            if not 0.0 <= value <= LARGEST_NUMBER:
                raise InputError(f"the {what} of joint '{self.name}' is {value:g}; it is finite and not negative")
        if (self.dry_friction > 0.0) != (self.friction_width > 0.0):
            raise InputError(f"joint '{self.name}' needs both dry_friction and friction_width, or neither")

    @property
    def unit(self) -> str:
        """Unit of its coordinate: rad or m."""
        return "m" if self.prismatic else "rad"

    @property
    def driven_freely(self) -> bool:
        """Whether neither rotor, damping nor friction stands between torque and motion."""
        return not any(getattr(self, what) for what in DRIVE)


@dataclass(frozen=True)
class Foot:
    """A point foot.

    Attributes:
        name: the user's label.
        frame: the link or joint of the file that the label stands for.
        link: index of the moving link that carries the foot.
        offset: position of the foot in that link's frame, (3,), m.
    """

    name: str
    frame: str
    link: int
    offset: Vector

    def __post_init__(self) -> None:
        """Check the names and the size of the numbers."""
        check_name("foot", self.name)
        check_name("foot's frame", self.frame)
        check_bounded(f"foot '{self.name}'", self.offset)


@dataclass(frozen=True, kw_only=True)
class Payload:
    """A point mass that a link carries; it is part of that link's inertia, this is the record of it.

    Attributes:
        mass: kg.
        position: in the frame of the link of the file, (3,), m.
        link: name of that link.
    """

    mass: float
    position: Vector
    link: str

    def __post_init__(self) -> None:
        """Check name and numbers."""
        check_name("payload's link", self.link)
        check_bounded("payload", self.mass, self.position)
