"""Actuator models: what a joint torque and a joint speed cost in electrical power (paper, section 4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, asdict, dataclass, field
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from amble.errors import InputError, UnknownNameError, shown
from amble.io.registry import Lookup
from amble.types import Vector


@dataclass(frozen=True)
class Actuator:
    """An electric motor behind a gear, the same one at every joint but for those that are named.

    Attributes:
        name: short name; every number computed with the model is labelled with it.
        torque_constant: motor torque a current gives, K_t, N m/A.
        resistance: winding resistance R, ohm.
        gear_ratio: joint torque over motor torque, N.
        source: where the numbers come from, one sentence.
        joints: joint -> its own motor, which has no ``joints``; all other joints have this one. A file holds the fields
            of each by name.

    Raises:
        InputError: where a number is not finite and positive, or a joint's motor is none.
    """

    name: str
    torque_constant: float
    resistance: float
    gear_ratio: float
    source: str
    _: KW_ONLY
    joints: Mapping[str, Actuator] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        """Refuse numbers no motor has."""
        if not isinstance(self.joints, Mapping):
            raise InputError(f"the joints of actuator '{self.name}' are {shown(self.joints)}, not a motor for each")
        own = {joint: actuator_from(motor, f"joint '{shown(joint)}'") for joint, motor in self.joints.items()}
        for joint, motor in own.items():
            if motor.joints:
                raise InputError(f"the motor of joint '{shown(joint)}' has joints of its own")
        object.__setattr__(self, "joints", own)
        for what in ("torque_constant", "resistance", "gear_ratio"):
            value = getattr(self, what)
            if not (isfinite(value) and value > 0.0):
                raise InputError(f"the {what} of actuator '{self.name}' is {value}; it must be finite and positive")

    @property
    def fields(self) -> dict[str, Any]:
        """The fields by name, as files hold them: ``joints`` only where a joint has its own motor."""
        found = asdict(self)
        for motor in found["joints"].values():
            del motor["joints"]
        return found if self.joints else {name: value for name, value in found.items() if name != "joints"}

    @property
    def heat_coefficient(self) -> float:
        """Heat a squared joint torque costs, R / (N K_t)^2, W/(N m)^2, of joints that have no motor of their own."""
        return self.resistance / (self.gear_ratio * self.torque_constant) ** 2

    def heat_coefficients(self, joints: Sequence[str]) -> Vector:
        """Return the heat that a squared torque of every joint costs, (n_joints,), W/(N m)^2.

        Args:
            joints: names of all joints of the robot, in order.

        Raises:
            UnknownNameError: a joint with its own motor is none of them.
        """
        for joint in self.joints:
            if joint not in joints:
                raise UnknownNameError("joint", joint, tuple(joints))
        return np.array([self.joints.get(joint, self).heat_coefficient for joint in joints])

    def fits(self, joints: Sequence[str]) -> bool:
        """Whether all joints with their own motor are among those of a robot."""
        return set(self.joints) <= set(joints)

    def heat(self, torque: ArrayLike, joints: Sequence[str] = ()) -> NDArray[np.float64]:
        """Power lost to heat in each winding, P_heat = R (tau / (N K_t))^2 (paper, section 4).

        Args:
            torque: joint torques tau, any shape, N m; joints along the last axis where they are named.
            joints: names of all joints of the robot, needed where some have their own motor.

        Returns:
            P_heat in the shape of ``torque``, W.

        Raises:
            UnknownNameError: a joint with its own motor is none of them.
        """
        coefficient = self.heat_coefficients(joints) if self.joints else self.heat_coefficient
        return coefficient * np.square(np.asarray(torque, dtype=np.float64))

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

    def power(self, torque: ArrayLike, speed: ArrayLike, joints: Sequence[str] = ()) -> NDArray[np.float64]:
        """Electrical power of each actuator, max(tau omega, 0) + R (tau / (N K_t))^2 (paper, section 4).

        Args:
            torque: joint torques tau, any shape, N m.
            speed: joint speeds omega, a shape that fits, rad/s.
            joints: as of ``heat``.

        Returns:
            P_mec + P_heat, W.
        """
        return self.mechanical(torque, speed) + self.heat(torque, joints)


def actuator_from(given: Actuator | Mapping[str, Any], where: str) -> Actuator:
    """Return an actuator that is given, or that has given fields.

    Args:
        given: the model, or its fields by name.
        where: whose it is, for the error.

    Raises:
        InputError: what is given is no actuator model.
    """
    if isinstance(given, Actuator):
        return given
    try:
        return Actuator(**given)
    except TypeError as error:
        raise InputError(f"the actuator of {where} is no actuator model: {error}") from None


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
