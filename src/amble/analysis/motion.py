"""A motion as the metrics see it: joint speeds and, for every allocation law, the torques along one trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from amble.analysis.quadrature import segment_bounds
from amble.errors import InputError, UnknownNameError
from amble.types import IntegerVector, NodeValues, Vector


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Samples along one trajectory, with the torques of each law (docs/theory/allocation.md, eq. 3).

    Forces of prismatic joints are torques at an arm of the leg length here, and their speeds turn it
    (``Robot.torque_arms``): powers are the same, squares and peaks of both kinds of joints compare.

    The samples need not be evenly spaced. At an event there is one sample just before and one just after it, at the
    same time, with different segment numbers: torques jump there, and no integral runs across.

    Attributes:
        label: which trajectory this is, such as "nominal" or "simulated".
        joints: joint names, in the order of the columns.
        times: (n,), s.
        segments: number of the segment between two events of every sample, (n,).
        speeds: joint speeds, (n, n_joints), rad/s.
        torques: law name -> joint torques, (n, n_joints), N m.
        distance: total horizontal distance walked, m; 0 where it stays in place.
        mass: mass of the robot, kg.
        gravity: m/s^2.

    Raises:
        InputError: where shapes do not fit together, a value is not finite, mass or gravity is not positive, or the
            distance is negative.
    """

    label: str
    joints: tuple[str, ...]
    times: Vector
    segments: IntegerVector
    speeds: NodeValues
    torques: Mapping[str, NodeValues]
    distance: float
    mass: float
    gravity: float

    def __post_init__(self) -> None:
        """Check shapes and numbers, so that no metric has to."""
        count, width = len(self.times), len(self.joints)
        expected: dict[str, tuple[NodeValues | IntegerVector, tuple[int, ...]]] = {
            "times": (self.times, (count,)),
            "segments": (self.segments, (count,)),
            "speeds": (self.speeds, (count, width)),
            **{f"torques of '{law}'": (torque, (count, width)) for law, torque in self.torques.items()},
        }
        for what, (values, shape) in expected.items():
            if np.shape(values) != shape:
                raise InputError(f"the {what} of the {self.label} motion have shape {np.shape(values)}, not {shape}")
            if not np.all(np.isfinite(values)):
                raise InputError(f"the {what} of the {self.label} motion hold a value that is not finite")
        for what, number in (("mass", self.mass), ("gravity", self.gravity)):
            if not (np.isfinite(number) and number > 0.0):
                raise InputError(f"the {what} of the {self.label} motion is {number}; it must be finite and positive")
        if not (np.isfinite(self.distance) and self.distance >= 0.0):
            raise InputError(
                f"the distance of the {self.label} motion is {self.distance}; it must be finite and not negative"
            )

    @property
    def duration(self) -> float:
        """Sum of the durations of all segments, s."""
        return float(sum(self.times[last - 1] - self.times[first] for first, last in segment_bounds(self.segments)))

    @property
    def speed(self) -> float:
        """Mean horizontal speed, m/s."""
        return self.distance / self.duration

    def torque(self, law: str) -> NodeValues:
        """Look the torques of a law up, (n, n_joints), N m.

        Raises:
            UnknownNameError: where the motion holds no torques of that law.
        """
        if law not in self.torques:
            raise UnknownNameError("law", law, self.torques)
        return self.torques[law]
