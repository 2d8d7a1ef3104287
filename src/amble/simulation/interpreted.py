"""The flow through a domain where there is no C compiler: scipy's DOP853, and the watch on the guards along its steps.

The rule for guards is that of native code: ``first_event`` of ``dormand_prince.c`` does the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, inf, isfinite, isnan
from typing import Any

import casadi as ca
import numpy as np

from amble.hybrid.system import numeric
from amble.simulation.flow import (
    EVENT_SAMPLES,
    MOST_STEPS,
    RESOLUTION,
    STEEP,
    STUCK,
    TOO_LONG,
    Arc,
    EventFunction,
    FlowDefinition,
)
from amble.types import Vector

FLAT = 0.01
"""Of the largest slope in a panel: the slope of a polynomial through the samples is no exact one."""

HALVINGS = 60
GOLDEN = 0.3819660112501051

SLOPES = (
    np.array(
        [[-25, 48, -36, 16, -3], [-3, -10, 18, -6, 1], [1, -8, 0, 8, -1], [-1, 6, -18, 10, 3], [3, -16, 36, -48, 25]]
    )
    / 3.0
)
"""Slopes at five evenly spaced samples, per panel, of the polynomial through them."""

Signed = Callable[[float], float]
"""The guard along the step, by its clock; it fires where it rises through zero."""


class SteepError(FloatingPointError):
    """A guard is steeper than its slope bound."""


def evaluated(function: ca.Function, clock: float, state: Vector, parameters: Vector) -> Any:
    """Evaluate a function (t, x, p).

    Raises:
        FloatingPointError: a solver inside did not converge, an assertion does not hold.
    """
    try:
        return function(clock, state, parameters)
    except RuntimeError:
        raise FloatingPointError from None


@dataclass(frozen=True)
class _Panel:
    """Looks at a guard with their values; ``entry`` says that the first is the guard's first at all."""

    clock: Vector
    value: Vector
    entry: bool


def first_event(definition: FlowDefinition, piece: Any, max_step: float, values: Vector) -> tuple[int, float] | None:
    """Sample the guards along a step, keeping their last values; returns the first crossing (guard, clock).

    Args:
        definition: of the flow.
        piece: dense output of the step.
        max_step: the longest time between two event samples, s.
        values: of the guards at the end of the step before, NaN where a guard was not sampled yet; changed.

    Raises:
        FloatingPointError: a guard is not a number.
        SteepError: a guard is steeper than its slope bound.
    """
    length = piece.t - piece.t_old
    panels = max(1, ceil(length / (EVENT_SAMPLES * max_step)))
    for number in range(panels):
        begin, end = (piece.t_old + length * edge / panels for edge in (number, number + 1))
        found, sound = (inf, -1), inf
        for guard, item in enumerate(definition.events):
            first = max(item.dead_time, RESOLUTION)
            if end <= first:
                continue
            signed = _along(definition, item, piece)
            panel = _sampled(signed, max(begin, first), end, values[guard])
            values[guard] = panel.value[-1]
            if panel.clock.size <= EVENT_SAMPLES:
                sound, values[guard] = min(sound, panel.clock[-1]), np.nan
            found = min(found, (_crossing(signed, panel, item.slope_bound), guard))
        if sound < inf and not found[0] <= sound:
            raise FloatingPointError
        if found[0] < inf:
            return found[1], found[0]
    return None


def _along(definition: FlowDefinition, item: EventFunction, piece: Any) -> Signed:
    def signed(clock: float) -> float:
        return item.direction * float(evaluated(item.function, clock, piece(clock), definition.parameters))

    return signed


def _sampled(signed: Signed, begin: float, end: float, known: float) -> _Panel:
    """Look at a guard from begin to end, up to where it is a number."""
    entry = isnan(known)
    clocks = np.linspace(begin, end, EVENT_SAMPLES + 1)
    values = [signed(begin) if entry else known]
    for clock in clocks[1:]:
        value = signed(float(clock))
        if isnan(value):
            break
        values.append(value)
    if isnan(values[0]):
        raise FloatingPointError
    return _Panel(clocks[: len(values)], np.array(values), entry)


def _crossing(signed: Signed, panel: _Panel, slope_bound: float) -> float:
    """Return the clock of the first crossing in a panel, infinite where there is none."""
    clock, value = panel.clock, panel.value
    slope = SLOPES @ value if value.size > EVENT_SAMPLES else None
    for i in range(value.size - 1):
        root = inf
        if isfinite(slope_bound):
            root = _bounded(signed, slope_bound, (clock[i], value[i]), (clock[i + 1], value[i + 1]))
        elif value[i] < 0 <= value[i + 1]:
            root = _root(signed, clock[i], clock[i + 1])
        elif (value[i] < 0) == (value[i + 1] < 0) and slope is not None and _turns(panel, slope, i):
            root = _excursion(signed, clock[i], clock[i + 1], -1 if value[i] < 0 else 1)
        if root < inf:
            return root
    return inf


