"""Expressions evaluated at many states at once, and the error by which they are judged."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from amble.robot import Robot
from amble.types import Matrix, Vector


def sampled(of: Robot, build: Callable[..., ca.SX], *samples: Matrix) -> Matrix:
    """Evaluate an expression of vectors at every sample, (samples, entries) with matrices in column order."""
    symbols = [ca.SX.sym(f"a{i}", of.size) for i in range(len(samples))]
    function = ca.Function("f", symbols, [ca.vec(ca.densify(build(*symbols)))])
    return np.asarray(function(*(sample.T for sample in samples))).reshape(-1, samples[0].shape[0], order="F").T


def theirs(evaluate: Callable[..., Matrix | Vector | float], *samples: Matrix) -> Matrix:
    """Evaluate an oracle at every sample, (samples, entries) with matrices in column order."""
    return np.array([np.ravel(evaluate(*row), order="F") for row in zip(*samples, strict=True)])


def relative_error(ours: Matrix, expected: Matrix) -> float:
    """Largest deviation of a sample, relative to the largest entry of that sample."""
    assert ours.shape == expected.shape
    assert np.isfinite(ours).all()
    return float((np.abs(ours - expected).max(axis=1) / np.abs(expected).max(axis=1)).max())
