"""Numbers that say how much work is done, or how far something differs: out of range they are refused in one sentence.

And how large the numbers are that files and arguments may hold.
"""

from __future__ import annotations

import numpy as np

from amble.errors import InputError, shown

LARGEST_SHOWN = 10**30
LARGEST_NUMBER = 1e12
"""Largest number of a robot or a gait, in SI units: products of a few stay far below the largest there is."""


def check_number(what: str, value: object, least: float, most: float) -> None:
    """Refuse what is no number or out of range.

    Args:
        what: it is, with its unit, such as "the delay (s)".
        value: the number.
        least: the smallest that can be.
        most: the largest.

    Raises:
        InputError: in one sentence.
    """
    number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not (number and least <= value <= most):  # type: ignore[operator]
        raise InputError(f"{what} is {shown(value)}; it can be from {least:g} to {most:g}")


def check_amount(what: str, value: object, least: int, most: int) -> None:
    """Refuse an amount that is no whole number or out of range.

    Args:
        what: of what so many were asked for, such as "cycles".
        value: the number.
        least: the smallest that can be.
        most: the largest.

    Raises:
        InputError: in one sentence.
    """
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not (whole and least <= value <= most):  # type: ignore[operator]
        huge = whole and abs(value) > LARGEST_SHOWN  # type: ignore[arg-type]
        asked = "more digits" if huge else shown(value)
        raise InputError(f"{asked} {what} were asked for; a whole number from {least:,} to {most:,} can be")
