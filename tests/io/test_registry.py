"""Kinds by name: built from plain values, written only where name and parameters rebuild them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from amble.errors import InputError, UnknownNameError
from amble.io.registry import Lookup, Registry


@dataclass(frozen=True)
class Spring:
    """Something with a name and parameters; it forgets what it does not list."""

    rates: tuple[float, ...]
    hidden: int = 0

    @property
    def name(self) -> str:
        return "spring"

    @property
    def parameters(self) -> dict[str, Any]:
        return {"rates": list(self.rates)}


@pytest.fixture
def registry() -> Registry[Spring]:
    found: Registry[Spring] = Registry("part")
    found.register("spring", Spring)
    return found


def test_round_trip(registry: Registry[Spring]) -> None:
    spring = Spring((1.0, 2.0))
    assert registry.encode(spring, "file") == {"name": "spring", "parameters": {"rates": [1.0, 2.0]}}
    assert registry.build("spring", {"rates": [1.0, 2.0]}) == spring
    assert registry.names == ("spring",)


def test_what_would_not_come_back_is_not_written(registry: Registry[Spring]) -> None:
    with pytest.raises(InputError, match="part 'spring' cannot be written to a file: register a class"):
        registry.encode(Spring((1.0,), hidden=3), "file")
    with pytest.raises(InputError, match="cannot be written"):
        Registry[Spring]("part").encode(Spring((1.0,)), "file")


def test_names_and_parameters_must_be_known(registry: Registry[Spring]) -> None:
    with pytest.raises(UnknownNameError, match="unknown part 'damper'; known: spring"):
        registry.build("damper", {})
    with pytest.raises(UnknownNameError, match="unknown parameter of part 'spring' 'length'; known: rates, hidden"):
        registry.build("spring", {"length": 1.0})


def test_a_name_is_given_once(registry: Registry[Spring]) -> None:
    registry.register("spring", Spring)  # the same again, as when a module is imported twice
    with pytest.raises(InputError, match="another part of the name 'spring'"):
        registry.register("spring", lambda **_: Spring(()))


def test_a_lookup_holds_things_by_name() -> None:
    lookup: Lookup[float] = Lookup("size")
    lookup.register("small", 1.0)
    lookup.register("large", 9.0)
    lookup.register("small", 1.0)
    assert (lookup.names, lookup.entries, list(lookup)) == (("small", "large"), (1.0, 9.0), ["small", "large"])
    assert lookup["large"] == 9.0
    assert "small" in lookup
    assert "huge" not in lookup
    with pytest.raises(UnknownNameError, match="unknown size 'huge'; known: small, large"):
        lookup["huge"]
    with pytest.raises(InputError, match="another size of the name 'small'"):
        lookup.register("small", 2.0)
