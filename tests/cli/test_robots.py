"""``amble robots``."""

from __future__ import annotations

import pytest

from amble.robot import catalogue
from tests.cli.run import exit_code


def test_robots_lists_the_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("robots") == 0
    header, *lines = capsys.readouterr().out.splitlines()
    assert header.split() == ["name", "mass", "(kg)", "joints", "feet"]
    assert [line.split()[0] for line in lines] == list(catalogue.names())
    assert lines[0].split() == ["astro", "21.50", "12", "fl", "rl", "fr", "rr"]
