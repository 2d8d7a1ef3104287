"""The bilinear matrix inequality problem of orbital stabilisation, solved in the weights and W together.

The problem (Akbari Hamed et al. 2014; docs/theory/stability.md, eq. 20 to 24): find weights theta, W > 0 and the least
r with r^2 W - A(theta)^T W A(theta) > 0. It is bilinear in W and theta. With trace W bounded by c its best W for given
weights solves a Lyapunov equation, and r is the smoothed spectral radius (``lyapunov``): W is eliminated, and a smooth
function of the weights alone is left, with an exact gradient. No linear model in the weights and no semidefinite
program is needed.
"""

from __future__ import annotations

import itertools

import numpy as np

from amble.errors import InputError, NotSolvedError
from amble.progress import Progress, ProgressReport
from amble.stability.lyapunov import smoothed_radius
from amble.stability.orbit import Orbit
from amble.stability.weighted_map import Weighting, weighted_map
from amble.types import Vector

TRACE = 1e5
"""Bound c of trace W for states in natural units, so that no disturbance grows by more than sqrt(c)."""

SIZE_PENALTY = 1e-4
"""Weight of |theta|^2 beside log r: large weights amplify what the model leaves out."""

EVALUATIONS = 150
MEMORY = 30


def least_bound(orbit: Orbit, weighting: Weighting, theta: Vector, progress: Progress | None = None) -> Vector:
    """Descend from theta to weights of least bound r, by L-BFGS.

    Raises:
        NotSolvedError: the return map of some weights cannot be computed.
    """
    from scipy.optimize import minimize

    numbers = itertools.count(1)

    def objective(trial: Vector) -> tuple[float, Vector]:
        here = weighted_map(orbit, weighting, trial)
        found = smoothed_radius(here.matrix, TRACE)
        if progress is not None:
            quantity = "contraction bound of the return map"
            progress(
                ProgressReport(
                    what="evaluation", done=next(numbers), of=EVALUATIONS, quantity=quantity, value=found.value
                )
            )
        value = float(np.log(found.value)) + SIZE_PENALTY * float(trial @ trial)
        return value, here.gradient(found.slope) + 2.0 * SIZE_PENALTY * trial

    options = {"maxfun": EVALUATIONS, "maxcor": MEMORY}
    try:
        return np.asarray(minimize(objective, theta, jac=True, method="L-BFGS-B", options=options).x)
    except (InputError, np.linalg.LinAlgError) as error:
        raise NotSolvedError(f"no return map for the weights that the descent tried: {error}") from None
