"""Versions of what computes."""

from __future__ import annotations

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
