"""How robust a gait is: gains from the linearisation, reaches, and trials of pushes in several engines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, pi, sqrt
from pathlib import Path

import numpy as np

from amble.analysis.proportions import half_survives
from amble.gait import Gait
from amble.gait.unilateral_loop import on_unilateral_ground
from amble.gait.unilateral_state import unilateral_start
from amble.progress import Progress, ProgressReport, silent
from amble.simulation.walk import walk
from amble.stability.fast_mode import fast_mode
from amble.stability.input_gains import CycleMap, Disturbance, disturbances, input_gains
from amble.stability.push_response import PushResponse, push_response
from amble.stability.robustness import Cell, Reach, Robustness, Trial, TrialSettings
from amble.workflow.push_trials import TOLERANCE, TrialFolder, engine_named
from amble.workflow.trial_runs import check_trials, do_trials

SECTORS, PHASE_BINS = 8, 4
"""Directions and phases of pushes are compared in so many cells."""

WITHIN = 3
"""Directions, and phases, of a cell whose predictions are averaged."""

SMALLEST, LARGEST, HALVINGS = 1e-4, 1.0, 6
"""Sizes of errors between which a reach is searched for, in natural units, and steps: to 15 %."""


def robustness(
    gait: Gait,
    out: Path,
    engines: Sequence[str] = ("native",),
    trials: int = 1000,
    settings: TrialSettings | None = None,
    workers: int = 1,
    progress: Progress | None = None,
) -> Robustness:
    """Linearise a gait for errors of its plant and pushes, then push it many times, and compare.

    Args:
        gait: a stabilised gait.
        out: folder that keeps the trials, in pieces; a run that was interrupted goes on from them.
        engines: names: ``native``, ``mujoco``.
        trials: of pushes in each.
        settings: of the trials.
        workers: processes.
        progress: called with what is being done.

    Raises:
        InputError: the gait is not stable or not stabilised, it turns, an engine cannot walk it, or the folder holds
            other trials.
        FallError: a walk with a small disturbance does not come back.
        WorkError: a worker fails.
    """
    settings, notify = settings or TrialSettings(), progress or silent
    check_trials(trials, workers)
    for name in engines:
        engine_named(name)
    notify(ProgressReport(what="spectrum of the return map"))
    cycle = CycleMap.of(gait)
    gains = input_gains(cycle, notify)
    response = push_response(cycle, settings.friction, notify)
    reaches = _reaches(cycle, settings, notify)
    folder = TrialFolder(place=Path(out) / "trials", gait=gait, settings=settings)
    done = do_trials(folder, engines, trials, workers, notify)
    return Robustness(
        gait=gait,
        settings=settings,
        radius=cycle.spectrum.radius,
        rate=cycle.rate,
        friction_used=response.friction_used,
        gains=gains,
        reaches=reaches,
        fast=fast_mode(cycle),
        trials=done,
        cells=tuple(_cells(response, done)),
    )


def _reaches(cycle: CycleMap, settings: TrialSettings, notify: Progress) -> tuple[Reach, ...]:
    kinds = [(kind, sign) for kind in disturbances(cycle.gait.robot) for sign in ((1, -1) if kind.both_signs else (1,))]
    found = []
    for number, (kind, sign) in enumerate(kinds):
        notify(ProgressReport(what=f"reach of {kind.name}", done=number, of=len(kinds)))
        found.append(_reach(cycle, settings, kind, sign))
    return tuple(found)


def _reach(cycle: CycleMap, settings: TrialSettings, kind: Disturbance, sign: int) -> Reach:
    """Search by halving the logarithm between the largest size that is borne and the smallest that is not."""

    def ended(size: float) -> str:
        errors = kind.errors(sign * size, settings.friction)
        system = on_unilateral_ground(cycle.gait, cycle.loop, errors)
        start = unilateral_start(cycle.gait, cycle.state)
        walked = walk(system, start, settings.cycles, TOLERANCE, 2, 2.0 * cycle.gait.period)
        return "" if walked.cycles >= settings.cycles else walked.arcs[-1].arc.ended or walked.ended

    low, high = SMALLEST, LARGEST if sign > 0 or kind.key != "trunk" else 0.9
    why = ended(low)
    if why:
        return Reach(disturbance=kind, sign=sign, size=0.0, ended=why)
    why = ended(high)
    if not why:
        return Reach(disturbance=kind, sign=sign, size=inf, ended="")
    for _ in range(HALVINGS):
        middle = sqrt(low * high)
        here = ended(middle)
        low, high, why = (low, middle, here) if here else (middle, high, why)
    return Reach(disturbance=kind, sign=sign, size=low, ended=why)


def _cells(response: PushResponse, trials: Mapping[str, Sequence[Trial]]) -> list[Cell]:
    found = []
    for sector in range(SECTORS):
        middle = 2.0 * pi * sector / SECTORS
        directions = middle + 2.0 * pi / SECTORS * ((np.arange(WITHIN) + 0.5) / WITHIN - 0.5)
        for bin_ in range(PHASE_BINS):
            places = np.flatnonzero((response.phases * PHASE_BINS).astype(int) == bin_)
            pairs = [(int(place), float(angle)) for place in places for angle in directions]
            inside = {
                name: [trial for trial in done if _sector(trial) == sector and int(trial.phase * PHASE_BINS) == bin_]
                for name, done in trials.items()
            }
            found.append(
                Cell(
                    direction=middle,
                    phase=(bin_ + 0.5) / PHASE_BINS,
                    by_metric=float(np.mean([response.by_metric(*pair) for pair in pairs])),
                    by_contact=float(np.mean([response.by_contact(*pair) for pair in pairs])),
                    measured={name: _threshold(some) for name, some in inside.items()},
                    trials={name: len(some) for name, some in inside.items()},
                )
            )
    return found


def _threshold(trials: Sequence[Trial]) -> float | None:
    if not trials:
        return None
    return half_survives([trial.impulse for trial in trials], [trial.survived for trial in trials])


def _sector(trial: Trial) -> int:
    return int(np.floor(trial.direction / (2.0 * pi / SECTORS) + 0.5)) % SECTORS
