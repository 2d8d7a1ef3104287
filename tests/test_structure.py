"""The structure of the package: imports between files go one way, files and functions are of readable length."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from pathlib import Path

import pytest

import amble

SOURCES = Path(amble.__file__).parent


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


LONGEST_FILE, LONGEST_FUNCTION = 310, 60
"""Lines; a function counts with its signature and docstring."""


def functions(tree: ast.AST) -> dict[str, int]:
    """Name of every function with its lines."""
    found = (node for node in ast.walk(tree) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)))
    return {each.name: (each.end_lineno or each.lineno) - each.lineno + 1 for each in found}


def test_a_function_is_measured_with_its_docstring() -> None:
    assert functions(ast.parse('class A:\n    def f(self):\n        """One."""\n        return 1\n')) == {"f": 3}


def test_files_and_functions_are_no_longer_than_one_reads_at_once() -> None:
    long: list[str] = []
    for path in sorted(SOURCES.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        name = path.relative_to(SOURCES)
        lines = len(text.splitlines())
        long += [f"{name} has {lines} lines"] if lines > LONGEST_FILE else []
        long += [f"{name}: {f} has {n} lines" for f, n in functions(ast.parse(text)).items() if n > LONGEST_FUNCTION]
    assert long == []


MOST_POSITIONAL = 5
"""Fields that a record may take by position: of more, two arrays that are swapped pass the type check."""


def positional(tree: ast.AST) -> dict[str, int]:
    """Name of every dataclass with the number of fields that it takes by position."""
    found = {}
    for node in ast.walk(tree):
        made = [ast.unparse(each) for each in getattr(node, "decorator_list", ()) if "dataclass" in ast.unparse(each)]
        if isinstance(node, ast.ClassDef) and made and "kw_only=True" not in made[0]:
            kinds = [ast.unparse(each.annotation) for each in node.body if isinstance(each, ast.AnnAssign)]
            kinds = [kind for kind in kinds if not kind.startswith("ClassVar")]
            found[node.name] = kinds.index("KW_ONLY") if "KW_ONLY" in kinds else len(kinds)
    return found


def test_fields_by_position_are_counted() -> None:
    text = (
        "@dataclass\nclass A:\n    a: int\n    _: KW_ONLY\n    b: int\n@dataclass(kw_only=True)\nclass B:\n    a: int\n"
    )
    assert positional(ast.parse(text)) == {"A": 1}


def test_records_of_more_than_five_fields_are_built_by_keyword() -> None:
    for path in sorted(SOURCES.rglob("*.py")):
        for name, count in positional(ast.parse(path.read_text(encoding="utf-8"))).items():
            assert count <= MOST_POSITIONAL, f"{path.relative_to(SOURCES)}: {name} takes {count} fields by position"
