"""Where a stabilisation begins: at the weights of the gait problem or the gains of a law, or at a neighbour's."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from amble.control.outputs import controllable, selection_matrix
from amble.defaults import FREE
from amble.errors import InputError, WorkError, printable
from amble.gait import Feedback, Gait
from amble.gait.linearising_law import InputOutputLinearisation
from amble.stability.gain_search import GainSearch
from amble.stability.weight_search import EVALUATIONS, Closed, WeightSearch

logger = logging.getLogger("amble")

FEW = 15
"""Evaluations of a descent from a neighbour's weights. ASTRo's amble from 0.2 to 0.3 m/s in three steps: radius 0.73
under the weights kept, 0.23 after one such descent a step, which take a thirtieth of the time of whole ones."""

ENOUGH = 0.6
"""Spectral radius of a gait cycle at which descents from a neighbour's weights end."""


@dataclass(frozen=True)
class Descents:
    """How many descents, at most, of how many evaluations each; none is begun at a radius of ``enough`` or below."""

    rounds: int
    evaluations: int
    enough: float = 0.0


WHOLE, NEAR = Descents(3, EVALUATIONS), Descents(5, FEW, ENOUGH)
"""Each of the whole ones is on the closed loop's own orbit under the weights of the one before."""


@dataclass(frozen=True, kw_only=True)
class SearchStart:
    """A search with the closed loop where it begins.

    Attributes:
        search: over weights or gains.
        closed: the closed loop at its start.
        free: coordinates whose weights are free; none for gains.
        descents: what is worth trying from there first.
    """

    search: WeightSearch | GainSearch
    closed: Closed
    free: tuple[str, ...]
    descents: Descents


def begin(gait: Gait, free: Sequence[str] | None, near: Gait | None) -> SearchStart:
    """Start from a neighbour where the closed loop has an orbit under its weights or gains, else from the gait.

    Errors and arguments are those of ``stabilization``.
    """
    own = gait.control is None or isinstance(gait.control, InputOutputLinearisation)
    angles = tuple(name for name in FREE if name in controllable(gait.robot))
    freed = tuple(angles if free is None else free) if own else ()
    feedback = None if near is None else near.feedback
    if near is not None and feedback is not None:
        known = tuple(dict.fromkeys((*freed, *(_weighted(near, feedback) if own and free is None else ()))))
        try:
            return _started(
                WeightSearch.of(gait, known, feedback.weights)
                if own
                else GainSearch.of(replace(gait, control=near.control)),
                known,
                NEAR,
            )
        except (WorkError, InputError) as error:
            logger.info("the neighbour's weights are no start: %s", printable(str(error).splitlines()[0]))
    return _started(WeightSearch.of(gait, freed) if own else GainSearch.of(gait), freed, WHOLE)


def _started(search: WeightSearch | GainSearch, free: tuple[str, ...], descents: Descents) -> SearchStart:
    return SearchStart(search=search, closed=search.close(np.zeros(search.size)), free=free, descents=descents)


def _weighted(gait: Gait, feedback: Feedback) -> tuple[str, ...]:
    """Return the coordinates whose weights are not those of the gait problem."""
    names, found = controllable(gait.robot), set[int]()
    for stance in gait.pattern.solved:
        changed = feedback.weights[stance.name] != selection_matrix(gait.robot, gait.outputs.of(stance.name))
        found |= set(np.flatnonzero(changed.any(axis=0)).tolist())
    return tuple(names[place] for place in sorted(found))
