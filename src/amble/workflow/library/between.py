"""Between the gaits of a library: one gain-scheduled impedance law for all of them, and how fast commands may change.

transitions/transitions.json    axes, the gaits with their hashes, what was found out
transitions/LABEL.json          every gait under the impedance law, with the gains that were chosen for it
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from amble.errors import InputError, listed, shown_path
from amble.gait import Gait
from amble.gait.files import content_hash, load_gait, save_gait
from amble.gait.impedance import Impedance
from amble.gait.plant_errors import PlantErrors
from amble.gait.schedule import Schedule
from amble.gait.schedule_tables import grid_values, impedance_schedule
from amble.gait.unfolding import unfolded
from amble.io.reader import read_record
from amble.io.storage import atomic_write, check_replaceable, confined, dumps, replacing_folder
from amble.progress import Progress, ProgressReport, silent
from amble.simulation.steering import Steered, Stepper
from amble.simulation.steering import steer as walk_steered
from amble.stability.scheduled import Tracking, track
from amble.stability.stabilize import stabilization
from amble.types import Json, frozen
from amble.workflow.library.axes import UNITS, label
from amble.workflow.library.files import Library, LibraryEntry, load_library

FORMAT, FORMAT_VERSION = "amble transitions", 2
FOLDER, HEADER = "transitions", "transitions.json"

COMMANDED = ("speed", "lateral_speed", "yaw_rate", "height")
"""Axes along which a robot can be steered; ground and load are not its to choose."""

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


class _Record(BaseModel):
    """What ``transitions.json`` holds and a reader needs; the numbers beside it are for people."""

    model_config = ConfigDict(extra="ignore", strict=True)

    format: str
    format_version: int
    axes: list[str] = Field(min_length=1, max_length=len(COMMANDED))
    gaits: dict[str, str] = Field(min_length=2, max_length=100_000)
    changes: list[Positive]
    friction: Positive | None
    leads: list[Annotated[float, Field(allow_inf_nan=False)]]


RECORD = TypeAdapter(_Record)


@dataclass(frozen=True, kw_only=True)
class Transitions:
    """A law that follows commands between the gaits of a library.

    Attributes:
        schedule: the law.
        changes: how far the command of every axis may move from step to step.
        friction: of the ground on which that was found out; None for that of the gaits.
    """

    schedule: Schedule
    changes: tuple[float, ...]
    friction: float | None = None

    @property
    def axes(self) -> tuple[str, ...]:
        """What is commanded."""
        return self.schedule.axes


def transitions(
    library: Library | str | Path, *, friction: float | None = None, progress: Progress | None = None
) -> Transitions:
    """Lead a library to where it can be steered, and write that into its folder ``transitions``.

    Every certified gait gets gains of the impedance law that stabilise it, from its neighbour's; gaits of lateral
    speeds or yaw rates from 0 on are completed by their mirror images; between the gaits the law is interpolated
    (``gait.schedule``); at every gait and between every two an orbit is found, one metric in which all of them
    contract, torques that keep a walk from lagging behind, and the largest change of commands that can be walked
    (``stability.scheduled``).

    Args:
        library: a library, or its folder, with two values or more along each commanded axis and one along others.
        friction: of the ground, where gaits were solved for less to keep a margin.
        progress: called with what is being done.

    Raises:
        InputError: there are no gaits to steer between.
        NotStabilizedError: no gains stabilise a gait.
        NotSolvedError: between two gaits there is no orbit.
        WorkError: the orbits do not contract in one metric, or no change of commands is small enough.
    """
    PlantErrors(friction=friction)  # which refuses what is no friction before the work
    found = library if isinstance(library, Library) else load_library(library)
    notify, folder = progress or silent, found.folder / FOLDER
    with confined(found.folder):
        check_replaceable(folder, _ours)
    axes, entries = _grid(found)
    given = _alike({place: found.gait(entry) for place, entry in entries.items()})
    grid_values(given, axes)  # which refuses gaits between which nothing is interpolated before the work
    gaits: dict[tuple[float, ...], Gait] = {}
    spans = np.ptp(np.array(list(entries)), axis=0)
    middle = min(entries, key=lambda place: _distance(place, np.mean(list(entries), axis=0), spans))
    for place in sorted(entries, key=lambda place: (_distance(place, middle, spans), place)):
        notify(ProgressReport(what="gains", done=len(gaits), of=len(entries)))
        near = min(gaits, key=lambda other: (_distance(place, other, spans), other)) if gaits else None
        gait = replace(given[place], control=Impedance())
        gaits[place] = stabilization(gait, near=None if near is None else gaits[near]).gait
    schedule = impedance_schedule(gaits, axes, images=True)
    tracking = track(schedule, friction=friction, progress=notify)
    hashes = {entries[place].label: content_hash(gait) for place, gait in sorted(gaits.items())}
    with confined(found.folder), replacing_folder(folder, _ours) as fresh:
        for place, gait in gaits.items():
            save_gait(gait, fresh / f"{entries[place].label}.json")
        atomic_write(fresh / HEADER, dumps(_tree(hashes, tracking, friction)) + "\n")
    return Transitions(schedule=tracking.schedule, changes=tracking.changes, friction=friction)


def load_transitions(library: str | Path) -> Transitions:
    """Read what ``transitions`` wrote into the folder of a library.

    Raises:
        InputError: it is not there, cannot be read, or a gait is not the one that it tells of.
    """
    folder = Path(library) / FOLDER
    record = read_record(folder / HEADER, "transitions of a library", RECORD)
    what = f"'{shown_path(folder / HEADER)}' is no record of transitions"
    if (record.format, record.format_version) != (FORMAT, FORMAT_VERSION):
        raise InputError(f"{what} of format version {FORMAT_VERSION}")
    known = {label(entry.values): entry.values for entry in load_library(library).certified}
    missing = [name for name in record.gaits if name not in known]
    if missing or not set(record.axes) <= set(COMMANDED) or len(record.changes) != len(record.axes):
        raise InputError(
            f"{what} of this library (`amble transitions` writes it anew): {listed(missing) or 'its axes'}"
        )
    gaits = {}
    for name, told in record.gaits.items():
        gait = load_gait(folder / f"{name}.json")
        if content_hash(gait) != told:
            raise InputError(
                f"'{shown_path(folder / name)}.json' is not the gait that {HEADER} tells of: it was changed "
                "after it was made; `amble transitions` makes it anew"
            )
        gaits[tuple(known[name].get(axis, np.nan) for axis in record.axes)] = gait
    schedule = impedance_schedule(gaits, record.axes, images=True)
    pattern, robot = schedule.gait.pattern, schedule.gait.robot
    shape = (*map(len, schedule.values), len(record.axes), len(pattern.solved), len(robot.joints))
    if len(record.leads) != int(np.prod(shape)):
        raise InputError(
            f"{what} of these gaits (`amble transitions` writes it anew): it has {len(record.leads)} leads"
        )
    schedule = replace(schedule, leads=frozen(np.reshape(record.leads, shape)))
    return Transitions(schedule=schedule, changes=tuple(record.changes), friction=record.friction)


def steer(
    found: Transitions,
    commands: Sequence[tuple[float, Sequence[float]]],
    duration: float,
    *,
    progress: Progress | None = None,
) -> Steered:
    """Walk under commands of speed (and what else the axes are) on ground that pushes only.

    Args:
        found: the law, and how fast its command may change.
        commands: (time in s, one number an axis), in order of time, the first at 0, where the walk begins.
        duration: how long to walk at least, s.
        progress: called after every step.

    Raises:
        InputError: commands are out of order or range, or there are too many; the duration is not positive.
    """
    stepper = Stepper(found.schedule, found.friction)
    return walk_steered(stepper, commands, found.changes, duration, progress=progress)


def _grid(found: Library) -> tuple[tuple[str, ...], dict[tuple[float, ...], LibraryEntry]]:
    """The axes with more than one value, and the certified gaits by their values along them."""
    entries = found.certified
    values = {name: {entry.values[name] for entry in entries if name in entry.values} for name in UNITS}
    axes = tuple(name for name in UNITS if len(values[name]) > 1)
    if not axes:
        raise InputError(
            f"the library has {len(entries)} certified gaits, and no axis with two values or more to steer along"
        )
    others = [name for name in axes if name not in COMMANDED]
    if others:
        raise InputError(
            f"the library has several values of {listed(others)}, which no command can change; build one with one value"
        )
    return axes, {tuple(entry.values[name] for name in axes): entry for entry in entries}


def _alike(gaits: dict[tuple[float, ...], Gait]) -> dict[tuple[float, ...], Gait]:
    """Write mirrored gaits out where others turn: between such a law is interpolated."""
    if all(gait.pattern.mirrored for gait in gaits.values()):
        return gaits
    return {place: unfolded(gait) for place, gait in gaits.items()}


def _ours(name: str) -> bool:
    """Whether a file of this name may be one of earlier transitions."""
    return name.endswith(".json")


def _distance(place: Sequence[float], other: Sequence[float], spans: Sequence[float]) -> float:
    return float(np.linalg.norm((np.array(place) - np.array(other)) / spans))


def _tree(hashes: Mapping[str, str], tracking: Tracking, friction: float | None) -> Json:
    """What is written of a schedule that can be steered."""
    schedule = tracking.schedule
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "axes": list(schedule.axes),
        "units": [UNITS[axis] for axis in schedule.axes],
        "gaits": dict(hashes),
        "changes": list(tracking.changes),
        "friction": friction,
        "walked_changes": list(tracking.tried),
        "contraction_bound_of_a_step": tracking.rate,
        "orbits": [
            {
                "command": list(sample.command),
                "speed_m_s": sample.speed,
                "step_s": sample.duration,
                "yaw_rate_rad_s": sample.yaw_rate,
                "radius_of_a_step": sample.radius,
            }
            for sample in tracking.samples
        ],
        "leads": [] if schedule.leads is None else list(map(float, schedule.leads.ravel())),
    }
