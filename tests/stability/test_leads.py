"""Torques of changes of the command: with them a step ends on the next command's orbit but for second order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.gait import Gait
from amble.gait.impedance import Impedance, unpacked
from amble.gait.schedule import Schedule
from amble.gait.schedule_tables import impedance_schedule
from amble.stability.common_bound import common_bound
from amble.stability.leads import _Ends, with_leads
from amble.stability.sampled_step import SampledStep, sampled_step

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def schedule(stabilised_gait: Gait) -> Schedule:
    """One gait at two speeds, of the second the feed-forward changed at random by some 0.1 N m: another orbit."""
    gait = replace(stabilised_gait, control=Impedance())
    found = impedance_schedule({(0.2,): gait, (0.3,): gait}, ("speed",))
    tables, rng, joints = found.tables.copy(), np.random.default_rng(1), len(gait.robot.joints)
    for row in tables[1]:
        unpacked(row, joints)[4][1, :, :, 0] += rng.normal(scale=0.1, size=joints)
    return replace(found, tables=tables)


@pytest.fixture(scope="module")
def samples(schedule: Schedule) -> dict[tuple[float, ...], SampledStep]:
    return {(speed,): sampled_step(schedule, (speed,)) for speed in (0.2, 0.3)}


def test_what_a_step_misses_is_of_second_order(
    schedule: Schedule, samples: dict[tuple[float, ...], SampledStep]
) -> None:
    """From either orbit, over a tenth and a fifth of the range: a tenth of the miss without at most."""
    metric = common_bound([matrix for sample in samples.values() for matrix in sample.matrices]).metric
    led, root = with_leads(schedule, samples, metric), np.linalg.cholesky(metric).T
    for begin, sign in ((0.2, 1.0), (0.3, -1.0)):
        for share in (0.1, 0.2):
            after = begin + sign * 0.1 * share
            misses = []
            for each in (schedule, led):
                ends = _Ends(each)
                there = sampled_step(schedule, (after,)).state[ends.kept]
                misses.append(np.linalg.norm(root @ (ends(samples[(begin,)].state, (begin,), (after,)) - there)))
            assert misses[1] <= 0.1 * misses[0]
            assert misses[0] > 0.0
