"""A gait file reads back exactly, and whatever is wrong with it is said in one sentence."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples.extending.phase_configuration import ConfigurationPhase

from amble.amounts import LARGEST_NUMBER
from amble.control.allocation import BoundedMinimumNorm, DropActuator, WeightedMinimumNorm
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.gait.files import content_hash, load_gait, save_gait
from amble.gait.impedance import Impedance
from amble.gait.linearising_law import InputOutputLinearisation
from amble.hybrid import HeightField, Plane
from amble.robot import catalogue
from amble.types import frozen
from tests.gait.example import random_gait
from tests.grounds import on_ground


def assert_same(left: Any, right: Any) -> None:
    """Compare two records field by field, numbers bit for bit."""
    assert type(left) is type(right)
    if isinstance(left, np.ndarray):
        assert left.shape == right.shape
        assert left.tobytes() == right.tobytes()
    elif isinstance(left, Mapping):
        assert list(left) == list(right)
        for key in left:
            assert_same(left[key], right[key])
    elif isinstance(left, tuple):
        assert len(left) == len(right)
        for one, other in zip(left, right, strict=True):
            assert_same(one, other)
    elif dataclasses.is_dataclass(left):
        for field in dataclasses.fields(left):
            assert_same(getattr(left, field.name), getattr(right, field.name))
    else:
        assert left == right


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    return save_gait(random_gait(), tmp_path / "gait.json")


LAWS = (
    DropActuator(("rl_hip_pitch", "rr_hip_pitch")),
    WeightedMinimumNorm({"fl_knee": 2.0, "rr_knee": 1.0 / 3.0}),
    BoundedMinimumNorm(0.1 + 0.2, 5.0),
)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("stabilised", [True, False])
def test_round_trip_is_exact(tmp_path: Path, seed: int, stabilised: bool) -> None:
    gait = random_gait(seed, LAWS[seed], stabilised)
    again = load_gait(save_gait(gait, tmp_path / "gait.json"))
    assert_same(gait, again)
    assert again.robot.hash == gait.robot.hash


def test_a_control_law_reads_back_and_is_part_of_the_content(tmp_path: Path) -> None:
    gait = random_gait(2)
    law = Impedance(stance_stiffness=80.0, swing_damping=0.5, stiffness={"D1 fl_knee": 1.0 / 3.0})
    under = replace(gait, control=law)
    path = save_gait(under, tmp_path / "gait.json")
    assert json.loads(path.read_text())["control_law"]["parameters"] == {
        "stance_stiffness": {"value": 80.0, "unit": "N m/rad"},
        "swing_damping": {"value": 0.5, "unit": "N m s/rad"},
        "stiffness": {"D1 fl_knee": {"value": 1.0 / 3.0, "unit": "N m/rad"}},
    }
    assert load_gait(path).control == law
    assert load_gait(path).gains == gait.gains
    assert content_hash(load_gait(path)) == content_hash(under) != content_hash(gait)
    own = replace(gait, control=InputOutputLinearisation(*gait.gains))
    assert content_hash(own) == content_hash(gait)
    with pytest.raises(InputError, match="has the gains of the gait"):
        save_gait(replace(gait, control=InputOutputLinearisation(1.0, 2.0)), path)


def test_ground_and_contact_are_in_the_file(tmp_path: Path) -> None:
    gait = on_ground(random_gait(1), Plane(slope=0.1, friction=0.7))
    path = save_gait(gait, tmp_path / "gait.json")
    tree = json.loads(path.read_text())
    assert tree["ground"]["parameters"] == {
        "friction": {"value": 0.7, "unit": "1"},
        "slope": {"value": 0.1, "unit": "rad"},
        "heading": {"value": 0.0, "unit": "rad"},
    }
    assert tree["contact"] == {"name": "point", "parameters": {}}
    assert load_gait(path).pattern == gait.pattern
    tree["ground"]["name"] = "moon"
    path.write_text(json.dumps(tree))
    with pytest.raises(UnknownNameError, match=r"unknown ground .*'moon'; known: plane"):
        load_gait(path)
    with pytest.raises(InputError, match="cannot be written to a file"):
        save_gait(on_ground(gait, HeightField(function=lambda x, y: 0.1 * x * y, symmetric=True)), path)


@pytest.mark.parametrize("seed", range(20))
def test_floats_of_any_bits_are_exact(tmp_path: Path, seed: int) -> None:
    """Subnormal, large, tiny and negative zero: sixty-four random bits, where they are a number of a gait."""
    gait, random = random_gait(), np.random.default_rng(seed)

    def drawn(array: np.ndarray) -> np.ndarray:
        bits = random.integers(0, 2**64, size=array.shape, dtype=np.uint64).view(np.float64)
        special = random.choice([-0.0, 5e-324, LARGEST_NUMBER, 0.1 + 0.2], size=array.shape)
        return frozen(np.where((np.abs(bits) <= LARGEST_NUMBER) & (random.random(array.shape) < 0.9), bits, special))

    fields = ("coefficients", "positions", "velocities", "accelerations", "torques", "forces", "impulse")
    domains = tuple(
        dataclasses.replace(domain, **{name: drawn(getattr(domain, name)) for name in fields})
        for domain in gait.domains
    )
    gait = dataclasses.replace(gait, domains=domains)
    assert_same(gait, load_gait(save_gait(gait, tmp_path / "gait.json")))


def test_the_file_is_strict_json_with_units(saved: Path) -> None:
    tree = json.loads(saved.read_text(), parse_constant=pytest.fail)
    assert tree["format_version"] == 3
    assert tree["speed"] == {"value": 0.2, "unit": "m/s"}
    assert tree["limits"]["torques"]["fl_knee"] == {"value": "inf", "unit": "N m"}
    assert tree["domains"]["D1"]["positions"]["units"][:4] == ["m", "m", "m", "rad"]


def test_arrays_of_a_loaded_gait_cannot_be_written(saved: Path) -> None:
    with pytest.raises(ValueError, match="read-only"):
        load_gait(saved).domains[0].positions[0, 0] = 1.0


def test_the_right_robot_is_accepted(saved: Path) -> None:
    assert load_gait(saved, catalogue.astro()).robot == catalogue.astro()


def test_another_robot_is_refused(saved: Path) -> None:
    with pytest.raises(InputError, match="gait of another robot"):
        load_gait(saved, catalogue.astro_cad())


def change(*path: str | int, to: Any = None) -> Callable[[Any], None]:
    """Make a function that changes one entry of the tree; None removes it."""

    def apply(tree: Any) -> None:
        for key in path[:-1]:
            tree = tree[key]
        if to is None:
            del tree[path[-1]]
        else:
            tree[path[-1]] = to

    return apply


WRONG = {
    "version 2": (change("format_version", to=2), "format version 2; amble 0.1.0 reads it"),
    "later version": (change("format_version", to=4), "format version 4; this release reads 3"),
    "version in words": (change("format_version", to="3"), "format version '3'; this release reads 3"),
    "format": (change("format", to="other"), "not a gait file"),
    "no version": (change("format_version"), "format version None"),
    "missing part": (change("solver"), "'solver' is missing"),
    "unknown part": (change("extra", to=1), "unknown key in gait file 'gait.json' 'extra'; known: versions"),
    "missing number": (change("domains", "D1", "duration"), "'duration' is missing"),
    "unknown number": (change("domains", "D1", "phase", to=1), "unknown key .* 'phase'"),
    "missing domain": (change("domains", "D2"), "'D2' is missing"),
    "unknown joint in limits": (
        change("limits", "speeds", "knee", to={}),
        "unknown joint .* 'knee'; known: fl_hip_yaw",
    ),
    "unknown coordinate": (change("outputs", "domains", "D1", 0, to="hip"), "unknown coordinate .* 'hip'; known: roll"),
    "repeated coordinate": (change("outputs", "domains", "D1", 0, to="fl_knee"), "repeat a coordinate"),
    "unknown foot": (change("pattern", "stances", 0, to=["fr", "xx"]), "unknown foot .* 'xx'; known: fl"),
    "stances": (change("pattern", "stances", 0, to="fr"), "stances\\[0\\] is not a list"),
    "unknown law": (change("allocation_law", "name", to="best"), "unknown allocation law .* 'best'"),
    "law parameters": (
        change("allocation_law", "parameters", to={"power": 2}),
        "unknown parameter of allocation law 'pinv' 'power'; known: none",
    ),
    "unit": (change("speed", "unit", to="km/h"), "unit 'km/h', not 'm/s'"),
    "columns": (
        change("domains", "D1", "positions", "units", 0, to="mm"),
        "the units 'mm, m, m, rad, .*, not 'm, m, m, rad",
    ),
    "text for a number": (change("speed", "value", to="fast"), "'fast', which is not a finite number"),
    "truth for a number": (change("speed", "value", to=True), "True, which is not a finite number"),
    "infinite speed": (change("speed", "value", to="inf"), "'inf', which is not a finite number"),
    "shape": (change("domains", "D1", "torques", "value", 0), "shape 6 x 12, not 7 x 12"),
    "ragged": (change("domains", "D1", "torques", "value", 0, 0), "rows of different lengths"),
    "count": (change("outputs", "order", to=4.5), "not a whole number"),
    "flag": (change("pattern", "mirrored", to="yes"), "not true or false"),
    "object": (change("robot", to=[1]), "is not an object"),
    "robot number": (change("robot", "links", 0, "mass", "value", to=10.0), "gait of another robot"),
    "robot hash": (change("robot", "hash", to="0"), "gait of another robot"),
    "parent that is none": (change("robot", "joints", 0, "parent", to=99), "moves link 1 on link 99"),
    "own parent": (change("robot", "joints", 0, "parent", to=1), "link 'fl_hip' .* is in a cycle"),
    "cycle": (change("robot", "joints", 0, "parent", to=3), "link 'fl_hip' .* is in a cycle"),
    "child twice": (change("robot", "joints", 0, "child", to=2), "is joint 1, but moves link 2"),
    "foot on no link": (change("robot", "feet", 0, "link", to=13), "is on link 13 of 13"),
    "link too many": (change("robot", "joints", 0), "has 13 links on 11 joints"),
    "robot twins": (change("robot", "twins", to=[["fl"]]), "twins\\[0\\] is not a list of 2"),
    "overlays": (change("robot", "overlays", "payload", to={"mass": 1}), "overlays, payload, mass is not an object"),
    "ground": (change("ground", "name", to="stairs"), "unknown ground .* 'stairs'; known: plane"),
    "friction": (change("ground", "parameters", "friction", "value", to=0.0), "the friction coefficient is 0"),
    "contact": (change("contact", "name", to="plate"), "unknown contact .* 'plate'; known: point"),
    "phase": (change("phase", "name", to="angle"), "unknown phase .* 'angle'; known: time"),
    "landing rule": (change("landing_rule", "name", to="any"), "unknown landing rule .* 'any'; known: one by one"),
    "control law": (change("control_law", "name", to="servo"), "unknown control law .*; known: .*input-output"),
    "parameters of the default law": (change("control_law", "parameters", to={}), "unknown key .* 'parameters'"),
    "no parameters": (change("control_law", "name", to="impedance"), "'parameters' is missing"),
    "mesh": (change("mesh", "intervals", "D1", to=4), "shape 7, not 9"),
    "one node": (change("mesh", "intervals", "D1", to=0), "D1 is 0; it must be from 1"),
    "feedback duration": (change("feedback", "durations", "D1", "value", to=0.0), "D1 is 0; it must be positive"),
    "no reference": (change("feedback", "references", "D1", "value", to=[[]] * 15), "shape 15 x 0, not 15 x any"),
    "huge integer": (change("speed", "value", to=10**300), "more than 40 digits"),
    "large integer": (change("outputs", "order", to=10**18), "it must be from 1 to"),
    "feedback": (change("feedback", "start", "value", to=[0.0]), "shape 1, not 36"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_entry_is_refused_in_one_sentence(saved: Path, name: str) -> None:
    damage, message = WRONG[name]
    tree = json.loads(saved.read_text())
    damage(tree)
    saved.write_text(json.dumps(tree))
    with pytest.raises(InputError, match=message) as caught:
        load_gait(saved)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("word", ["NaN", "Infinity"])
def test_what_is_not_json_is_refused(saved: Path, word: str) -> None:
    saved.write_text(saved.read_text().replace('"value": 0.2', f'"value": {word}'))
    with pytest.raises(InputError, match=f"holds {word}"):
        load_gait(saved)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_refused(saved: Path, share: float) -> None:
    data = saved.read_bytes()
    saved.write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError, match="is not JSON"):
        load_gait(saved)


def test_a_key_given_twice_is_refused(saved: Path) -> None:
    saved.write_text(saved.read_text().replace('"speed":', '"speed": 1, "speed":', 1))
    with pytest.raises(InputError, match="key 'speed' twice"):
        load_gait(saved)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: No such file"):
        load_gait(tmp_path / "none.json")


def test_a_binary_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "gait.json").write_bytes(b"\x80\xff\x00")
    with pytest.raises(InputError, match="is not text"):
        load_gait(tmp_path / "gait.json")


@pytest.mark.parametrize("stabilised", [True, False])
def test_a_phase_and_its_numbers_read_back(tmp_path: Path, stabilised: bool) -> None:
    gait = on_configuration(random_gait(3, stabilised=stabilised))
    again = load_gait(save_gait(gait, tmp_path / "gait.json"))
    assert again.outputs.phase == gait.outputs.phase
    for ours, theirs in zip(again.domains, gait.domains, strict=True):
        np.testing.assert_array_equal(ours.phase_numbers, theirs.phase_numbers)
    if stabilised:
        assert again.feedback is not None
        assert {name: tuple(value) for name, value in again.feedback.phase_numbers.items()} == NUMBERS


def test_time_has_no_numbers_in_a_file(tmp_path: Path) -> None:
    path = save_gait(random_gait(1), tmp_path / "gait.json")
    assert json.loads(path.read_text())["phase"] == {"name": "time", "parameters": {}}
    assert "phase_numbers" not in path.read_text()


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("phase", "name"), "sundial", "unknown phase .* 'sundial'"),
        (("phase", "parameters"), {"slope": 1.0}, "unknown parameter of phase 'configuration' 'slope'; known: coeff"),
        (("phase", "parameters"), {}, "phase 'configuration' needs the parameter 'coefficients'"),
        (("phase", "parameters"), [1.0], "phase, parameters is not an object"),
        (("domains", "D1", "phase_numbers", "value"), [0.1], "phase_numbers has the shape 1, not 2"),
        (("domains", "D1", "phase_numbers", "value"), [0.1, 0.1], "domain 'D1' is not finite with theta_start = 0.1"),
        (("feedback", "phase_numbers", "D2", "value"), [0.1, 0.1], "domain 'D2' is not finite with theta_start = 0.1"),
        (("feedback", "phase_numbers"), {}, "phase_numbers: 'D1' is missing"),
    ],
)
def test_a_wrong_phase_is_refused_in_one_sentence(
    tmp_path: Path, place: tuple[str, ...], value: object, message: str
) -> None:
    path = save_gait(on_configuration(random_gait(1, stabilised=True)), tmp_path / "gait.json")
    tree = json.loads(path.read_text())
    change(*place, to=value)(tree)
    path.write_text(json.dumps(tree))
    with pytest.raises(InputError, match=message):
        load_gait(path)


NUMBERS = {"D1": (0.1, -0.2), "D2": (0.3, 0.4)}


def on_configuration(gait: Gait) -> Gait:
    """The gait on a phase of the configuration, with numbers in every domain."""
    outputs = replace(gait.outputs, phase=ConfigurationPhase({"D1": {"y": -1.0}, "D2": {"x": 1.0, "pitch": 0.5}}))
    domains = tuple(replace(domain, phase_numbers=np.array(NUMBERS[domain.name])) for domain in gait.domains)
    numbers = {name: np.array(value) for name, value in NUMBERS.items()}
    feedback = None if gait.feedback is None else replace(gait.feedback, phase_numbers=numbers)
    return replace(gait, outputs=outputs, domains=domains, feedback=feedback)
