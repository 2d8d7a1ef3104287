"""The program as a whole: help, version, exit codes, start-up."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from typer.main import get_command

from amble.cli import robots
from amble.cli.app import app
from amble.errors import InputError, NotSolvedError
from amble.residual import Residual
from tests.cli.run import exit_code


def test_help_lists_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("--help") == 0
    assert "robots" in capsys.readouterr().out


def test_every_command_that_writes_takes_out() -> None:
    """As README.md says; transitions are a part of their library's folder."""
    commands = get_command(app).commands
    without = {name for name, command in commands.items() if "out" not in {each.name for each in command.params}}
    assert without == {"check", "doctor", "robots", "transitions"}


def test_every_command_takes_json_and_quiet_and_tells_its_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    for name in get_command(app).commands:
        assert exit_code(name, "--help") == 0
        said = " ".join(capsys.readouterr().out.split())
        for part in ("--json", "--quiet", "0 done", "1 the work failed", "2 usage or input is bad"):
            assert part in said, (name, part)


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("--version") == 0
    assert capsys.readouterr().out.startswith("amble 0.")


BAD_USAGE = [("nonsense",), ("robots", "--nonsense"), ("robots", "one", "extra"), ("reproduce", "--method", "magic")]


@pytest.mark.parametrize("arguments", BAD_USAGE)
def test_bad_usage_exits_2(arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(*arguments) == 2
    assert "Error:" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "code", "says"),
    [
        (InputError("no such file"), 2, "error: no such file"),
        (NotSolvedError("Infeasible", [Residual("D1 node 3 torque", -1.0, 2.0, 1.0)]), 1, "D1 node 3 torque"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
def test_errors_become_exit_codes(
    error: BaseException,
    code: int,
    says: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(robots, "print_table", fail)
    assert exit_code("robots") == code
    captured = capsys.readouterr()
    assert says in captured.err
    assert captured.out == ""


def test_a_bug_traces(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(robots, "print_table", fail)
    with pytest.raises(ZeroDivisionError):
        exit_code("robots")


HEAVY = ("numpy", "casadi", "rich", "pydantic", "matplotlib", "xarray", "cvxpy", "scipy")


@pytest.mark.parametrize(("given", "found"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "2"}, "2")])
def test_linear_algebra_has_one_thread_unless_the_user_says_otherwise(given: dict[str, str], found: str) -> None:
    code = (
        "import atexit, os, sys; sys.argv = ['amble', '--version']; from amble.cli import main\n"
        "atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS'], 'numpy' in sys.modules)); main()"
    )
    without = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    done = subprocess.run(
        [sys.executable, "-c", code], env={**without, **given}, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == f"{found} False"


@pytest.mark.parametrize(
    "statement", ["import amble", "import amble.cli", "from amble.cli import main; main(['--help'])"]
)
def test_start_up_imports_nothing_heavy(statement: str) -> None:
    """Seconds depend on the machine; what is imported does not."""
    code = f"import atexit, sys; atexit.register(lambda: print([n for n in {HEAVY} if n in sys.modules])); {statement}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shell_completion(shell: str) -> None:
    environment = {**os.environ, "_AMBLE_COMPLETE": f"complete_{shell}", "COMP_WORDS": "amble ro", "COMP_CWORD": "1"}
    environment |= {"_TYPER_COMPLETE_ARGS": "amble ro", "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    code = "from amble.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment)
    assert "robots" in done.stdout
