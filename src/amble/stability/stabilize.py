"""Exponential orbital stabilisation: output weights or gains that make the orbit attractive without moving it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from amble.defaults import METHOD, METHODS, Method
from amble.errors import UnknownNameError, WorkError
from amble.gait import Gait
from amble.progress import Progress, ProgressReport, silent
from amble.stability.descent import improved
from amble.stability.gain_search import GainSearch
from amble.stability.nearest_gains import nearest_gains
from amble.stability.search_start import NEAR, WHOLE, Descents, begin
from amble.stability.weight_search import CHEAPEST, Closed, WeightSearch

TARGET, SMALLEST_GAIN = 0.95, 0.1
"""Spectral radius of a gait cycle above which more weights are freed, where nobody says which are, or gains changed;
share of the bound that a descent has to gain for another to follow."""

BELOW_ONE = float(np.nextafter(1.0, 0.0))

TOGETHER, SMALLEST_STEP = 8, 0.01
"""Descents of the bound of one W for all orders of landing, at most; share of it that each has to gain for another."""

FLAT = 1e-6
"""Slope, by the steepest, of weights that do not matter: those on outputs that are controlled anyway have none."""

FREED = 3
"""Joints whose weights are freed at a time: those in which the bound is steepest."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """The closed loop under some weights, computed at its own fixed point.

    Attributes:
        number: from 1; 0 is the start.
        radius: spectral radius of a whole gait cycle; where feet land one by one, the largest of all orders.
        bound: r of a whole gait cycle: V(x) = x^T W x falls by r^2 in it, in every order of landing.
        length: how far the weights moved.
        drift: how far the fixed point moved since the start, largest component.
        seconds: wall time since the start.
    """

    number: int
    radius: float
    bound: float
    length: float
    drift: float
    seconds: float


@dataclass(frozen=True, kw_only=True)
class Stabilized:
    """The result of a stabilisation.

    Attributes:
        gait: the gait with stabilised feedback, starting at its own fixed point.
        steps: the accepted steps, the first the start; every one has a smaller bound than the one before, and no larger
            radius than the start.
        reason: why it stopped, with every set of weights that was tried, and why steps were refused.
        parameters: number of free weights.
        free: coordinates whose weights were free in the end.
        seconds: wall time of everything, s.
    """

    gait: Gait
    steps: tuple[Step, ...]
    reason: str
    parameters: int
    free: tuple[str, ...]
    seconds: float

    @property
    def initial(self) -> float:
        """Spectral radius of a gait cycle before."""
        return self.steps[0].radius

    @property
    def radius(self) -> float:
        """Spectral radius of a gait cycle after."""
        return self.steps[-1].radius

    @property
    def bound(self) -> float:
        """Contraction bound r of a gait cycle after."""
        return self.steps[-1].bound


class NotStabilizedError(WorkError):
    """The orbit stays unstable; the message names the best radius and the outputs that limit it."""


def stabilize(
    gait: Gait, free: Sequence[str] | None = None, method: Method = METHOD, progress: Progress | None = None
) -> Gait:
    """Return the gait with output weights that make its orbit exponentially stable; see ``stabilization``."""
    return stabilization(gait, free, method, progress).gait


def stabilization(
    gait: Gait,
    free: Sequence[str] | None = None,
    method: Method = METHOD,
    progress: Progress | None = None,
    near: Gait | None = None,
) -> Stabilized:
    """Stabilise a gait's orbit by weights on the outputs, y = H (y_a - y_d), or by the gains of its control law.

    Gains of a ``TorqueLaw`` such as ``Impedance`` change as little as leads to ``TARGET`` (``nearest_gains``).

    For weights the contraction bound of the return map is minimised (``least_bound``) on the closed loop's orbit, and
    again on that under the weights found, until that gains less than 10 %. Where nobody says which are free, those of
    the base are first; while the spectral radius stays above ``TARGET``, the joints in which the bound is steepest are
    freed as well, until no other weight matters. Where the orbit would stay unstable so, ill-conditioned outputs are
    priced less, down to ``CHEAPEST``.

    Args:
        gait: the gait; feedback that it already has is replaced.
        free: coordinates among roll, pitch, yaw and the joints whose columns of H are free, by default growing.
        method: what chooses the parameters; there is one, the paper's "bilinear".
        progress: called with every accepted step, and between them.
        near: a stabilised gait of the same stances and outputs, such as that of a speed a little less: its weights or
            gains are the start, and short descents are tried first. Without an orbit under them all begins anew.

    Raises:
        InputError: feet land one by one in too many orders, or the law has no gains to choose.
        UnknownNameError: a free coordinate or the method does not exist.
        NotStabilizedError: the radius stays at 1 or above; the message says why.
        FallError, NotSolvedError: the closed loop has no orbit near the gait.
    """
    began, notify = time.perf_counter(), progress or silent
    _require_method(method)
    notify(ProgressReport(what="orbit of the closed loop"))
    start = begin(gait, free, near)
    search, here, freed, descents = start.search, start.closed, start.free, start.descents
    steps, reasons = [_step(0, here, here, began)], list[str]()
    notify(_report(steps[0]))
    if isinstance(search, GainSearch):
        there, reason = nearest_gains(search, here, TARGET, notify)
        steps += [_step(1, there, here, began)] if there is not here else []
        return _result(search, there, steps, [reason], freed, began)
    while True:
        search, here = _descended(search, here, steps, reasons, began, notify, descents)
        if descents is NEAR and not here.contracts(TARGET):
            descents = WHOLE
            continue
        if free is not None or here.contracts(TARGET):
            break
        if not (more := _steepest(search, here, freed)):
            search, here = _joined(search, here, steps, reasons, began, notify)
            if here.contracts(BELOW_ONE) or search.price <= CHEAPEST:
                break
            search = _cheaper(search, here, reasons, notify)
            continue
        reasons[-1] += f" (spectral radius {here.radius:.4g} with {', '.join(freed)} free)"
        notify(ProgressReport(what=f"weights of {', '.join(more)} are freed"))
        search, freed = search.freeing(here, (*freed, *more)), (*freed, *more)
        here = replace(here, theta=np.zeros(search.size))
    return _result(search, here, steps, reasons, freed, began)


def _result(
    search: WeightSearch | GainSearch,
    here: Closed,
    steps: Sequence[Step],
    reasons: Sequence[str],
    freed: tuple[str, ...],
    began: float,
) -> Stabilized:
    reason = "; ".join(reasons)
    if here.radius >= 1.0:
        raise NotStabilizedError(_explanation(search, here, freed, reason))
    return Stabilized(
        gait=here.gait,
        steps=tuple(steps),
        reason=reason,
        parameters=here.theta.size,
        free=freed,
        seconds=time.perf_counter() - began,
    )


def _require_method(method: str) -> None:
    if method != METHOD:
        raise UnknownNameError("method", method, METHODS)


def _descended(
    search: WeightSearch,
    here: Closed,
    steps: list[Step],
    reasons: list[str],
    began: float,
    notify: Progress,
    descents: Descents,
) -> tuple[WeightSearch, Closed]:
    """Descend in what is free; steps, and in one sentence why it stopped, are added to what is handed in."""
    refusals: list[str] = []
    reason = f"{descents.rounds} descents done"
    for _ in range(descents.rounds):
        there = improved(search, here, steps[0].radius, notify, refusals, descents.evaluations)
        if there is None:
            reason = "no step reduces the bound any more"
            break
        steps.append(_step(len(steps), there, here, began))
        notify(_report(steps[-1]))
        gain, here = 1.0 - there.bound / here.bound, there
        if gain < SMALLEST_GAIN:
            reason = f"the last descent gained less than {SMALLEST_GAIN:.0%}"
            break
        if here.contracts(descents.enough):
            reason = f"a spectral radius of {descents.enough:g} is enough"
            break
        search = search.around(here)
    reasons.append("; ".join([reason, *(f"refused: {refusal}" for refusal in refusals)]))
    return _joined(search, here, steps, reasons, began, notify) if here.radius <= TARGET else (search, here)


def _joined(
    search: WeightSearch, here: Closed, steps: list[Step], reasons: list[str], began: float, notify: Progress
) -> tuple[WeightSearch, Closed]:
    """Where feet land one by one, descend the bound of one W for all orders of landing until it is below 1."""
    refusals: list[str] = []
    for _ in range(TOGETHER):
        if len(here.passages) == 1 or here.contracts(BELOW_ONE):
            break
        search = search.around(here)
        there = improved(search, here, steps[0].radius, notify, refusals)
        if there is None:
            reasons[-1] += f"; one W for all orders of landing is not found, r = {here.bound:.4g}"
            reasons[-1] += "".join(f"; refused: {refusal}" for refusal in refusals)
            break
        steps.append(_step(len(steps), there, here, began))
        notify(_report(steps[-1]))
        gain, here = 1.0 - there.bound / here.bound, there
        if gain < SMALLEST_STEP:
            break
    return search, here


def _cheaper(search: WeightSearch, here: Closed, reasons: list[str], notify: Progress) -> WeightSearch:
    """Go on with a tenth of the price of ill-conditioned outputs."""
    reasons[-1] += f" (spectral radius {here.radius:.4g} with ill-conditioned outputs at a price of {search.price:g})"
    notify(ProgressReport(what="ill-conditioned outputs cost a tenth from here on"))
    return replace(search, price=search.price / 10.0)


def _steepest(search: WeightSearch, here: Closed, freed: Sequence[str]) -> tuple[str, ...]:
    """Return the coordinates to free next: the steepest of those that are not; none where no other weight matters."""
    effect = search.pulls(here.theta)
    least = FLAT * max(effect.values())
    others = sorted(
        (name for name in effect if name not in freed and effect[name] > least), key=lambda name: -effect[name]
    )
    return tuple(others[:FREED])


def _step(number: int, there: Closed, before: Closed, began: float) -> Step:
    return Step(
        number=number,
        radius=there.radius,
        bound=there.bound,
        length=float(np.linalg.norm(there.theta - before.theta)),
        drift=there.drift,
        seconds=time.perf_counter() - began,
    )


def _report(step: Step) -> ProgressReport:
    return ProgressReport(
        what="step",
        done=step.number,
        of=WHOLE.rounds,
        quantity="spectral radius of the full cycle",
        value=step.radius,
        detail=f"contraction bound {step.bound:.4g}",
    )


def _explanation(search: WeightSearch | GainSearch, here: Closed, free: Sequence[str], reason: str) -> str:
    """Say what limits the bound: by how much a weight on each coordinate, or a gain, would change it, best first."""
    effect = search.pulls(here.theta)
    steepest = sorted(effect, key=lambda name: -effect[name])

    def told(names: Sequence[str]) -> str:
        return ", ".join(f"{name} ({effect[name]:.2g})" for name in names)

    stays = f"the orbit stays unstable: best spectral radius of a gait cycle {here.radius:.4g} ({reason}); "
    if isinstance(search, GainSearch):
        return f"{stays}slope of the logarithm of its bound in the logarithms of the gains: {told(steepest[:6])}"
    others = [name for name in steepest if name not in free][:3]
    return (
        f"{stays}slope of the logarithm of its bound in the weights that were free: {told(free)}; "
        f"in those that were not: {told(others)}"
    )
