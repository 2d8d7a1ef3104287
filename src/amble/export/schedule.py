"""A gain-scheduled impedance law as C99: tables of all its gaits, and a command beside the interface of one gait."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from amble.errors import InputError
from amble.export.impedance import REAL, DomainTable, impedance_code, vectors
from amble.export.law import numbers, whole_numbers
from amble.export.vectors import SEED
from amble.gait.impedance import HOLD
from amble.gait.landing_stances import landings
from amble.gait.ramp import at_clock, planned, ramped
from amble.gait.schedule import Schedule
from amble.types import NodeValues, Vector

INSIDE = 5
"""Steps of the test vectors between commands that are drawn, beside the gaits at both ends of all axes."""


def schedule_texts(schedule: Schedule, changes: Sequence[float]) -> tuple[dict[str, str], dict[str, str]]:
    """Return what the templates leave open in code, and the test vectors: name -> text.

    Args:
        schedule: the law.
        changes: how far the command of every axis may move from step to step.

    Raises:
        InputError: a change is missing or not positive.
    """
    if len(changes) != len(schedule.axes) or not all(0.0 < change < np.inf for change in changes):
        raise InputError("every axis needs a largest change of its command a step, above 0")
    gait, axes = schedule.gait, len(schedule.axes)
    nodes = [_domains(schedule, packed) for packed in schedule.tables.reshape(-1, *schedule.tables.shape[axes:])]
    code = impedance_code(gait, nodes)
    solved = gait.pattern.solved
    leads = [schedule.lead(command) for command in itertools.product(*schedule.values)]
    passed = [*range(len(solved)), *(solved.index(following) or len(solved) for _, following in landings(gait))]
    lowest, highest = ([row[end] for row in schedule.values] for end in (0, -1))
    grid = [
        f"#define STEP {len(solved)}",
        "/* Stances of a step that have passed where a law begins; of landings that end a step all of them. */",
        whole_numbers("PASSED", "LAWS", passed),
        "/* Torques that a change of the command by 1 a step adds, gait by gait: by axes, stances and joints, N m. */",
        numbers("LEAD", str(sum(lead.size for lead in leads)), np.ravel(leads), REAL),
        "/* Values of the gaits, axis by axis, and how many; range, change a step, and where amble_enter begins. */",
        whole_numbers("GAITS", "AMBLE_AXES", [len(row) for row in schedule.values]),
        numbers("GRID", str(sum(map(len, schedule.values))), itertools.chain(*schedule.values), REAL),
        numbers("LOWEST", "AMBLE_AXES", lowest, REAL),
        numbers("HIGHEST", "AMBLE_AXES", highest, REAL),
        numbers("CHANGE", "AMBLE_AXES", changes, REAL),
        numbers("START", "AMBLE_AXES", [min(row, key=abs) for row in schedule.values], REAL),
        "",
    ]
    code |= {"AXES": str(axes), "TABLES": "\n".join([code["TABLES"], *grid])}
    return code, {"test_vectors.txt": _vectors(schedule, lowest, highest)}


def _vectors(schedule: Schedule, lowest: Sequence[float], highest: Sequence[float]) -> str:
    """At the gaits at both ends of all axes, and in steps from one drawn command to another."""
    generator, lines, peak = np.random.default_rng(SEED), list[str](), 0.0
    drawn = [[generator.uniform(lowest, highest).tolist() for _ in range(2)] for _ in range(INSIDE)]
    arms = schedule.gait.robot.torque_arms
    for before, after in ([lowest, lowest], [highest, highest], *drawn):
        law = ramped(schedule, before, after)
        laws = [entry.parameters for entry in (*law.entries, *law.between.values())]

        def table(place: int, clock: float, laws: Sequence[Vector] = laws) -> DomainTable:
            return DomainTable.of(at_clock(laws[place], clock), arms, planned(laws[place]))

        largest, more = vectors(schedule.gait, table, generator, [*before, *after])
        peak, lines = max(peak, largest), lines + more
    return "\n".join([repr(peak), *lines, ""])


def _domains(schedule: Schedule, packed: NodeValues) -> list[DomainTable]:
    """Tables of the solved stances, then of those between landings, whose planned duration is the next stance's."""
    gait, arms = schedule.gait, schedule.gait.robot.torque_arms
    solved = gait.pattern.solved
    following = [*range(len(solved)), *(solved.index(stance) for _, stance in landings(gait))]
    durations = [float(packed[place][1]) / HOLD for place in following]
    return [DomainTable.of(row, arms, duration) for row, duration in zip(packed, durations, strict=True)]
