"""The public names of the package: what resolves, what a type checker sees, and what README.md shows."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import amble
from amble.gait import Gait
from amble.synthesis import GaitProblem
from tests.robots import path as robot_file

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize("name", amble.__all__)
def test_every_public_name_resolves(name: str) -> None:
    assert getattr(amble, name) is not None
    assert name in dir(amble)


def test_an_unknown_name_says_what_is_known() -> None:
    with pytest.raises(AttributeError, match="no attribute 'walk'; known: ACTUATORS, Actuator"):
        amble.walk  # type: ignore[attr-defined]  # noqa: B018


def test_names_are_those_of_their_homes() -> None:
    from amble.gait.files import load_gait

    assert amble.load_gait is load_gait


def test_table_and_stub_say_the_same() -> None:
    """Where each name comes from, and which names there are."""
    tree = ast.parse((ROOT / "src" / "amble" / "__init__.pyi").read_text(encoding="utf-8"))
    homes: dict[str, str] = {}
    for statement in tree.body:
        if isinstance(statement, ast.ImportFrom):
            for alias in statement.names:
                assert alias.asname is not None, "without a second name a type checker does not see it"
                homes[alias.asname] = f"{statement.module}.{alias.name}"
    modules = set(amble._MODULES)  # type: ignore[attr-defined]
    table: dict[str, str] = amble._HOME  # type: ignore[attr-defined]
    expected = {name: home if name in modules else f"{home}.{name}" for name, home in table.items()}
    assert homes == expected
    listed = next(each.value for each in tree.body if isinstance(each, ast.Assign))
    assert sorted(ast.literal_eval(listed)) == sorted(amble.__all__) == sorted(["__version__", *table])


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("mypy")


def typed(script: Path, cache: Path) -> subprocess.CompletedProcess[str]:
    """Check a script as a user would, against the package as it is installed here."""
    options = ["--strict", "--config-file", str(ROOT / "pyproject.toml"), "--follow-imports", "silent"]
    command = [sys.executable, "-m", "mypy", *options, "--cache-dir", str(cache), str(script)]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)


WRONG = """
import amble

robot = amble.robots.astro()
gait = amble.synthesise(amble.gait_problem(robot, "amble", speed=0.2))
amble.simulate(robot, cycles=3)
amble.simulate(amble.load_gait("gait.json"), cycle=3)
radius: str = amble.certify(amble.load_gait("gait.json")).radius
"""


def test_a_misspelt_name_or_argument_and_a_wrong_type_fail_the_type_check(tmp_path: Path, cache: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(WRONG)
    done = typed(script, cache)
    assert done.returncode == 1, done.stderr
    lines: dict[int, str] = {}
    for found in re.finditer(r":(\d+): error: (.*)", done.stdout):
        lines[int(found.group(1))] = lines.get(int(found.group(1)), "") + found.group(2)
    assert set(lines) == {5, 6, 7, 8}, done.stdout
    assert 'has no attribute "synthesise"' in lines[5]
    assert "No overload variant" in lines[6]
    assert '"cycle"' in lines[7]
    assert "Incompatible types" in lines[8]


def blocks() -> list[str]:
    """Every block of Python in README.md."""
    return re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)


def test_readme_and_examples_pass_the_type_check(tmp_path: Path, cache: Path) -> None:
    for number, block in enumerate(blocks()):
        script = tmp_path / f"readme_{number}.py"
        script.write_text(block)
        done = typed(script, cache)
        assert done.returncode == 0, done.stdout + done.stderr
    for example in sorted((ROOT / "examples").glob("*.py")):
        done = typed(example, cache)
        assert done.returncode == 0, done.stdout + done.stderr


def run_block(number: int, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Run a block as it stands, in a folder with the file that it reads; returns its names."""
    block, names = blocks()[number], {"__name__": "readme"}
    if "go2.urdf" in block:
        (folder / "go2.urdf").write_bytes(robot_file("go2").read_bytes())
    monkeypatch.chdir(folder)
    exec(compile(block, f"README.md, block {number}", "exec"), names)
    return names


WHOLE = [number for number, block in enumerate(blocks()) if "amble.stabilize(" in block]
"""Blocks that go from a robot to a certificate: a gait is optimised and stabilised, which takes long."""


@pytest.mark.parametrize(
    "number", [pytest.param(n, marks=pytest.mark.slow) if n in WHOLE else n for n in range(len(blocks()))]
)
def test_the_code_of_the_readme_runs(number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_block(number, tmp_path, monkeypatch)


@pytest.mark.parametrize("number", WHOLE)
def test_the_long_code_of_the_readme_runs_on_a_stored_gait(
    number: int, stabilised_gait: Gait, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The two long steps hand out the stored gait, if what they are given fits it; everything else is done."""

    def synthesize(problem: GaitProblem) -> Gait:
        gait = replace(stabilised_gait, feedback=None)
        assert problem.pattern.name == gait.pattern.name
        assert problem.pattern.robot.name == gait.robot.name
        assert problem.speed == gait.speed
        return gait

    def stabilize(gait: Gait) -> Gait:
        assert gait.feedback is None
        return stabilised_gait

    monkeypatch.setattr(amble, "synthesize", synthesize)
    monkeypatch.setattr(amble, "stabilize", stabilize)
    names = run_block(number, tmp_path, monkeypatch)
    assert names["certificate"].radius < 0.5
    assert names["trace"].cycles == 500


EXAMPLES = [
    pytest.param(path, marks=pytest.mark.slow if path.stem == "mujoco_walk" else (), id=path.stem)
    for path in sorted((ROOT / "examples").glob("*.py"))
]


@pytest.mark.parametrize("example", EXAMPLES)
def test_every_example_runs(example: Path) -> None:
    done = subprocess.run([sys.executable, str(example)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout
