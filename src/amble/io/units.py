"""Units: of quantities in a specification (a plain number is SI, ``"150 ms"`` carries its unit), of coordinates."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Mapping, Sequence
from typing import Any

from amble.io.reader import parse_number

UNITS: Mapping[str, Mapping[str, float]] = {
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0},
    "time": {"s": 1.0, "ms": 1e-3},
    "speed": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "km/h": 1.0 / 3.6},
    "angular speed": {"rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.pi / 30.0},
    "acceleration": {"m/s^2": 1.0, "rad/s^2": 1.0},
    "force": {"N": 1.0, "kN": 1e3},
    "torque": {"N m": 1.0, "kN m": 1e3},
    "position gain": {"1/s^2": 1.0},
    "velocity gain": {"1/s": 1.0},
    "ratio": {"1": 1.0, "%": 1e-2},
}
"""Dimension -> unit -> its size in SI units."""


def parse_quantity(value: Any, dimension: str) -> float:
    """Return the SI value of a number or of text such as ``"0.2 m/s"``.

    Raises:
        ValueError: where it is neither, is not finite, or has an unknown unit; the message names the known ones.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError(f"{reprlib.repr(value)} is not a number or text such as '1 {next(iter(UNITS[dimension]))}'")
    try:
        number = _with_unit(value, UNITS[dimension], dimension) if isinstance(value, str) else float(value)
    except OverflowError:  # a whole number of hundreds of digits
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{reprlib.repr(value)} is not a finite number")
    return number


def _with_unit(text: str, units: Mapping[str, float], dimension: str) -> float:
    digits, *words = text.split() or [""]
    unit = " ".join(words)
    if unit not in units:
        said = f"unknown unit '{unit}'" if unit else "no unit"
        raise ValueError(f"'{text}' has {said} for a quantity of {dimension}; known: {', '.join(units)}")
    try:
        return parse_number(digits) * units[unit]
    except ValueError:
        raise ValueError(f"'{text}' does not begin with a number") from None


LENGTHS = ("x", "y", "z")
"""Coordinates in m; all others are in rad."""


def unit_of(coordinate: str, per_second: str = "") -> str:
    """Return the unit of a coordinate, or of its derivative."""
    return ("m" if coordinate in LENGTHS else "rad") + per_second


def units(coordinates: Sequence[str], per_second: str = "") -> list[str]:
    """Return the unit of every coordinate, or of its derivative."""
    return [unit_of(name, per_second) for name in coordinates]
