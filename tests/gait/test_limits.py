"""Limits check themselves."""

from __future__ import annotations

import math

import pytest

from amble.errors import InputError
from amble.gait import Limits


def limits(**changed: object) -> Limits:
    given: dict[str, object] = {
        "durations": {"D1": (0.1, 0.2)},
        "positions": {"z": (0.3, math.inf), "yaw": (0.0, 0.0)},
        "speeds": {"knee": math.inf},
        "torques": {"knee": 50.0},
        "acceleration": 100.0,
        "touchdown_velocity": ((-0.1, 0.1), (-0.1, 0.1), (-math.inf, 0.0)),
        "normal_force": 0.0,
        "clearance": 0.0,
    }
    return Limits(**{**given, **changed})  # type: ignore[arg-type]


def test_open_and_pinned_bounds_are_fine() -> None:
    assert limits().positions["yaw"] == (0.0, 0.0)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"durations": {"D1": (0.2, 0.1)}}, "duration of D1 is bounded by 0.2 to 0.1"),
        ({"durations": {"D1": (0.0, 0.1)}}, "shortest duration of D1 is 0"),
        ({"positions": {"z": (1.0, 0.0)}}, "position of z is bounded by 1 to 0"),
        ({"positions": {"z": (math.nan, 1.0)}}, "position of z is bounded by nan to 1"),
        ({"torques": {"knee": -1.0}}, "largest torque of knee is -1"),
        ({"speeds": {"knee": math.nan}}, "largest speed of knee is nan"),
        ({"acceleration": 0.0}, "largest acceleration is 0"),
        ({"touchdown_velocity": ((0.0, 1.0), (0.0, 1.0), (0.0, -1.0))}, "touchdown velocity along z is bounded by 0"),
        ({"clearance": -0.1}, "least clearance is -0.1"),
        ({"normal_force": math.inf}, "least normal force is inf"),
    ],
)
def test_bounds_without_room(changed: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        limits(**changed)
