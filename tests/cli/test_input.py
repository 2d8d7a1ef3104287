"""Whatever is wrong with an input is one sentence and exit code 2, and nothing is written."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from amble.codegen import compiler
from tests.cli.run import exit_code
from tests.hostile import ATTACK, ATTACK_ON_ONE_LINE, MARKER

GAIT = Path(__file__).parents[1] / "data" / "stabilised-amble.json"

SPEC = """
[robot]
name = "astro"
[gait]
name = "amble"
speed = 0.2
[limits]
clearance = 0.02
normal_force = 10
"""

OWN_ROBOT = SPEC.replace('name = "astro"', 'file = "robot.urdf"\nfeet = { fl = "a", fr = "b" }')

FIXED_BASE = '<robot name="r"><link name="world"/><link name="a"/><joint name="j" type="fixed">'
FIXED_BASE += '<parent link="world"/><child link="a"/></joint></robot>'

SPECIFICATIONS = {
    "unknown key": (SPEC + "clearence = 1", "unknown key"),
    "unknown unit": (SPEC.replace("speed = 0.2", 'speed = "0.2 mph"'), "unknown unit 'mph'"),
    "nan": (SPEC.replace("speed = 0.2", "speed = nan"), "not a finite number"),
    "unknown joint": (SPEC + "torques = { knee = 1 }", "unknown joint 'knee'"),
    "unknown foot": (SPEC.replace('name = "amble"', 'stances = [["fx"], ["fl"]]'), "unknown foot 'fx'"),
    "missing robot": (OWN_ROBOT, "cannot be read"),
    "not toml": ("[robot", "is not TOML"),
    "digits": (SPEC.replace("0.2", "9" * 5000, 1), "more than 40 digits"),
    "large": (SPEC.replace("0.2", "9" * 400, 1), "more than 40 digits"),
    "nesting": (SPEC + "x = " + "[" * 400 + "]" * 400, "nested deeper than 32"),
    "underscore": (SPEC.replace("speed = 0.2", 'speed = "0_2 m/s"'), "does not begin with a number"),
    "nul in a path": (OWN_ROBOT.replace("robot.urdf", "robot\\u0000.urdf"), "no file has such a name"),
    "device as a robot": (OWN_ROBOT.replace("robot.urdf", "/dev/zero"), "a device or a pipe, not a file"),
    "folder as a robot": (OWN_ROBOT.replace("robot.urdf", "."), "cannot be read"),
}


@pytest.mark.parametrize("name", SPECIFICATIONS)
def test_a_wrong_specification(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text, message = SPECIFICATIONS[name]
    Path("spec.toml").write_text(text)
    assert exit_code("synthesize", "spec.toml") == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("error: ")
    assert captured.err.count("\n") == 1
    assert message in captured.err
    assert captured.out == ""
    assert os.listdir() == ["spec.toml"]


ROBOTS = {
    "malformed": ("<robot", "not well-formed"),
    "fixed base": (FIXED_BASE, "fixed"),
    "jointless": ('<robot name="r"><link name="a"/></robot>', "no actuated joint"),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_a_wrong_robot(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    urdf, message = ROBOTS[name]
    Path("robot.urdf").write_text(urdf)
    Path("spec.toml").write_text(OWN_ROBOT)
    assert exit_code("synthesize", "spec.toml") == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("command", ["check", "simulate", "compare", "certify", "stabilize", "export"])
@pytest.mark.parametrize(
    "content",
    [
        *(None, b"", b'{"format": "amble gait"', b"\x80\xff", b"{}", b'{"format": NaN}'),
        *(b"9" * 5000, b"[" * 500 + b"]" * 500, b'{"format": "\\ud800"}', b'{"format": 1' + b"0" * 400 + b"}"),
    ],
)
def test_a_wrong_gait(
    command: str,
    content: bytes | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    if content is not None:
        Path("gait.json").write_bytes(content)
    before = os.listdir()
    assert exit_code(command, "gait.json", *(["--out", "out"] if command != "check" else [])) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("error: ")
    assert captured.err.count("\n") == 1
    assert os.listdir() == before


def test_an_empty_folder_has_no_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("report", str(tmp_path)) == 2
    assert "cannot be read" in capsys.readouterr().err


def spoiled(folder: Path, name: str) -> Path:
    """The stored gait with another name of its robot, which its hash does not hold."""
    tree = json.loads(GAIT.read_text())
    tree["robot"]["name"] = name
    file = folder / "gait.json"
    file.write_text(json.dumps(tree))
    return file


@pytest.mark.skipif(compiler() is None, reason="there is no C compiler")
@pytest.mark.parametrize("command", [("simulate", "--cycles", "1", "--controller", "c"), ("export",)])
@pytest.mark.parametrize(("name", "code"), [(ATTACK, 2), (ATTACK_ON_ONE_LINE, 0)])
def test_a_gait_file_runs_no_code(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: tuple[str, ...],
    name: str,
    code: int,
) -> None:
    """A name that left the comment of the exported C was compiled and run."""
    monkeypatch.chdir(tmp_path)
    head, *options = command
    assert exit_code(head, str(spoiled(tmp_path, name)), *options) == code
    if code == 2:
        said = capsys.readouterr().err.splitlines()
        assert said == [line for line in said if line.startswith("error: the name of a robot")]
        assert len(said) == 1
    elif head == "export":
        tool = compiler()
        assert tool is not None
        sources = [str(path) for path in (tmp_path / "controller").glob("*.c")]
        subprocess.run([tool.path, "-o", "replay", *sources, "-lm"], check=True)
        subprocess.run(["./replay", "controller/test_vectors.txt"], check=True, capture_output=True)
    assert not (tmp_path / MARKER).exists()


@pytest.mark.parametrize("command", ["check", "simulate", "compare", "certify", "stabilize", "export", "synthesize"])
def test_what_never_ends_is_no_input(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in ("/dev/zero", str(tmp_path / "pipe")):
        assert exit_code(command, path) == 2
        error = capsys.readouterr().err
        assert "not a file" in error
        assert error.count("\n") == 1


HEADER = {"format": "amble results", "format_version": 1}
STABLE = {
    "spectral_radius": {"initial": 2.3, "stabilized": 0.4, "error": 1e-5},
    "multipliers": {"initial": [[2.3, 0.0]], "stabilized": [[0.4, 0.0]]},
    "section_distances": [1e-3, 1e-4],
    "perturbed": {"size": 1e-3, "cycles": 2, "sound_from_cycle": 0, "before_sound": None},
}

RESULTS: dict[str, Any] = {
    "not text": b"\x80\xff",
    "utf-16": json.dumps(HEADER).encode("utf-16"),
    "empty": b"",
    "list": b"[]",
    "earlier": {"robot": "astro", "settings": {}},
    "foreign": {"format": "other", "format_version": 1},
    "later": {**HEADER, "format_version": 2},
    "settings number": {**HEADER, "settings": 3},
    "settings list": {**HEADER, "settings": [1]},
    "a list in the settings": {**HEADER, "settings": {"a": [1]}},
    "seconds text": {**HEADER, "seconds": {"a": "b"}},
    "seconds list": {**HEADER, "seconds": {"a": [1.0]}},
    "seconds infinite": b'{"format": "amble results", "format_version": 1, "seconds": {"a": 1e999}}',
    "digits": b'{"format": "amble results", "format_version": 1, "seconds": {"a": 1' + b"0" * 400 + b"}}",
    "nested": b'{"a": ' + b"[" * 400 + b"]" * 400 + b"}",
    "surrogate": b'{"format": "amble results", "format_version": 1, "settings": {"a": "\\ud800"}}',
    "two axes": {**HEADER, **STABLE, "section_distances": [[1.0, 2.0]]},
    "one distance": {**HEADER, **STABLE, "section_distances": 3},
    "no distances": {**HEADER, **STABLE, "section_distances": []},
    "multipliers": {**HEADER, **STABLE, "multipliers": {"initial": [1.0], "stabilized": [[0.4, 0.0]]}},
    "three numbers": {**HEADER, **STABLE, "multipliers": {"initial": [[1.0, 0.0, 0.0]], "stabilized": [[0.4, 0.0]]}},
    "radius": {**HEADER, **STABLE, "spectral_radius": [1.0]},
    "radius text": {**HEADER, **STABLE, "spectral_radius": {"initial": "a", "stabilized": 0.4, "error": 0.1}},
    "contraction": {**HEADER, **STABLE, "contraction": 3},
    "perturbed": {**HEADER, **STABLE, "perturbed": [1]},
    "perturbed cycles": {**HEADER, **STABLE, "perturbed": {**STABLE["perturbed"], "cycles": 1.5}},
    "before sound": {**HEADER, **STABLE, "perturbed": {**STABLE["perturbed"], "before_sound": {"max_friction": 1}}},
    "stabilization": {**HEADER, **STABLE, "stabilization": "fast"},
}

PLACES: dict[str, Callable[[Path], Any]] = {
    "folder": Path.mkdir,
    "pipe": os.mkfifo,
    "device": lambda path: path.symlink_to("/dev/zero"),
    "broken link": lambda path: path.symlink_to("nowhere"),
}


@pytest.mark.parametrize("name", [*RESULTS, *PLACES])
def test_earlier_results_that_are_something_else(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "results.json"
    if name in PLACES:
        PLACES[name](path)
    else:
        content = RESULTS[name]
        path.write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())
    assert exit_code("report", str(tmp_path)) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    said, sentence = captured.err.splitlines()
    assert said == "reporting ..."
    assert sentence.startswith("error: ")
    assert "results" in sentence
