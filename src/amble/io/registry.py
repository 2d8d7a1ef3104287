"""Kinds of things by name: what a file holds of one is its name and its parameters, and others may add kinds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Generic, Protocol, TypeVar

from amble.errors import InputError, UnknownNameError
from amble.types import Json


class Named(Protocol):
    """A thing that its name and its parameters rebuild."""

    @property
    def name(self) -> str:
        """Name of the kind."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Plain JSON values."""


T = TypeVar("T", bound=Named)


class Registry(Generic[T]):
    """Name -> what builds the thing from its parameters, given by keyword; open to everyone.

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
            UnknownNameError: there is no such kind.
            InputError: the parameters are not the kind's.
        """
        if name not in self._builders:
            raise UnknownNameError(self.kind, name, self._builders)
        plain = {key: tuple(value) if isinstance(value, list) else value for key, value in parameters.items()}
        try:
            return self._builders[name](**plain)
        except (TypeError, ValueError) as error:
            raise InputError(f"parameters of {self.kind} '{name}' do not fit: {error}") from None

    def to_dict(self, thing: T) -> Json:
        """Return name and parameters.

        Raises:
            InputError: they would not rebuild the thing.
        """
        tree = {"name": thing.name, "parameters": dict(thing.parameters)}
        if thing.name not in self._builders or self.build(thing.name, thing.parameters) != thing:
            raise InputError(
                f"{self.kind} '{thing.name}' cannot be written to a file: register a class that its name and "
                "parameters rebuild"
            )
        return tree
