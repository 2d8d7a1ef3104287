"""Allocation laws side by side on the amble: what each of them promises, pointwise and in the table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.analysis import Samples, compare_allocations, every_law, samples_of_gait
from amble.analysis.allocation import LawMetrics, law_torques
from amble.control import MinimumPeak, PseudoInverse
from amble.control.actuator import ACTUATORS
from amble.gait import Gait
from amble.report.allocation import allocation_figure, allocation_results, allocation_table
from tests.grounds import on_friction


@pytest.fixture(scope="module")
def samples(stabilised_gait: Gait) -> Samples:
    return samples_of_gait(stabilised_gait)


@pytest.fixture(scope="module")
def torques(stabilised_gait: Gait, samples: Samples) -> dict[str, np.ndarray]:
    return law_torques(samples, every_law(stabilised_gait).laws)


@pytest.fixture(scope="module")
def metrics(stabilised_gait: Gait) -> dict[str, LawMetrics]:
    return {entry.law: entry for entry in compare_allocations(stabilised_gait)}


# pointwise orders of closed forms: roundoff only
ROUNDOFF = 1e-10


@pytest.mark.parametrize("model", ["paper", "datasheet"])
def test_least_power_is_least_at_every_instant(
    samples: Samples, torques: dict[str, np.ndarray], metrics: dict[str, LawMetrics], model: str
) -> None:
    speeds = samples.velocities[:, 6:]
    best = ACTUATORS[model].power(torques[f"power ({model})"], speeds).sum(axis=1)
    for label, values in torques.items():
        assert np.all(best <= ACTUATORS[model].power(values, speeds).sum(axis=1) * (1.0 + ROUNDOFF)), label
        # the integral's own error is far below the differences
        assert metrics[f"power ({model})"].cot[model] <= metrics[label].cot[model] * (1.0 + 1e-9)


def test_least_peak_is_least_at_every_instant(torques: dict[str, np.ndarray]) -> None:
    """All joints of ASTRo have the same effort limit, so the relative peak is the peak; swing torques are the same."""
    best = np.abs(torques["peak"]).max(axis=1)
    for label, values in torques.items():
        assert np.all(best <= np.abs(values).max(axis=1) * (1.0 + ROUNDOFF)), label


def test_the_pseudo_inverse_has_the_smallest_norm_at_every_instant(torques: dict[str, np.ndarray]) -> None:
    best = np.linalg.norm(torques["pinv"], axis=1)
    for label, values in torques.items():
        assert np.all(best <= np.linalg.norm(values, axis=1) * (1.0 + ROUNDOFF)), label


def test_a_limit_that_binds_is_active_but_not_missed(stabilised_gait: Gait, metrics: dict[str, LawMetrics]) -> None:
    """Friction between what the pseudo-inverse uses and what the motion needs at least."""
    tight = 0.95 * metrics["pinv"].friction_used
    gait = on_friction(stabilised_gait, tight)
    found = {entry.law: entry for entry in compare_allocations(gait)}
    assert 0.0 < found["bounded"].active < 0.5
    assert found["bounded"].missed == 0.0
    # the feet of an optimised gait are level to 1e-8 m, which the law takes for level
    assert found["bounded"].friction_used == pytest.approx(tight, rel=1e-7)
    assert found["pinv"].missed > 0.0
    assert found["bounded"].rms_torque > found["pinv"].rms_torque
    # continuous torques change from sample to sample by a multiple of the spacing; a jump would stay what it is
    coarse = {entry.law: entry for entry in compare_allocations(_thinned(gait))}
    for law in ("pinv", "bounded"):
        assert coarse[law].torque_jump > 1.5 * found[law].torque_jump


def _thinned(gait: Gait) -> Gait:
    """The gait at every third node."""
    names = ("times", "positions", "velocities", "accelerations", "torques", "forces")
    return replace(gait, domains=tuple(replace(d, **{n: getattr(d, n)[::3] for n in names}) for d in gait.domains))


def test_limits_that_do_not_bind_change_nothing(torques: dict[str, np.ndarray]) -> None:
    assert np.max(np.abs(torques["bounded"] - torques["pinv"])) < 1e-9


def test_table_and_numbers_say_the_same(metrics: dict[str, LawMetrics]) -> None:
    table = allocation_table(list(metrics.values()))
    numbers = allocation_results(list(metrics.values()))
    assert [row[0] for row in table.rows] == list(numbers) == list(metrics)
    for row in table.rows:
        assert float(row[3]) == pytest.approx(numbers[row[0]]["nominal"]["rms_torque"], abs=1e-3)


def test_the_figure_has_one_line_a_law_and_joint(stabilised_gait: Gait) -> None:
    laws = {"pinv": PseudoInverse(), "peak": MinimumPeak()}
    axes = allocation_figure(stabilised_gait, laws).axes
    assert [len(axis.lines) for axis in axes] == [2] * 6
