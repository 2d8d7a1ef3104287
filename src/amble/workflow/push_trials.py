"""Trials of pushes: a gait walks from its orbit, is pushed once, and walks on or not, in one engine or several.

Trial i of a seed is the same in every engine and however many trials there are. Trials are done in pieces, one file
each, which appears whole or not at all: what a run has finished the next one does not do again.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from amble.codegen.cache import content_key
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.gait.files import content_hash, load_gait, save_gait
from amble.gait.linearising_law import control_of
from amble.gait.plant_errors import PlantErrors
from amble.gait.unilateral_loop import unilateral_loop
from amble.gait.unilateral_state import Push, unilateral_start
from amble.io.reader import read_json, read_record
from amble.io.storage import atomic_write, confined
from amble.simulation.walk import walk
from amble.stability.push_response import impulse_unit, push_of
from amble.stability.robustness import SURVIVED, Trial, TrialSettings
from amble.types import Json

PIECE = 50
"""Trials of one file."""

TOLERANCE, TIME_LIMIT = 1e-6, 2.0
"""Of the native engine; the longest stay in a domain in gait periods."""

LONGEST_REASON = 300
"""Characters of why a walk ended, in a file."""

PIECES = TypeAdapter(list[Trial])

Run = Callable[[Push], tuple[int, str]]
"""An engine, ready: a push -> completed cycles, and why the walk ended (or ``SURVIVED``)."""


def drawn(gait: Gait, settings: TrialSettings, number: int) -> tuple[float, float, float]:
    """Draw impulse (N s), direction (rad) and phase of a trial; small impulses are likelier."""
    share, turn, phase = np.random.default_rng([settings.seed, number]).uniform(size=3)
    return float(settings.largest * share**3 * impulse_unit(gait.robot)), float(2.0 * pi * turn), float(phase)


def native_engine(gait: Gait, settings: TrialSettings) -> Run:
    """Prepare amble's own unilateral simulation."""
    system, prepared = unilateral_loop(gait, errors=PlantErrors(friction=settings.friction)), dict[str, Any]()
    limit = TIME_LIMIT * gait.period

    def run(push: Push) -> tuple[int, str]:
        start = unilateral_start(gait, push=push)
        found = walk(system, start, settings.cycles, TOLERANCE, 2, limit, prepared=prepared)
        return found.cycles, SURVIVED if found.cycles >= settings.cycles else found.arcs[-1].arc.ended or found.ended

    return run


def mujoco_engine(gait: Gait, settings: TrialSettings) -> Run:
    """Prepare MuJoCo with the exported controller in the loop."""
    from amble.validation.cases import Case, Scales
    from amble.validation.loop import Loop
    from amble.validation.mujoco_model import mujoco_model

    scales = Scales.of(gait.robot)
    plant, usual = scales.applied(Case(name="pushed", friction=settings.friction), gait)
    loop, model = Loop(gait, None, scales.confirm), mujoco_model(gait.robot, plant)

    def run(push: Push) -> tuple[int, str]:
        x, y, z = push.force
        found = loop(model, replace(usual, cycles=settings.cycles, push=(x, y, z, push.begin, push.end)))
        if found.cycles >= settings.cycles:
            return found.cycles, SURVIVED
        return found.cycles, "fell" if found.fell else "walked no farther"

    return run


ENGINES: Mapping[str, Callable[[Gait, TrialSettings], Run]] = {"native": native_engine, "mujoco": mujoco_engine}


def engine_named(name: str) -> Callable[[Gait, TrialSettings], Run]:
    """Look an engine up.

    Raises:
        UnknownNameError: there is no engine of that name.
    """
    if name not in ENGINES:
        raise UnknownNameError("engine", name, ENGINES)
    return ENGINES[name]


