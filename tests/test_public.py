"""The public names of the package."""

from __future__ import annotations

import re
from pathlib import Path

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


def test_the_names_in_the_readme_exist() -> None:
    text = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    page = re.search(r"```python\n(.*?)```", text, re.DOTALL)
    assert page is not None
    used = set(re.findall(r"\bamble\.([A-Za-z_]+)", page.group(1)))
    assert used
    for name in used:
        assert hasattr(amble, name), name
