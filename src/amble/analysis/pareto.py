"""Which of several choices no other one beats in two numbers at once."""

from __future__ import annotations

from collections.abc import Sequence


def undominated(costs: Sequence[float], gains: Sequence[float]) -> list[bool]:
    """Say of every choice whether none costs at most as much and gives at least as much, one of them strictly.

    Args:
        costs: of the choices, less is better.
        gains: of the choices, more is better.
    """
    pairs = list(zip(costs, gains, strict=True))
    return [not any((c <= cost and g >= gain) and (c < cost or g > gain) for c, g in pairs) for cost, gain in pairs]
