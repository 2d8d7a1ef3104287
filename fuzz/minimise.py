"""Delta debugging: the smallest part of an input that still fails in the same way (Zeller, Hildebrandt 2002)."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

Item = TypeVar("Item")

TRIES = 400
"""Inputs that are tried for one failure."""


class Budget:
    """A predicate that says no once it was asked often enough."""

    def __init__(self, fails: Callable[[bytes], bool], tries: int = TRIES) -> None:
        self._fails, self.left = fails, tries

    def __call__(self, content: bytes) -> bool:
        """Whether the content still fails."""
        if self.left <= 0:
            return False
        self.left -= 1
        return self._fails(content)


def minimised(content: bytes, fails: Callable[[bytes], bool], tries: int = TRIES) -> bytes:
    """Return a smaller content that fails too: as a tree where it is one, then in lines, then in bytes."""
    budget = Budget(fails, tries)
    try:
        tree = json.loads(content)
    except ValueError:
        tree = None
    if isinstance(tree, dict) and budget(_dumped(tree)):
        return _dumped(_smaller_tree(tree, budget))
    lines = content.splitlines(keepends=True)
    content = b"".join(shrunk(lines, lambda part: budget(b"".join(part))))
    if len(content) < 2000:
        single = [content[i : i + 1] for i in range(len(content))]
        content = b"".join(shrunk(single, lambda part: budget(b"".join(part))))
    return content


def shrunk(items: Sequence[Item], fails: Callable[[Sequence[Item]], bool]) -> list[Item]:
    """Return a part of a sequence that still fails: pieces are left out, from halves down to single items."""
    kept, size = list(items), max(1, len(items) // 2)
    while kept:
        at = 0
        while at < len(kept):
            without = kept[:at] + kept[at + size :]
            if fails(without):
                kept = without
            else:
                at += size
        if size == 1:
            return kept
        size //= 2
    return kept


def _dumped(tree: Any) -> bytes:
    return json.dumps(tree).encode("utf-8", "surrogatepass")


def _smaller_tree(tree: Any, budget: Budget) -> Any:
    """Leave keys out, shorten lists, and put 0 in the place of parts, level by level."""
    level: list[tuple[Any, ...]] = [()]
    while level:
        following = []
        for path in level:
            part = _at(tree, path)
            for key in list(part) if isinstance(part, dict) else list(range(len(part)))[::-1]:
                kept = part[key]
                del part[key]
                if budget(_dumped(tree)):
                    continue
                part.insert(key, kept) if isinstance(part, list) else part.__setitem__(key, kept)
            keys = list(part) if isinstance(part, dict) else range(len(part))
            following += [(*path, key) for key in keys if isinstance(part[key], dict | list) and part[key]]
        level = following if budget.left > 0 else []
    return tree


def _at(tree: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        tree = tree[key]
    return tree
