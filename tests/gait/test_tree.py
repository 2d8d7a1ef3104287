"""Properties of the JSON codec on arbitrary content: what is written reads back exactly, or is refused."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from amble.errors import InputError, UnknownNameError
from amble.io.codec import Reader, dumps, loads, quantity, table
from amble.types import Matrix

few = settings(derandomize=True, max_examples=60, deadline=None, database=None)

numbers = st.floats(allow_nan=False, allow_infinity=False)
limits = st.floats(allow_nan=False)
texts = st.text(st.characters(exclude_categories=("Cs",)), max_size=8)
plain = st.none() | st.booleans() | st.integers(-(2**70), 2**70) | numbers | texts
trees = st.recursive(
    plain, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(texts, inner, max_size=4), max_leaves=25
)
shapes = arrays.array_shapes(min_dims=0, max_dims=3, min_side=1, max_side=4)
matrices = arrays.arrays(np.float64, arrays.array_shapes(min_dims=2, max_dims=2, max_side=5), elements=numbers)


def written(key: str, value: Any) -> Reader:
    """Write an object with one key, and return the reader of what comes back."""
    return Reader(loads(dumps({key: value}), "text"), "file")


def same(left: Any, right: Any) -> bool:
    """Equal to the last bit: type by type, and with the sign of zero."""
    if type(left) is not type(right):
        return False
    if isinstance(left, dict):
        return list(left) == list(right) and all(same(left[key], right[key]) for key in left)
    if isinstance(left, list):
        return len(left) == len(right) and all(map(same, left, right))
    return bool(left == right) and (not isinstance(left, float) or math.copysign(1, left) == math.copysign(1, right))


@few
@given(trees)
def test_a_tree_reads_back_exactly(tree: Any) -> None:
    text = dumps(tree)
    assert same(loads(text, "text"), tree)
    assert same(json.loads(text), tree)
    assert dumps(loads(text, "text")) == text


@few
@given(texts, st.data())
def test_a_quantity_reads_back_exactly(unit: str, data: st.DataObject) -> None:
    shape = data.draw(shapes)
    values = data.draw(arrays.arrays(np.float64, shape, elements=limits))
    back = written("a", quantity(values if values.ndim else float(values), unit)).array("a", unit, shape, infinite=True)
    assert back.dtype == np.float64
    assert np.array_equal(back, values)
    assert np.array_equal(np.signbit(back), np.signbit(values))
    assert not back.flags.writeable
    if np.isinf(values).any():
        with pytest.raises(InputError, match="not a finite number"):
            written("a", quantity(values, unit)).array("a", unit, shape)


@few
@given(matrices, st.data())
def test_a_table_reads_back_exactly(values: Matrix, data: st.DataObject) -> None:
    units = data.draw(st.lists(texts, min_size=values.shape[1], max_size=values.shape[1]))
    back = written("a", table(values, units)).columns("a", units, len(values))
    assert np.array_equal(back, values)


@few
@given(matrices, texts, texts)
def test_another_unit_is_refused(values: Matrix, unit: str, other: str) -> None:
    assume(unit != other)
    with pytest.raises(InputError, match="has the unit"):
        written("a", quantity(values, unit)).array("a", other, values.shape)


@few
@given(matrices, st.data())
def test_another_shape_is_refused(values: Matrix, data: st.DataObject) -> None:
    other = data.draw(shapes.filter(lambda shape: shape != values.shape))
    with pytest.raises(InputError, match="has the shape"):
        written("a", quantity(values, "m")).array("a", "m", other)


@few
@given(st.dictionaries(texts, plain, min_size=1, max_size=4), texts)
def test_keys_that_are_missing_or_unknown_are_refused(tree: dict[str, Any], key: str) -> None:
    assume(key not in tree)
    reader = Reader(loads(dumps(tree), "text"), "file")
    assert reader.expect(*tree).names() == tuple(tree)
    with pytest.raises(InputError, match="is missing"):
        reader.expect(*tree, key)
    with pytest.raises(UnknownNameError):
        reader.expect(*list(tree)[1:])


@few
@given(st.dictionaries(texts, plain, min_size=1, max_size=4), st.data())
def test_a_key_twice_is_refused(tree: dict[str, Any], data: st.DataObject) -> None:
    key = data.draw(st.sampled_from(list(tree)))
    twice = f"{json.dumps(tree)[:-1]}, {json.dumps(key)}: 1}}"
    with pytest.raises(InputError, match="twice in one object"):
        loads(twice, "text")


@few
@given(st.lists(st.sampled_from([math.nan, math.inf, -math.inf, 1.0]), min_size=1, max_size=4))
def test_only_finite_numbers_are_json(values: list[float]) -> None:
    assume(not all(map(math.isfinite, values)))
    with pytest.raises(ValueError, match="not JSON compliant"):
        dumps({"a": values})
    with pytest.raises(InputError, match="which is not a number"):
        loads(json.dumps(values), "text")


@few
@given(st.text(max_size=40))
def test_any_text_is_read_or_refused_in_one_sentence(text: str) -> None:
    refusal = ""
    try:
        tree = loads(text, "text")
    except InputError as error:
        refusal = str(error)
    assert refusal.startswith("text ") if refusal else same(json.loads(text), tree)


@few
@given(st.integers(309, 6000), st.sampled_from(["", "-"]))
def test_a_whole_number_beyond_all_floats_is_refused(digits: int, sign: str) -> None:
    text = f'{{"a": {{"value": {sign}{"9" * digits}, "unit": "m"}}}}'
    with pytest.raises(InputError, match=r"which is not a finite number|is not JSON"):
        Reader(loads(text, "text"), "file").array("a", "m", ())
