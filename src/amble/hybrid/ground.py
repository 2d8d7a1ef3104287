"""Ground: where it lies, which way it faces, how much friction it gives, and what leaves it unchanged.

Gravity always acts along -z of the world; a slope belongs to the ground. Every ground is the graph of a height
z = h(x, y), smooth where feet touch it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import cos, isfinite, pi, sin, tan
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from amble.amounts import LARGEST_NUMBER
from amble.errors import InputError
from amble.io.registry import Registry
from amble.types import Vector, frozen

CASADI = (ca.SX, ca.MX, ca.DM)

ROUNDING = 1e-15
"""A component of a plane's gradient below this is the rounding of a sine or cosine."""


@dataclass(frozen=True, kw_only=True)
class Ground(ABC):
    """A rigid surface z = h(x, y) with a friction coefficient; immutable and hashable.

    Points and vectors are in world axes: casadi expressions (3,), or numpy arrays (..., 3) with the axis last.

    Attributes:
        units: parameter -> unit, as files hold them.
        friction: coefficient mu of the contact of any foot, 1.

    Raises:
        InputError: the friction coefficient is not finite and positive.
    """

    units: ClassVar[Mapping[str, str]] = {"friction": "1"}

    friction: float = 0.6

    def __post_init__(self) -> None:
        """Refuse ground that nothing can stand on."""
        if isinstance(self.friction, bool) or not isinstance(self.friction, int | float):
            raise InputError(f"the friction coefficient is {self.friction!r}, not a number")
        if not 0.0 < self.friction < float("inf"):
            raise InputError(f"the friction coefficient is {self.friction:g}; it must be finite and positive")
        if self.friction > LARGEST_NUMBER:
            raise InputError(f"the friction coefficient is {self.friction:g}; it goes up to {LARGEST_NUMBER:g}")

    @property
    @abstractmethod
    def name(self) -> str:
        """Short name of the kind, as used in files."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Parameters as plain JSON values; with the name they rebuild the ground."""
        return {"friction": self.friction}

    @abstractmethod
    def surface(self, x: ca.SX, y: ca.SX) -> ca.SX:
        """Write the height h(x, y) over two casadi scalars, m."""

    @property
    def level(self) -> bool:
        """Whether this is the plane z = 0, which a turn about the vertical leaves unchanged."""
        return False

    @property
    def translations(self) -> Mapping[str, Vector]:
        """Translations that leave the ground unchanged: "x" or "y" -> the one that lies over a metre of that axis."""
        return {}

    @property
    def mirrored(self) -> bool:
        """Whether the mirror y -> -y leaves the ground unchanged."""
        return False

    def height(self, x: Any, y: Any) -> Any:
        """Return h(x, y), m."""
        return self._at(x, y)[0]

    def normal(self, point: Any) -> Any:
        """Return the upward unit normal (-h_x, -h_y, 1) / |.| over (or under) a point, (3,)."""
        frame = self.frame(point)
        return frame[:, 2] if isinstance(frame, CASADI) else frame[..., 2]

    def gap(self, point: Any) -> Any:
        """Return n_z (z - h(x, y)), m: the signed distance of a point from a plane; from other ground to first order.

        Positive above the ground.
        """
        x, y, z = components(point)
        if self.level:
            return z
        height, along_x, along_y = self._at(x, y)
        return (z - height) / (1.0 + along_x**2 + along_y**2) ** 0.5

    def frame(self, point: Any) -> Any:
        """Return two unit tangents and the normal at a point as columns, (3, 3).

        The first tangent lies over the world's x axis, so on level ground the frame is that of the world.
        """
        if self.level:
            return ca.SX.eye(3) if isinstance(point, CASADI) else _broadcast(np.eye(3), np.shape(point)[:-1])
        x, y, _ = components(point)
        _, along_x, along_y = self._at(x, y)
        one = along_x * 0.0 + 1.0
        first = _unit(one, 0.0 * one, along_x)
        normal = _unit(-along_x, -along_y, one)
        second = _cross(normal, first)
        if isinstance(point, CASADI):
            return ca.horzcat(*[ca.vertcat(*column) for column in (first, second, normal)])
        return np.stack([np.stack(column, axis=-1) for column in (first, second, normal)], axis=-1)

    def _at(self, x: Any, y: Any) -> tuple[Any, Any, Any]:
        """Height and its slopes along x and y."""
        function = _surface(self)
        if isinstance(x, CASADI) or isinstance(y, CASADI):
            height, along_x, along_y = function(x, y)
            return height, along_x, along_y
        x, y = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        found = function(x.reshape(1, -1), y.reshape(1, -1))
        height, along_x, along_y = (np.asarray(part).reshape(x.shape) for part in found)
        return height, along_x, along_y


