"""One descent in free weights: of the mean bound of all orders of landing, or of that of one W for them all.

Each A_i of an order of landing may contract while no W does for all: ASTRo's trot at 0.2 sqrt(g l) came to radii below
0.9 and a common r of 1.04. From there weights theta and L, W = L^T L, are descended together, with the largest
|L A_i(theta) L^-1| smoothed by a moment of all singular values (``common_bound``).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from amble.errors import InputError, NotSolvedError, WorkError
from amble.progress import Progress, ProgressReport
from amble.stability.common_bound import common_bound, smoothed_norm
from amble.stability.weight_search import (
    MEMORY,
    Closed,
    ParametrisedMap,
    WeightSearch,
    least_bound,
    size_penalty,
)
from amble.types import Vector

SHARES = (1.0, 0.25, 0.0625)
"""Parts of the way to new weights that are tried."""

EXPONENT, EVALUATIONS = 16, 100
"""Of the moment, and of the return map in a descent of the common bound, at most."""


def least_common_bound(
    evaluate: Callable[[Vector], ParametrisedMap],
    theta: Vector,
    price: float,
    progress: Progress | None = None,
    evaluations: int = EVALUATIONS,
) -> Vector:
    """Descend from theta to parameters of least r with r^2 W - A_i^T W A_i > 0 for one W, by L-BFGS in them and L.

    Args:
        evaluate: what a choice of the parameters makes of the return map.
        theta: where to start.
        price: weight of the conditioning beside log r.
        progress: called after every evaluation.
        evaluations: of the return map, at most.

    Raises:
        NotSolvedError: the return map of some parameters cannot be computed.
    """
    from scipy.optimize import minimize

    count, done, penalty = theta.size, 0, size_penalty(price)

    def objective(trial: Vector) -> tuple[float, Vector]:
        nonlocal done
        here = evaluate(trial[:count])
        value, pull, slopes = smoothed_norm(trial[count:].reshape(root.shape) @ root, here.matrices, EXPONENT)
        done += 1
        if progress is not None:
            quantity = "contraction bound of all orders of landing"
            progress(
                ProgressReport(what="evaluation", done=done, of=evaluations, quantity=quantity, value=np.exp(value))
            )
        strain, steeper = here.conditioning()
        weights = trial[:count]
        slope = here.gradient(slopes) + price * steeper + 2.0 * penalty * weights
        total = value + price * strain + penalty * float(weights @ weights)
        return total, np.concatenate([slope, (pull @ root.T).ravel()])

    options = {"maxfun": evaluations, "maxcor": MEMORY}
    try:
        root = np.linalg.cholesky(common_bound(evaluate(theta).matrices).metric).T
        start = np.concatenate([theta, np.eye(len(root)).ravel()])
        found = minimize(objective, start, jac=True, method="L-BFGS-B", options=options)
        return np.asarray(found.x[:count])
    except (InputError, np.linalg.LinAlgError) as error:
        raise NotSolvedError(f"no return map for the weights that the descent tried: {error}") from None


def improved(
    search: WeightSearch,
    here: Closed,
    largest: float,
    notify: Progress,
    refusals: list[str],
    evaluations: int | None = None,
) -> Closed | None:
    """Return a closed loop of smaller bound whose radius is at most ``largest``; None, and why not, where none is.

    Args:
        search: the free weights.
        here: the closed loop to start from.
        largest: spectral radius, at most.
        notify: called between evaluations.
        refusals: what is added to, in sentences, where steps are refused.
        evaluations: of the mean bound's descent; None descends the bound of one W for all orders of landing.
    """
    try:
        proposed = (
            least_common_bound(search.evaluate, here.theta, search.price, notify)
            if evaluations is None
            else least_bound(search.evaluate, here.theta, notify, None, evaluations, search.price)
        )
    except WorkError as error:
        refusals.append(str(error))
        return None
    for share in SHARES:
        trial: Vector = here.theta + share * (proposed - here.theta)
        try:
            there = search.close(trial)
        except (WorkError, InputError) as error:  # the closed loop fell, did not close, or has dependent outputs
            refusals.append(str(error))
            continue
        if there.bound < here.bound and there.radius <= largest:
            return there
    return None
