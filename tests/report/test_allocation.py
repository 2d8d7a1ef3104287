"""Allocation laws side by side on the amble: what each of them promises, pointwise and in the table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.analysis import (
    Comparison,
    LawMetrics,
    LimitUse,
    Samples,
    compare_laws,
    every_law,
    samples_of_gait,
    with_laws,
)
from amble.control import MinimumPeak, PseudoInverse
from amble.control.actuator import ACTUATORS
from amble.gait import Gait
from amble.report.allocation import allocation_figure, allocation_results, law_table
from tests.grounds import on_friction


@pytest.fixture(scope="module")
def samples(stabilised_gait: Gait) -> Samples:
    return samples_of_gait(stabilised_gait)


@pytest.fixture(scope="module")
def torques(stabilised_gait: Gait, samples: Samples) -> dict[str, np.ndarray]:
    return dict(with_laws(samples, every_law(stabilised_gait).laws).torques)


@pytest.fixture(scope="module")
def comparison(stabilised_gait: Gait) -> Comparison:
    return compare_laws(stabilised_gait)


@pytest.fixture(scope="module")
def metrics(comparison: Comparison) -> dict[str, LawMetrics]:
    return {entry.law: entry for entry in comparison.metrics}


def use(entry: LawMetrics) -> LimitUse:
    assert entry.limits is not None
    return entry.limits


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
        assert metrics[f"power ({model})"].energy[model].cot <= metrics[label].energy[model].cot * (1.0 + 1e-9)


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
    tight = 0.95 * use(metrics["pinv"]).friction_used
    gait = on_friction(stabilised_gait, tight)
    found = {entry.law: entry for entry in compare_laws(gait).metrics}
    assert 0.0 < use(found["bounded"]).active < 0.5
    assert use(found["bounded"]).missed == 0.0
    # the feet of an optimised gait are level to 1e-8 m, which the law takes for level
    assert use(found["bounded"]).friction_used == pytest.approx(tight, rel=1e-7)
    assert use(found["pinv"]).missed > 0.0
    assert found["bounded"].torques.rms_torque > found["pinv"].torques.rms_torque
    # continuous torques change from sample to sample by a multiple of the spacing; a jump would stay what it is
    coarse = {entry.law: entry for entry in compare_laws(_thinned(gait)).metrics}
    for law in ("pinv", "bounded"):
        assert use(coarse[law]).torque_jump > 1.5 * use(found[law]).torque_jump


def _thinned(gait: Gait) -> Gait:
    """The gait at every third node."""
    names = ("times", "positions", "velocities", "accelerations", "torques", "forces")
    return replace(gait, domains=tuple(replace(d, **{n: getattr(d, n)[::3] for n in names}) for d in gait.domains))


def test_limits_that_do_not_bind_change_nothing(torques: dict[str, np.ndarray]) -> None:
    assert np.max(np.abs(torques["bounded"] - torques["pinv"])) < 1e-9


def test_table_and_numbers_say_the_same(comparison: Comparison, metrics: dict[str, LawMetrics]) -> None:
    table = law_table(comparison, "nominal")
    numbers = allocation_results(comparison)
    assert [row[0] for row in table.rows] == list(numbers) == list(metrics) == list(comparison.laws)
    columns = {name: place for place, name in enumerate(table.header)}
    for row in table.rows:
        said = numbers[row[0]]["nominal"]
        for column, value in (
            ("CoT (paper)", said["cot"]["paper"]),
            ("CoT (datasheet)", said["cot"]["datasheet"]),
            ("RMS (N m)", said["rms_torque"]),
            ("peak (N m)", said["peak_torque"]),
            ("friction used", said["friction_used"]),
        ):
            assert float(row[columns[column]]) == pytest.approx(value, rel=6e-3), column  # three digits and more
        assert row[columns["peak joint"]] == said["peak_joint"]
    one = law_table(comparison, "nominal", ["datasheet"])
    assert [name for name in one.header if name.startswith("CoT")] == ["CoT (datasheet)"]


def test_the_figure_has_one_line_a_law_and_joint(stabilised_gait: Gait) -> None:
    laws = {"pinv": PseudoInverse(), "peak": MinimumPeak()}
    axes = allocation_figure(stabilised_gait, laws).axes
    assert [len(axis.lines) for axis in axes] == [2] * 6
