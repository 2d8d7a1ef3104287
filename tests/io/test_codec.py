"""What a codec writes it reads back, bit for bit, and nothing else."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from amble.errors import InputError, UnknownNameError
from amble.io.codec import FLAG, TEXT, ByName, Codec, Count, ListOf, Named, NameIn, Optional, Record
from amble.io.quantities import Array, Bare, Columns, Interval, Number
from amble.io.storage import dumps
from amble.types import Matrix

finite = st.floats(allow_nan=False, allow_infinity=False)
limits = st.floats(allow_nan=False)


def again(codec: Codec, value: Any) -> Any:
    """Write a value as a file has it, and read it."""
    return codec.decode(json.loads(dumps({"x": codec.encode(value, "x")}))["x"], "x")


def same_bits(left: Matrix, right: Matrix) -> bool:
    return left.shape == right.shape and left.tobytes() == right.tobytes()


@settings(deadline=None)
@given(arrays(np.float64, array_shapes(max_dims=2, max_side=6), elements=limits))
def test_an_array_is_exact(values: Matrix) -> None:
    assert same_bits(again(Array("m", *values.shape, infinite=True), values), values)


@settings(deadline=None)
@given(arrays(np.float64, st.tuples(st.integers(1, 5), st.just(3)), elements=finite))
def test_columns_are_exact(values: Matrix) -> None:
    assert same_bits(again(Columns(["m", "m", "rad"], None), values), values)
    assert same_bits(again(Bare(None, 3), values), values)


@settings(deadline=None)
@given(limits, st.tuples(limits, limits))
def test_numbers_are_exact(number: float, pair: tuple[float, float]) -> None:
    assert repr(again(Number("m", infinite=True), number)) == repr(number)
    assert repr(again(Interval("m", infinite=True), pair)) == repr(pair)


def test_what_is_read_cannot_be_written() -> None:
    with pytest.raises(ValueError, match="read-only"):
        again(Array("m", 2), [1.0, 2.0])[0] = 3.0


WRONG: dict[str, tuple[Codec, Any, str]] = {
    "truth among numbers": (Array("m", 2), {"value": [1.0, True], "unit": "m"}, "x holds True"),
    "truth": (Number("m"), {"value": True, "unit": "m"}, "x holds True"),
    "text": (Array("m", 2), {"value": [1.0, "2"], "unit": "m"}, "x holds '2'"),
    "null": (Array("m", 2), {"value": [1.0, None], "unit": "m"}, "x holds None"),
    "object": (Array("m", 2), {"value": [1.0, {}], "unit": "m"}, "x holds {}"),
    "infinite": (Number("m"), {"value": "inf", "unit": "m"}, "x holds 'inf'"),
    "overflow": (Number("m"), {"value": float("inf"), "unit": "m"}, "x holds inf"),
    "nan": (Number("m", infinite=True), {"value": float("nan"), "unit": "m"}, "x holds nan"),
    "empty": (Array("m", None), {"value": [], "unit": "m"}, "shape 0, not any"),
    "list for a number": (Number("m"), {"value": [1.0], "unit": "m"}, "shape 1, not one number"),
    "number for a list": (Array("m", 1), {"value": 1.0, "unit": "m"}, "shape of one number, not 1"),
    "too deep": (Array("m", 1, 1), {"value": [[[1.0]]], "unit": "m"}, "shape 1 x 1 x 1, not 1 x 1"),
    "ragged": (Array("m", 2, 2), {"value": [[1.0, 2.0], [1.0]], "unit": "m"}, "rows of different lengths"),
    "ragged in depth": (Array("m", 2), {"value": [1.0, [1.0]], "unit": "m"}, "rows of different lengths"),
    "very deep": (Array("m", 1), {"value": json.loads("[" * 80 + "1.0" + "]" * 80), "unit": "m"}, "different lengths"),
    "unit": (Number("m"), {"value": 1.0, "unit": "mm"}, "the unit 'mm', not 'm'"),
    "unit of a kind": (Number("m"), {"value": 1.0, "unit": ["m"]}, "the unit 'm', not 'm'"),
    "no unit": (Number("m"), {"value": 1.0}, "'unit' is missing"),
    "no quantity": (Number("m"), 1.0, "x is not an object"),
    "units": (Columns(["m", "s"]), {"value": [1.0, 2.0], "units": ["s", "m"]}, "the units 's, m', not 'm, s'"),
    "not positive": (Number("m", positive=True), {"value": 0.0, "unit": "m"}, "must be positive"),
    "count": (Count(), 1.0, "not a whole number"),
    "count of truth": (Count(), True, "not a whole number"),
    "negative count": (Count(), -1, "it must be from 0"),
    "flag": (FLAG, 1, "not true or false"),
    "string": (TEXT, None, "not a string"),
    "list": (ListOf(TEXT), "ab", "x is not a list"),
    "entry": (ListOf(TEXT), ["a", 1], r"x\[1\] is not a string"),
    "pair": (ListOf(TEXT, 2), ["a"], "not a list of 2"),
    "record": (Record(dict, {"a": TEXT}), [], "not an object"),
    "missing": (Record(dict, {"a": TEXT}), {}, "'a' is missing"),
    "no kind": (Named("ground", {}), {}, "not an object with a 'name'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_sentence(name: str) -> None:
    codec, entry, match = WRONG[name]
    with pytest.raises(InputError, match=match) as caught:
        codec.decode(entry, "x")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("codec", "value"),
    [
        (Array("m", 2), [1.0, float("nan")]),
        (Array("m", 2), [1.0]),
        (Number("m"), float("inf")),
        (TEXT, 3),
        (NameIn("foot", ["fl"]), "fr"),
        (ByName("foot", {"fl": TEXT}), {"fr": "a"}),
        (Named("ground", {"plane": Record(dict, {})}), {"name": "stairs"}),
    ],
)
def test_what_could_not_be_read_back_is_not_written(codec: Codec, value: Any) -> None:
    with pytest.raises(InputError):
        codec.encode(value, "x")


@dataclass(frozen=True)
class Ground:
    """A kind from outside, which brings its own name."""

    friction: float
    name: str = "gravel"


def test_a_kind_from_outside_is_one_line() -> None:
    codec = Named("ground", {"gravel": Record(Ground, {"friction": Number("1")})})
    assert codec.encode(Ground(0.4), "x") == {"name": "gravel", "friction": {"value": 0.4, "unit": "1"}}
    assert again(codec, Ground(0.4)) == Ground(0.4)
    with pytest.raises(UnknownNameError, match="unknown key in x 'slope'; known: friction"):
        codec.decode({"name": "gravel", "friction": {"value": 0.4, "unit": "1"}, "slope": 1}, "x")


def test_fields_may_follow_from_fields_before_them() -> None:
    codec = Record(dict, {"count": Count(), "values": lambda known: Array("m", known["count"])})
    assert list(again(codec, {"count": 2, "values": [1.0, 2.0]})["values"]) == [1.0, 2.0]
    with pytest.raises(InputError, match="x, values has the shape 2, not 3"):
        codec.decode({"values": {"value": [1.0, 2.0], "unit": "m"}, "count": 3}, "x")


def test_an_optional_key_is_written_only_where_it_is_used() -> None:
    codec = Record(dict, {"a": Optional(TEXT)})
    assert codec.encode({"a": None}, "x") == {}
    assert codec.decode({}, "x") == codec.decode({"a": None}, "x") == {"a": None}
    assert again(codec, {"a": "b"}) == {"a": "b"}
    with pytest.raises(InputError, match="x, a is not a string"):
        codec.decode({"a": 1}, "x")
