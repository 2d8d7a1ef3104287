"""Limits check themselves."""

from __future__ import annotations

import math

import numpy as np
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
        ({"normal_force": 5.0, "standing_force": 4.0}, "of a foot that stays is 4"),
        ({"standing_force": math.nan}, "of a foot that stays is nan"),
        ({"standing_force": math.inf}, "of a foot that stays is inf"),
    ],
)
def test_bounds_without_room(changed: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        limits(**changed)


def test_the_bound_of_a_foot_that_leaves_falls_to_the_normal_force() -> None:
    progress = np.array([0.0, 0.25, 1.0])
    both = limits(normal_force=2.0, standing_force=10.0)
    np.testing.assert_allclose(both.least_normal_force(True, progress), [10.0, 8.0, 2.0])
    np.testing.assert_allclose(both.least_normal_force(False, progress), 10.0)
    np.testing.assert_allclose(limits(normal_force=2.0).least_normal_force(True, progress), 2.0)
