"""The example of an allocation law: against a least-squares solver, in the gait problem, in a file, from a command."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from examples.extending.law_even import EvenTorques

from amble.control import LAWS
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import load_gait, save_gait
from amble.synthesis import gait_problem
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import build_program
from tests.cli.run import exit_code
from tests.control.allocation.stances import allocate, samples
from tests.robots import robot

ROOT = Path(__file__).parents[2]
LAW = EvenTorques(4.0)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_it_is_the_least_squares_solution(count: int) -> None:
    """The same cost as rows of a least-squares problem: r, and sqrt(k) times its distance from its mean."""
    limits = np.array([joint.effort for joint in robot("go2").joints])
    for sample in samples("go2", count, 20, seed=3):
        steered = np.any(sample.torque_basis != 0.0, axis=1)
        size = int(steered.sum())
        rows = np.vstack([np.eye(size), np.sqrt(LAW.evenness) * (np.eye(size) - 1.0 / size)])
        N, u = ((part.T / limits).T[steered] for part in (sample.torque_basis, sample.torques))
        expected = np.linalg.lstsq(rows @ N, -rows @ u, rcond=None)[0]
        found = allocate("go2", count, LAW, sample)[0]
        np.testing.assert_allclose(N @ found, N @ expected, atol=1e-9)


def test_more_evenness_means_less_spread() -> None:
    limits = np.array([joint.effort for joint in robot("go2").joints])
    for sample in samples("go2", 4, 20, seed=1):
        steered = np.any(sample.torque_basis != 0.0, axis=1)
        torques = [
            (sample.torques + sample.torque_basis @ allocate("go2", 4, EvenTorques(k), sample)[0])
            for k in (0.0, 1.0, 9.0)
        ]
        spreads = [np.std((torque / limits)[steered]) for torque in torques]
        assert spreads[0] > spreads[1] > spreads[2]


def test_a_gait_is_optimised_under_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    of = robot("astro")
    program = build_program(gait_problem(of, "amble", speed=0.2, law=LAW, intervals=2))
    assert "D1 node 0 law even 0" in program.program.row_names
    guess = initial_guess(program.problem, program.layout)
    assert np.all(np.isfinite(np.asarray(program.program.nlp(guess / program.layout.scale, program.parameters)[1])))


def test_files_hold_it(walking_gait: Gait, tmp_path: Path) -> None:
    gait = replace(walking_gait, law=LAW)
    assert load_gait(save_gait(gait, tmp_path / "gait.json")).law == LAW
    tree = json.loads((tmp_path / "gait.json").read_text())
    assert tree["allocation_law"] == {"name": "even", "parameters": {"evenness": {"value": 4.0, "unit": "1"}}}
    with pytest.raises(InputError, match="the evenness is -1; it must not be negative"):
        LAWS.build("even", {"evenness": -1})


def test_a_command_names_the_plugin(walking_gait: Gait, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(save_gait(walking_gait, tmp_path / "gait.json"))
    words = ["compare", file, "--json", "--law", "even:evenness=4", "--law", "pinv"]
    assert exit_code(*words, "--plugin", "examples.extending.law_even") == 0
    found = json.loads(capsys.readouterr().out)
    assert "even" in json.dumps(found["allocation"])
    assert exit_code(*words, "--plugin", "examples.extending.nothing") == 2
    assert "plugin 'examples.extending.nothing' cannot be imported: No module named" in capsys.readouterr().out


@pytest.mark.parametrize(("plugin", "code"), [("law_even.py", 0), (None, 2)])
def test_without_the_plugin_the_name_is_unknown(
    plugin: str | None, code: int, walking_gait: Gait, tmp_path: Path
) -> None:
    """In a process of its own: a file that names the law loads nothing by itself."""
    file = save_gait(replace(walking_gait, law=LAW), tmp_path / "gait.json")
    more = [] if plugin is None else ["--plugin", str(ROOT / "examples" / "extending" / plugin)]
    words = [sys.executable, "-m", "amble", "compare", str(file), "--law", "pinv", *more]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    if code:
        assert done.stderr.count("\n") == 1
        assert "unknown allocation law" in done.stderr
        assert "known: pinv, drop, weighted, power, peak, bounded" in done.stderr
