"""Which laws are compared on a gait: those that apply, and why the others do not."""

from __future__ import annotations

import json
from dataclasses import replace
from math import inf

import pytest

from amble.analysis import compare, compare_laws, every_law, paper_laws, samples_of_gait
from amble.analysis.laws import labelled
from amble.control import BoundedMinimumNorm, MinimumPeak, MinimumPower, PseudoInverse
from amble.control.actuator import ACTUATORS, DATASHEET, PAPER, Actuator
from amble.control.allocation import law_from
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from tests.synthetic import three_footed_gait

OWN = Actuator("own", 0.1, 0.2, 9.0, "a test")


def without_torque_limits(gait: Gait) -> Gait:
    """The gait on the same robot from a file that says nothing of effort."""
    robot = gait.robot
    free = replace(robot, joints=tuple(replace(joint, effort=inf) for joint in robot.joints))
    return replace(gait, pattern=replace(gait.pattern, robot=free), limits=replace(gait.limits, torques={}))


def test_every_law_applies_to_the_paper_s_gait(stabilised_gait: Gait) -> None:
    chosen = every_law(stabilised_gait)
    assert list(chosen.laws) == ["drop", "pinv", "power (paper)", "power (datasheet)", "peak", "bounded"]
    assert chosen.notes == ()


def test_a_robot_without_torque_limits_is_compared_by_what_needs_none(stabilised_gait: Gait) -> None:
    gait = without_torque_limits(stabilised_gait)
    chosen = every_law(gait)
    assert list(chosen.laws) == ["drop", "pinv", "power (paper)", "power (datasheet)"]
    assert list(chosen.omitted) == ["peak", "bounded"]
    assert "has no torque limit" in chosen.notes[0]
    found = compare_laws(gait)
    assert found.laws == tuple(chosen.laws)
    assert all(entry.limits is not None and entry.limits.peak_relative_torque == 0.0 for entry in found.metrics)
    with pytest.raises(InputError, match="has no torque limit"):
        compare_laws(gait, {"peak": MinimumPeak()})


def test_a_stance_of_three_feet_is_compared_without_the_dropped_actuator() -> None:
    gait = three_footed_gait()
    chosen = every_law(gait)
    assert "drop" not in chosen.laws
    assert list(chosen.omitted) == ["drop"]
    assert "with 3 feet" in chosen.omitted["drop"]
    assert list(paper_laws(gait).laws) == ["pinv"]
    found = compare_laws(gait, paper_laws(gait).laws)
    assert {entry.law for entry in found.metrics} == {"pinv"}


def test_laws_of_one_name_are_told_apart() -> None:
    laws = [MinimumPower("paper"), MinimumPower(OWN), BoundedMinimumNorm()]
    assert list(labelled(laws)) == ["power (paper)", "power (own)", "bounded"]


def test_no_law_is_an_error(stabilised_gait: Gait) -> None:
    samples = samples_of_gait(stabilised_gait)
    with pytest.raises(InputError, match="no allocation law"):
        compare([samples], {}, [ACTUATORS["paper"]])
    with pytest.raises(InputError, match="no allocation law"):
        compare_laws(stabilised_gait, {})
    with pytest.raises(InputError, match="no allocation law"):
        compare_laws(stabilised_gait, [])


def test_a_comparison_prints_its_numbers(stabilised_gait: Gait) -> None:
    found = compare_laws(stabilised_gait, [PseudoInverse()])
    lines = str(found).splitlines()
    assert lines[0].split()[:4] == ["motion", "law", "actuator", "CoT"]
    assert len(lines) == 1 + 2  # actuator models
    assert lines[1].split()[:3] == ["nominal", "pinv", "paper"]
    assert float(lines[1].split()[3]) == pytest.approx(found.of("pinv", "nominal", "paper").cot, rel=1e-3)


def test_least_power_takes_any_actuator_model() -> None:
    assert MinimumPower(PAPER) == MinimumPower("paper") == MinimumPower()
    assert hash(MinimumPower(PAPER)) == hash(MinimumPower("paper"))
    assert MinimumPower(DATASHEET).parameters == {"actuator": "datasheet"}
    own = MinimumPower(OWN)
    fields = {"name": "own", "torque_constant": 0.1, "resistance": 0.2, "gear_ratio": 9.0, "source": "a test"}
    assert own.parameters == {"actuator": fields}  # as files had it before joints could have motors of their own
    several = MinimumPower(replace(OWN, joints={"fl_knee": PAPER}))
    assert {several: 1}[MinimumPower(several.parameters["actuator"])] == 1
    for law in (own, several):
        assert law_from(law.name, json.loads(json.dumps(law.parameters))) == law
    with pytest.raises(UnknownNameError, match="known: paper, datasheet"):
        MinimumPower("none")
    with pytest.raises(InputError, match="is no actuator model"):
        MinimumPower({"name": "own"})
