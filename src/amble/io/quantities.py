"""Numbers with units: in specifications (a plain number is SI, ``"150 ms"`` carries its unit) and in JSON.

In JSON each number or array has its unit, or one unit a column, in the shape that its codec states.
"""

from __future__ import annotations

import math
import re
import reprlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from amble.errors import InputError, shown
from amble.io.codec import Codec, expect_keys
from amble.io.reader import parse_number
from amble.types import Json, Matrix, frozen

INFINITE = {"inf": math.inf, "-inf": -math.inf}
"""A limit that does not exist; JSON has no infinity of its own."""

UNITS: Mapping[str, Mapping[str, float]] = {
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0},
    "time": {"s": 1.0, "ms": 1e-3},
    "speed": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "km/h": 1.0 / 3.6},
    "angular speed": {"rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.pi / 30.0},
    "acceleration": {"m/s^2": 1.0, "rad/s^2": 1.0},
    "force": {"N": 1.0, "kN": 1e3},
    "torque": {"N m": 1.0, "kN m": 1e3},
    "mass": {"kg": 1.0, "g": 1e-3},
    "inertia": {"kg m^2": 1.0, "g cm^2": 1e-7},
    "damping": {"N m s/rad": 1.0},
    "linear damping": {"N s/m": 1.0},
    "position gain": {"1/s^2": 1.0},
    "velocity gain": {"1/s": 1.0},
    "ratio": {"1": 1.0, "%": 1e-2},
}
"""Dimension -> unit -> its size in SI units."""


class Array(Codec):
    """Numbers of one unit in an array; None in the shape stands for any length but zero."""

    def __init__(self, unit: str, *shape: int | None, infinite: bool = False) -> None:
        self._key, self._unit, self._shape, self._infinite = "unit", unit, shape, infinite

    def encode(self, value: Any, place: str) -> Json:
        """Write value and unit."""
        array = np.asarray(value, dtype=np.float64)
        self._check(array, place)
        return {"value": _written(array), self._key: self._units()}

    def decode(self, entry: Any, place: str) -> Any:
        """Return a read-only array."""
        fields = expect_keys(entry, place, ("value", self._key))
        if fields[self._key] != self._units():
            found, wanted = (_listed(units) for units in (fields[self._key], self._units()))
            raise InputError(f"{place} has the {self._key} '{found}', not '{wanted}'")
        array = _numbers(fields["value"], place, self._infinite)
        self._check(array, place)
        return array

    def _units(self) -> Any:
        return self._unit

    def _check(self, array: Matrix, place: str) -> None:
        wanted, got = self._shape, array.shape
        fits = len(wanted) == len(got) and all(
            w == g or (w is None and g > 0) for w, g in zip(wanted, got, strict=True)
        )
        if not fits:
            words = " x ".join("any" if length is None else str(length) for length in wanted) or "one number"
            raise InputError(f"{place} has the shape {' x '.join(map(str, got)) or 'of one number'}, not {words}")
        bad = np.isnan(array) if self._infinite else ~np.isfinite(array)
        if bad.any():
            raise InputError(f"{place} holds {array[bad][0]}, which is not a finite number")


class Columns(Array):
    """Numbers whose last axis has a unit a column: one row where ``rows`` is not given."""

    def __init__(self, units: Sequence[str], *rows: int | None) -> None:
        super().__init__("", *rows, len(units))
        self._key, self._columns = "units", list(units)

    def _units(self) -> list[str]:
        return self._columns


class Number(Array):
    """One number of a unit."""

    def __init__(self, unit: str, infinite: bool = False, positive: bool = False) -> None:
        super().__init__(unit, infinite=infinite)
        self._positive = positive

    def decode(self, entry: Any, place: str) -> float:
        """Return the number."""
        return float(super().decode(entry, place))

    def _check(self, array: Matrix, place: str) -> None:
        super()._check(array, place)
        if self._positive and not array > 0.0:
            raise InputError(f"{place} is {float(array):g}; it must be positive")


class Interval(Array):
    """A lower and an upper bound of a unit."""

    def __init__(self, unit: str, infinite: bool = False) -> None:
        super().__init__(unit, 2, infinite=infinite)

    def decode(self, entry: Any, place: str) -> tuple[float, float]:
        """Return the pair."""
        lower, upper = super().decode(entry, place)
        return float(lower), float(upper)


class Bare(Array):
    """Numbers without a unit, as results hold them whose keys or documentation name it."""

    def __init__(self, *shape: int | None) -> None:
        super().__init__("", *shape)

    def encode(self, value: Any, place: str) -> Any:
        """Write the numbers."""
        return super().encode(value, place)["value"]

    def decode(self, entry: Any, place: str) -> Any:
        """Return a read-only array."""
        return super().decode({"value": entry, "unit": ""}, place)