@dataclass(frozen=True, kw_only=True)
class Plane(Ground):
    """A plane through the world's origin.

    Attributes:
        slope: angle between the plane and the horizontal, rad.
        heading: direction in which the plane rises, about z from the world's x axis, rad; a negative slope falls.
    """

    units: ClassVar[Mapping[str, str]] = {"friction": "1", "slope": "rad", "heading": "rad"}

    slope: float = 0.0
    heading: float = 0.0

    def __post_init__(self) -> None:
        """Refuse walls and overhangs.

        Raises:
            InputError: an angle is not a number, or the slope is not below a right angle.
        """
        super().__post_init__()
        for what, angle in (("slope", self.slope), ("heading", self.heading)):
            if isinstance(angle, bool) or not isinstance(angle, int | float) or not isfinite(angle):
                raise InputError(f"the {what} of the ground is {angle!r}; it must be a finite angle in rad")
        if not abs(self.slope) < 0.5 * pi:
            raise InputError(f"the slope of the ground is {self.slope:g} rad; it must be below a right angle")

    @property
    def name(self) -> str:
        """Name in files."""
        return "plane"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Friction, slope and heading."""
        return {"friction": self.friction, "slope": self.slope, "heading": self.heading}

    @cached_property
    def gradient(self) -> tuple[float, float]:
        """Slopes h_x and h_y."""
        steepest = tan(self.slope)
        along_x, along_y = steepest * cos(self.heading), steepest * sin(self.heading)
        return _rounded(along_x), _rounded(along_y)

    def surface(self, x: ca.SX, y: ca.SX) -> ca.SX:
        """Write h_x x + h_y y."""
        along_x, along_y = self.gradient
        return along_x * x + along_y * y

    @property
    def level(self) -> bool:
        """Whether the plane does not slope."""
        return self.gradient == (0.0, 0.0)

    @property
    def translations(self) -> Mapping[str, Vector]:
        """Along the plane, over the world's x and y."""
        along_x, along_y = self.gradient
        return {"x": frozen([1.0, 0.0, along_x]), "y": frozen([0.0, 1.0, along_y])}

    @property
    def mirrored(self) -> bool:
        """Whether the plane does not rise sideways."""
        return self.gradient[1] == 0.0


@dataclass(frozen=True, kw_only=True)
class HeightField(Ground):
    """Ground given by a function of casadi expressions, for use at once; a file cannot hold a function.

    Attributes:
        function: (x, y) -> height, m.
        symmetric: claim that the function is even in y.
    """

    function: Callable[[ca.SX, ca.SX], ca.SX]
    symmetric: bool = False

    @property
    def name(self) -> str:
        """Name in messages."""
        return "height field"

    def surface(self, x: ca.SX, y: ca.SX) -> ca.SX:
        """Write the height."""
        return self.function(x, y)

    @property
    def mirrored(self) -> bool:
        """What the ground claims."""
        return self.symmetric


FLAT = Plane()
"""Level ground at height 0."""

GROUNDS: Registry[Ground] = Registry("ground")
"""The grounds that files can hold."""

GROUNDS.register("plane", Plane)


def components(values: Any) -> tuple[Any, ...]:
    """Split a casadi column, or a numpy array along its last axis, into its entries."""
    if isinstance(values, CASADI):
        return tuple(values[i, :] for i in range(values.shape[0]))
    array = np.asarray(values)
    return tuple(array[..., i] for i in range(array.shape[-1]))


def into_frame(vector: Any, frame: Any) -> Any:
    """Return frame^T vector: world components -> those along the tangents and the normal, (3,) or (..., 3)."""
    if isinstance(vector, CASADI):
        return ca.SX(frame).T @ vector if isinstance(vector, ca.SX) else frame.T @ vector
    return np.einsum("...ji,...j->...i", frame, vector)


@lru_cache(maxsize=64)
def _surface(ground: Ground) -> ca.Function:
    """(x, y) -> height and its two slopes."""
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    height = ca.SX(ground.surface(x, y))
    slopes = [ca.gradient(height, symbol) for symbol in (x, y)]
    return ca.Function("surface", [x, y], [ca.densify(part) for part in (height, *slopes)])


def _rounded(value: float) -> float:
    return 0.0 if abs(value) < ROUNDING else value


def _unit(x: Any, y: Any, z: Any) -> tuple[Any, Any, Any]:
    length = (x**2 + y**2 + z**2) ** 0.5
    return x / length, y / length, z / length


def _cross(a: tuple[Any, ...], b: tuple[Any, ...]) -> tuple[Any, Any, Any]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _broadcast(matrix: Any, shape: tuple[int, ...]) -> Any:
    return np.broadcast_to(matrix, (*shape, *matrix.shape))
