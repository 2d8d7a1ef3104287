"""Quantities in JSON: every number with its unit, read back strictly.

A tree is written with ``quantity`` and ``table`` and read through a ``Reader``, which knows where in the file it
stands and refuses what is missing, unknown, of another unit or shape, or not finite.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from amble.errors import InputError, UnknownNameError
from amble.types import Json, Matrix, frozen

INFINITE = {"inf": math.inf, "-inf": -math.inf}
"""A limit that does not exist; JSON has no infinity of its own."""


def quantity(value: float | Matrix | Sequence[float], unit: str) -> Json:
    """One number, vector or matrix with its unit."""
    return {"value": plain(value), "unit": unit}


def table(value: Matrix, units: Sequence[str]) -> Json:
    """A vector, or the rows of a matrix, whose columns have different units."""
    return {"units": list(units), "value": plain(value)}


def plain(value: Any) -> Any:
    """Numbers as JSON has them; floats are written so that they read back exactly."""
    if isinstance(value, np.ndarray | tuple | list):
        return [plain(entry) for entry in value]
    number = float(value)
    for word, infinity in INFINITE.items():
        if number == infinity:
            return word
    return number


class Reader:
    """One JSON object with its place in the file, for sentences such as "domains[0]: 'duration' is missing"."""

    def __init__(self, tree: Any, place: str) -> None:
        if not isinstance(tree, dict):
            raise InputError(f"{place} is not an object")
        self._tree, self._place = tree, place

    def expect(self, *keys: str) -> Reader:
        """Refuse keys that are unknown or missing, and return the reader itself."""
        for key in self._tree:
            if key not in keys:
                raise UnknownNameError(f"key in {self._place}", key, keys)
        for key in keys:
            if key not in self._tree:
                raise InputError(f"{self._place}: '{key}' is missing")
        return self

    def names(self) -> tuple[str, ...]:
        """Return the keys of the object, in file order."""
        return tuple(self._tree)

    def expect_among(self, kind: str, known: Iterable[str]) -> Reader:
        """Refuse keys that are not names of this kind, and return the reader itself."""
        names = tuple(known)
        for key in self._tree:
            if key not in names:
                raise UnknownNameError(f"{kind} in {self._place}", key, names)
        return self

    def raw(self, key: str) -> Any:
        """Return a value as the file has it."""
        return self._tree[key]

    def inside(self, key: str) -> Reader:
        """Return a reader of the object under a key."""
        return Reader(self._tree[key], self._where(key))

    def each(self, key: str) -> list[Reader]:
        """Return readers of the objects in the list under a key."""
        entries = self._list(key)
        return [Reader(entry, f"{self._where(key)}[{number}]") for number, entry in enumerate(entries)]

    def text(self, key: str) -> str:
        """Return a string."""
        value = self._tree[key]
        if not isinstance(value, str):
            raise InputError(f"{self._where(key)} is not a string")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """Return a list of strings."""
        values = self._list(key)
        if not all(isinstance(value, str) for value in values):
            raise InputError(f"{self._where(key)} is not a list of strings")
        return tuple(values)

    def flag(self, key: str) -> bool:
        """Return true or false."""
        value = self._tree[key]
        if not isinstance(value, bool):
            raise InputError(f"{self._where(key)} is not true or false")
        return value

    def count(self, key: str) -> int:
        """Return a whole number."""
        value = self._tree[key]
        if isinstance(value, bool) or not isinstance(value, int):
            raise InputError(f"{self._where(key)} is not a whole number")
        return value

    def number(self, key: str, unit: str, infinite: bool = False) -> float:
        """Return a number of the unit."""
        return float(self.array(key, unit, (), infinite))

    def pair(self, key: str, unit: str, infinite: bool = False) -> tuple[float, float]:
        """Return two numbers of the unit."""
        first, second = self.array(key, unit, (2,), infinite)
        return float(first), float(second)

    def array(self, key: str, unit: str, shape: tuple[int | None, ...], infinite: bool = False) -> Matrix:
        """Return an array of the unit; None in the shape stands for any length."""
        entry = self.inside(key).expect("value", "unit")
        found = entry.text("unit")
        if found != unit:
            raise InputError(f"{self._where(key)} has the unit '{found}', not '{unit}'")
        return self._shaped(key, entry.raw("value"), shape, infinite)

    def columns(self, key: str, units: list[str], rows: int | None) -> Matrix:
        """Return an array whose columns have the given units: one row, or as many as given."""
        entry = self.inside(key).expect("units", "value")
        if list(entry.texts("units")) != units:
            raise InputError(f"{self._where(key)} does not have the units {', '.join(units)}")
        shape = (len(units),) if rows is None else (rows, len(units))
        return self._shaped(key, entry.raw("value"), shape, False)

    def _shaped(self, key: str, value: Any, shape: tuple[int | None, ...], infinite: bool) -> Matrix:
        values = _numbers(value, self._where(key), infinite)
        try:
            array = np.array(values, dtype=np.float64)
        except ValueError:
            raise InputError(f"{self._where(key)} has rows of different lengths") from None
        same = len(array.shape) == len(shape)
        if not same or any(want is not None and want != got for want, got in zip(shape, array.shape, strict=True)):
            wanted = " x ".join("any" if length is None else str(length) for length in shape) or "one number"
            raise InputError(f"{self._where(key)} has the shape {' x '.join(map(str, array.shape)) or 1}, not {wanted}")
        return frozen(array)

    def _list(self, key: str) -> list[Any]:
        value = self._tree[key]
        if not isinstance(value, list):
            raise InputError(f"{self._where(key)} is not a list")
        return value

    def _where(self, key: str) -> str:
        return f"{self._place}: '{key}'"


def _numbers(value: Any, where: str, infinite: bool) -> Any:
    if isinstance(value, list):
        return [_numbers(entry, where, infinite) for entry in value]
    if infinite and isinstance(value, str) and value in INFINITE:
        return INFINITE[value]
    try:
        finite = not isinstance(value, bool) and isinstance(value, int | float) and math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        finite = False
    if not finite:
        raise InputError(f"{where} holds {value!r}, which is not a finite number")
    return float(value)


def dumps(tree: Any, indent: str = "") -> str:
    """JSON text with one line for every list of plain values, so that a matrix reads as one."""
    deeper = indent + "  "
    if isinstance(tree, dict) and tree and any(isinstance(value, dict | list) for value in tree.values()):
        body = ",\n".join(f"{deeper}{json.dumps(key)}: {dumps(value, deeper)}" for key, value in tree.items())
        return f"{{\n{body}\n{indent}}}"
    if isinstance(tree, list) and any(isinstance(value, dict | list) for value in tree):
        body = ",\n".join(f"{deeper}{dumps(value, deeper)}" for value in tree)
        return f"[\n{body}\n{indent}]"
    return json.dumps(tree, allow_nan=False, ensure_ascii=False)


def loads(text: str, what: str) -> Any:
    """Parse JSON strictly: no NaN, no key twice.

    Raises:
        InputError: in one sentence that begins with ``what``.
    """

    def refuse_constant(word: str) -> None:
        raise InputError(f"{what} holds {word}, which is not a number")

    def unique(pairs: list[tuple[str, Any]]) -> Json:
        tree = dict(pairs)
        if len(tree) != len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise InputError(f"{what} has the key '{twice}' twice in one object")
        return tree

    try:
        return json.loads(text, parse_constant=refuse_constant, object_pairs_hook=unique)
    except (ValueError, RecursionError) as error:  # ValueError: not JSON, or a whole number of thousands of digits
        raise InputError(f"{what} is not JSON: {error}") from None
