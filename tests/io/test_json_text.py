"""Properties of JSON text on arbitrary content: what is written reads back exactly, or is refused."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from amble.errors import InputError
from amble.io.reader import parse_json
from amble.io.storage import dumps

few = settings(derandomize=True, max_examples=60, deadline=None, database=None)

numbers = st.floats(allow_nan=False, allow_infinity=False)
texts = st.text(st.characters(exclude_categories=("Cs",)), max_size=8)
plain = st.none() | st.booleans() | st.integers(-(2**70), 2**70) | numbers | texts
trees = st.recursive(
    plain, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(texts, inner, max_size=4), max_leaves=25
)


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
    assert same(parse_json(text, "text"), tree)
    assert same(json.loads(text), tree)
    assert dumps(parse_json(text, "text")) == text


@few
@given(st.dictionaries(texts, plain, min_size=1, max_size=4), st.data())
def test_a_key_twice_is_refused(tree: dict[str, Any], data: st.DataObject) -> None:
    key = data.draw(st.sampled_from(list(tree)))
    twice = f"{json.dumps(tree)[:-1]}, {json.dumps(key)}: 1}}"
    with pytest.raises(InputError, match="twice in one object"):
        parse_json(twice, "text")


@few
@given(st.lists(st.sampled_from([math.nan, math.inf, -math.inf, 1.0]), min_size=1, max_size=4))
def test_only_finite_numbers_are_json(values: list[float]) -> None:
    assume(not all(map(math.isfinite, values)))
    with pytest.raises(ValueError, match="not JSON compliant"):
        dumps({"a": values})
    with pytest.raises(InputError, match="which is not a number"):
        parse_json(json.dumps(values), "text")


@few
@given(st.text(max_size=40))
def test_any_text_is_read_or_refused_in_one_sentence(text: str) -> None:
    refusal = ""
    try:
        tree = parse_json(text, "text")
    except InputError as error:
        refusal = str(error)
    assert refusal.startswith("text ") if refusal else same(json.loads(text), tree)