def _listed(units: Any) -> str:
    texts = isinstance(units, list) and all(isinstance(unit, str) for unit in units)
    return shown(", ".join(units) if texts else units, 200)


def _written(array: Matrix) -> Any:
    """Numbers as JSON has them; floats are written so that they read back exactly."""
    if np.isfinite(array).all():
        return array.tolist()
    return _with_words(array.tolist())


def _with_words(value: Any) -> Any:
    if isinstance(value, list):
        return [_with_words(entry) for entry in value]
    return value if math.isfinite(value) else ("inf" if value > 0.0 else "-inf")


def _numbers(value: Any, place: str, infinite: bool) -> Matrix:
    """Return numbers, lists of them, or lists of lists, as an array; nothing is converted but the words of infinity."""
    rows = value if isinstance(value, list) and value and isinstance(value[0], list) else [value]
    cells = [row if isinstance(row, list) else [row] for row in rows]
    if not all(set(map(type, row)) <= {float} for row in cells):
        value = _converted(value, place, infinite)
    try:
        return frozen(value)
    except ValueError:
        raise InputError(f"{place} has rows of different lengths") from None


def _converted(value: Any, place: str, infinite: bool) -> Any:
    if isinstance(value, list):
        return [_converted(entry, place, infinite) for entry in value]
    if infinite and isinstance(value, str) and value in INFINITE:
        return INFINITE[value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        quoted = f"'{shown(value)}'" if isinstance(value, str) else shown(value)
        raise InputError(f"{place} holds {quoted}, which is not a finite number")
    return float(value)


JOINED = re.compile(r"^(\s*[-+]?[0-9.]++(?:[eE][-+]?[0-9]+)?+)([A-Za-z%])")
"""A number with its unit right behind it, as in 0.4m/s; set apart before the text is cut at spaces."""


def parse_quantity(value: Any, dimension: str) -> float:
    """Return the SI value of a number or of text such as ``"0.2 m/s"``.

    Raises:
        ValueError: where it is neither, is not finite, or has an unknown unit; the message names the known ones.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError(f"{reprlib.repr(value)} is not a number or text such as '1 {next(iter(UNITS[dimension]))}'")
    return _finite(value, UNITS[dimension], dimension)


class Measured(float):
    """An SI number that knows the dimension of the unit it was written with; empty where it had none."""

    dimension: str = ""


def parse_measured(value: Any, dimensions: Sequence[str]) -> Measured:
    """Return what ``parse_quantity`` does for a quantity that has one of several dimensions; errors as there."""
    if isinstance(value, Measured):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError(
            f"{reprlib.repr(value)} is not a number or text such as '1 {next(iter(UNITS[dimensions[0]]))}'"
        )
    known = {unit: size for dimension in dimensions for unit, size in UNITS[dimension].items()}
    found = Measured(_finite(value, known, " or ".join(dimensions)))
    if isinstance(value, str):
        _, unit = _apart(value)
        found.dimension = next(dimension for dimension in dimensions if unit in UNITS[dimension])
    return found


def require_dimension(value: float, wanted: str, what: str) -> None:
    """Refuse a number that was written with a unit of another dimension.

    Raises:
        InputError: in one sentence.
    """
    given = getattr(value, "dimension", "")
    if given and given != wanted:
        units = ", ".join(UNITS[wanted])
        raise InputError(f"the {what} has a unit for a quantity of {given}; it is one of {wanted} ({units})")


def _finite(value: float | str, units: Mapping[str, float], dimension: str) -> float:
    try:
        number = _with_unit(value, units, dimension) if isinstance(value, str) else float(value)
    except OverflowError:  # a whole number of hundreds of digits
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{reprlib.repr(value)} is not a finite number")
    return number


def _apart(text: str) -> tuple[str, str]:
    """Return number and unit of a text."""
    digits, *words = JOINED.sub(r"\1 \2", text).split() or [""]
    return digits, " ".join(words)


def _with_unit(text: str, units: Mapping[str, float], dimension: str) -> float:
    digits, unit = _apart(text)
    if unit not in units:
        said = f"unknown unit '{unit}'" if unit else "no unit"
        raise ValueError(f"'{text}' has {said} for a quantity of {dimension}; known: {', '.join(units)}")
    try:
        return parse_number(digits) * units[unit]
    except ValueError:
        raise ValueError(f"'{text}' does not begin with a number") from None
