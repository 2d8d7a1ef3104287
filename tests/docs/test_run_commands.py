"""Console blocks of pages are run as they stand, and what does not end as the page says is told."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.run_commands import commands, run

TEXT = """
```console
$ python3 -m venv .venv
$ source .venv/bin/activate
$ pip install '.[reproduce]'
$ echo one > file
output
```
text
```console
$ cat file   # exits with 1
$ cat file && false   # exits with 1
$ cat gone
```
"""


@pytest.fixture
def page(tmp_path: Path) -> Path:
    path = tmp_path / "page.md"
    path.write_text(TEXT, encoding="utf-8")
    return path


def test_environments_are_left_out(page: Path) -> None:
    assert commands(page)[0] == "echo one > file"
    assert len(commands(page)) == 4


def test_what_ends_otherwise_is_told(page: Path, tmp_path: Path) -> None:
    first, second = run(page, tmp_path)
    assert "'cat file   # exits with 1' ended with 0" in first
    assert "'cat gone' ended with 1" in second
