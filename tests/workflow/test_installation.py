"""What ``amble doctor`` finds, and what it says of a broken installation."""

from __future__ import annotations

import importlib.metadata
import json
from pathlib import Path

import pytest

import amble
from amble.workflow.installation import inspect_installation
from tests.cli.run import exit_code


def lost(monkeypatch: pytest.MonkeyPatch, library: str) -> None:
    """Let a library be looked for in vain."""
    version = importlib.metadata.version

    def without(name: str) -> str:
        if name == library:
            raise importlib.metadata.PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(importlib.metadata, "version", without)


def test_versions_compiler_and_cache_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_CACHE", str(tmp_path))
    (tmp_path / "some.so").write_bytes(b"1234")
    found = inspect_installation()
    assert found.versions["amble"] == amble.__version__
    assert found.versions["numpy"] == importlib.metadata.version("numpy")
    assert (found.cache, found.cached, found.fault) == (tmp_path, 4, "")


def test_users_extras_are_told_with_their_libraries(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [
        "numpy>=2.0",
        "xarray>=1; extra == 'reproduce'",
        'nothing-of-this>=1 ; extra == "view"',
        "ruff; extra == 'lint'",
    ]
    monkeypatch.setattr(importlib.metadata, "requires", lambda _: lines)
    found = inspect_installation()
    assert found.extras == {
        "reproduce": {"xarray": importlib.metadata.version("xarray")},
        "view": {"nothing-of-this": None},
    }
    assert "extra 'view' is not complete (nothing-of-this): pip install 'amble[view]'" in found.advice


def test_without_a_compiler_it_is_advice(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    assert exit_code("doctor") == 0
    assert "there is no C compiler: everything is interpreted" in capsys.readouterr().out


def test_a_compiler_that_builds_nothing_is_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "impostor"
    script.write_text('#!/bin/sh\n[ "$1" = --version ] && echo impostor 1.0\n', encoding="utf-8")
    script.chmod(0o755)
    monkeypatch.setenv("AMBLE_COMPILER", str(script))
    assert exit_code("doctor") == 1
    assert "the C compiler cannot be used: " in capsys.readouterr().err


def test_a_lost_library_of_the_core_is_a_failure(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lost(monkeypatch, "pydantic")
    assert exit_code("doctor", "--json") == 1
    said = json.loads(capsys.readouterr().out)
    assert said["error"]["message"] == "pydantic is missing: pip install pydantic"
    assert said["versions"]["pydantic"] is None
