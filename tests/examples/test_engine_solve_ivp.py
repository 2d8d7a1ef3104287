"""The example of an engine: it walks as amble's own does, and says the same where a motion ends."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from examples.extending import engine_solve_ivp
from examples.simplest_walker import SHORT_STEP, find_orbit, simplest_walker

from amble.errors import UnknownNameError
from amble.gait import Gait
from amble.gait.files import save_gait
from amble.simulation import simulate
from amble.simulation.walk import ENGINES
from tests.cli.run import exit_code
from tests.hybrids import bouncing_ball

NAME = "solve_ivp"


def test_it_is_registered() -> None:
    assert ENGINES.names == ("native", NAME)
    assert engine_solve_ivp.MultistepFlow(bouncing_ball(), "flight").name == "flight"


def test_a_ball_bounces_as_on_paper() -> None:
    """After a fall from h the speed is sqrt(2 g h), and each bounce keeps 0.8 of it."""
    trace = simulate(bouncing_ball(), np.array([1.0, 0.0]), 3, 1e-10, engine=NAME)
    assert trace.completed
    speeds = [abs(event.before[1]) for event in trace.events]
    np.testing.assert_allclose(speeds, np.sqrt(2.0 * 9.81) * np.array([1.0, 0.8, 0.64]), rtol=1e-7)


def test_a_walker_walks_as_with_the_native_engine() -> None:
    system = simplest_walker()
    start = find_orbit(system, SHORT_STEP)[0].state
    ours, theirs = (simulate(system, start, 2, 1e-10, engine=name) for name in (NAME, "native"))
    np.testing.assert_allclose(ours.section, theirs.section, atol=1e-6)  # a multiplier of 4 grows the tolerance
    np.testing.assert_allclose(ours.time[-1], theirs.time[-1], atol=1e-6)


def test_a_motion_without_an_end_says_so() -> None:
    high = np.array([10.0, 0.0])
    ours, theirs = (simulate(bouncing_ball(), high, 1, time_limit=0.1, engine=name) for name in (NAME, "native"))
    assert ours.ended == theirs.ended
    assert "reached no guard within the time limit in domain 'flight' of cycle 0 at 0.1 s" in ours.ended


def test_a_gait_walks_a_cycle(stabilised_gait: Gait) -> None:
    ours, theirs = (simulate(stabilised_gait, cycles=1, engine=name) for name in (NAME, "native"))
    assert ours.completed
    np.testing.assert_allclose(ours.section, theirs.section, atol=1e-5)
    np.testing.assert_allclose(ours.signals["torque"][0], theirs.signals["torque"][0], atol=1e-9)


def test_the_command_line_names_it(stabilised_gait: Gait, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(save_gait(stabilised_gait, tmp_path / "gait.json"))
    words = ["simulate", file, "--cycles", "1", "--json", "--out", str(tmp_path / "trace.nc")]
    assert exit_code(*words, "--engine", NAME, "--plugin", "examples.extending.engine_solve_ivp") == 0
    assert json.loads(capsys.readouterr().out)["simulation"]["cycles"] == 1
    assert exit_code(*words, "--engine", "bullet") == 2
    assert "unknown engine 'bullet'; known: native, solve_ivp" in capsys.readouterr().out


def test_an_unknown_engine_names_those_there_are() -> None:
    with pytest.raises(UnknownNameError, match="unknown engine 'bullet'; known: native, solve_ivp"):
        simulate(bouncing_ball(), np.array([1.0, 0.0]), engine="bullet")
