"""What a gait is asked for: mean velocities forward and to the left, and how fast it turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from amble.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Command:
    """Mean velocities in axes that turn with the heading and are the world's at the entry of the first domain.

    Attributes:
        forward: m/s; negative backwards.
        lateral: to the left, m/s.
        yaw_rate: mean rate of the heading about the vertical, counter-clockwise, rad/s.

    Raises:
        InputError: a value is not a number of reasonable size.
    """

    forward: Any
    lateral: Any = 0.0
    yaw_rate: Any = 0.0

    def __post_init__(self) -> None:
        """Check numbers; symbols pass."""
        for what, value, unit in (
            ("speed", self.forward, "m/s"),
            ("lateral speed", self.lateral, "m/s"),
            ("yaw rate", self.yaw_rate, "rad/s"),
        ):
            if not isinstance(value, ca.SX) and not -100.0 < value < 100.0:
                raise InputError(f"the {what} is {value} {unit}; it must be a number of reasonable size")

    @property
    def straight(self) -> bool:
        """Whether the heading stays."""
        return not isinstance(self.yaw_rate, ca.SX) and self.yaw_rate == 0.0

    @property
    def in_place(self) -> bool:
        """Whether it goes nowhere; it may turn."""
        return bool(self.forward == 0.0 and self.lateral == 0.0)

    @property
    def ahead(self) -> bool:
        """Whether it is the same for its left-right mirror image."""
        return bool(self.lateral == 0.0 and self.yaw_rate == 0.0)

    def way(self, duration: Any) -> tuple[Any, Any, Any]:
        """Return where a duration leads: displacement along the world's x and y, m, and change of the heading, rad.

        The displacement is the integral of the velocities turned by yaw_rate t, symbols or numbers.
        """
        x, y = self.forward * duration, self.lateral * duration
        if self.straight:
            return x, y, 0.0 * duration
        angle = self.yaw_rate * duration
        sine, cosine = (ca.sin, ca.cos) if isinstance(angle, ca.SX) else (np.sin, np.cos)
        along, across = sine(angle) / angle, (1.0 - cosine(angle)) / angle
        return along * x - across * y, across * x + along * y, angle
