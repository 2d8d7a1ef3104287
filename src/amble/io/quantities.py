"""Numbers in JSON: each number or array with its unit, or one unit a column, in the shape that its codec states."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from amble.errors import InputError, shown
from amble.io.codec import Codec, expect_keys
from amble.types import Json, Matrix, frozen

INFINITE = {"inf": math.inf, "-inf": -math.inf}
"""A limit that does not exist; JSON has no infinity of its own."""


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
