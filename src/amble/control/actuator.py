"""Actuator models: what a joint torque and a joint speed cost in electrical power (paper, section 4)."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from amble.errors import InputError
from amble.io.registry import Lookup


@dataclass(frozen=True)
class Actuator:
    """An electric motor behind a gear; the same one at every joint.

    Attributes:
        name: short name; every number computed with the model is labelled with it.
        torque_constant: motor torque a current gives, K_t, N m/A.
        resistance: winding resistance R, ohm.
        gear_ratio: joint torque over motor torque, N.
        source: where the numbers come from, one sentence.

    Raises:
        InputError: where a number is not finite and positive.
    """

    name: str
    torque_constant: float
    resistance: float
    gear_ratio: float
    source: str

    def __post_init__(self) -> None:
        """Refuse numbers no motor has."""
        for what in ("torque_constant", "resistance", "gear_ratio"):
            value = getattr(self, what)
            if not (isfinite(value) and value > 0.0):
                raise InputError(f"the {what} of actuator '{self.name}' is {value}; it must be finite and positive")

    @property
    def heat_coefficient(self) -> float:
        """Heat a squared joint torque costs, R / (N K_t)^2, W/(N m)^2."""
        return self.resistance / (self.gear_ratio * self.torque_constant) ** 2

    def heat(self, torque: ArrayLike) -> NDArray[np.float64]:
        """Power lost to heat in each winding, P_heat = R (tau / (N K_t))^2 (paper, section 4).

        Args:
            torque: joint torques tau, any shape, N m.

        Returns:
            P_heat in the shape of ``torque``, W.
        """
        return self.heat_coefficient * np.square(np.asarray(torque, dtype=np.float64))

    def mechanical(self, torque: ArrayLike, speed: ArrayLike) -> NDArray[np.float64]:
        """Mechanical power without recuperation, P_mec = max(tau omega, 0) (paper, section 4).

        Args:
            torque: joint torques tau, any shape, N m.
            speed: joint speeds omega, a shape that fits, rad/s.

        Returns:
            P_mec, W.
        """
        product = np.asarray(torque, dtype=np.float64) * np.asarray(speed, dtype=np.float64)
        return np.maximum(product, 0.0)

    def power(self, torque: ArrayLike, speed: ArrayLike) -> NDArray[np.float64]:
        """Electrical power of each actuator, max(tau omega, 0) + R (tau / (N K_t))^2 (paper, section 4).

        Args:
            torque: joint torques tau, any shape, N m.
            speed: joint speeds omega, a shape that fits, rad/s.

        Returns:
            P_mec + P_heat, W.
        """
        return self.mechanical(torque, speed) + self.heat(torque)


PAPER = Actuator(
    name="paper",
    torque_constant=0.29,
    resistance=0.55,
    gear_ratio=6.0,
    source="RMD-X8-Pro-H as the paper counts it: only the additional gear of 6:1, so that heat is overstated 38-fold.",
)
"""The model behind the paper's Table 1."""

DATASHEET = Actuator(
    name="datasheet",
    torque_constant=0.29,
    resistance=0.55,
    gear_ratio=37.2,
    source="RMD-X8-Pro-H with its built-in gear of 6.2:1 and the additional 6:1; K_t and R are motor-side values.",
)
"""The model with the whole gear chain."""

ACTUATORS: Lookup[Actuator] = Lookup("actuator")
"""The models that files and the command line can name; reports compute their numbers with each of them."""

for _model in (PAPER, DATASHEET):
    ACTUATORS.register(_model.name, _model)
