"""The example of a gait: its table from duty factors, its problem, its name in a specification."""

from __future__ import annotations

import numpy as np
import pytest
from examples.extending.gait_canter import canter

from amble.errors import UnknownNameError
from amble.hybrid import FLAT, POINT
from amble.hybrid.gaits import GAITS
from amble.synthesis import gait_problem
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import build_program, require_full_rank
from tests.robots import robot


def test_three_beats_and_a_flight() -> None:
    pattern = GAITS["canter"](robot("astro"), FLAT, POINT)
    assert pattern == canter(robot("astro"))
    assert not pattern.mirrored
    assert [set(stance.feet) for stance in pattern.stances] == [
        {"rr"},
        {"rr", "rl", "fr"},
        {"rl", "fr"},
        {"rl", "fr", "fl"},
        {"fl"},
        set(),
    ]
    assert [len(switch.landing) for switch in pattern.all_switches] == [2, 0, 1, 0, 0, 1]


def test_its_gait_problem_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    program = build_program(gait_problem(robot("astro"), "canter", speed=0.5, intervals=2))
    guess = initial_guess(program.problem, program.layout)
    assert np.all(np.isfinite(np.asarray(program.program.nlp(guess / program.layout.scale, program.parameters)[1])))
    require_full_rank(program, guess / program.layout.scale)


def test_an_unknown_gait_names_those_there_are() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown gait 'hop'; known: amble, trot, .*, tripod, canter"):
        gait_problem(robot("astro"), "hop", speed=0.1)
