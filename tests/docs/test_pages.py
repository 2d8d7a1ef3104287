"""The sources of the site: every page is reached, every public name is on a page of the reference."""

from __future__ import annotations

import ast
import re
from collections import Counter
from pathlib import Path

import pytest

import amble

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(DOCS.rglob("*.md"))


def test_every_page_is_in_a_table_of_contents() -> None:
    listed: set[Path] = set()
    for page in PAGES:
        for tree in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            names = [line for line in tree.splitlines() if line and not line.startswith(":")]
            listed |= {(page.parent / f"{name}.md").resolve() for name in names}
    assert listed == {page.resolve() for page in PAGES} - {(DOCS / "index.md").resolve()}


def test_the_reference_holds_every_public_name_once() -> None:
    pages = [page.read_text(encoding="utf-8") for page in (DOCS / "reference").glob("*.md")]
    named = Counter(
        name.rsplit(".", 1)[-1]
        for text in pages
        for name in re.findall(r"^\.\. auto\w+:: ([\w.]+)$", text, re.MULTILINE)
    )
    modules = {amble._HOME[name].rsplit(".", 1)[-1]: name for name in amble._MODULES}  # type: ignore[attr-defined]
    found = Counter({modules.get(name, name): count for name, count in named.items()})
    assert found == Counter(set(amble.__all__) - {"__version__"})


@pytest.mark.parametrize("page", [page for page in PAGES if "decisions" not in page.name], ids=lambda page: page.name)
def test_code_of_pages_is_python(page: Path) -> None:
    """Code that the site does not run is at least Python, and names what amble has."""
    text = page.read_text(encoding="utf-8")
    for block in re.findall(r"```(?:\{code-cell\} )?python\n(?:^:.*\n)*(.*?)```", text, re.DOTALL | re.MULTILINE):
        lines = block.splitlines()
        indent = min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
        tree = ast.parse("\n".join(line[indent:] for line in lines))
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "amble":
                assert hasattr(amble, node.attr), f"{page.name} uses amble.{node.attr}"


def test_commands_of_pages_exist() -> None:
    """Every `amble COMMAND --option` of a console block is one that the program has."""
    from typer.main import get_command

    from amble.cli.app import app

    commands = vars(get_command(app))["commands"]
    found = 0
    for page in PAGES:
        for block in re.findall(r"```console\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            for name, rest in re.findall(r"(?:^\$ |&& |bin/)amble (\w+)([^&#\n]*)", block, re.MULTILINE):
                options = {option for each in commands[name].params for option in each.opts}
                assert set(re.findall(r"(?<!\S)--?[a-z][\w-]*", rest)) <= options, f"{page.name}: amble {name}{rest}"
                found += 1
    assert found > 10
