"""The example of a gait: its table from duty factors, its problem, its name in a specification."""

from __future__ import annotations

import numpy as np
import pytest
from examples.extending.gait_crawl import CRAWL, crawl, stance_table

from amble.control import joint_outputs
from amble.errors import UnknownNameError
from amble.hybrid.gaits import GAITS, trot
from amble.synthesis import gait_problem
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import build_program
from amble.synthesis.rank import require_full_rank
from tests.robots import robot

FREE = {
    "D1": ["rl_hip_yaw", "fr_hip_yaw", "rr_hip_pitch"],
    "D2": ["rl_hip_yaw", "fl_hip_yaw", "fr_hip_pitch"],
}
"""A stance on three feet has three internal forces: as many joints are left out."""


def test_feet_stand_for_their_duty_factor() -> None:
    feet = {"a": (0.1, 0.6), "b": (0.35, 0.55), "c": (0.7, 0.7)}
    rows = stance_table(feet)
    events = sorted({phase % 1.0 for land, duty in feet.values() for phase in (land, land + duty)})
    lengths = np.diff([*events, events[0] + 1.0])
    assert len(rows) == len(events)
    for foot, (_, duty) in feet.items():
        assert sum(length for row, length in zip(rows, lengths, strict=True) if foot in row) == pytest.approx(duty)


def test_a_table_of_duty_factors_is_the_trot_too() -> None:
    diagonal = {"fl": (0.0, 0.5), "rr": (0.0, 0.5), "fr": (0.5, 0.5), "rl": (0.5, 0.5)}
    of = robot("astro")
    table = [tuple(sorted(row)) for row in stance_table(diagonal)]
    assert table == [tuple(sorted(stance.feet)) for stance in trot(of).stances]


def test_one_foot_swings_at_a_time() -> None:
    pattern = GAITS["crawl"](robot("astro"), trot(robot("astro")).ground, trot(robot("astro")).contact)
    assert pattern == crawl(robot("astro"))
    assert pattern.mirrored
    swings = [set(CRAWL) - set(stance.feet) for stance in pattern.stances]
    assert swings == [{"fl"}, {"rr"}, {"fr"}, {"rl"}]
    for switch in pattern.all_switches:
        assert (len(switch.landing), len(switch.lifting)) == (1, 1)


def test_its_gait_problem_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    of = robot("astro")
    outputs = joint_outputs(crawl(of), free=FREE)
    program = build_program(gait_problem(of, "crawl", speed=0.1, outputs=outputs, intervals=2))
    names = program.program.row_names
    assert sum("D1->D2 impact" in name for name in names) == of.size + 9
    guess = initial_guess(program.problem, program.layout)
    assert np.all(np.isfinite(np.asarray(program.program.nlp(guess / program.layout.scale, program.parameters)[1])))
    require_full_rank(program, guess)


def test_an_unknown_gait_names_those_there_are() -> None:
    with pytest.raises(UnknownNameError, match="unknown gait 'hop'; known: amble, trot, crawl"):
        gait_problem(robot("astro"), "hop", speed=0.1)
