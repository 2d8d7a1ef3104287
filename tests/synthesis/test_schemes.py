"""Gaits on meshes of five and seven nodes an interval: their check, refinement, files, metrics, and a common limit."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.analysis.energy import torque_metrics
from amble.analysis.even_samples import evenly_sampled
from amble.analysis.samples import samples_of_gait
from amble.control.actuator import PAPER
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.gait.files import load_gait, save_gait
from amble.gait.style import Style
from amble.numerics.collocation import HERMITE_SIMPSON, STAGES, collocation_scheme, node_positions
from amble.synthesis import GaitProblem, gait_problem, refine, synthesize
from amble.synthesis.problem import INTERVALS
from amble.verification.check import check
from tests.robots import PLANAR, robot

MORE = [name for name in STAGES if name != HERMITE_SIMPSON]


@pytest.fixture(scope="module")
def problem(small_problem: GaitProblem) -> GaitProblem:
    """The coarse problem on four intervals of five nodes."""
    return replace(small_problem, scheme="lobatto-5", intervals=4)


@pytest.fixture(scope="module")
def gait(problem: GaitProblem) -> Gait:
    return synthesize(problem, tolerance=1e-6)


def test_the_motion_is_followed_between_the_nodes(gait: Gait) -> None:
    """By all that the check looks at, limits among them; cost and motion are better than a mesh of as many nodes."""
    report = check(gait)
    assert report.passed
    assert abs(report.worst["motion"].value) < 2e-7  # Hermite-Simpson with as many nodes: 1e-5
    assert gait.solver.linear_solver == "structured"


def test_a_finer_mesh_divides_the_error_by_the_schemes_order(problem: GaitProblem, gait: Gait) -> None:
    """Between the nodes it falls with the power s + 1 (Hairer and Wanner II, theorem 7.10)."""
    finer = refine(problem, gait, 2)
    assert finer.scheme == gait.scheme
    assert finer.domains[0].intervals == 2 * gait.domains[0].intervals
    before, after = (abs(check(each).worst["motion"].value) for each in (gait, finer))
    assert before / after == pytest.approx(2**6, rel=0.1)  # the next term of the error counts


def test_a_file_holds_the_scheme(gait: Gait, tmp_path: Path) -> None:
    place = tmp_path / "gait.json"
    save_gait(gait, place)
    again = load_gait(place)
    assert again.scheme == "lobatto-5"
    np.testing.assert_array_equal(again.domains[1].torques, gait.domains[1].torques)
    content = json.loads(place.read_text())
    assert content["mesh"] == {"name": "lobatto-5", "intervals": {"D1": 4, "D2": 4}}
    content["mesh"]["name"] = "radau"
    place.write_text(json.dumps(content))
    with pytest.raises(
        UnknownNameError, match=r"unknown mesh .* 'radau'; known: hermite-simpson, lobatto-5, lobatto-7"
    ):
        load_gait(place)
    content["mesh"] = {"name": "lobatto-7", "intervals": {"D1": 4, "D2": 4}}
    place.write_text(json.dumps(content))
    with pytest.raises(InputError, match="has the shape"):
        load_gait(place)


def test_nodes_that_the_scheme_does_not_have_are_refused(gait: Gait) -> None:
    domain = gait.domains[0]
    cut = {
        name: getattr(domain, name)[:-2] for name in ("positions", "velocities", "accelerations", "torques", "forces")
    }
    with pytest.raises(InputError, match="has 15 nodes; scheme 'lobatto-5' has one and 4 more for every interval"):
        replace(domain, **cut, times=domain.times[:-2], duration=float(domain.times[-3]))
    moved = np.array(domain.times)
    moved[1] *= 1.01
    with pytest.raises(InputError, match=r"misses the nodes of scheme 'lobatto-5' by 0\.00043 of the duration"):
        replace(domain, times=moved)
    with pytest.raises(InputError, match="have the schemes hermite-simpson, lobatto-5, not one"):
        replace(gait, domains=(evenly_sampled(domain), gait.domains[1]))


def test_samples_are_even_and_hold_the_cost(gait: Gait) -> None:
    """Splines through the samples integrate the squared torques as the scheme's weights do."""
    samples = samples_of_gait(gait)
    for number in range(4):
        spacing = np.diff(samples.times[samples.segments == number])
        np.testing.assert_allclose(spacing, spacing[0], rtol=1e-9)
    metrics = torque_metrics(samples.motion({"law": samples.torques}), "law", PAPER)
    joints = len(gait.robot.joints)
    assert metrics.rms_torque**2 * joints == pytest.approx(
        gait.solver.objective, rel=1e-5
    )  # splines against polynomials of degree 4


def test_a_gait_on_another_scheme_is_a_start(problem: GaitProblem, gait: Gait) -> None:
    """Multipliers belong to a mesh; the motion serves any."""
    other = synthesize(replace(problem, scheme=HERMITE_SIMPSON, intervals=5), start=gait, tolerance=1e-6)
    assert other.scheme == HERMITE_SIMPSON
    assert other.solver.objective == pytest.approx(gait.solver.objective, rel=2e-3)  # the mesh of Hermite-Simpson


def test_each_scheme_has_its_number_of_intervals() -> None:
    """About as many nodes as three-stage meshes of the same accuracy need, or fewer."""
    assert set(INTERVALS) == set(STAGES)
    for name, intervals in INTERVALS.items():
        posed = gait_problem(robot("astro"), "trot", speed=0.1, scheme=name)
        assert posed.intervals == intervals
        assert posed.nodes == node_positions(collocation_scheme(name), intervals).size
    with pytest.raises(UnknownNameError, match="collocation scheme 'radau'"):
        gait_problem(robot("astro"), "trot", speed=0.1, scheme="radau")


@pytest.mark.slow
def test_all_schemes_have_the_same_limit() -> None:
    """Finer meshes of every scheme come nearer to the optimum of one that is finer than all; limits hold at nodes."""

    def optimum(scheme: str, intervals: int) -> float:
        posed = gait_problem(robot("astro"), "amble", speed=0.2, scheme=scheme, intervals=intervals)
        return synthesize(posed, tolerance=1e-6).solver.objective

    best = optimum("lobatto-7", 10)
    for scheme, coarse, fine in ((HERMITE_SIMPSON, 8, 30), ("lobatto-5", 3, 10), ("lobatto-7", 2, 5)):
        far, near = (abs(optimum(scheme, intervals) / best - 1.0) for intervals in (coarse, fine))
        assert near < 1e-4 < far < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("scheme", MORE)
def test_the_cost_of_torque_rates_is_that_of_the_polynomials(scheme: str) -> None:
    """The check integrates them through the recorded nodes, the program by the scheme's table."""
    posed = gait_problem(robot(PLANAR), "walk", speed=0.5, scheme=scheme)
    found = synthesize(replace(posed, cost=Style(effort_rate=0.001)))
    assert check(found).worst["cost"].passed
