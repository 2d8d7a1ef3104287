"""What disturbances do to a certified gait: the amble of `make run`, and a biped that is certified but easily falls."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import ortho_group

from amble.analysis import ContactReport, contact_report
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.files import load_gait
from amble.hybrid import HybridSystem
from amble.progress import ProgressReport
from amble.robot.natural_units import natural_units
from amble.simulation import simulate
from amble.simulation.simulate import perturbed
from amble.stability import Spectrum, certify, disturbance, fixed_point, multipliers
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.disturbance import SEEDS, SIZES, Disturbance, Growth, disturb, growth, in_units
from tests.grounds import on_friction
from tests.hybrids import travelling

BIPED = Path(__file__).parents[1] / "data" / "biped-of-small-basin.json"


@pytest.mark.parametrize("seed", range(8))
def test_it_is_the_largest_over_many_powers(seed: int) -> None:
    draw = np.random.default_rng(seed)
    size = int(draw.integers(2, 9))
    matrix = draw.normal(size=(size, size))
    matrix = np.triu(draw.uniform(0, 20) * matrix, 1) + np.diag(draw.uniform(-0.97, 0.97, size))
    turn = ortho_group.rvs(size, random_state=seed)
    found = growth(turn @ matrix @ turn.T)
    norms = [np.linalg.norm(np.linalg.matrix_power(matrix, k), 2) for k in range(1, 1000)]
    assert found.factor == pytest.approx(max(norms))
    assert found.cycles == 1 + int(np.argmax(norms))


def test_what_only_shrinks_has_its_first_cycle_s_factor() -> None:
    assert growth(np.diag([0.5, 0.2])).factor == pytest.approx(0.5)
    assert growth(np.zeros((3, 3))).cycles == 1


def test_a_known_transient() -> None:
    """A = [[r, c], [0, r]]: A^k = [[r^k, k c r^(k-1)], [0, r^k]], largest near k = -1 / log r."""
    r, c = 0.95, 100.0
    found = growth(np.array([[r, c], [0.0, r]]))
    assert found.cycles == pytest.approx(-1 / np.log(r), abs=1)
    assert found.factor == pytest.approx(found.cycles * c * r ** (found.cycles - 1), rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_scaled_growth_is_that_of_the_scaled_system(seed: int) -> None:
    """Change the units of the states by hand, symmetries and all, and compare the norms of the powers."""
    draw = np.random.default_rng(seed)
    n, k = 7, int(draw.integers(0, 3))
    units = np.exp(draw.normal(size=n))
    along = draw.normal(size=(n, k))
    # a map that keeps the span of the generators
    whole = np.linalg.qr(np.column_stack([along, draw.normal(size=(n, n - k))]))[0]
    block = draw.normal(size=(n, n))
    block[k:, :k] = 0.0
    matrix = whole @ block @ whole.T

    def reduced(matrix: np.ndarray, along: np.ndarray) -> Spectrum:
        basis = np.linalg.qr(along, mode="complete")[0][:, k:] if k else np.eye(n)
        quotient = basis.T @ matrix @ basis
        return Spectrum(multipliers=np.linalg.eigvals(quotient), radius=0.0, neutral=(), matrix=quotient, basis=basis)

    scaled = reduced(matrix * units[np.newaxis, :] / units[:, np.newaxis], along / units[:, np.newaxis])
    found = in_units(reduced(matrix, along), units)
    for power in (1, 2, 5):
        expected = np.linalg.norm(np.linalg.matrix_power(scaled.matrix, power), 2)
        assert np.linalg.norm(np.linalg.matrix_power(found, power), 2) == pytest.approx(expected, rel=1e-9)


def test_multipliers_do_not_know_units() -> None:
    system: HybridSystem = travelling(0.7, -1)
    found = multipliers(system, fixed_point(system, np.array([0.0, 0.3, 1.0, -2.0, 0.4])).state)
    scaled = in_units(found, np.array([1.0, 0.1, 5.0, 5.0, 2.0]))
    np.testing.assert_allclose(
        np.sort(np.abs(np.linalg.eigvals(scaled))), np.sort(np.abs(found.multipliers)), atol=1e-8
    )


def disturbed(gait: Gait, spectrum: Spectrum | None = None) -> Disturbance:
    system, state = closed_loop(gait), closed_loop_fixed_point(gait)[1].state
    return disturb(gait, system, state, spectrum or multipliers(system, state))


def still(states: int) -> Spectrum:
    return Spectrum(
        multipliers=np.zeros(states),
        radius=0.0,
        neutral=(),
        matrix=np.zeros((states, states)),
        basis=np.eye(states),
    )


def test_the_amble_comes_back_from_a_thousandth_and_is_not_warned(stabilised_gait: Gait) -> None:
    """From a hundredth of every unit one of the drawn starts ends in a motion without an impact."""
    found = disturbed(stabilised_gait)
    assert (found.returns, found.failed, found.warnings) == (1e-3, 1e-2, ())
    assert found.seed is not None
    assert "cannot go on" in found.reason
    assert found.growth.factor == pytest.approx(28.7, abs=0.5)


def test_nothing_is_told_of_a_fall_where_every_start_comes_back(
    stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules["amble.stability.disturbance"], "SIZES", (1e-4, 1e-3))
    found = disturbed(stabilised_gait)
    assert (found.returns, found.failed, found.seed, found.reason, found.warnings) == (1e-3, None, None, "", ())


def test_a_biped_that_is_stable_but_easily_falls_is_warned() -> None:
    """Radius 0.936 by an eigenvalue descent that saw no transient; it falls in cycle 31 from a start changed by 1e-3.

    Its return map grows to a norm of 146 in these units.
    """
    gait = load_gait(BIPED)
    found = disturbed(gait)
    assert found.growth.factor > 100.0
    assert found.returns < 1e-3
    assert found.failed is not None
    (warning,) = found.warnings
    assert "small basin" in warning
    assert found.reason in warning
    # what is said can be seen again from the recorded seed
    system, state = closed_loop(gait), closed_loop_fixed_point(gait)[1].state
    units = natural_units(gait.robot, gait.robot.leg_length)
    start = state + units * perturbed(np.zeros(len(state)), found.failed, found.seed or 0)
    trace = simulate(system, start, 60)
    far = np.linalg.norm((trace.section[-1] - state)[2:] / units[2:])
    assert not trace.completed or far > found.failed


@pytest.mark.slow
def test_a_trot_that_is_certified_and_easily_falls_is_warned() -> None:
    """Of a public quadruped (Spirit): certified at 0.956, and starts changed by 1e-4 do not come back.

    Its weights lower the eigenvalues with a preference for a large return map: the powers of that grow to 1,610 in SI
    units. Weights under which they grow to 2e4, in units of l and sqrt(l / g), are refused: their error bar is 112.
    """
    certificate = certify(load_gait(BIPED.with_name("trot-of-small-basin.json")))
    found = certificate.disturbance
    assert found is not None
    assert 0.94 < certificate.spectrum.radius < 0.97
    assert found.growth.factor > 500.0
    assert (found.returns, found.failed) == (0.0, 1e-4)
    (warning,) = found.warnings
    assert "small basin" in warning


def test_contacts_that_stay_unsound_are_a_reason(stabilised_gait: Gait) -> None:
    """The amble uses 0.594 of friction 0.6; where the ground holds 0.5, no size returns with sound contacts."""
    slippery = on_friction(stabilised_gait, 0.5)
    found = disturbed(slippery, still(2 * slippery.robot.size))
    assert (found.returns, found.failed, found.seed) == (0.0, SIZES[0], SEEDS[0])
    assert "contacts are not sound" in found.reason
    assert "of 0.5" in found.reason
    assert found.warnings


@pytest.mark.parametrize(("cycle", "returns"), [(0, 1e-4), (9, 1e-4), (10, 0.0), (19, 0.0)])
def test_a_foot_that_stays_off_the_ground_where_it_is_stopped_is_a_reason(
    cycle: int, returns: float, stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Under the rule 'simultaneous' one foot's touchdown stops the others wherever they are; the forces are sound."""
    monkeypatch.setattr(disturbance, "SIZES", (1e-4,))
    monkeypatch.setattr(disturbance, "SEEDS", (0,))
    real = contact_report

    def lifted(*given: Any) -> ContactReport:
        report = real(*given)
        gaps = np.array(report.landing_gaps)
        gaps[cycle] = 1.1e-3 * stabilised_gait.robot.leg_length
        return replace(report, landing_gaps=gaps)

    monkeypatch.setattr(disturbance, "contact_report", lifted)
    found = disturbed(stabilised_gait)
    assert found.returns == returns
    assert ("do not land at once" in found.reason) == (returns == 0.0)


