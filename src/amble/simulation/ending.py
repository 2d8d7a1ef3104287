"""Why a motion ends without a transition, in words that name the cause."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amble.hybrid import Transition
from amble.simulation.flow import RESOLUTION, TOO_LONG, Arc, Flow
from amble.simulation.prepared import PreparedDomain
from amble.types import Vector

MOST_EVENTS = 10000
"""Events of one cycle: a motion that never enters the first domain again has to end."""

TOO_MANY = f"has not entered the first domain again after {MOST_EVENTS} events"
ZENO = "has events that accumulate (Zeno): they follow each other faster than their clock can be told"

FEWEST_STAYS, MOST_STAYS = 5, 200
SHRINKING, SHRUNK = 0.9999, 0.6
"""Each stay is this share of the one before at most, and the last this share of the first of them."""

ACCUMULATED = 100.0 * RESOLUTION
"""A stay in a domain so short that its end is no longer located well, s."""

SHORTLY = 1e-6
"""After this share of the time limit it is seen where a guard goes from the entry."""


def endless(stays: Sequence[float], passed: int) -> str:
    """Say why a motion with ever more events is not followed farther; empty where it is.

    Events accumulate where the last stays in a domain shrink, each against the one before, and the last is nothing. Of
    stays that are short and come to a limit above 0 the ratio goes to 1.

    Args:
        stays: durations of the stays in the present domain so far, in order, s.
        passed: events of the present cycle so far.
    """
    if passed >= MOST_EVENTS:
        return TOO_MANY
    latest = np.array(stays[-MOST_STAYS:])
    if latest.size < FEWEST_STAYS or latest[-1] >= ACCUMULATED:
        return ""
    shrinks = np.all(latest[1:] <= SHRINKING * latest[:-1]) and latest[-1] <= SHRUNK * latest[0]
    return ZENO if shrinks else ""


def explained(here: PreparedDomain, flow: Flow, entry: Vector, arc: Arc, place: str, time_limit: float) -> str:
    """Say why an arc ended without a transition, where, and what the user can do.

    Args:
        here: the domain.
        flow: through it.
        entry: state at its entry, (n,); of a flow that carries more than the state, all of it.
        arc: the arc.
        place: where it ended, in words.
        time_limit: the longest that a domain may last, s.
    """
    if arc.ended != TOO_LONG:
        return f"{arc.ended} {place}"
    limit = f"reached no guard within the time limit {place} (time_limit is {time_limit:g} s)"
    short = SHORTLY * time_limit
    later = flow(entry, 1e-10, short, 2, short).state[-1]
    passed = [_passed(here, transition, entry, later, short) for transition in here.leaving]
    return "; ".join([limit, *filter(None, passed)])


def _passed(here: PreparedDomain, transition: Transition, entry: Vector, later: Vector, short: float) -> str:
    """Say how a guard was already past zero at the entry; empty where it was not."""
    size = here.domain.state_size
    before, after = (
        transition.direction * float(transition.guard(clock, state[:size], here.domain.parameters))
        for clock, state in ((0.0, entry), (short, later))
    )
    if not after > max(before, 0.0) or transition.dead_time > 0.0:
        return ""
    if abs(before) <= 1e-3 * (after - before):
        return (
            f"the guard of '{transition.name}' is zero at the entry and passes it at once: where the fields of both "
            "sides point at it the motion slides along it, for which there is no domain"
        )
    if before > 0.0:
        return f"the guard of '{transition.name}' was past zero at the entry and moved away"
    return ""
