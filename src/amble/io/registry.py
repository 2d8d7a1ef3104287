"""Kinds of things by name: what a file holds of one is its name and its parameters, and others may add kinds."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, Generic, Protocol, TypeVar

from amble.errors import InputError, UnknownNameError
from amble.io.codec import ByName, Codec, NameIn, expect_keys
from amble.io.quantities import Number
from amble.types import Json


class Named(Protocol):
    """A thing that its name and its parameters rebuild.

    A ``units`` of its class, parameter -> unit, names the parameters that files hold with a unit: numbers, or numbers
    by name.
    """

    @property
    def name(self) -> str:
        """Name of the kind."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Plain JSON values."""


T = TypeVar("T", bound=Named)


class Registry(Codec, Generic[T]):
    """Name -> what builds the thing from its parameters, given by keyword; open to everyone, and the codec of files.

    Attributes:
        kind: what the things are called in messages.
    """

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._builders: dict[str, Callable[..., T]] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """The known names."""
        return tuple(self._builders)

    def register(self, name: str, builder: Callable[..., T]) -> None:
        """Add a kind; from then on files and specifications can name it.

        Args:
            name: the ``name`` of what the builder builds.
            builder: a class or function that takes the ``parameters`` by keyword.

        Raises:
            InputError: another builder has the name.
        """
        if self._builders.setdefault(name, builder) is not builder:
            raise InputError(f"there is another {self.kind} of the name '{name}'")

    def build(self, name: str, parameters: Mapping[str, Any]) -> T:
        """Rebuild a thing from its name and parameters.

        Raises:
            UnknownNameError: there is no such kind, or it has no such parameter.
            InputError: a parameter is missing or not one that the kind takes.
        """
        if name not in self._builders:
            raise UnknownNameError(self.kind, name, self._builders)
        fields = inspect.signature(self._builders[name]).parameters
        for key in parameters:
            if key not in fields:
                raise UnknownNameError(f"parameter of {self.kind} '{name}'", key, fields)
        for key, field in fields.items():
            if key not in parameters and field.default is field.empty:
                raise InputError(f"{self.kind} '{name}' needs the parameter '{key}'")
        units = self._units(name)
        plain = {key: _plain(value, key in units) for key, value in parameters.items()}
        try:
            return self._builders[name](**plain)
        except (TypeError, ValueError) as error:
            raise InputError(f"parameters of {self.kind} '{name}' do not fit: {error}") from None

    def encode(self, value: T, place: str) -> Json:
        """Write name and parameters.

        Raises:
            InputError: they would not rebuild the thing.
        """
        if value.name not in self._builders or self.build(value.name, value.parameters) != value:
            raise InputError(
                f"{place}: {self.kind} '{value.name}' cannot be written to a file: register a class that its name and "
                "parameters rebuild"
            )
        units = self._units(value.name)
        written = {
            key: _number(units[key], isinstance(entry, Mapping)).encode(entry, f"{place}, {key}")
            if key in units
            else entry
            for key, entry in value.parameters.items()
        }
        return {"name": value.name, "parameters": written}

    def decode(self, entry: Any, place: str) -> T:
        """Read a thing; it refuses parameters that are not its own."""
        fields = expect_keys(entry, place, ("name", "parameters"))
        name = NameIn(self.kind, self._builders).decode(fields["name"], place)
        units, parameters = self._units(name), fields["parameters"]
        if not isinstance(parameters, dict):
            raise InputError(f"{place}, parameters is not an object")
        found = {
            key: _number(units[key], not _has_unit(value)).decode(value, f"{place}, {key}") if key in units else value
            for key, value in parameters.items()
        }
        return self.build(name, found)

    def _units(self, name: str) -> Mapping[str, str]:
        units: Mapping[str, str] = getattr(self._builders[name], "units", {})
        return units


def _plain(value: Any, number: bool) -> Any:
    """Lists as tuples; whole numbers with a unit as the floats that files hold, so that they read back the same."""
    if number and isinstance(value, Mapping):
        return {name: _float(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return tuple(value)
    return _float(value) if number else value


def _float(value: Any) -> Any:
    try:
        return float(value) if type(value) is int else value
    except OverflowError:  # the kind refuses it
        return value


def _number(unit: str, by_name: bool) -> Codec:
    """One number, or one for every name that has one."""
    return ByName("name", Number(unit)) if by_name else Number(unit)


def _has_unit(entry: Any) -> bool:
    return not isinstance(entry, dict) or isinstance(entry.get("unit"), str)
