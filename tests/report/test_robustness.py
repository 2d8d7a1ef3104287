"""The page on robustness: its tables and figures say what the records hold."""

from __future__ import annotations

import json
from dataclasses import replace
from math import inf, pi
from pathlib import Path

import numpy as np
import pytest

from amble.gait import Gait
from amble.report.robustness import (
    correlation_table,
    outcome_table,
    push_table,
    robustness_figures,
    robustness_table,
    write_robustness,
)
from amble.stability.fast_mode import FastMode
from amble.stability.input_gains import InputGain, disturbances
from amble.stability.robustness import SURVIVED, Cell, Reach, Robustness, Trial, TrialSettings


@pytest.fixture(scope="module")
def found(stabilised_gait: Gait) -> Robustness:
    """A gait that takes pushes of 5 N s but 2 N s to the side, on paper."""
    generator = np.random.default_rng(1)
    trials = []
    for number in range(400):
        impulse, direction = float(generator.uniform(0.0, 10.0)), float(generator.uniform(0.0, 2.0 * pi))
        limit = 2.0 if abs(np.sin(direction)) > 0.7 else 5.0
        ended = SURVIVED if impulse < limit else "fell"
        trials.append(Trial(impulse=impulse, direction=direction, phase=number % 7 / 7.0, cycles=8, ended=ended))
    kinds = disturbances(stabilised_gait.robot)
    gains = [
        InputGain(name=kind.name, unit=kind.unit, natural=kind.natural, direct=1.0, later=0.5, weighted=2.0, gain=4.0)
        for kind in kinds
    ]
    reaches = [Reach(disturbance=kind, sign=1, size=0.1, ended="fell") for kind in kinds]
    reaches[0] = replace(reaches[0], size=inf, ended="")
    cells = [
        Cell(
            direction=2.0 * pi * sector / 8,
            phase=0.5,
            by_metric=1.0 + sector,
            by_contact=9.0 - sector,
            measured={"native": None if sector == 7 else 1.0 + sector},
            trials={"native": 50},
        )
        for sector in range(8)
    ]
    return Robustness(
        gait=stabilised_gait,
        settings=TrialSettings(),
        radius=0.5,
        rate=0.6,
        friction_used=0.594,
        gains=tuple(gains),
        reaches=tuple(reaches),
        fast=FastMode(pinned=30.0, lost=3000.0, flight=3500.0, growth=-0.1),
        trials={"native": tuple(trials)},
        cells=tuple(cells),
    )


def test_tables_say_how_far(found: Robustness) -> None:
    rows = robustness_table(found).rows
    assert rows[0][2] == "more than tried"
    assert float(rows[1][2]) == pytest.approx(0.1 * found.gains[1].natural, rel=1e-2)
    pushes = {row[0]: row for row in push_table(found).rows}
    assert float(pushes["forward"][2]) == pytest.approx(5.0, rel=0.1)
    assert float(pushes["left"][2]) == pytest.approx(2.0, rel=0.1)
    assert sum(int(row[2]) for row in outcome_table(found).rows) == 400


def test_correlations_leave_out_what_is_not_known(found: Robustness) -> None:
    """One prediction in the order of what was measured, one against it; of eight cells seven are known."""
    rows = {row[1]: row[2:] for row in correlation_table(found).rows}
    assert rows["1 / |b|_W"] == ("1.00", "7")
    assert rows["first contact lost"] == ("-1.00", "7")


@pytest.mark.usefixtures("unrendered")
def test_the_page_is_written_whole(found: Robustness, tmp_path: Path) -> None:
    paths = write_robustness(tmp_path, found)
    assert all(path.stat().st_size > 0 for path in paths)
    numbers = json.loads((tmp_path / "robustness.json").read_text())["robustness"]
    assert numbers["survived"]["native"] == sum(trial.survived for trial in found.trials["native"])
    assert numbers["reaches"][0]["size"] is None
    text = (tmp_path / "robustness.html").read_text()
    assert "How far errors of the plant can go" in text
    assert "http" not in text.replace("http://www.w3.org", "")


def test_a_page_of_thresholds_that_are_all_zero_is_written(found: Robustness, tmp_path: Path) -> None:
    """Two trials of a gait with a small basin: no walk goes on."""
    cells = tuple(replace(cell, measured={"native": 0.0}) for cell in found.cells)
    write_robustness(tmp_path, replace(found, cells=cells))
    figure, _ = robustness_figures(replace(found, cells=cells))["predictions"]
    assert [text.get_text() for text in figure.axes[0].texts] == ["no threshold measured"]


def test_thresholds_stand_at_plain_numbers(found: Robustness) -> None:
    """Powers of ten with factors were printed over each other on axes of one decade."""
    figure, _ = robustness_figures(found)["predictions"]
    figure.draw_without_rendering()
    for axis in (figure.axes[0].xaxis, figure.axes[0].yaxis):
        shown = [label.get_text() for label in (*axis.get_majorticklabels(), *axis.get_minorticklabels())]
        assert [float(text) for text in shown if text]  # no mathematics


def test_the_survival_curve_has_wilsons_intervals(found: Robustness) -> None:
    figure, _ = robustness_figures(found)["push_survival"]
    line = figure.axes[0].lines[0]
    share = np.asarray(line.get_ydata(), dtype=float)
    assert share[0] == 100.0
    assert share[-1] == 0.0
    assert len(share) == 12
