"""The gains nearest to those of the start under which an orbit attracts.

Default gains were tried against errors of the plant (docs/validation.md). Gains found for the return map alone were
not: they ring where commands come late. So gains change as little as makes the orbit attract
(docs/theory/impedance.md, section 4).
"""

from __future__ import annotations

from amble.errors import InputError, WorkError
from amble.progress import Progress, ProgressReport
from amble.stability.gain_search import GainSearch
from amble.stability.weight_search import Closed, least_bound

PRICES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.006, 0.004, 0.002, 0.001)
"""Of the sum of squares of log(gain / gain at the start), beside the logarithm of the contraction bound; in turn."""


def nearest_gains(search: GainSearch, start: Closed, target: float, progress: Progress) -> tuple[Closed, str]:
    """Return the closed loop under the nearest gains whose spectral radius is at most a target, and why it is these.

    The price of a change falls from descent to descent, each of which begins where the one before ended, until the
    radius is reached, in all orders of landing by one quadratic function. Where it is not, the closed loop of the
    smallest radius is returned.

    Args:
        search: over the gains.
        start: the closed loop at theta = 0.
        target: spectral radius of a gait cycle.
        progress: called with every price and after every evaluation.
    """
    if start.contracts(target):
        return start, f"a spectral radius of {target:g} is enough"
    best, theta, refused = start, start.theta, list[str]()
    for number, price in enumerate(PRICES):
        progress(ProgressReport(what=f"gains at a price of {price:g} for change", done=number, of=len(PRICES)))
        try:
            theta = least_bound(search.evaluate, theta, progress, search.bounds, price=price)
            if search.radius(theta) > target and price > PRICES[-1]:
                continue
            there = search.close(theta)
        except (WorkError, InputError) as error:  # no return map, no orbit near, or another orbit
            refused.append(str(error))
            continue
        if there.bound < best.bound and (there.radius < best.radius or there.contracts(target)):
            best = there
        if best.contracts(target):
            break
    reached = f"gains nearest to those of the start with a spectral radius of at most {target:g}"
    orders = " and one quadratic function for all orders of landing" if best.radius <= target else ""
    reason = reached if best.contracts(target) else f"no gains were found with a spectral radius of {target:g}{orders}"
    return best, "; ".join([reason, *(f"refused: {why}" for why in refused)])
