"""Axes of a library: ranges and steps, where the walk begins, what each value does to the specification."""

from __future__ import annotations

from pathlib import Path

import pytest

from amble.errors import InputError, UnknownNameError
from amble.hybrid import Plane
from amble.synthesis.specification import read_specification
from amble.workflow.library.axes import check_ends, label, read_library

SPEC = """
[robot]
name = "astro"
[gait]
name = "amble"
speed = "0.2 m/s"
[limits.base]
z = [0.33, 0.37]
{more}
[library.axes]
{axes}
"""


def written(folder: Path, axes: str, more: str = "") -> Path:
    path = folder / "spec.toml"
    path.write_text(SPEC.format(axes=axes, more=more), encoding="utf-8")
    return path


def test_values_and_first_point(tmp_path: Path) -> None:
    axes = 'height = { range = ["340 mm", "360 mm"], step = "10 mm" }\nspeed = { range = [0.1, 0.4], step = 0.1 }'
    library = read_library(written(tmp_path, axes))
    assert library.grid.names == ("height", "speed")  # in the order of the file
    assert library.grid.values == ((0.34, 0.35, 0.36), (0.1, 0.2, 0.3, 0.4))
    assert library.grid.first == (1, 1)  # the middle of z, and the speed that the specification names
    assert label({"height": 0.34, "speed": 0.1}) == label({"speed": 0.1, "height": 0.34}) == "speed_0.1-height_0.34"


def test_every_axis_changes_its_number_and_nothing_else(tmp_path: Path) -> None:
    axes = "\n".join(
        (
            "speed = { range = [0.2, 0.2], step = 0.1 }",
            'slope = { range = ["0 deg", "4 deg"], step = "2 deg" }',
            "friction = { range = [0.4, 0.6], step = 0.1 }",
            "height = { range = [0.34, 0.36], step = 0.01 }",
            'payload = { range = ["0 kg", "2 kg"], step = "1 kg" }',
        )
    )
    library = read_library(written(tmp_path, axes, "[ground]\nfriction = 0.5"))
    assert library.grid.first == (0, 0, 1, 1, 0)
    values = {"speed": 0.3, "slope": 0.05, "friction": 0.4, "height": 0.36, "payload": 1.5}
    plain, problem = library.problem(library.grid.at(library.grid.first)), library.problem(values)
    assert problem.speed == 0.3
    assert isinstance(problem.pattern.ground, Plane)
    assert problem.pattern.ground.slope == 0.05
    assert problem.pattern.ground.friction == 0.4
    assert problem.limits.positions["z"] == pytest.approx((0.34, 0.38))  # as wide as the specification's
    assert problem.pattern.robot.mass == pytest.approx(plain.pattern.robot.mass + 1.5)
    assert plain.pattern.robot.payload is None


def test_turns_take_the_gait_without_its_mirror(tmp_path: Path) -> None:
    library = read_library(written(tmp_path, "yaw_rate = { range = [-0.1, 0.1], step = 0.1 }"))
    assert library.problem({"yaw_rate": 0.0}).pattern.mirrored
    turning = library.problem({"yaw_rate": -0.1})
    assert turning.yaw_rate == -0.1
    assert not turning.pattern.mirrored


@pytest.mark.parametrize(
    ("axes", "expected"),
    [
        ("", "names no axis; known: speed, lateral_speed"),
        ("speed = { range = [0.1, 0.25], step = 0.1 }", "no whole number of steps"),
        ("speed = { range = [0.3, 0.1], step = 0.1 }", "lies above the upper end"),
        ("speed = { range = [0.1, 0.3], step = 0.0 }", "must be above 0"),
        ("speed = { range = [0.1, 0.3], step = -0.1 }", "must be above 0"),
        ("speed = { range = [0.1, 0.3], step = 1e-9 }", "too many"),
        ("speed = { range = [0.1, inf], step = 0.1 }", "not a finite number"),
        ('speed = { range = ["0.1 m", "0.3 m"], step = 0.1 }', "unknown unit"),
        ("speed = { range = [0.1, 0.3] }", "step' is missing"),
        ("speed = [0.1, 0.3]", "library.axes.speed"),
        (
            "speed = { range = [0.0, 0.4], step = 0.001 }\nfriction = { range = [0.1, 0.8], step = 0.001 }",
            "make 281101 gaits",
        ),
    ],
)
def test_axes_that_cannot_be(tmp_path: Path, axes: str, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        read_library(written(tmp_path, axes))


def test_an_axis_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="'colour'; known: speed, lateral_speed, yaw_rate, height"):
        read_library(written(tmp_path, "colour = { range = [0.1, 0.3], step = 0.1 }"))


def test_one_kind_of_file_is_not_taken_for_the_other(tmp_path: Path) -> None:
    path = written(tmp_path, "speed = { range = [0.1, 0.3], step = 0.1 }")
    with pytest.raises(InputError, match="amble library"):
        read_specification(path)
    path.write_text(path.read_text(encoding="utf-8").split("[library")[0], encoding="utf-8")
    with pytest.raises(InputError, match="amble synthesize"):
        read_library(path)


@pytest.mark.parametrize(
    ("axes", "sentence"),
    [
        ("friction = { range = [-0.1, 0.6], step = 0.1 }", "axis friction at -0.1: "),
        ("payload = { range = [-1.0, 1.0], step = 1.0 }", "axis payload at -1 kg: "),
        ("speed = { range = [0.2, 200.2], step = 100.0 }", "axis speed at 200.2 m/s: "),
    ],
)
def test_an_end_of_an_axis_that_no_gait_can_have_is_refused_before_any_is_made(
    tmp_path: Path, axes: str, sentence: str
) -> None:
    with pytest.raises(InputError) as refused:
        check_ends(read_library(written(tmp_path, axes)))
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(sentence)


def test_ends_that_gaits_can_have_pass(tmp_path: Path) -> None:
    check_ends(read_library(written(tmp_path, "friction = { range = [0.4, 0.6], step = 0.1 }")))
