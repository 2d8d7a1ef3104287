"""``amble stabilize``: its choices are the library's."""

from __future__ import annotations

from typing import get_args

from amble.cli.stabilize import BASE, Method
from amble.stability import stabilize


def test_the_methods_are_those_of_the_library() -> None:
    assert {method.value for method in Method} == set(get_args(stabilize.Method))


def test_the_free_coordinates_are_those_of_the_library() -> None:
    assert BASE == stabilize.BASE
