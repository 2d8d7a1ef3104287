"""A ground of one's own: gentle waves across the way. One class, one registration; then files can name it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Any

import casadi as ca

from amble.errors import InputError
from amble.hybrid import GROUNDS, Ground
from amble.types import Vector, frozen


@dataclass(frozen=True, kw_only=True)
class SineGround(Ground):
    """Waves with crests along y: h = amplitude sin(2 pi x / wavelength).

    Attributes:
        amplitude: m.
        wavelength: m.

    Raises:
        InputError: the wavelength is not positive.
    """

    amplitude: float
    wavelength: float

    def __post_init__(self) -> None:
        """Refuse waves without length."""
        super().__post_init__()
        if not self.wavelength > 0.0:
            raise InputError(f"the wavelength of the ground is {self.wavelength:g} m; it must be positive")

    @property
    def name(self) -> str:
        """Name in files."""
        return "sine"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """What a file holds, besides the name."""
        return {"friction": self.friction, "amplitude": self.amplitude, "wavelength": self.wavelength}

    def surface(self, x: ca.SX, y: ca.SX) -> ca.SX:
        """Write the height; slopes, normals and gaps follow from it."""
        del y
        return self.amplitude * ca.sin(2.0 * pi / self.wavelength * x)

    @property
    def translations(self) -> Mapping[str, Vector]:
        """Only along the crests."""
        return {"y": frozen([0.0, 1.0, 0.0])}

    @property
    def mirrored(self) -> bool:
        """The same on the left and on the right."""
        return True


GROUNDS.register("sine", SineGround)
