"""The structure of the package: imports between files go one way."""

from __future__ import annotations

from collections.abc import Mapping

import pytest


def circles(imports: Mapping[str, set[str]]) -> list[str]:
    """Files in or between circles: what is left when files that import or are imported by none left are taken away."""
    left = dict(imports)
    while True:
        imported = set().union(*left.values())
        kept = {name for name, targets in left.items() if targets and name in imported}
        if len(kept) == len(left):
            return sorted(left)
        left = {name: left[name] & kept for name in kept}


@pytest.mark.parametrize(
    ("imports", "found"),
    [
        ({"a": {"b"}, "b": {"c"}, "c": set()}, []),
        ({"a": {"b"}, "b": {"a"}, "c": {"a"}, "d": set()}, ["a", "b"]),
        ({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a", "c"}}, ["a", "b", "c"]),
    ],
)
def test_what_counts_as_a_circle(imports: Mapping[str, set[str]], found: list[str]) -> None:
    assert circles(imports) == found


def test_no_files_import_each_other_in_a_circle() -> None:
    """Eight files of the robot and three of the simulation did, by imports inside functions."""
    grimp = pytest.importorskip("grimp", reason="grimp comes with import-linter, of the extra lint")
    graph = grimp.build_graph("amble", exclude_type_checking_imports=True)
    imports = {name: set(graph.find_modules_directly_imported_by(name)) for name in graph.modules}
    assert len(imports) > 100
    assert circles(imports) == []
