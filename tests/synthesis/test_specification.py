"""A specification describes a problem completely, or is refused in one sentence."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
from examples.extending.phase_configuration import ConfigurationPhase

from amble.control import TimePhase
from amble.errors import InputError, UnknownNameError
from amble.hybrid import POINT, Plane
from amble.io.quantities import UNITS, parse_quantity
from amble.robot import catalogue, load_robot, symmetrized
from amble.robot.mirror import AsymmetryError
from amble.synthesis import GaitProblem, gait_problem
from amble.synthesis.problem import INTERVALS
from amble.synthesis.specification import read_specification
from amble.synthesis.specified import problem_of
from tests.robots import path

SMALLEST = """
[robot]
name = "astro"
[gait]
name = "amble"
speed = 0.2
[limits]
clearance = 0.02
normal_force = 10
"""

OWN_ROBOT = """
[robot]
file = "robot.urdf"
feet = { fl = "fl_foot", rl = "rl_foot", fr = "fr_foot", rr = "rr_foot" }
[gait]
stances = [["fr", "rl"], ["fr", "rr"], ["fl", "rr"], ["fl", "rl"]]
mirrored = true
speed = "0.72 km/h"
[outputs]
order = 5
free = { D1 = ["rl_hip_pitch"] }
position_gain = "400 1/s^2"
velocity_gain = 40
[law]
name = "drop"
parameters = { joints = ["rl_hip_pitch", "rr_hip_pitch"] }
[ground]
friction = "50 %"
[limits]
clearance = "20 mm"
normal_force = "10 N"
duration = ["10 ms", 0.15]
durations = { D2 = [0.02, 0.05] }
torque = "50 N m"
torques = { fl_knee = 30 }
acceleration = 100
base = { z = [0.3, "90 cm"], yaw = ["-10 deg", "10 deg"] }
joints = { fl_knee = [1.0, 2.0] }
touchdown_velocity = { x = [-0.2, 0.3], y = ["-10 cm/s", 0.1], z = [-2, -0.06] }
[posture]
height = 0.3
[posture.angles]
"""


def problem(folder: Path, text: str) -> GaitProblem:
    (folder / "spec.toml").write_text(text)
    return problem_of(read_specification(folder / "spec.toml"), folder)


@pytest.fixture
def own_robot(tmp_path: Path) -> str:
    """Put a robot file beside the specification and complete the posture."""
    urdf = resources.files("amble.robot.catalogue") / "astro.urdf"
    (tmp_path / "robot.urdf").write_text(urdf.read_text())
    angles = catalogue.posture("astro").angles
    return OWN_ROBOT + "".join(f"{name} = {angle}\n" for name, angle in angles.items())


@pytest.mark.parametrize(("dimension", "unit"), [(d, u) for d, units in UNITS.items() for u in units])
def test_every_unit_is_read(dimension: str, unit: str) -> None:
    assert parse_quantity(f"-2.5e0 {unit}", dimension) == -2.5 * UNITS[dimension][unit]


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("180 deg", "angle", math.pi),
        ("3.6 km/h", "speed", 1.0),
        ("60 rpm", "angular speed", 2.0 * math.pi),
        ("5   N  m", "torque", 5.0),
        ("0.4m/s", "speed", 0.4),
        ("-1.5e-1rad", "angle", -0.15),
        ("2.rad/s^2", "acceleration", 2.0),
        ("10%", "ratio", 0.1),
        (7, "force", 7.0),
    ],
)
def test_units_are_right(text: str, dimension: str, value: float) -> None:
    assert parse_quantity(text, dimension) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "value",
    ["", "fast", "0.2", "0.2 ms", "0.2ms", "0.2e", "m/s", "x m/s", True, None, [1.0], math.nan, math.inf, "nan m/s"],
)
def test_what_is_not_a_quantity_is_refused(value: Any) -> None:
    with pytest.raises(ValueError, match=r"known: m/s|not a|begin with a number"):
        parse_quantity(value, "speed")


def test_the_catalogue_completes_a_short_specification(tmp_path: Path) -> None:
    found = problem(tmp_path, SMALLEST)
    bounds = catalogue.bounds("astro")
    assert found.pattern.name == "amble"
    assert found.law.name == "pinv"
    assert found.posture == catalogue.posture("astro")
    assert found.pattern.ground == Plane(friction=0.6)
    assert found.limits.durations == {"D1": bounds.duration, "D2": bounds.duration}
    assert found.limits.positions == bounds.positions
    assert set(found.limits.torques.values()) == {bounds.torque}


def test_a_file_may_be_named_from_the_users_folder(
    tmp_path: Path, own_robot: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    home, elsewhere = tmp_path / "home", tmp_path / "elsewhere"
    home.mkdir()
    elsewhere.mkdir()
    name = next(path.name for path in tmp_path.iterdir() if path.suffix == ".urdf")
    (tmp_path / name).rename(home / name)
    monkeypatch.setenv("HOME", str(home))
    assert problem(elsewhere, own_robot.replace(f'"{name}"', f'"~/{name}"')).pattern.robot.source == name
    with pytest.raises(InputError, match="home folder of nobody known here"):
        problem(elsewhere, own_robot.replace(f'"{name}"', f'"~nobody-of-this-name/{name}"'))


def test_a_long_specification_is_read_completely(tmp_path: Path, own_robot: str) -> None:
    found = problem(tmp_path, own_robot)
    limits = found.limits
    assert found.pattern.robot == catalogue.astro()
    assert found.pattern.mirrored
    assert found.speed == pytest.approx(0.2, rel=1e-15)
    assert found.gains == (400.0, 40.0)
    assert found.outputs.order == 5
    assert "rl_hip_pitch" not in found.outputs.of("D1").coordinates
    assert found.law.name == "drop"
    assert limits.durations == {"D1": (0.01, 0.15), "D2": (0.02, 0.05)}
    assert limits.torques["fl_knee"] == 30.0
    assert limits.torques["rl_knee"] == 50.0
    assert limits.speeds["rl_knee"] == 4.0  # the file's own
    assert limits.positions["fl_knee"] == (1.0, 2.0)
    assert limits.positions["rl_knee"] == catalogue.bounds("astro").positions["rl_knee"]  # as in ``gait_problem``
    assert limits.positions["z"] == (0.3, 0.9)
    assert limits.positions["yaw"] == (pytest.approx(-math.pi / 18), pytest.approx(math.pi / 18))
    assert limits.touchdown_velocity == ((-0.2, 0.3), (-0.1, 0.1), (-2.0, -0.06))
    assert found.pattern.ground.friction == 0.5


def test_a_slope_is_part_of_the_ground(tmp_path: Path) -> None:
    slope = '[ground]\nfriction = 0.8\nslope = "10 deg"\n'
    found = problem(tmp_path, SMALLEST + slope).pattern
    assert found.ground == Plane(friction=0.8, slope=math.radians(10.0))
    assert found.contact == POINT
    with pytest.raises(UnknownNameError, match="unknown ground 'moon'; known: plane"):
        problem(tmp_path, SMALLEST + '[ground]\nname = "moon"\n')
    with pytest.raises(UnknownNameError, match="unknown contact 'wheel'; known: point"):
        problem(tmp_path, SMALLEST + '[contact]\nname = "wheel"\n')
    with pytest.raises(InputError, match="takes no slope or heading"):
        problem(tmp_path, SMALLEST + '[ground]\nname = "moon"\nslope = 0.1\n')
    with pytest.raises(InputError, match="takes slope and heading, no parameters"):
        problem(tmp_path, SMALLEST + "[ground]\nparameters = { slope = 0.1 }\n")


UNKNOWN = {
    "section": ("[limits]", "[limit]\n[limits]", "unknown key in spec.toml 'limit'; known: robot, gait, limits"),
    "key": ("speed = 0.2", "speed = 0.2\nsped = 1", r"unknown key in \[gait\] of spec.toml 'sped'; known: speed, name"),
    "robot": ('"astro"', '"astra"', "unknown robot 'astra'; known: astro, astro_cad"),
    "gait": ('"amble"', '"ambel"', "unknown gait 'ambel'; known: amble, trot"),
    "law": ("[limits]", '[law]\nname = "best"\n[limits]', "unknown allocation law 'best'; known: pinv"),
    "domain": ("[limits]", "[limits]\ndurations = { D7 = [0, 1] }", "unknown domain 'D7'; known: D1, D2"),
    "joint": ("[limits]", "[limits]\ntorques = { knee = 1 }", "unknown joint 'knee'; known: fl_hip_yaw"),
    "free joint": (
        "[limits]",
        '[outputs]\nfree = { D1 = ["knee"] }\n[limits]',
        "unknown joint 'knee'; known: fl_hip_yaw",
    ),
    "free domain": (
        "[limits]",
        '[outputs]\nfree = { D7 = ["fl_knee"] }\n[limits]',
        "unknown domain 'D7'; known: D1, D2",
    ),
    "phase": (
        "[limits]",
        '[outputs]\nphase = { name = "sundial" }\n[limits]',
        "unknown phase 'sundial'; known: time",
    ),
    "foot": ('name = "amble"', 'stances = [["fx"], ["fl"]]', "unknown foot 'fx'; known: fl, rl, fr, rr"),
    "base": (
        "[limits]",
        "[limits]\nbase = { x = [0, 1] }",
        r"unknown key in \[limits.base\] of spec.toml 'x'; known: z",
    ),
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_unknown_names_are_refused_with_the_known_ones(tmp_path: Path, name: str) -> None:
    old, new, message = UNKNOWN[name]
    with pytest.raises(UnknownNameError, match=message):
        problem(tmp_path, SMALLEST.replace(old, new))


WRONG = {
    "unit": (
        "0.2",
        '"0.2 knots"',
        "'gait.speed': '0.2 knots' has unknown unit 'knots' for a quantity of speed; known: m/s",
    ),
    "nan": ("0.2", "nan", "'gait.speed': nan is not a finite number"),
    "inf": ("normal_force = 10", "normal_force = inf", "'limits.normal_force': inf is not a finite number"),
    "missing section": ("[gait]", "[robot.gait]", r"spec.toml lacks \[gait\] name or stances .*; \[gait\] speed$"),
    "everything missing": (
        SMALLEST,
        "[robot]\nfile = 'a.urdf'",
        r"\[robot\] feet .*; \[gait\] name .*; .* speed$",
    ),
    "tolerance": ('name = "astro"', 'name = "astro"\nsymmetrize = true', "takes no symmetrize"),
    "kind": ('"amble"', "7", "'gait.name': input should be a valid string"),
    "order as text": (
        "[limits]",
        '[outputs]\norder = "4"\n[limits]',
        "'outputs.order': input should be a valid integer",
    ),
    "order above what is compiled": ("[limits]", "[outputs]\norder = 15\n[limits]", "less than or equal to 14"),
    "order below what meets both ends": ("[limits]", "[outputs]\norder = 2\n[limits]", "greater than or equal to 3"),
    "endless order": ("[limits]", f"[outputs]\norder = {10**30}\n[limits]", "'outputs.order': input should be less"),
    "scheme": (
        "[limits]",
        '[solver]\nscheme = "radau"\n[limits]',
        "unknown collocation scheme 'radau'; known: hermite-",
    ),
    "endless mesh": ("[limits]", f"[solver]\nintervals = {10**9}\n[limits]", "'solver.intervals': input should be"),
    "line break in a key": ("[limits]", '[limits]\n"a\\nb" = 1', r"unknown key in \[limits\] .* 'a\\nb'"),
    "line break in a name": ("[limits]", '[limits]\njoints = { "a\\nb" = 1 }', r"'limits.joints.a\\nb'"),
    "reversed": ("[limits]", "[limits]\nduration = [2, 1]", "the lower end 2 lies above the upper end 1"),
    "one end": ("[limits]", "[limits]\nduration = [2]", "'limits.duration': .* at least 2 items"),
    "two robots": ('name = "astro"', 'name = "astro"\nfile = "a.urdf"', "either the name .* or a file"),
    "feet of a known robot": ('name = "astro"', 'name = "astro"\nfeet = { fl = "a" }', "takes no feet"),
    "no robot": ('name = "astro"', "", r"lacks \[robot\] name .* or file"),
    "no feet": ('name = "astro"', 'file = "a.urdf"', r"lacks \[robot\] feet"),
    "no gait": ('name = "amble"', "", r"lacks \[gait\] name or stances"),
    "mirrored": ('name = "amble"', 'name = "amble"\nmirrored = true', "takes no 'mirrored'"),
    "posture": (
        "[limits]",
        "[posture]\nheight = 1\nangles = { fl_knee = 1 }\n[limits]",
        "lacks the angle of fl_hip_yaw",
    ),
    "speed": ("0.2", "1e9", "speed"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_does_not_fit_is_refused_in_one_sentence(tmp_path: Path, name: str) -> None:
    old, new, message = WRONG[name]
    with pytest.raises(InputError, match=message) as caught:
        problem(tmp_path, SMALLEST.replace(old, new))
    assert "\n" not in str(caught.value)


GO2 = """
[robot]
file = "{file}"
feet = {{ fl = "FL_foot", fr = "FR_foot", rl = "RL_foot", rr = "RR_foot" }}
[gait]
name = "trot"
speed = 0.5
"""


def test_a_robot_of_a_file_has_the_defaults_of_python(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """The file asked for bounds, durations and posture one after the other, and knew no nearly symmetric robot."""
    go2 = GO2.format(file=path("go2"))
    found = problem(tmp_path, go2)
    assert "left and right are averaged" in caplog.text
    asked = load_robot(path("go2"), {"fl": "FL_foot", "fr": "FR_foot", "rl": "RL_foot", "rr": "RR_foot"})
    assert found == gait_problem(asked, "trot", speed=0.5)
    assert found.pattern.robot == symmetrized(asked)
    assert found == problem(tmp_path, go2.replace("[gait]", "symmetrize = true\n[gait]"))
    with pytest.raises(AsymmetryError, match=r"symmetrize = true in \[robot\], --symmetrize, or amble\.symmetrized"):
        problem(tmp_path, go2.replace("[gait]", "symmetrize = false\n[gait]"))
    tolerant = problem(tmp_path, go2.replace("[gait]", "symmetry_tolerance = '1 %'\n[gait]"))
    assert tolerant.pattern.robot == replace(asked, symmetry_tolerance=0.01)


def test_what_the_file_gives_takes_the_place_of_a_default(tmp_path: Path) -> None:
    go2 = GO2.format(file=path("go2"))
    limits = problem(tmp_path, go2).limits
    some = "[limits]\nduration = [0.1, 0.2]\nspeed = 9\ntorques = { FL_calf_joint = 8 }\nbase = { z = [0.2, 0.4] }\n"
    given = problem(tmp_path, go2 + some + "node_margins = false\n")
    assert limits.acceleration == given.limits.acceleration
    assert not given.node_margins
    assert given.limits == replace(
        limits,
        durations={"D1": (0.1, 0.2)},
        speeds=dict.fromkeys(limits.speeds, 9.0),
        torques={**limits.torques, "FL_calf_joint": 8.0},
        positions={**limits.positions, "z": (0.2, 0.4)},
    )
    assert limits.standing_force is not None  # 10 % of the weight
    for lines, standing in (("standing_force = 30", 30.0), ("normal_force = 5", limits.standing_force)):
        assert problem(tmp_path, f"{go2}[limits]\n{lines}\n").limits.standing_force == standing
    assert problem(tmp_path, go2 + "[limits]\nnormal_force = 40\n").limits.standing_force == 40.0  # more than 10 %


@pytest.mark.parametrize(
    ("gait", "default"),
    [
        ('name = "trot"', "one by one"),
        ('name = "bound"', "simultaneous"),
        ('stances = [["fl", "rr"], ["fr", "rl"]]', "one by one"),
    ],
)
def test_the_landing_rule_is_a_key_of_the_gait(tmp_path: Path, gait: str, default: str) -> None:
    def rule(text: str) -> str:
        path = tmp_path / "gait.toml"
        path.write_text(SMALLEST.replace('name = "amble"', gait + text), encoding="utf-8")
        return problem_of(read_specification(path)).pattern.landing_rule

    assert rule("") == default
    for known in ("one by one", "simultaneous"):
        assert rule(f'\nlanding_rule = "{known}"') == known
    with pytest.raises(UnknownNameError, match="unknown landing rule 'any'; known: one by one, simultaneous"):
        rule('\nlanding_rule = "any"')


@pytest.mark.parametrize("text", ["[robot", "a = nope", '[robot]\nname = "a"\nname = "b"'])
def test_what_is_not_toml_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(tomllib.TOMLDecodeError):
        tomllib.loads(text)
    with pytest.raises(InputError, match="is not TOML"):
        problem(tmp_path, text)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read_specification(tmp_path / "none.toml")


def test_a_phase_is_named_with_its_parameters(tmp_path: Path) -> None:
    coefficients = "{ D1 = { y = -1.0, roll = 0.5 } }"
    section = f'[outputs.phase]\nname = "configuration"\nparameters = {{ coefficients = {coefficients} }}\n[limits]'
    found = problem(tmp_path, SMALLEST.replace("[limits]", section)).outputs.phase
    assert found == ConfigurationPhase({"D1": {"y": -1.0, "roll": 0.5}})
    assert problem(tmp_path, SMALLEST).outputs.phase == TimePhase()


FOOTFALLS = """
[robot]
name = "astro"
[gait]
speed = 0.1
mirrored = true
[gait.footfalls]
"""


def test_duty_factors_are_a_way_to_write_a_table(tmp_path: Path) -> None:
    falls = "".join(
        f"{foot} = {{ phase = {0.25 * place}, duty = 0.875 }}\n" for place, foot in enumerate(("rl", "fl", "rr", "fr"))
    )
    found = problem(tmp_path, FOOTFALLS + falls)
    crawl = problem(tmp_path, '[robot]\nname = "astro"\n[gait]\nspeed = 0.1\nname = "crawl"\n')
    assert found.pattern.stances == crawl.pattern.stances
    assert found.outputs == crawl.outputs
    with pytest.raises(InputError, match=r"unknown foot 'hind'"):
        problem(tmp_path, FOOTFALLS + falls.replace("rl", "hind"))
    with pytest.raises(InputError, match=r"duty factor of a footfall is 1\.5"):
        problem(tmp_path, FOOTFALLS + falls.replace("0.875", "1.5"))
    with pytest.raises(InputError, match=r"one of name, stances \(a table\) and footfalls"):
        problem(tmp_path, FOOTFALLS.replace("mirrored = true", 'name = "trot"') + falls)


def test_a_scheme_has_its_intervals_where_none_are_asked_for(tmp_path: Path) -> None:
    asked = problem(tmp_path, SMALLEST + '[solver]\nscheme = "lobatto-7"\nintervals = 3\n')
    assert (asked.scheme, asked.intervals) == ("lobatto-7", 3)
    default = problem(tmp_path, SMALLEST + '[solver]\nscheme = "lobatto-5"\n')
    assert (default.scheme, default.intervals) == ("lobatto-5", INTERVALS["lobatto-5"])
    assert problem(tmp_path, SMALLEST).intervals == INTERVALS["hermite-simpson"] == 15
