"""Bezier curves: Bernstein basis with derivatives, for numbers and casadi symbols; degree elevation; fitting."""

from __future__ import annotations

from math import comb
from typing import Any

import casadi as ca
import numpy as np

from amble.errors import InputError
from amble.types import Matrix, Vector


def bernstein(order: int, phase: Any) -> list[Any]:
    """Return the order + 1 Bernstein polynomials at a phase in [0, 1]; number, array or casadi symbol."""
    if order < 0:
        raise InputError(f"the order of a Bezier curve is {order}; it must not be negative")
    return [comb(order, k) * phase**k * (1 - phase) ** (order - k) for k in range(order + 1)]


def bernstein_derivatives(order: int, phase: Any) -> tuple[list[Any], list[Any], list[Any]]:
    """Return the Bernstein basis and its first and second derivatives with respect to the phase.

    Uses B'_{k,n} = n (B_{k-1,n-1} - B_{k,n-1}) (Farin, Curves and Surfaces for CAGD, section 5.3).
    """
    basis = bernstein(order, phase)
    first = _differentiate(order, [bernstein(order - 1, phase)] if order >= 1 else [], 1)
    second = _differentiate(order, [bernstein(order - 2, phase)] if order >= 2 else [], 2)
    return basis, first, second


def bezier(coefficients: ca.SX, phase: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return a Bezier curve and its first two derivatives with respect to the phase, as casadi columns.

    Args:
        coefficients: (curves, order + 1).
        phase: scalar.
    """
    order = coefficients.shape[1] - 1
    rows = bernstein_derivatives(order, phase)
    value, first, second = (ca.mtimes(coefficients, ca.vertcat(*row)) for row in rows)
    return value, first, second


def evaluate(coefficients: Matrix, phase: Vector) -> tuple[Matrix, Matrix, Matrix]:
    """Return curve values and first two phase derivatives at many phases, each (phases, curves)."""
    order = coefficients.shape[1] - 1
    phase = np.asarray(phase, dtype=np.float64)
    rows = bernstein_derivatives(order, phase)
    value, first, second = (np.stack([np.broadcast_to(b, phase.shape) for b in row], axis=-1) for row in rows)
    return value @ coefficients.T, first @ coefficients.T, second @ coefficients.T


def elevate(coefficients: Matrix, order: int) -> Matrix:
    """Return the same curves written with a higher order (exact up to rounding)."""
    current = coefficients.shape[1] - 1
    if order < current:
        raise InputError(f"a Bezier curve of order {current} cannot be written with order {order}")
    raised = np.array(coefficients, dtype=np.float64)
    for n in range(current + 1, order + 1):
        k = np.arange(n + 1) / n
        before = np.hstack([raised[:, :1] * 0.0, raised])
        after = np.hstack([raised, raised[:, :1] * 0.0])
        raised = k * before + (1.0 - k) * after
    return raised


def fit(values: Matrix, rates: Matrix, phase: Vector, order: int) -> Matrix:
    """Fit Bezier curves to samples of values and phase derivatives by least squares; the ends are met exactly.

    Args:
        values: (samples, curves), the first at phase 0 and the last at phase 1.
        rates: derivative with respect to the phase at the samples, (samples, curves).
        phase: (samples,), from 0 to 1.
        order: order of the curves, at least 3.

    Returns:
        Coefficients, (curves, order + 1). Value and rate at both ends are met exactly, so that a closed loop which
        starts on the samples starts on the curve.
    """
    if order < 3:
        raise InputError(f"a fit that meets values and rates at both ends needs order 3 or more, not {order}")
    basis, first, _ = bernstein_derivatives(order, np.asarray(phase, dtype=np.float64))
    rows = np.vstack([np.stack(basis, axis=-1), np.stack(first, axis=-1) / order])
    target = np.vstack([values, rates / order])
    coefficients = np.zeros((order + 1, values.shape[1]))
    coefficients[0], coefficients[-1] = values[0], values[-1]
    coefficients[1] = values[0] + rates[0] / order
    coefficients[-2] = values[-1] - rates[-1] / order
    inner = np.arange(2, order - 1)
    if inner.size:
        fixed = np.setdiff1d(np.arange(order + 1), inner)
        residual = target - rows[:, fixed] @ coefficients[fixed]
        coefficients[inner] = np.linalg.lstsq(rows[:, inner], residual, rcond=None)[0]
    return coefficients.T


def _differentiate(order: int, lower: list[list[Any]], times: int) -> list[Any]:
    """Combine the basis of order - times into the derivative of the basis of ``order``."""
    if not lower:
        return [0.0] * (order + 1)
    row = lower[0]
    for step in range(times, 0, -1):
        n = order - step + 1
        padded = [0.0, *row, 0.0]
        row = [n * (padded[k] - padded[k + 1]) for k in range(n + 1)]
    return row
