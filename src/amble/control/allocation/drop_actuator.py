"""The law of Ma et al. (2019): switch as many stance-leg actuators off as there are free directions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from amble.control.allocation.law import AllocationLaw, Redundancy
from amble.errors import InputError, UnknownNameError, listed, shown
from amble.numerics.linear_algebra import OrthogonalFactor


@dataclass(frozen=True)
class DropActuator(AllocationLaw):
    """u_j = 0 for every listed joint j that belongs to a stance leg.

    Attributes:
        joints: joints whose actuators are off while their leg stands. A joint of a swing leg keeps its actuator:
            dropping it would make the decoupling matrix singular (docs/theory/allocation.md, section 1).
    """

    joints: tuple[str, ...]

    def __post_init__(self) -> None:
        """Take a single name for a tuple of one.

        Raises:
            InputError: where the joints are no names.
        """
        if isinstance(self.joints, str):
            object.__setattr__(self, "joints", (self.joints,))
        if not isinstance(self.joints, tuple) or not all(isinstance(joint, str) for joint in self.joints):
            raise InputError(f"the joints to drop are {shown(self.joints)}; they must be a list of names")

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "drop"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The dropped joints."""
        return {"joints": list(self.joints)}

    def optimality_conditions(self, redundancy: Redundancy) -> ca.SX:
        """u_j = 0."""
        return redundancy.torques[self._dropped(redundancy)]

    def allocate(self, redundancy: Redundancy) -> ca.SX:
        """Solve u_j + n_j s = 0 for the dropped joints."""
        dropped = self._dropped(redundancy)
        if not dropped:
            return ca.SX(0, 1)
        return OrthogonalFactor.of(redundancy.torque_basis[dropped, :]).solve(-redundancy.torques[dropped])

    def _dropped(self, redundancy: Redundancy) -> list[int]:
        """Indices of the joints that are off in this stance.

        Raises:
            UnknownNameError: a listed joint does not exist.
            InputError: not exactly as many listed joints stand as there are free directions.
        """
        robot, feet = redundancy.robot, redundancy.feet
        for joint in self.joints:
            if joint not in robot.joint_names:
                raise UnknownNameError("joint", joint, robot.joint_names)
        standing = {joint for foot in feet for joint in robot.legs[foot]}
        dropped = [robot.joint_names.index(joint) for joint in self.joints if joint in standing]
        if len(dropped) != redundancy.size:
            raise InputError(
                f"of the actuators to drop ({listed(self.joints)}) {len(dropped)} belong to the stance legs "
                f"{', '.join(feet)}, but {redundancy.size} must: dropping a joint of a swing leg makes the "
                "decoupling matrix singular, and dropping fewer leaves the torques undetermined"
            )
        return dropped
