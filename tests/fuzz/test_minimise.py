"""What is left of a failing input is what makes it fail."""

from __future__ import annotations

import json
import random

from fuzz.minimise import minimised, shrunk


def test_a_sequence_shrinks_to_the_items_that_matter() -> None:
    for seed in range(20):
        draw = random.Random(seed)
        wanted = set(draw.sample(range(100), draw.randrange(1, 5)))
        assert shrunk(range(100), lambda part, wanted=wanted: wanted <= set(part)) == sorted(wanted)


def test_bytes_shrink() -> None:
    content = b"\n".join(b"line %d" % number for number in range(50)) + b"\n<bad>\n"
    assert minimised(content, lambda part: b"<bad>" in part, tries=2000) == b"<bad>"


def test_a_tree_stays_a_tree() -> None:
    tree = {"a": [1, 2, {"b": 3, "bad": [4, 5]}], "c": {"d": 1}}

    def fails(content: bytes) -> bool:
        return "bad" in str(json.loads(content)["a"])

    left = minimised(json.dumps(tree).encode(), lambda content: b'"a": [' in content and fails(content))
    assert json.loads(left) == {"a": [{"bad": []}]}
