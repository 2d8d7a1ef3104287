"""The example of a cost: the gait it gives costs less of it than the paper's, is checked, and is written to a file."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from examples.extending.cost_power import ElectricalPower

from amble.control.actuator import ACTUATORS
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.gait.cost import COSTS, TORQUE_SQUARED
from amble.gait.files import content_hash, load_gait, save_gait
from amble.synthesis import GaitProblem, synthesize
from amble.verification.check import check

COST = ElectricalPower("datasheet", 0.5)


def mean_power(gait: Gait) -> float:
    """The smoothed power by Simpson's rule over the nodes, by numpy."""
    work = duration = 0.0
    r = ACTUATORS["datasheet"].heat_coefficient
    for domain in gait.domains:
        product = domain.torques * domain.velocities[:, 6:]
        power = np.sum(0.5 * (product + np.hypot(product, 0.5) - 0.5) + r * domain.torques**2, axis=1)
        step = domain.duration / (domain.times.size - 1)
        work += step / 3.0 * (power[0] + 4.0 * power[1::2].sum() + 2.0 * power[2:-1:2].sum() + power[-1])
        duration += domain.duration
    return work / duration


@pytest.fixture(scope="module")
def both(small_problem: GaitProblem) -> tuple[Gait, Gait]:
    coarse = replace(small_problem, intervals=3)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")  # solving is shorter than compiling
        plain = synthesize(coarse, tolerance=1e-6)
        return plain, synthesize(replace(coarse, cost=COST), plain, tolerance=1e-6)


def test_it_finds_the_gait_of_less_power(both: tuple[Gait, Gait]) -> None:
    plain, frugal = both
    assert frugal.solver.objective == pytest.approx(mean_power(frugal), rel=1e-9)
    assert mean_power(frugal) < 0.99 * mean_power(plain)
    squares = [float(np.mean(np.concatenate([domain.torques for domain in gait.domains]) ** 2)) for gait in both]
    assert squares[0] < squares[1]  # and each is best by its own measure


def test_check_computes_it_again(both: tuple[Gait, Gait]) -> None:
    frugal = both[1]
    row = check(frugal, tolerance=1.0).worst["cost"]
    assert row.name == "mean of the cost 'electrical power' less the solver's"
    assert abs(row.value) < 0.02  # three intervals a domain
    wrong = replace(frugal, solver=replace(frugal.solver, objective=1.5 * frugal.solver.objective))
    assert abs(check(wrong, tolerance=1.0).worst["cost"].value) > 0.2


def test_files_hold_it_only_where_it_is_used(both: tuple[Gait, Gait], tmp_path: Path) -> None:
    plain, frugal = both
    assert "cost" not in json.loads(save_gait(plain, tmp_path / "plain.json").read_text())
    tree = json.loads(save_gait(frugal, tmp_path / "frugal.json").read_text())
    smoothing = {"value": 0.5, "unit": "W"}
    assert tree["cost"] == {"name": "electrical power", "parameters": {"actuator": "datasheet", "smoothing": smoothing}}
    assert tree["solver"]["objective"]["unit"] == "W"
    read = load_gait(tmp_path / "frugal.json")
    assert read.cost == COST
    assert content_hash(read) == content_hash(replace(frugal, cost=TORQUE_SQUARED))
    tree["cost"]["name"] = "noise"
    (tmp_path / "frugal.json").write_text(json.dumps(tree))
    with pytest.raises(UnknownNameError, match=r"known: torque squared, style, electrical power"):
        load_gait(tmp_path / "frugal.json")


def test_what_has_a_breakpoint_is_refused() -> None:
    with pytest.raises(InputError, match="the smoothing of the power is 0 W"):
        COSTS.build("electrical power", {"smoothing": 0.0})
    with pytest.raises(UnknownNameError, match="unknown actuator 'servo'"):
        COSTS.build("electrical power", {"actuator": "servo"})
