"""Versions of what computes."""

from __future__ import annotations

from importlib import metadata

import casadi
import numpy as np
import pytest
import scipy

import amble
from amble.report.versions import computing_versions


def test_the_versions_are_those_of_what_is_loaded() -> None:
    found = computing_versions()
    loaded = {"amble": amble, "casadi": casadi, "numpy": np, "scipy": scipy}
    assert {name: found[name] for name in loaded} == {name: module.__version__ for name, module in loaded.items()}
    assert all(found.values())


def test_without_a_compiler_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    assert computing_versions()["C compiler"] == "none, interpreted"


def test_a_library_that_is_left_out_is_recorded_as_such(monkeypatch: pytest.MonkeyPatch) -> None:
    version = metadata.version

    def without(name: str) -> str:
        if name == "cvxpy":
            raise metadata.PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(metadata, "version", without)
    found = computing_versions()
    assert found["cvxpy"] == "not installed"
    assert found["clarabel"] == version("clarabel")
