"""The public names of the package."""

from __future__ import annotations

import pytest

import amble


@pytest.mark.parametrize("name", amble.__all__)
def test_every_public_name_resolves(name: str) -> None:
    assert getattr(amble, name) is not None
    assert name in dir(amble)


def test_an_unknown_name_says_what_is_known() -> None:
    with pytest.raises(AttributeError, match="no attribute 'walk'; known: Actuator"):
        amble.walk  # noqa: B018


def test_names_are_those_of_their_homes() -> None:
    from amble.gait.files import load_gait

    assert amble.load_gait is load_gait
