"""``amble stabilize``: its choices are the library's."""

from __future__ import annotations

from amble.cli.stabilize import BASE
from amble.stability import stabilize


def test_the_free_coordinates_are_those_of_the_library() -> None:
    assert BASE == stabilize.BASE
