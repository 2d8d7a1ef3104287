"""Records of the robustness of a gait: trials of pushes, reaches of errors, and both beside predictions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

from amble.amounts import check_amount
from amble.analysis.proportions import rank_correlation
from amble.errors import InputError
from amble.gait import Gait
from amble.stability.fast_mode import FastMode
from amble.stability.input_gains import Disturbance, InputGain
from amble.types import Json

MOST_CYCLES = 10_000
"""Of a pushed walk."""

LARGEST = 1.0
"""Impulse of the largest push, in m sqrt(g l)."""

SURVIVED = "walked on"


MOST_FRICTION, MOST_IMPULSE = 10.0, 1000.0
"""Of trials; the impulse in m sqrt(g l)."""


@dataclass(frozen=True, kw_only=True)
class TrialSettings:
    """What is tried.

    Attributes:
        seed: of the pushes.
        cycles: gait cycles that are walked, the push in the first of them.
        friction: of the ground.
        largest: impulse of the largest push, in m sqrt(g l).

    Raises:
        InputError: a number is out of its range.
    """

    seed: int = 1
    cycles: int = 8
    friction: float = 0.8
    largest: float = LARGEST

    def __post_init__(self) -> None:
        """Refuse what cannot be tried."""
        if self.seed < 0:
            raise InputError(f"the seed of the pushes is a whole number from 0 on, not {self.seed}")
        check_amount("cycles", self.cycles, 2, MOST_CYCLES)
        if not 0.0 < self.friction <= MOST_FRICTION or not 0.0 < self.largest <= MOST_IMPULSE:
            raise InputError(
                f"friction and largest impulse of the trials are positive numbers, up to {MOST_FRICTION:g} and "
                f"{MOST_IMPULSE:g}"
            )


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One push, and what became of the walk.

    Attributes:
        impulse: N s.
        direction: horizontal, rad from x (forward) to y (left).
        phase: share of the cycle at which the push begins.
        cycles: completed.
        ended: why the walk ended; ``SURVIVED`` where all cycles were walked.
    """

    impulse: float
    direction: float
    phase: float
    cycles: int
    ended: str

    @property
    def survived(self) -> bool:
        """Whether all cycles were walked."""
        return self.ended == SURVIVED


@dataclass(frozen=True, kw_only=True)
class Reach:
    """How large an error of the plant a walk bears with sound contacts, natively and all along.

    Attributes:
        disturbance: what it is.
        sign: 1 or -1.
        size: in natural units; 0 where the smallest that was tried is too large, infinite where the largest is borne.
        ended: what ends the walk with a little more.
    """

    disturbance: Disturbance
    sign: int
    size: float
    ended: str

    def to_dict(self) -> Json:
        """Return it as a dictionary for a JSON file."""
        size = None if self.size == inf else self.sign * self.size * self.disturbance.natural
        return {"name": self.disturbance.name, "unit": self.disturbance.unit, "size": size, "ended": self.ended}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """Pushes of one range of directions and phases.

    Attributes:
        direction: middle, rad.
        phase: middle, share of the cycle.
        by_metric: impulse that the linearisation predicts by W, up to a factor, N s.
        by_contact: impulse at which it predicts the first lost contact, N s.
        measured: engine -> impulse that half of the trials survive, N s; None where more do at every size tried.
        trials: engine -> number of trials in the cell.
    """

    direction: float
    phase: float
    by_metric: float
    by_contact: float
    measured: Mapping[str, float | None]
    trials: Mapping[str, int]

    def to_dict(self) -> Json:
        """Return it as a dictionary for a JSON file."""
        return {**vars(self), "measured": dict(self.measured), "trials": dict(self.trials)}


@dataclass(frozen=True, kw_only=True)
class Robustness:
    """What is known about the robustness of a gait.

    Attributes:
        gait: the gait.
        settings: of the trials.
        radius: spectral radius of the full cycle.
        rate: r of the certificate's W.
        friction_used: largest friction that the orbit uses.
        gains: of errors of the plant.
        reaches: how large they may be.
        fast: fastest modes.
        trials: engine -> trials of pushes.
        cells: pushes by direction and phase, predicted and measured.
    """

    gait: Gait
    settings: TrialSettings
    radius: float
    rate: float
    friction_used: float
    gains: tuple[InputGain, ...]
    reaches: tuple[Reach, ...]
    fast: FastMode
    trials: Mapping[str, tuple[Trial, ...]]
    cells: tuple[Cell, ...]

    def correlations(self) -> dict[str, dict[str, tuple[float | None, int]]]:
        """Return engine -> prediction -> rank correlation with what was measured, over how many cells.

        Cells in which more than half of the trials survive at every size are left out: their threshold is not known.
        """
        found: dict[str, dict[str, tuple[float | None, int]]] = {}
        for engine in self.trials:
            known = [(cell, size) for cell in self.cells if (size := cell.measured[engine]) is not None]
            sizes = [size for _, size in known]
            found[engine] = {
                name: (rank_correlation([float(getattr(cell, name)) for cell, _ in known], sizes), len(known))
                for name in ("by_metric", "by_contact")
            }
        return found

    def to_dict(self) -> Json:
        """Return it as a dictionary for a JSON file."""
        return {
            "gait": self.gait.pattern.name,
            "robot": self.gait.robot.name,
            "settings": dict(vars(self.settings)),
            "spectral_radius": self.radius,
            "contraction_bound": self.rate,
            "friction_used": self.friction_used,
            "gains": [gain.to_dict() for gain in self.gains],
            "reaches": [reach.to_dict() for reach in self.reaches],
            "fast_mode": self.fast.to_dict(),
            "trials": {name: len(trials) for name, trials in self.trials.items()},
            "survived": {name: sum(trial.survived for trial in trials) for name, trials in self.trials.items()},
            "cells": [cell.to_dict() for cell in self.cells],
            "rank_correlations": {
                engine: {name: {"value": value, "cells": count} for name, (value, count) in pairs.items()}
                for engine, pairs in self.correlations().items()
            },
        }
