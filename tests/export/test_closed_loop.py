"""Walking on the compiled controller is walking on the model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.codegen import compiler
from amble.control import joint_outputs
from amble.errors import WorkError
from amble.export import exported_loop
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.files import load_gait
from amble.hybrid import gait_pattern
from amble.simulation import simulate
from amble.synthesis import GaitProblem, synthesize

GAIT = Path(__file__).parents[1] / "data" / "stabilised-amble.json"


@pytest.mark.skipif(compiler() is None, reason="there is no C compiler")
def test_twenty_cycles_are_the_same() -> None:
    """Both loops round alike, so the traces agree far below the tolerance of the integrator."""
    gait = load_gait(GAIT)
    start = start_state(gait)
    model, native = (simulate(loop, start, 20) for loop in (closed_loop(gait), exported_loop(gait)))
    assert model.completed
    assert native.completed
    assert native.state.shape == model.state.shape
    assert np.max(np.abs(native.state - model.state)) <= 1e-9
    for name, values in model.signals.items():
        assert np.max(np.abs(native.signals[name] - values)) <= 1e-7 * max(1.0, np.max(np.abs(values))), name


@pytest.mark.slow
@pytest.mark.skipif(compiler() is None, reason="there is no C compiler")
def test_a_trot_whose_feet_land_in_pairs_is_the_same(small_problem: GaitProblem) -> None:
    """Both loops from the recorded entry through both double landings of a cycle."""
    pattern = gait_pattern(small_problem.pattern.robot, (("fr", "rl"), ("fl", "rr")), True, "trot")
    limits = replace(small_problem.limits, durations={stance.name: (0.1, 0.3) for stance in pattern.solved})
    outputs = joint_outputs(pattern)
    trot = replace(small_problem, pattern=pattern, outputs=outputs, limits=limits, intervals=3)
    gait = synthesize(trot, tolerance=1e-6)
    model, native = (simulate(loop, start_state(gait), 1) for loop in (closed_loop(gait), exported_loop(gait)))
    assert [len(switch.landing) for switch in pattern.all_switches] == [2, 2]
    assert len(model.events) == 2
    assert [event.transition for event in native.events] == [event.transition for event in model.events]
    assert native.state.shape == model.state.shape
    assert np.max(np.abs(native.state - model.state)) <= 1e-9
    for name in ("torque", "force"):
        values = model.signals[name]
        assert np.max(np.abs(native.signals[name] - values)) <= 1e-7 * max(1.0, np.max(np.abs(values))), name


def test_without_a_compiler_the_reason_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    with pytest.raises(WorkError, match="needs a C compiler"):
        exported_loop(load_gait(GAIT))
