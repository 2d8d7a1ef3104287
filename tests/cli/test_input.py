"""Whatever is wrong with an input is one sentence and exit code 2, and nothing is written."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

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
    "massless": ('<robot name="r"><link name="a"/></robot>', "no mass"),
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
@pytest.mark.parametrize("content", [None, b"", b'{"format": "amble gait"', b"\x80\xff", b"{}", b'{"format": NaN}'])
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
