"""Shares of trials: how sure they are, where they cross a half, and whether two orders agree."""

from __future__ import annotations

from collections.abc import Sequence
from math import erf, sqrt

import numpy as np

from amble.errors import InputError
from amble.types import Vector

NORMAL_95 = 1.959963984540054
"""Two-sided 95 % quantile of the normal distribution."""


def wilson(successes: int, trials: int, quantile: float = NORMAL_95) -> tuple[float, float]:
    """Return Wilson's score interval of a share.

    The shares p that a test of (k / n - p) / sqrt(p (1 - p) / n) against the quantile does not refuse.

    Args:
        successes: k.
        trials: n.
        quantile: of the normal distribution, two-sided; 95 % by default.

    Raises:
        InputError: there is no trial, or k is no number of n trials.
    """
    if not 0 <= successes <= trials or trials < 1:
        raise InputError(f"{successes} of {trials} trials is no share")
    from scipy.stats import binomtest

    found = binomtest(successes, trials).proportion_ci(confidence_level=erf(quantile / sqrt(2.0)), method="wilson")
    return float(found.low), float(found.high)


def falling_share(survived: Vector) -> Vector:
    """Return the most likely chance to survive each trial where a larger size never makes survival likelier, (n,).

    Isotonic regression (Ayer and others, Annals of Mathematical Statistics 26, 1955).

    Args:
        survived: 1 or 0, by ascending size, (n,).
    """
    from scipy.optimize import isotonic_regression

    if not len(survived):
        return np.zeros(0)
    return np.asarray(isotonic_regression(survived, increasing=False).x, dtype=np.float64)


def half_survives(sizes: Sequence[float] | Vector, survived: Sequence[bool] | Vector) -> float | None:
    """Return the size from which fewer than half of the trials survive; None where none was so large.

    Between the largest trial with a chance of at least a half and the next one; 0 where no trial has it.

    Args:
        sizes: of the disturbance of each trial, (n,).
        survived: whether it was survived, (n,).
    """
    order = np.argsort(sizes, kind="stable")
    size, lived = np.asarray(sizes, dtype=np.float64)[order], np.asarray(survived, dtype=np.float64)[order]
    above = np.flatnonzero(falling_share(lived) >= 0.5)
    if not above.size:
        return 0.0
    last = int(above[-1])
    return None if last == len(size) - 1 else float(0.5 * (size[last] + size[last + 1]))


def rank_correlation(first: Sequence[float] | Vector, second: Sequence[float] | Vector) -> float | None:
    """Return Spearman's rank correlation, equal values at their mean rank; None where one of both does not vary."""
    from scipy.stats import spearmanr

    one, other = (np.asarray(values, dtype=np.float64) for values in (first, second))
    if len(one) < 2 or not (np.ptp(one) > 0.0 and np.ptp(other) > 0.0):
        return None
    return float(spearmanr(one, other).statistic)
