"""What is open from outside: names under which others register what amble did not know.

``Lookup`` holds things by name: readers, gaits, solvers. A ``Registry`` holds what builds a thing from its parameters,
and so is the codec of files: what they hold of the thing is its name and its parameters.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
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
Entry = TypeVar("Entry")


class Lookup(Generic[Entry]):
    """Name -> entry, open to everyone.

    Attributes:
        kind: what the entries are called in messages.
    """

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._entries: dict[str, Entry] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """The known names, as they were registered."""
        return tuple(self._entries)

    @property
    def entries(self) -> tuple[Entry, ...]:
        """What is registered, in the order of the names."""
        return tuple(self._entries.values())

    def register(self, name: str, entry: Entry) -> None:
        """Add an entry; from then on it can be named.

        Raises:
            InputError: another entry has the name.
        """
        known = self._entries.setdefault(name, entry)
        if known is not entry and known != entry:
            raise InputError(f"there is another {self.kind} of the name '{name}'")

    def __getitem__(self, name: str) -> Entry:
        """Return what has a name.

        Raises:
            UnknownNameError: nothing has; the message lists the known names.
        """
        if name not in self._entries:
            raise UnknownNameError(self.kind, name, self._entries)
        return self._entries[name]

    def __contains__(self, name: object) -> bool:
        """Whether a name is known."""
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        """Go through the names."""
        return iter(self._entries)


class Registry(Lookup[Callable[..., T]], Codec, Generic[T]):
    """Name -> what builds the thing from its parameters, given by keyword: a class or a function."""

    def build(self, name: str, parameters: Mapping[str, Any]) -> T:
        """Rebuild a thing from its name and parameters.

        Raises:
            UnknownNameError: there is no such kind, or it has no such parameter.
            InputError: a parameter is missing or not one that the kind takes.
        """
        builder = self[name]
        fields = inspect.signature(builder).parameters
        for key in parameters:
            if key not in fields:
                raise UnknownNameError(f"parameter of {self.kind} '{name}'", key, fields)
        for key, field in fields.items():
            if key not in parameters and field.default is field.empty:
                raise InputError(f"{self.kind} '{name}' needs the parameter '{key}'")
        units = self._units(name)
        plain = {key: _plain(value, key in units) for key, value in parameters.items()}
        try:
            return builder(**plain)
        except (TypeError, ValueError) as error:
            raise InputError(f"parameters of {self.kind} '{name}' do not fit: {error}") from None

    def encode(self, value: T, place: str) -> Json:
        """Write name and parameters.

        Raises:
            InputError: they would not rebuild the thing.
        """
        if value.name not in self._entries or self.build(value.name, value.parameters) != value:
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
        name = NameIn(self.kind, self._entries).decode(fields["name"], place)
        units, parameters = self._units(name), fields["parameters"]
        if not isinstance(parameters, dict):
            raise InputError(f"{place}, parameters is not an object")
        found = {
            key: _number(units[key], not _has_unit(value)).decode(value, f"{place}, {key}") if key in units else value
            for key, value in parameters.items()
        }
        return self.build(name, found)

    def _units(self, name: str) -> Mapping[str, str]:
        units: Mapping[str, str] = getattr(self._entries[name], "units", {})
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
