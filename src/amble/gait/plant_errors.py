"""What a walk on unilateral ground meets that its model does not have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from amble.control.allocation.law import finite
from amble.errors import InputError, UnknownNameError
from amble.robot import Robot


@dataclass(frozen=True, kw_only=True)
class PlantErrors:
    """What a plant and its controller's timing differ in from the model; nothing by default. SI units.

    Attributes:
        friction: coefficient of the ground; the gait's own where none is given.
        damping: of all joints, beside that of the record, N m s/rad; of prismatic joints at an arm of the leg length.
        dry_friction: of all joints, N m, likewise.
        trunk: factor of the base link's mass and inertia.
        delay: time until a torque command arrives, s; to first order (``unilateral_loop``).
        lateness: time by which the controller sees a touchdown late, s; to first order.
        steps: foot -> height of the ground where it lands, m.

    Raises:
        InputError: a number is not finite, or a friction or the trunk's factor is not positive.
    """

    friction: float | None = None
    damping: float = 0.0
    dry_friction: float = 0.0
    trunk: float = 1.0
    delay: float = 0.0
    lateness: float = 0.0
    steps: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what no plant has."""
        numbers = {item.name: getattr(self, item.name) for item in fields(self) if item.name != "steps"}
        numbers |= {f"step of '{foot}'": height for foot, height in self.steps.items()}
        for name, value in numbers.items():
            if value is not None:
                finite(name.replace("_", " "), value)
        for name in ("friction", "trunk"):
            if numbers[name] is not None and not numbers[name] > 0.0:
                raise InputError(f"the {name} of a plant is {numbers[name]:g}; it must be positive")

    @property
    def late(self) -> float:
        """How long the torques of the last stance go on behind a switch, s."""
        return self.delay + self.lateness

    def heights(self, robot: Robot) -> list[float]:
        """Return the height of the ground under every foot of a robot, m.

        Raises:
            UnknownNameError: a step is that of a foot that the robot does not have.
        """
        for foot in self.steps:
            if foot not in robot.foot_names:
                raise UnknownNameError("foot", foot, robot.foot_names)
        return [float(self.steps.get(foot, 0.0)) for foot in robot.foot_names]


EXACT = PlantErrors()