@pytest.mark.parametrize("scale", [10.0, 100.0])
def test_a_fall_is_a_reason_and_ends_the_trials(
    stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch, scale: float
) -> None:
    monkeypatch.setattr(disturbance, "SIZES", (1e-4, scale * 1e-2, scale * 1e-1))
    told: list[ProgressReport] = []
    system, state = closed_loop(stabilised_gait), closed_loop_fixed_point(stabilised_gait)[1].state
    found = disturb(stabilised_gait, system, state, still(len(state)), told.append)
    assert (found.returns, found.failed) == (1e-4, scale * 1e-2)
    assert "motion" in found.reason
    assert found.warnings  # 1e-4 is below 1e-3
    assert str(told[0]) == "start changed by 0.0001, seed 0, 20 cycles"
    assert not any(report.what.startswith(f"start changed by {scale * 1e-1:g},") for report in told)


@pytest.mark.parametrize(("returns", "warned"), [(0.0, True), (1e-4, True), (1e-3, False), (1e-2, False)])
def test_only_a_small_basin_is_warned(returns: float, warned: bool) -> None:
    found = Disturbance(
        length=0.5, time=0.2, growth=Growth(3.0, 2), returns=returns, failed=0.1, seed=1, reason="the motion fell"
    )
    assert bool(found.warnings) == warned
    tree = json.loads(json.dumps(found.to_dict()))
    assert tree["basin"]["returns_from"] == returns
    assert tree["basin"]["seeds"] == [0, 1, 2, 3]
    assert tree["basin"]["failed"] == {"size": 0.1, "seed": 1, "reason": "the motion fell"}
    assert tree["growth"] == {"factor": 3.0, "cycles": 2}
    assert "factor 3 at most, after 2 cycles" in str(found)
    assert ("less than 0.0001" in str(found)) == (returns == 0.0)