def _turns(panel: _Panel, slope: Vector, i: int) -> bool:
    """Whether a guard of one sign at samples i and i + 1 may come to zero between.

    It turns there, and it is no farther from zero than it changes in the panel. At the entry a guard may be zero and
    rest there: roundoff turns it.
    """
    pair = panel.value[i : i + 2]
    if np.abs(pair).min() > np.ptp(panel.value):
        return False
    sign = -1 if pair[0] < 0 else 1
    flat = FLAT * np.abs(slope).max()
    return bool(sign * slope[i] < (-flat if panel.entry and i == 0 else flat) and sign * slope[i + 1] > -flat)


def _excursion(signed: Signed, begin: float, end: float, sign: int) -> float:
    """Return the first crossing of a guard that leaves its side (sign) and returns between begin and end.

    By golden sections towards the extreme that is closest to zero.
    """
    a, b = begin, end
    c, d = a + GOLDEN * (b - a), b - GOLDEN * (b - a)
    at_c, at_d = signed(c), signed(d)
    for _ in range(HALVINGS):
        where, value = (c, at_c) if sign * at_c < sign * at_d else (d, at_d)
        if (value < 0) != (sign < 0):
            return _root(signed, begin, where) if sign < 0 else _root(signed, where, end)
        if where == c:
            b, d, at_d = d, c, at_c
            c = a + GOLDEN * (b - a)
            at_c = signed(c)
        else:
            a, c, at_c = c, d, at_d
            d = b - GOLDEN * (b - a)
            at_d = signed(d)
    return inf


def _bounded(signed: Signed, bound: float, begin: tuple[float, float], end: tuple[float, float]) -> float:
    """Return the first crossing of a guard with a bounded slope: what the bound does not rule out is halved."""
    (a, at_a), (b, at_b) = begin, end
    reach = bound * (b - a)
    if not abs(at_b - at_a) <= reach * (1 + 1e-6) + 1e-12 * (abs(at_a) + abs(at_b)):
        raise SteepError
    if abs(at_a) + abs(at_b) > reach or b - a < RESOLUTION:
        return _root(signed, a, b) if at_a < 0 <= at_b else inf
    middle = 0.5 * (a + b)
    between = middle, signed(middle)
    left = _bounded(signed, bound, begin, between)
    return _bounded(signed, bound, between, end) if left == inf else left


def _root(signed: Signed, earlier: float, later: float) -> float:
    from scipy.optimize import brentq

    if signed(earlier) >= 0:  # zero within roundoff where a step began
        return earlier
    return float(brentq(signed, earlier, later, xtol=1e-15, rtol=1e-15, maxiter=1000))


@dataclass(frozen=True)
class InterpretedFlow:
    """A prepared flow."""

    definition: FlowDefinition

    def __call__(self, start: Vector, tolerance: float, time_limit: float, samples: int, max_step: float) -> Arc:
        """Integrate from a state at clock 0 until an event fires; see ``Flow``."""
        entry = np.array(start, dtype=np.float64)
        pieces: list[Any] = []
        try:
            with np.errstate(all="ignore"):  # what is not finite is reported, not warned about
                crossing = self._integrate(entry, tolerance, time_limit, max_step, pieces)
        except SteepError:
            return _arc(pieces, entry, samples, pieces[-1].t_old, None, STEEP)
        except FloatingPointError:
            return _arc(pieces, entry, samples, pieces[-1].t if pieces else 0.0, None, STUCK)
        if crossing is None:
            return _arc(pieces, entry, samples, time_limit, None, TOO_LONG)
        which, ended = self.definition.outcome(crossing[0])
        return _arc(pieces, entry, samples, crossing[1], which, ended)

    def _integrate(
        self, start: Vector, tolerance: float, time_limit: float, max_step: float, pieces: list[Any]
    ) -> tuple[int, float] | None:
        """Step from breakpoint to breakpoint, collecting the dense output; returns the first crossing (guard, clock).

        Raises:
            FloatingPointError: where the motion cannot go on.
        """
        from scipy.integrate import DOP853

        values = np.full(len(self.definition.events), np.nan)
        clock, state = 0.0, start
        for limit in (*(at for at in self.definition.breakpoints if at < time_limit), time_limit):
            stepper = DOP853(self._rate, clock, state, limit, rtol=tolerance, atol=tolerance)
            while stepper.status == "running":
                stepper.step()
                if stepper.status == "failed" or len(pieces) >= MOST_STEPS:
                    raise FloatingPointError
                pieces.append(stepper.dense_output())
                crossing = first_event(self.definition, pieces[-1], max_step, values)
                if crossing is not None:
                    return crossing
            clock, state = stepper.t, stepper.y
        return None

    def _rate(self, clock: float, state: Vector) -> Vector:
        return numeric(evaluated(self.definition.field, clock, state, self.definition.parameters))


def prepare(definition: FlowDefinition) -> InterpretedFlow:
    """Prepare a flow."""
    return InterpretedFlow(definition)


def _arc(pieces: Sequence[Any], start: Vector, samples: int, end: float, fired: int | None, ended: str) -> Arc:
    clock = np.linspace(0.0, end, samples)
    starts = [piece.t_old for piece in pieces]
    state = np.tile(np.array(start, dtype=np.float64), (samples, 1))
    for row, moment in enumerate(clock):
        if pieces:
            state[row] = pieces[max(int(np.searchsorted(starts, moment, side="right")) - 1, 0)](moment)
    return Arc(clock, state, fired, ended, len(pieces))
