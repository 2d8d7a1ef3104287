"""The choices of the commands are the library's."""

from __future__ import annotations

import inspect

import pytest

from amble.cli.making import stabilize as stabilize_command
from amble.cli.reproducing import reproduce as reproduce_command
from amble.cli.walking import simulate as simulate_command
from amble.defaults import FREE, METHODS
from amble.simulation import simulate
from amble.stability.stabilize import stabilization
from amble.workflow import reproduce
from tests.cli.run import exit_code


def default(function: object, name: str) -> object:
    assert callable(function)
    return inspect.signature(function).parameters[name].default


def test_a_command_and_its_function_have_the_same_defaults() -> None:
    assert default(stabilize_command, "method") == default(stabilization, "method")
    assert default(stabilize_command, "free") is default(stabilization, "free") is None
    for name in ("method", "cycles", "tolerance"):
        assert default(reproduce_command, name) == default(reproduce, name), name
    for name, own in (("cycles", "cycles"), ("tolerance", "tolerance"), ("perturb", "perturbation"), ("seed", "seed")):
        assert default(simulate_command, name) == default(simulate, own), name


def test_help_names_the_methods_and_the_free_coordinates(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("stabilize", "--help") == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "|".join(METHODS) in said
    assert ", ".join(FREE) in said
