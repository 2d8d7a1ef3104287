"""A cost of one's own: the electrical power of the motors, smoothed. One class, one registration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca

from amble.control.actuator import ACTUATORS
from amble.errors import InputError
from amble.gait.cost import COSTS, Cost, Instant


@dataclass(frozen=True)
class ElectricalPower(Cost):
    """L = sum_j s(u_j w_j) + r u_j^2 with s(p) = (p + sqrt(p^2 + e^2) - e) / 2, which tends to max(p, 0) as e vanishes.

    A solver by Newton's method needs two derivatives; max(p, 0) has a breakpoint where a motor turns from driving to
    braking.

    Attributes:
        actuator: name of the model, for r = R / (N K_t)^2.
        smoothing: e, W.

    Raises:
        UnknownNameError: there is no actuator of that name.
        InputError: the smoothing is not positive.
    """

    units: ClassVar[Mapping[str, str]] = {"smoothing": "W"}

    actuator: str = "paper"
    smoothing: float = 1.0

    def __post_init__(self) -> None:
        """Refuse a model that does not exist and a breakpoint."""
        ACTUATORS[self.actuator]
        if not 0.0 < self.smoothing < float("inf"):
            raise InputError(f"the smoothing of the power is {self.smoothing:g} W; it must be finite and positive")

    @property
    def name(self) -> str:
        """Name in files."""
        return "electrical power"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """What a file holds, besides the name."""
        return {"actuator": self.actuator, "smoothing": self.smoothing}

    @property
    def unit(self) -> str:
        """Watt."""
        return "W"

    def running(self, instant: Instant) -> ca.SX:
        """Sum over the motors."""
        # shorthand
        r, e = ACTUATORS[self.actuator].heat_coefficient, self.smoothing
        u, w = instant.torques, instant.joint_speeds

        driving = 0.5 * (u * w + ca.sqrt((u * w) ** 2 + e**2) - e)
        return ca.sum1(driving) + r * ca.sumsqr(u)


COSTS.register("electrical power", ElectricalPower)
