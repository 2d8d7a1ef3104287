"""Commands on a gait file: a stabilised amble of ASTRo that ``amble reproduce`` wrote."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.cli.checking import read
from amble.errors import InputError
from amble.gait.files import load_gait, save_gait
from amble.robot import Adaptation, load_robot, symmetrized
from amble.simulation import load_trace
from amble.types import frozen
from tests.cli.run import exit_code
from tests.robots import path as urdf

GAIT = Path(__file__).parents[1] / "data" / "stabilised-amble.json"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a gait and the trace of three cycles."""
    place = tmp_path_factory.mktemp("run")
    (place / "gait.json").write_bytes(GAIT.read_bytes())
    assert exit_code("simulate", str(GAIT), "--cycles", "3", "--out", str(place / "trace.nc")) == 0
    return place


def test_simulate_writes_a_trace_and_tells_of_the_contacts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "trace.nc"
    assert exit_code("simulate", str(GAIT), "--cycles", "2", "--perturb", "1e-4", "--seed", "3", "--out", str(out)) == 0
    said = capsys.readouterr().out
    assert "2 cycles" in said
    assert f"wrote {out}" in said
    assert "smallest normal force of a stance foot" in said
    trace = load_trace(out)
    assert trace.completed
    assert trace.cycles == 2
    again = tmp_path / "again.nc"
    assert (
        exit_code("simulate", str(GAIT), "--cycles", "2", "--perturb", "1e-4", "--seed", "3", "--out", str(again)) == 0
    )
    assert np.array_equal(load_trace(again).state, trace.state)


