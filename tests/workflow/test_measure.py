"""What a report needs of a gait and its trace, also where one of the paper's methods does not apply."""

from __future__ import annotations

import json
from dataclasses import replace
from math import inf
from pathlib import Path

import pytest

from amble.control import PseudoInverse
from amble.errors import FallError, InputError
from amble.gait import Gait
from amble.gait.files import save_gait
from amble.progress import ProgressReport
from amble.report.run import run_files
from amble.simulation import Trace, save_trace
from amble.workflow import measure, rewrite_report
from tests.synthetic import THREE, synthetic_gait, synthetic_trace, three_footed_gait


def without_torque_limits() -> Gait:
    gait = replace(synthetic_gait(), law=PseudoInverse())
    robot = gait.robot
    robot = replace(robot, joints=tuple(replace(joint, effort=inf) for joint in robot.joints))
    return replace(gait, pattern=replace(gait.pattern, robot=robot), limits=replace(gait.limits, torques={}))


CASES = {
    "three feet": (three_footed_gait, THREE, "Left out: drop"),
    "no torque limits": (without_torque_limits, None, "Left out: peak"),
}


def case(name: str) -> tuple[Gait, Trace, str]:
    build, stances, sentence = CASES[name]
    return build(), synthetic_trace(3) if stances is None else synthetic_trace(3, stances=stances), sentence


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("name", CASES)
def test_any_gait_has_a_report(name: str, tmp_path: Path) -> None:
    gait, trace, sentence = case(name)
    save_gait(gait, tmp_path / "gait.json")
    save_trace(trace, tmp_path / "trace.nc", {})
    told: list[ProgressReport] = []
    report = rewrite_report(tmp_path, progress=told.append)
    written = {each.file for each in told if each.file is not None}
    assert written <= set(run_files(tmp_path))
    page = (tmp_path / "report.md").read_text()
    assert sentence in page
    results = json.loads((tmp_path / "results.json").read_text())
    methods = results["methods_datasheet"]  # the paper's own actuator is the paper's gait's
    assert ("reduction_datasheet" in results) == ("drop" in methods) == (name != "three feet")
    assert set(results["allocation"]) == {entry.law for entry in report.comparison.metrics} | set(results["allocation"])
    assert methods["pinv"]["simulated"]["rms_torque"] > 0.0


def test_a_motion_without_a_whole_cycle_is_an_error() -> None:
    with pytest.raises(FallError, match="no whole cycle"):
        measure(synthetic_gait(), replace(synthetic_trace(1), cycles=0, ended="the motion fell"), {}, {})


@pytest.mark.parametrize("content", [b"\x80\xff", b"[1, 2]", b"{"])
def test_earlier_results_that_cannot_be_used_are_refused(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "results.json").write_bytes(content)
    with pytest.raises(InputError, match=r"results file '.*results.json'"):
        rewrite_report(tmp_path)


@pytest.mark.parametrize("name", ["report.md", "results.json", "figures"])
def test_a_link_in_the_place_of_a_report_is_not_followed(name: str, tmp_path: Path) -> None:
    folder, outside = tmp_path / "run", tmp_path / "outside"
    outside.mkdir()
    folder.mkdir()
    (folder / name).symlink_to(outside if name == "figures" else outside / "victim")
    with pytest.raises(InputError, match="leads out of it"):
        rewrite_report(folder)
    with pytest.raises(InputError, match="leads out of it"):
        rewrite_report(outside, folder)
    assert not list(outside.iterdir())
