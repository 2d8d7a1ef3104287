"""Starts beside the orbit, reproducibly."""

from __future__ import annotations

import numpy as np

from amble.errors import InputError
from amble.types import Vector, frozen


def perturbed(state: Vector, size: float, seed: int) -> Vector:
    """Change every state by exactly size, up or down at random, in the state's own unit.

    Args:
        state: (n_x,).
        size: of every change, at least 0; with 0 the state itself is returned.
        seed: of the random numbers; the same seed gives the same start.

    Raises:
        InputError: the size is negative or not finite.
    """
    if not 0.0 <= size < np.inf:
        raise InputError(f"the size of a perturbation is a number from 0 on, not {size}")
    sign = np.random.default_rng(seed).choice([-1.0, 1.0], len(state))
    return frozen(np.asarray(state) + size * sign)
