"""Records in JSON: one description of a record's fields both writes it and reads it back strictly.

``Record`` names the fields of a record and the codec of each: text, a number with its unit (``quantities``), a list of
further records. What a codec writes reads back exactly; what it reads is refused, in a sentence that names the
place, where a key is missing or unknown, a unit or a shape differs, or a number is not finite.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from amble.errors import InputError, UnknownNameError, shown
from amble.types import Json

LARGEST_COUNT = 2**31 - 1
"""Whole numbers count iterations, variables and nodes."""


class Codec(ABC):
    """How one kind of value is written and read.

    ``place`` is where in the file it stands, for sentences such as "gait file 'a.json', domains, D1: 'duration' is
    missing".
    """

    @abstractmethod
    def encode(self, value: Any, place: str) -> Any:
        """Return the value as JSON has it.

        Raises:
            InputError: the value could not be read back.
        """

    @abstractmethod
    def decode(self, entry: Any, place: str) -> Any:
        """Return the value that an entry of the file means.

        Raises:
            InputError: in one sentence, what is wrong with the entry.
        """


class Plain(Codec):
    """A value that JSON has itself: text, true or false."""

    def __init__(self, kind: type, name: str) -> None:
        self._kind, self._name = kind, name

    def encode(self, value: Any, place: str) -> Any:
        """Return the value itself."""
        return self.decode(value, place)

    def decode(self, entry: Any, place: str) -> Any:
        """Return the entry itself."""
        if type(entry) is not self._kind:
            raise InputError(f"{place} is not {self._name}")
        return entry


TEXT = Plain(str, "a string")
FLAG = Plain(bool, "true or false")


class Count(Codec):
    """A whole number from ``least`` to ``most``."""

    def __init__(self, least: int = 0, most: int = LARGEST_COUNT) -> None:
        self._least, self._most = least, most

    def encode(self, value: Any, place: str) -> int:
        """Return the number."""
        return self.decode(int(value), place)

    def decode(self, entry: Any, place: str) -> int:
        """Return the number."""
        if type(entry) is not int:
            raise InputError(f"{place} is not a whole number")
        if not self._least <= entry <= self._most:
            raise InputError(f"{place} is {entry}; it must be from {self._least} to {self._most}")
        return entry


class ListOf(Codec):
    """A list, read as a tuple."""

    def __init__(self, each: Codec, length: int | None = None) -> None:
        self._each, self._length = each, length

    def encode(self, value: Any, place: str) -> list[Any]:
        """Write every entry."""
        return [self._each.encode(entry, f"{place}[{number}]") for number, entry in enumerate(value)]

    def decode(self, entry: Any, place: str) -> tuple[Any, ...]:
        """Read every entry."""
        if not isinstance(entry, list) or (self._length is not None and len(entry) != self._length):
            raise InputError(f"{place} is not a list{'' if self._length is None else f' of {self._length}'}")
        return tuple(self._each.decode(one, f"{place}[{number}]") for number, one in enumerate(entry))


class NameIn(Codec):
    """One of the names of a kind."""

    def __init__(self, kind: str, known: Iterable[str]) -> None:
        self._kind, self._known = kind, tuple(known)

    def encode(self, value: Any, place: str) -> str:
        """Return the name."""
        return self.decode(value, place)

    def decode(self, entry: Any, place: str) -> str:
        """Return the name."""
        name = TEXT.decode(entry, place)
        if name not in self._known:
            raise UnknownNameError(f"{self._kind} ({place})", name, self._known)
        return str(name)


class ByName(Codec):
    """An object whose keys are names of a kind.

    Args:
        kind: what the names are, such as "joint".
        codecs: known name -> codec, or one codec for any name.
        complete: whether every known name must be there.
    """

    def __init__(self, kind: str, codecs: Mapping[str, Codec] | Codec, complete: bool = False) -> None:
        self._kind, self._codecs, self._complete = kind, codecs, complete

    def encode(self, value: Any, place: str) -> Json:
        """Write every entry."""
        self._check(value, place)
        return {name: self._codec(name).encode(entry, f"{place}, {shown(name)}") for name, entry in value.items()}

    def decode(self, entry: Any, place: str) -> Json:
        """Read every entry, in file order."""
        if not isinstance(entry, dict):
            raise InputError(f"{place} is not an object")
        self._check(entry, place)
        return {name: self._codec(name).decode(one, f"{place}, {shown(name)}") for name, one in entry.items()}

    def _codec(self, name: str) -> Codec:
        return self._codecs if isinstance(self._codecs, Codec) else self._codecs[name]

    def _check(self, names: Mapping[str, Any], place: str) -> None:
        if isinstance(self._codecs, Codec):
            return
        for name in names:
            if name not in self._codecs:
                raise UnknownNameError(f"{self._kind} ({place})", name, self._codecs)
        for name in self._codecs if self._complete else ():
            if name not in names:
                raise InputError(f"{place}: '{shown(name)}' is missing")


class Optional(Codec):
    """A key that is written only where its value is not None, so that files without it keep their hash.

    Null, as results have it, reads as None.
    """

    def __init__(self, each: Codec) -> None:
        self._each = each

    def encode(self, value: Any, place: str) -> Any:
        """Write the value."""
        return self._each.encode(value, place)

    def decode(self, entry: Any, place: str) -> Any:
        """Read the value."""
        return None if entry is None else self._each.decode(entry, place)


Field = Codec | Callable[[Mapping[str, Any]], Codec]
"""The codec of a field, or what finds it from the fields before it."""


class Record(Codec):
    """An object with one key a field.

    Args:
        build: makes the record from its fields by keyword; ``dict`` leaves them a dictionary.
        fields: name -> codec, in file order; where lengths or units follow from fields before it, a function of those.
        take: returns the fields of a record; its attributes where not given.
        open: whether further keys may stand there, which are not looked at.
    """

    def __init__(
        self,
        build: Callable[..., Any],
        fields: Mapping[str, Field],
        take: Callable[[Any], Mapping[str, Any]] | None = None,
        open: bool = False,
    ) -> None:
        self._build, self._fields, self._take, self._open = build, fields, take, open

    def encode(self, value: Any, place: str) -> Json:
        """Write every field."""
        if self._take is not None:
            known = self._take(value)
        else:
            known = value if isinstance(value, Mapping) else {name: getattr(value, name) for name in self._fields}
        found: Json = {}
        for name, field in self._fields.items():
            codec = field if isinstance(field, Codec) else field(known)
            if not (isinstance(codec, Optional) and known.get(name) is None):
                found[name] = codec.encode(known[name], f"{place}, {name}")
        return found

    def decode(self, entry: Any, place: str) -> Any:
        """Read every field, then build the record."""
        given = expect_keys(entry, place, self._fields if not self._open else None, needed=False)
        known: Json = {}
        for name, field in self._fields.items():
            codec = field if isinstance(field, Codec) else field(known)
            if name in given:
                known[name] = codec.decode(given[name], f"{place}, {name}")
            elif isinstance(codec, Optional):
                known[name] = None
            else:
                raise InputError(f"{place}: '{name}' is missing")
        return self._build(**known)


class Named(Codec):
    """One of several kinds of a thing, told apart by their name: ``{"name": "plane", ...its parameters}``.

    Args:
        kind: what it is, such as "ground".
        known: name -> codec of the parameters of that kind. A value is a record with a ``name``, or a dictionary.
    """

    def __init__(self, kind: str, known: Mapping[str, Record]) -> None:
        self._kind, self._known = kind, known

    def encode(self, value: Any, place: str) -> Json:
        """Write name and parameters."""
        name = value["name"] if isinstance(value, Mapping) else value.name
        return {"name": name, **self._known[NameIn(self._kind, self._known).encode(name, place)].encode(value, place)}

    def decode(self, entry: Any, place: str) -> Any:
        """Read the parameters by the codec of the name."""
        if not isinstance(entry, dict) or "name" not in entry:
            raise InputError(f"{place} is not an object with a 'name'")
        name = NameIn(self._kind, self._known).decode(entry["name"], place)
        found = self._known[name].decode({key: one for key, one in entry.items() if key != "name"}, place)
        return {"name": name, **found} if isinstance(found, dict) else found


def expect_keys(entry: Any, place: str, keys: Iterable[str] | None, needed: bool = True) -> Json:
    """Return an object whose keys are known, where known ones are given, and all there where they are needed.

    Raises:
        InputError: it is no object, or a key is unknown or missing.
    """
    if not isinstance(entry, dict):
        raise InputError(f"{place} is not an object")
    known = tuple(entry if keys is None else keys)
    for key in entry:
        if key not in known:
            raise UnknownNameError(f"key in {place}", key, known)
    for key in known if needed else ():
        if key not in entry:
            raise InputError(f"{place}: '{key}' is missing")
    return entry
