"""Libraries of the extras: the core never imports them, and their absence is told in one sentence."""

from __future__ import annotations

import ast
import importlib.util
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from amble.errors import MissingExtraError
from amble.optional import require
from tests.cli.run import exit_code

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "src" / "amble"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = {
    extra: [re.split(r"[><=]", line)[0] for line in lines]
    for extra, lines in PROJECT["optional-dependencies"].items()
    if extra not in ("all", "test", "lint", "bench", "docs")
}
IMPORTED = {"python-flint": "flint"}
HOME = {IMPORTED.get(library, library): extra for extra, libraries in EXTRAS.items() for library in libraries}
WHOLE_PACKAGES = {"proof": "flint"}
"""Packages that ask once, at their import, and which nothing else imports before it asked."""
WORKERS = {"mjcf_worker.py": "mujoco"}
"""Scripts that a module runs which has asked."""

IMPORT_EVERYTHING = """
import importlib, pkgutil, sys
for name in sys.argv[1:]:
    sys.modules[name] = None  # an import of it fails
import amble
for module in pkgutil.walk_packages(amble.__path__, "amble.", onerror=str):
    if module.name != "amble.__main__" and not module.name.startswith("amble.proof"):
        importlib.import_module(module.name)
"""


def without(monkeypatch: pytest.MonkeyPatch, library: str) -> None:
    """Let a library be looked for in vain."""
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == library else find(name))


def imports(tree: ast.AST, function: ast.AST | None = None) -> Iterator[tuple[ast.AST | None, int, str]]:
    """Yield the innermost function, the line and the library of every import that happens at run time."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.Import | ast.ImportFrom):
            named = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module or ""]
            yield from ((function, node.lineno, name.split(".")[0]) for name in named if name)
        yield from imports(node, node if isinstance(node, ast.FunctionDef) else function)


def asks_before(function: ast.AST | None, line: int, library: str) -> bool:
    """Whether a function calls ``require("library", its extra, ...)``, or ``require_library()``, before a line."""
    wanted = f"require('{library}', '{HOME[library]}',", f"require_{library}()"
    calls = [node for node in ast.walk(function) if isinstance(node, ast.Call)] if function is not None else []
    return any(call.lineno < line and ast.unparse(call).startswith(wanted) for call in calls)


def test_every_import_of_an_optional_library_asks_for_it_first() -> None:
    found = 0
    for path in sorted(SOURCES.rglob("*.py")):
        for function, line, library in imports(ast.parse(path.read_text(encoding="utf-8"))):
            asked = library in (WHOLE_PACKAGES.get(path.parent.name), WORKERS.get(path.name))
            if library in HOME and not asked:
                found += 1
                assert asks_before(function, line, library), f"{path.relative_to(ROOT)}:{line} imports {library}"
    assert found > 0


def test_all_is_every_extra_of_users() -> None:
    assert PROJECT["optional-dependencies"]["all"] == [f"amble[{','.join(EXTRAS)}]"]


def test_every_module_imports_without_the_extras() -> None:
    done = subprocess.run(
        [sys.executable, "-c", IMPORT_EVERYTHING, *HOME], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr


def test_a_missing_library_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    require("matplotlib", "reproduce", "figures")
    without(monkeypatch, "matplotlib")
    with pytest.raises(MissingExtraError) as refused:
        require("matplotlib", "reproduce", "figures")
    assert str(refused.value) == ("figures need matplotlib, which is not installed: pip install 'amble[reproduce]'")


@pytest.mark.parametrize(
    ("library", "arguments"),
    [
        ("matplotlib", ("reproduce", "--out", "out")),
        ("matplotlib", ("report", "absent", "--out", "out")),
        ("matplotlib", ("compare", "--figure", "out/figure", "GAIT")),
    ],
)
def test_a_command_says_it_before_it_works(
    library: str,
    arguments: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    gait = ROOT / "tests" / "data" / "stabilised-amble.json"
    monkeypatch.chdir(tmp_path)
    without(monkeypatch, library)
    assert exit_code(*(str(gait) if argument == "GAIT" else argument for argument in arguments)) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert len(said.err.splitlines()) == 1
    assert f"need {library}, which is not installed: pip install 'amble[{HOME[library]}]'" in said.err
    assert not list(tmp_path.iterdir())