def test_a_fall_exits_1_with_the_trace(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "trace.nc"
    # half a radian and half a metre a second on every state is no start to walk from
    assert exit_code("simulate", str(GAIT), "--cycles", "5", "--perturb", "0.5", "--out", str(out)) == 1
    captured = capsys.readouterr()
    assert captured.err.splitlines()[-1].startswith("error: the motion")
    assert not load_trace(out).completed


@pytest.mark.slow
def test_another_law_walks_the_same_motion(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "drop.nc"
    assert exit_code("simulate", str(GAIT), "--cycles", "3", "--law", "drop", "--out", str(out)) == 0
    dropped, least = load_trace(out), load_trace(folder / "trace.nc")
    # the laws share the motion (docs/theory/allocation.md, eq. 6) up to the integrator's error, tolerance 1e-8
    np.testing.assert_allclose(dropped.state, least.state, atol=1e-5)
    assert np.abs(dropped.signals["torque"] - least.signals["torque"]).max() > 1.0


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("best", "unknown allocation law 'best'; known: pinv, drop"),
        ("drop:joints=[fl_hip]", "is not JSON"),
        ("pinv:power", "'power' is not key=value"),
        ("power:actuator=none", "unknown actuator 'none'; known: paper, datasheet"),
    ],
)
def test_a_wrong_law_exits_2(law: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("simulate", str(GAIT), "--law", law, "--out", str(tmp_path / "trace.nc")) == 2
    error = capsys.readouterr().err
    assert any(part in error for part in message.split("|")), error
    assert not list(tmp_path.iterdir())


def test_compare_tabulates_both_motions(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, figure = tmp_path / "comparison.json", tmp_path / "torques"
    words = ["--law", "drop", "--law", "pinv", "--law", "power:actuator=datasheet"]
    where = ["--trace", str(folder / "trace.nc"), "--out", str(out), "--figure", str(figure)]
    assert exit_code("compare", str(GAIT), *words, *where) == 0
    said = capsys.readouterr().out
    assert "along the nominal motion" in said
    assert "along the simulated motion" in said
    numbers = json.loads(out.read_text())["allocation"]
    assert list(numbers) == ["drop", "pinv", "power"]
    for motion in ("nominal", "simulated"):
        assert numbers["pinv"][motion]["rms_torque"] < numbers["drop"][motion]["rms_torque"]
        assert numbers["power"][motion]["cot"]["datasheet"] < numbers["pinv"][motion]["cot"]["datasheet"]
    assert figure.with_suffix(".png").stat().st_size > 10_000


def test_compare_tabulates_every_law_by_default(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("compare", str(GAIT)) == 0
    said = capsys.readouterr().out
    for law in ("drop", "pinv", "power", "peak", "bounded"):
        assert law in said


@pytest.mark.usefixtures("unrendered")
def test_report_fills_a_folder_and_keeps_what_is_known_of_stability(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_code("report", str(folder)) == 0
    assert "the paper's Table 1 beside ours" in capsys.readouterr().out
    results = json.loads((folder / "results.json").read_text())
    assert results["cycles"] == 3
    assert "spectral_radius" not in results
    stability = {
        "spectral_radius": {"initial": 11.4, "stabilized": 0.12, "error": 1e-3},
        "stabilization": {"steps": 2},
        "multipliers": {"initial": [[-11.4, 0.0]], "stabilized": [[0.0, 0.12], [0.0, -0.12]]},
        "section_error": 1e-9,
        "section_distances": [1e-3, 1e-4, 1e-5],
        "perturbed": {"size": 1e-3, "cycles": 2, "sound_from_cycle": 0, "before_sound": None},
    }
    (folder / "results.json").write_text(json.dumps({**results, **stability}))
    assert exit_code("report", str(folder)) == 0
    again = json.loads((folder / "results.json").read_text())
    assert {key: again[key] for key in stability} == stability
    figures = {path.name for path in (folder / "figures").iterdir()}
    assert {"torques.png", "torques.pdf", "multipliers.png", "section_distance.pdf"} <= figures
    page = (folder / "report.md").read_text()
    assert re.search(r"spectral radius before stabilisation +\| +11\.40 \|", page)
    assert re.search(r"contacts sound from cycle +\| +0 \|", page)


@pytest.mark.parametrize("text", ['{"spectral_radius": {"stabilized": 0.12}}', '{"perturbed": {"size": 1e-3}}'])
def test_report_refuses_stability_that_is_not_complete(
    text: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    header = {"format": "amble results", "format_version": 1}
    (folder / "results.json").write_text(json.dumps({**header, **json.loads(text)}))
    assert exit_code("report", str(folder)) == 2
    assert "stability entries" in capsys.readouterr().err
    (folder / "results.json").unlink()


def test_export_writes_the_controller(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "controller"
    assert exit_code("export", str(GAIT), "--law", "pinv", "-o", str(out)) == 0
    said = capsys.readouterr().out.splitlines()
    assert {Path(line.removeprefix("wrote ")) for line in said} == set(out.iterdir())
    assert (out / "amble_controller.h").exists()


def test_a_gait_of_another_robot_exits_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tree = json.loads(GAIT.read_text())
    tree["robot"]["links"][0]["mass"]["value"] *= 1.01
    (tmp_path / "gait.json").write_text(json.dumps(tree))
    assert exit_code("simulate", str(tmp_path / "gait.json"), "--out", str(tmp_path / "trace.nc")) == 2
    assert "gait of another robot" in capsys.readouterr().err


def test_a_changed_coefficient_fails_the_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tree = json.loads(GAIT.read_text())
    tree["domains"]["D1"]["coefficients"]["value"][2][1] *= 1.01
    (tmp_path / "gait.json").write_text(json.dumps(tree))
    assert exit_code("check", str(tmp_path / "gait.json")) == 1
    captured = capsys.readouterr()
    assert "D1 output fl_knee" in captured.out
    assert "(violated by" in captured.out
    assert "the gait does not hold" in captured.err


def test_what_a_urdf_does_not_say_is_the_gaits(tmp_path: Path) -> None:
    gait = load_gait(GAIT)
    robot = replace(gait.robot, gravity=9.8, twins=gait.robot.twins[::-1], symmetry_tolerance=1e-6)
    path = save_gait(replace(gait, pattern=replace(gait.pattern, robot=robot)), tmp_path / "gait.json")
    assert read(path, urdf("astro")).robot == robot
    with pytest.raises(InputError, match="gait of another robot"):
        read(path, urdf("astro_cad"))


def test_a_gait_may_be_that_of_the_files_robot_symmetrized(tmp_path: Path) -> None:
    """Every gait of a symmetrized robot was refused as that of another robot."""
    gait = load_gait(GAIT)
    file = tmp_path / "uneven.urdf"
    file.write_text(urdf("astro").read_text().replace('<mass value="1.18"/>', '<mass value="1.19"/>', 1))
    uneven = load_robot(file, {foot.name: foot.frame for foot in gait.robot.feet}, name="astro")
    for robot in (uneven, symmetrized(uneven)):
        assert robot != gait.robot
        pattern = replace(gait.pattern, robot=replace(robot, symmetry_tolerance=0.1))
        path = save_gait(replace(gait, pattern=pattern), tmp_path / "gait.json")
        assert read(path, file).robot == pattern.robot
        with pytest.raises(InputError, match="gait of another robot"):
            read(path, urdf("astro"))


def test_a_specification_says_what_a_urdf_and_a_gait_do_not(tmp_path: Path) -> None:
    """A gait of another base, a rotated one or with offset feet was refused as that of another robot."""
    gait = load_gait(GAIT)
    feet = {foot.name: foot.frame for foot in gait.robot.feet}
    listed = ", ".join(f'{name} = "{frame}"' for name, frame in feet.items())
    spec = tmp_path / "spec.toml"
    spec.write_text(
        f"""[robot]
file = "{urdf("astro")}"
feet = {{ {listed} }}
twins = [["fl", "fr"], ["rl", "rr"]]
base_rotation = [0.0, 0.1, 0.0]
foot_offsets = {{ fl = [0.01, 0.0, 0.0], fr = [0.01, 0.0, 0.0] }}
[gait]
name = "amble"
speed = 0.2
"""
    )
    offset = frozen([0.01, 0.0, 0.0])
    changed = Adaptation(base_rotation=(0.0, 0.1, 0.0), foot_offsets={"fl": offset, "fr": offset})
    robot = load_robot(urdf("astro"), feet, twins=[("fl", "fr"), ("rl", "rr")], adaptation=changed)
    path = save_gait(replace(gait, pattern=replace(gait.pattern, robot=robot)), tmp_path / "gait.json")
    assert read(path, spec).robot == robot
    with pytest.raises(InputError, match="gait of another robot"):
        read(path, urdf("astro"))
    spec.write_text(spec.read_text().replace("0.1, 0.0]", "0.2, 0.0]"))
    with pytest.raises(InputError, match="gait of another robot"):
        read(path, spec)


def test_a_unilateral_walk_tells_of_released_feet(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "trace.nc"
    assert exit_code("simulate", str(GAIT), "--cycles", "1", "--unilateral", "--out", str(out)) == 0
    assert "released 0 times, others touched 0 times" in capsys.readouterr().out
    assert load_trace(out).signals["contact"].shape[1] == 4
