"""Torque against robustness: what a front says, and what it refuses."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.stability.input_gains import CycleMap
from amble.stability.push_response import impulse_unit, push_response
from amble.workflow.front import Front, FrontPoint, front, median_push
from tests.cli.run import exit_code
from tests.conftest import DATA

BIPED = DATA / "biped-of-small-basin.json"


def test_a_smaller_push_is_borne_at_less_torque() -> None:
    points = tuple(
        FrontPoint(name=name, rms_torque=torque, push=push, radius=0.5, friction_used=0.4)
        for name, torque, push in (("a", 5.0, 1.0), ("b", 6.0, 2.0), ("c", 7.0, 1.5))
    )
    found = Front(points=points, robot="astro", friction=0.8)
    assert [found.cheapest(push).name for push in (0.5, 1.0, 1.2, 1.8)] == ["a", "a", "b", "b"]
    with pytest.raises(InputError, match="no gait bears a push of 3 N s; the most is 2 N s"):
        found.cheapest(3.0)


def test_gaits_of_two_robots_and_none_are_refused(stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="gaits of one robot"):
        front({"one": stabilised_gait, "other": load_gait(BIPED)})
    with pytest.raises(InputError, match="gaits of one robot"):
        front({})
    with pytest.raises(InputError, match="gait 'bare': the gait does not hold its closed loop's own orbit"):
        front({"bare": replace(stabilised_gait, feedback=None)})


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "f"
    assert exit_code("front", str(BIPED), "--bears", "1e-4", "--out", str(out)) == 0
    (point,) = json.loads((out / "front.json").read_text())["front"]["points"]
    assert point["best"]
    assert 0.0 < point["radius"] < 1.0
    assert 1e-4 < point["push"] < impulse_unit(load_gait(BIPED).robot)
    assert (out / "front.png").stat().st_size > 5_000
    said = capsys.readouterr().out
    assert f"least torque that bears 0.0001 N s: {BIPED}" in said
    assert exit_code("front", str(BIPED), str(BIPED), "--out", str(out)) == 2


@pytest.mark.slow
def test_half_of_all_pushes_cost_no_contact(stabilised_gait: Gait) -> None:
    """Counted among the directions and phases of the response itself."""
    response = push_response(CycleMap.of(stabilised_gait), 0.8)
    push = median_push(response)
    losses = [response.by_contact(k, 2.0 * np.pi * n / 16) for k in range(12) for n in range(16)]
    assert np.mean(np.array(losses) >= push) == pytest.approx(0.5, abs=0.01)
    found = front({"amble": stabilised_gait}, 0.8).points[0]
    assert found.push == pytest.approx(push, rel=1e-9)
    assert found.rms_torque == pytest.approx(5.29, abs=0.01)
