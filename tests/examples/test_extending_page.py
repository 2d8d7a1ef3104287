"""docs/extending.md: every example is named with its registry, imports only public amble, and registers once."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import amble

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
EXAMPLES = sorted((ROOT / "examples" / "extending").glob("*.py"))
ROWS = re.findall(
    r"^\| ([a-z ]+) \| `amble\.([A-Z_]+)` \| \[(\w+\.py)\]\(../examples/extending/\3\)", PAGE, re.MULTILINE
)


def test_there_is_one_example_for_each_extension_point() -> None:
    assert len(ROWS) == 11
    assert sorted(file for _, _, file in ROWS) == [path.name for path in EXAMPLES]


@pytest.mark.parametrize(("registry", "file"), [row[1:] for row in ROWS])
def test_an_example_is_one_registration(registry: str, file: str) -> None:
    text = (ROOT / "examples" / "extending" / file).read_text(encoding="utf-8")
    assert re.findall(r"^([A-Z_]+)\.register\(", text, re.MULTILINE) == [registry]
    assert hasattr(getattr(amble, registry), "register")
    assert not re.search(r"(from|import) (tests|benchmarks|examples)", text)
    assert not re.search(r"from amble[\w.]* import .*\b_\w", text)
