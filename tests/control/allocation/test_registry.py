"""Laws by name, with parameters that survive a file."""

from __future__ import annotations

import json

import pytest

from amble.control import (
    AllocationLaw,
    BoundedMinimumNorm,
    DropActuator,
    MinimumPeak,
    MinimumPower,
    PseudoInverse,
    WeightedMinimumNorm,
    law_from,
)
from amble.control.allocation.registry import LAWS
from amble.errors import InputError, UnknownNameError

EXAMPLES = [
    PseudoInverse(),
    DropActuator(("a", "b")),
    WeightedMinimumNorm({"a": 0.1 + 0.2, "b": 3.0}),
    MinimumPower("datasheet"),
    MinimumPeak(),
    BoundedMinimumNorm(0.7, 12.5),
]


@pytest.mark.parametrize("law", EXAMPLES, ids=lambda law: law.name)
def test_a_law_survives_json(law: AllocationLaw) -> None:
    assert law_from(law.name, json.loads(json.dumps(dict(law.parameters)))) == law


def test_every_law_of_the_registry_is_tried() -> None:
    assert {law.name for law in EXAMPLES} == set(LAWS.names)
    assert all(type(LAWS.build(law.name, law.parameters)) is type(law) for law in EXAMPLES)


def test_unknown_names_are_told_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="pinv, drop, weighted, power, peak, bounded"):
        law_from("qp", {})
    with pytest.raises(UnknownNameError, match="paper, datasheet"):
        MinimumPower("mine")


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("pinv", {"weights": {}}),
        ("weighted", {}),
        ("weighted", {"weights": {"a": 0.0}}),
        ("weighted", {"weights": {"a": float("nan")}}),
        ("weighted", {"weights": 3.0}),
        ("bounded", {"friction": 0.0}),
        ("bounded", {"friction": "0.6"}),
        ("bounded", {"normal_force": -1.0}),
        ("bounded", {"friktion": 0.6}),
        ("power", {"actuator": 3}),
    ],
)
def test_parameters_that_do_not_fit_are_refused(name: str, parameters: dict[str, object]) -> None:
    with pytest.raises(InputError):
        law_from(name, parameters)
