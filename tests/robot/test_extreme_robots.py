"""What is computed of a robot is a number or one sentence, without a warning, whatever allowed numbers it has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from amble.errors import InputError
from amble.hybrid import gait_pattern
from amble.robot import Robot
from amble.robot.catalogue import Posture
from amble.robot.natural_units import natural_units, velocity_unit
from amble.robot.plausibility import asymmetry, doubts, physical_rows
from amble.robot.proposal import standing_posture
from amble.robot.symmetry import symmetrized
from amble.synthesis.default_limits import default_limits
from amble.types import frozen
from amble.verification.residuals import sizes
from amble.view.shapes import link_shapes
from fuzz.robots import biped
from tests.seeds import seeds

STRAIGHT = dict.fromkeys(biped().joint_names, 0.0)
SIZES = (0.0, 5e-324, 1e-160, 1e-20, 1e-9, 1.0, 1e6, 1e12)

COMPUTED: dict[str, Callable[[Robot], object]] = {
    "rows": lambda robot: physical_rows(robot, mirrored=True),
    "mirror": lambda robot: robot.mirror,
    "doubts": doubts,
    "asymmetry": asymmetry,
    "average": symmetrized,
    "posture": standing_posture,
    "units": lambda robot: natural_units(robot, robot.leg_length),
    "velocity": velocity_unit,
    "sizes": sizes,
    "limits": lambda robot: default_limits(gait_pattern(robot, [["l"], ["r"]]), Posture(0.5, STRAIGHT)),
    "shapes": link_shapes,
}


def drawn(random: np.random.Generator) -> Robot:
    """A biped with some of its numbers very small or very large, left and right alike or not."""
    robot, both = biped(), bool(random.integers(2))

    def changed(part: Any, field: str) -> Any:
        value = np.array(getattr(part, field), dtype=np.float64)
        factor = SIZES[random.integers(len(SIZES))]
        value = np.clip(value * factor, -1e12, 1e12)
        return replace(part, **{field: float(value) if value.ndim == 0 else frozen(value)})

    for _ in range(random.integers(1, 4)):
        kind, field = (("links", "mass"), ("links", "center"), ("links", "inertia"), ("joints", "translation"))[
            random.integers(4)
        ]
        if random.random() < 0.2:
            kind, field = "feet", "offset"
        state = random.bit_generator.state
        parts = list(getattr(robot, kind))
        half = len(parts) // 2
        for number in range(len(parts)) if random.random() < 0.3 else (random.integers(half), len(parts) - 1):
            if both:
                random.bit_generator.state = state  # the same factor on both sides
            parts[number] = changed(parts[number], field)
        random.random(7)
        robot = replace(robot, **{kind: tuple(parts)})
    gravity = float(random.choice([5e-324, 1e-160, 9.81, 1e12]))
    return replace(robot, gravity=gravity, symmetry_tolerance=float(random.choice([1e-9, 1e300])))


@pytest.mark.parametrize("seed", seeds(3, 40))
def test_a_robot_of_extreme_numbers_is_a_number_or_a_sentence(seed: int) -> None:
    random = np.random.default_rng(seed)
    for _ in range(6):
        robot = drawn(random)
        for name, compute in COMPUTED.items():
            try:
                compute(robot)
            except InputError as error:
                said = str(error)
            else:
                said = name
            assert said.isprintable()


def test_a_robot_whose_legs_have_no_length_is_a_sentence() -> None:
    """Everything in one point: deviations of feet were divided by the length of the legs."""
    robot, nothing = biped(), frozen(np.zeros(3))
    joints = tuple(replace(joint, translation=nothing) for joint in robot.joints)
    robot = replace(robot, joints=joints, feet=tuple(replace(foot, offset=nothing) for foot in robot.feet))
    for name, compute in COMPUTED.items():
        if name in ("doubts", "shapes", "asymmetry"):
            compute(robot)
        else:
            with pytest.raises(InputError, match=r"length|one point"):
                compute(robot)
