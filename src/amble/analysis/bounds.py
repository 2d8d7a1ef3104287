"""What a simulated motion is held against."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from amble.control.motion_equations import SMALLEST_PIVOT
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.clearances import Motor


@dataclass(frozen=True, kw_only=True)
class ContactBounds:
    """Bounds of the monitors; contact quantities in the frame of the ground.

    Attributes:
        friction: largest |f_t| / f_n, the exact cone, 1.
        normal_force: smallest normal force of a stance foot, N.
        penetration: largest depth of a swing foot, m.
        drift: largest distance of a stance foot from where its stance phase began, m.
        touchdown: largest distance of a landing foot from the ground, above or below it, when an impact stops it, m.
        pivot: smallest pivot of the decoupling equations.
        torques: joint name -> largest |torque|, N m; a joint that is not named has no bound.
        speeds: joint name -> largest |rate|, rad/s; a joint that is not named has no bound.
        motors: joint name -> its largest torque over its speed; a joint that is not named has none.

    Raises:
        InputError: where a bound is negative or not a number.
    """

    friction: float
    normal_force: float
    penetration: float
    drift: float
    touchdown: float
    pivot: float
    torques: Mapping[str, float]
    speeds: Mapping[str, float]
    motors: Mapping[str, Motor] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse bounds that nothing can keep."""
        numbers = {name: getattr(self, name) for name in ("friction", "penetration", "drift", "touchdown", "pivot")}
        numbers |= {f"torque of '{joint}'": bound for joint, bound in self.torques.items()}
        numbers |= {f"speed of '{joint}'": bound for joint, bound in self.speeds.items()}
        for name, bound in numbers.items():
            if not bound >= 0.0:
                raise InputError(f"the bound on {name} is {bound}; it must not be negative")

    @classmethod
    def of_gait(
        cls,
        gait: Gait,
        penetration: float = 1e-3,
        drift: float = 1e-3,
        touchdown: float = 1e-5,
        pivot: float = SMALLEST_PIVOT,
    ) -> ContactBounds:
        """Take the friction and the limits of a gait; a simulated foot must push, however little.

        Args:
            gait: friction of its ground, torque and speed limits.
            penetration: depth that is tolerated, m; one millimetre is less than any floor is flat.
            drift: drift that is tolerated, m; a stance constraint without stabilisation drifts with the integrator.
            touchdown: distance of a landing foot from the ground that is tolerated, m; as much as ``amble.check`` does.
            pivot: smallest pivot under which the decoupling equations count as singular.
        """
        return cls(
            friction=gait.pattern.ground.friction,
            normal_force=0.0,
            penetration=penetration,
            drift=drift,
            touchdown=touchdown,
            pivot=pivot,
            torques=gait.limits.torques,
            speeds=gait.limits.speeds,
            motors=gait.limits.motors,
        )
