"""A crafted name in every text of a gait file: a sentence, or C that compiles without a warning and is harmless."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from amble.codegen import compiler
from amble.errors import InputError
from amble.export import export_controller
from amble.gait import Gait
from amble.gait.files import load_gait
from fuzz.gait_bases import small
from fuzz.kinds import rehash
from tests.hostile import ATTACK, ATTACK_ON_ONE_LINE, MARKER
from tests.test_names import renamed

STRICT = ("-std=c99", "-trigraphs", "-Wall", "-Wextra", "-Werror")

CRAFTED = (
    *(
        "*/",
        "/*",
        "//",
        "??/",
        "??=",
        "\\",
        '"',
        "'",
        "%n%s",
        "@TABLES@",
        "@ROBOT@",
        "{0}",
        "${x}",
        "\\u000a",
        "#error",
    ),
    *(f"$(touch {MARKER})", f"`touch {MARKER}`", f";touch {MARKER};", f'"); system("touch {MARKER}"); ("'),
    ATTACK_ON_ONE_LINE,
)
LINES = (ATTACK, "a\nb", "\r", "\u2028", "\0", "\x1b[31m", "\ud800", "x" * 101)
"""No names, wherever they stand."""


def texts(tree: Any) -> list[str]:
    """Every text of a tree, keys included, each once."""
    if isinstance(tree, dict):
        return list(dict.fromkeys(text for key, value in tree.items() for text in (key, *texts(value))))
    if isinstance(tree, list):
        return list(dict.fromkeys(text for value in tree for text in texts(value)))
    return [tree] if isinstance(tree, str) else []


def loaded(names: Mapping[str, str], file: Path) -> Gait | None:
    """Return the gait under other names; None where it is refused, which is one printable sentence."""
    tree = renamed(json.loads(small(1)), names)
    rehash(tree)
    file.write_bytes(json.dumps(tree).encode("utf-8", "surrogatepass"))
    try:
        return load_gait(file)
    except InputError as error:
        if not str(error).isprintable():
            raise
        return None


@pytest.fixture(scope="module")
def chosen(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """The texts of the file that may be any name, each found by one of the crafted ones."""
    file = tmp_path_factory.mktemp("texts") / "gait.json"
    tree = json.loads(small(1))
    every = [text for text in texts(tree) if text != tree["robot"]["hash"]]  # which ``loaded`` writes
    found = [text for number, text in enumerate(every) if loaded({text: CRAFTED[number % len(CRAFTED)]}, file)]
    assert len(found) > 20
    assert len(found) < len(every) - 60  # units and keys are not for users to choose
    return found


def test_what_is_no_line_of_text_is_refused_in_every_field(chosen: list[str], tmp_path: Path) -> None:
    for number, text in enumerate(chosen):
        assert loaded({text: LINES[number % len(LINES)]}, tmp_path / "gait.json") is None


@pytest.mark.skipif(compiler() is None, reason="no C compiler on this machine")
@pytest.mark.parametrize("shift", [0, *(pytest.param(shift, marks=pytest.mark.slow) for shift in (1, 2, 3))])
def test_names_in_every_field_at_once_make_harmless_c(
    shift: int, chosen: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tool = compiler()
    assert tool is not None
    monkeypatch.chdir(tmp_path)
    names = {text: f"{CRAFTED[(number + shift) % len(CRAFTED)]}{number}"[-100:] for number, text in enumerate(chosen)}
    gait = loaded(names, tmp_path / "gait.json")
    assert gait is not None
    exported = export_controller(gait, None, tmp_path / "controller")
    sources = [path.name for path in (*exported.sources, exported.folder / "replay.c")]
    command = [tool.path, *STRICT, *sources, "-o", "replay", "-lm"]
    done = subprocess.run(command, cwd=exported.folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    subprocess.run(["./replay", "test_vectors.txt"], cwd=exported.folder, capture_output=True, check=False)
    if shutil.which("cmake"):
        subprocess.run(["cmake", "-B", "build", "-S", "."], cwd=exported.folder, check=True, capture_output=True)
    assert not list(tmp_path.rglob(MARKER))