def run_trials(gait: Gait, settings: TrialSettings, run: Run, numbers: range) -> Iterator[Trial]:
    """Do trials one after the other."""
    for number in numbers:
        impulse, direction, phase = drawn(gait, settings, number)
        along = impulse * np.array([np.cos(direction), np.sin(direction)])
        cycles, ended = run(push_of(gait.robot, along, phase * gait.period))
        yield Trial(impulse=impulse, direction=direction, phase=phase, cycles=cycles, ended=ended)


def pieces(trials: int) -> tuple[range, ...]:
    """Cut trials into pieces."""
    return tuple(range(first, min(first + PIECE, trials)) for first in range(0, trials, PIECE))


@cache
def code_key() -> str:
    """Return a hash of amble's own sources and of the engine's version: a trial of other code is another trial."""
    root = Path(__file__).parents[1]
    files = sorted(path for path in root.rglob("*") if path.suffix in (".py", ".c", ".h"))
    engine = metadata.version("mujoco") if find_spec("mujoco") else ""
    return content_key([engine, *(path.read_text(encoding="utf-8") for path in files)])


@dataclass(frozen=True, kw_only=True)
class TrialFolder:
    """Where the pieces of trials are kept.

    Attributes:
        place: the folder.
        gait: the gait.
        settings: what is tried.
    """

    place: Path
    gait: Gait
    settings: TrialSettings

    def claim(self) -> None:
        """Write what is tried here, or check that it is this.

        Raises:
            InputError: the folder holds other trials, or cannot be written.
        """
        told = self.place / "trials.json"
        if os.path.lexists(told):
            try:
                before = read_json(told, "settings of trials")
            except InputError:
                before = None
            if before != self.content:
                raise InputError(
                    f"'{self.place}' holds trials of another gait, with other settings or of other code of amble; take "
                    "another folder (--out), or remove it"
                )
        with confined(self.place.parent):
            save_gait(self.gait, self.place / "gait.json")
            atomic_write(told, json.dumps(self.content, indent=1) + "\n")

    @property
    def content(self) -> Json:
        """What the trials follow from; the hash of the gait is that of its laws too."""
        return {
            "gait": content_hash(self.gait),
            "control": control_of(self.gait).name,
            "law": self.gait.law.name,
            "settings": asdict(self.settings),
            "piece": PIECE,
            "code": code_key(),
        }

    @classmethod
    def opened(cls, place: Path) -> TrialFolder:
        """Open a folder that was claimed.

        Raises:
            InputError: it was not.
        """
        settings = read_json(place / "trials.json", "settings of trials")["settings"]
        return cls(place=place, gait=load_gait(place / "gait.json"), settings=TrialSettings(**settings))

    def missing(self, engine: str, trials: int) -> list[range]:
        """Return the pieces that are still to be done."""
        return [piece for piece in pieces(trials) if self.read(engine, piece) is None]

    def file(self, engine: str, piece: range) -> Path:
        """Return the file of a piece."""
        return self.place / f"{engine}-{piece.start:07d}-{piece.stop:07d}.json"

    def write(self, engine: str, piece: range, trials: list[Trial]) -> None:
        """Write a piece, whole or not at all."""
        with confined(self.place.parent):
            atomic_write(self.file(engine, piece), json.dumps([asdict(trial) for trial in trials]) + "\n")

    def read(self, engine: str, piece: range) -> list[Trial] | None:
        """Read a piece; None where it is not there or is not one of these trials."""
        try:
            found = read_record(self.file(engine, piece), "piece of trials", PIECES)
        except InputError:
            return None
        if not all(self._possible(trial) for trial in found):
            return None
        expected = [drawn(self.gait, self.settings, number) for number in piece]
        same = [(trial.impulse, trial.direction, trial.phase) for trial in found] == expected
        return found if same else None

    def _possible(self, trial: Trial) -> bool:
        """Whether a walk can have ended so: with a reason in words, or sound at the end of the last cycle."""
        whole = trial.cycles == self.settings.cycles
        words = trial.ended.isprintable() and 0 < len(trial.ended) <= LONGEST_REASON
        return words and 0 <= trial.cycles <= self.settings.cycles and (whole or not trial.survived)
