"""Laws of steps in which the command moves: without jumps, and those of the commands where both are one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.impedance import HOLD, Impedance, unpacked
from amble.gait.ramp import SHARES, at_clock, planned, ramped
from amble.gait.schedule import Schedule
from amble.gait.schedule_tables import impedance_schedule
from amble.numerics.pieces import FAR
from amble.types import Vector
from tests.gait.test_schedule import references_at

JOINTS = 12


@pytest.fixture(scope="module")
def schedule(stabilised_gait: Gait) -> Schedule:
    """One gait at two speeds, the numbers of the second changed at random, ends of pieces and durations together."""
    gait = replace(stabilised_gait, control=Impedance())
    found = impedance_schedule({(0.2,): gait, (0.4,): gait}, ("speed",))
    rng = np.random.default_rng(3)
    tables = found.tables.copy()
    for row in tables[1]:
        ends, P, D, places, curves = unpacked(row, JOINTS)
        factor = rng.uniform(0.8, 1.3)
        for part in (ends, places):
            part[part < FAR] *= factor
        for part in (P, D, curves):
            np.multiply(part, rng.uniform(0.8, 1.2, part.shape), out=part)
    return replace(found, tables=tables)


def references(p: Vector, clock: float) -> Vector:
    return references_at(at_clock(p, clock), clock, JOINTS)


def test_where_the_command_stays_it_is_the_law_there(schedule: Schedule) -> None:
    law, there = ramped(schedule, (0.27,), (0.27,)), schedule.law((0.27,))
    for ours, own in zip(law.entries, there.entries, strict=True):
        for clock in (0.0, 0.03, 0.2):
            np.testing.assert_allclose(at_clock(ours.parameters, clock), own.parameters, rtol=1e-14)
        assert planned(ours.parameters) == pytest.approx(own.parameters[1] / HOLD, rel=1e-14)
        expected = sorted({*own.breakpoints, planned(ours.parameters)})
        np.testing.assert_allclose(ours.breakpoints, expected, rtol=1e-12)


def test_it_goes_over_from_one_command_to_the_other_without_a_jump(schedule: Schedule) -> None:
    """It begins as the law of the one and ends as that of the other; between stances numbers go on where they were."""
    law = ramped(schedule, (0.22,), (0.38,))
    first, second = schedule.law((0.22,)), schedule.law((0.38,))
    begin, *_ = law.entries
    *_, end = law.entries
    np.testing.assert_allclose(at_clock(begin.parameters, 0.0), first.entries[0].parameters, rtol=1e-14)
    for late in (1.0, 1.4):
        clock = late * planned(end.parameters)
        np.testing.assert_allclose(at_clock(end.parameters, clock), second.entries[-1].parameters, rtol=1e-14)
    for one, other in zip(law.entries, law.entries[1:], strict=False):
        assert one.parameters[1] == other.parameters[0]
    durations = np.array([entry.parameters[1] for entry in first.entries])
    assert law.entries[0].parameters[1] == pytest.approx(durations[0] / durations.sum(), rel=1e-14)


def test_at_its_breakpoints_it_is_at_an_end_of_its_pieces(schedule: Schedule) -> None:
    law = ramped(schedule, (0.38,), (0.22,))
    for entry in law.entries:
        assert list(entry.breakpoints) == sorted(entry.breakpoints)
        for clock in entry.breakpoints:
            ends, _, _, places, _ = unpacked(at_clock(entry.parameters, clock), JOINTS)
            inside = places[0, 1:]
            smooth = [*ends, *inside[inside < FAR], planned(entry.parameters)]
            assert min(abs(clock - end) for end in smooth) <= 1e-12


def test_a_change_adds_its_torques(schedule: Schedule) -> None:
    """In proportion to the change, interpolated between the gaits as the law is, in every stance."""
    solved = len(schedule.gait.pattern.solved)
    leads = np.random.default_rng(4).normal(size=(2, 1, solved, JOINTS))
    plain, led = (ramped(each, (0.25,), (0.35,)) for each in (schedule, replace(schedule, leads=leads)))
    for number, (without, with_leads) in enumerate(zip(plain.entries, led.entries, strict=True)):
        share = without.parameters[0]
        mean = leads[0, 0, number] + (0.25 + 0.5 * share) * (leads[1, 0, number] - leads[0, 0, number])
        moved = references(with_leads.parameters, 0.0) - references(without.parameters, 0.0)
        np.testing.assert_allclose(moved[2], 0.1 * mean, atol=1e-12)
        np.testing.assert_array_equal(moved[:2], 0.0)
    same, own = (ramped(each, (0.25,), (0.25,)) for each in (replace(schedule, leads=leads), schedule))
    for ours, expected in zip(same.entries, own.entries, strict=True):
        np.testing.assert_array_equal(ours.parameters[SHARES:], expected.parameters[SHARES:])


def test_commands_outside_are_refused(schedule: Schedule) -> None:
    for commands in (((0.1,), (0.3,)), ((0.3,), (0.5,))):
        with pytest.raises(InputError, match="outside the gaits"):
            ramped(schedule, *commands)
