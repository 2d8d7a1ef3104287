"""Ten rows of the fleet in continuous integration (`make fleet-ci`): found and checked, the quick ones walked too."""

from __future__ import annotations

from pathlib import Path

import pytest

from amble.gait.files import load_gait
from benchmarks import fleet_row
from benchmarks.fleet import rows
from benchmarks.fleet_row import Row, computed
from benchmarks.fleet_style import walking_style

pytestmark = pytest.mark.fleet

WALKED = [("planar biped", "walk", 0.1), ("planar biped", "run", 0.2), ("bolt", "walk", 0.1)]
"""Stabilised, certified and walked from a changed start as well, 20 cycles instead of 500."""

CHECKED = [
    *[(robot, "trot", 0.1) for robot in ("go2", "a1", "anymal_c", "solo12", "hyq", "mini_cheetah")],
    ("go2", "amble", 0.1),
]


def row(key: tuple[str, str, float], folder: Path, whole: bool) -> Row:
    """Compute a row of the table; a robot whose wheel is not installed is one that fails."""
    (asked,) = (entry for entry in rows() if entry.key == key)
    return computed(asked, folder, whole)


@pytest.mark.parametrize("key", CHECKED, ids=str)
def test_a_row_is_found_and_passes_its_check(key: tuple[str, str, float], tmp_path: Path) -> None:
    found = row(key, tmp_path, whole=False)
    assert found.solved, found.status
    assert found.passed, found.check
    assert walking_style(load_gait(tmp_path / f"{found.name}.json")).missed == ()


@pytest.mark.parametrize("key", WALKED, ids=str)
def test_a_row_walks(key: tuple[str, str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fleet_row, "CYCLES", 20)
    found = row(key, tmp_path, whole=True)
    assert found.solved, found.status
    assert found.passed, found.check
    assert found.certified, found.stability
    assert found.walked, found.walk
