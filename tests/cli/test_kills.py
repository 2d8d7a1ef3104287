"""Commands that are killed at any moment leave old or complete new files, and no debris after the next run."""

from __future__ import annotations

import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import pytest

from amble.cli.app import app
from amble.codegen import cache_folder, compiler
from amble.gait.files import load_gait
from amble.simulation import load_trace
from amble.synthesis.specification import read_specification
from amble.types import Json
from amble.workflow.library import load_transitions
from fuzz.records import write_library
from tests.cli.run import exit_code

pytestmark = pytest.mark.skipif(
    compiler() is None or os.name != "posix", reason="signals, and a compiler for the libraries"
)
GAIT = Path(__file__).parents[1] / "data" / "stabilised-amble.json"
BIPED = str(GAIT.with_name("biped-of-small-basin.json"))
"""Followed in half the time."""
STEERED = ("--commands", "{inputs}/commands.csv", "--duration", "0.3")
SHORT = ("--control", "impedance", "--case", "nominal", "--cycles", "1")
WHEEL = str(GAIT.parents[2] / "examples" / "rimless_wheel.py")
SENTENCE = {
    signal.SIGINT: "interrupted; files that were complete before are as they were",
    signal.SIGTERM: "terminated; files that were complete before are as they were",
}


@dataclass(frozen=True)
class Case:
    """A command, what it writes, and whether a result is whole.

    Attributes:
        arguments: of amble; they end with the place of the result, and {inputs} is the folder of ``inputs``.
        whole: reads a result; raises where it is not whole.
        kills: of the 200 and more that all commands together are given.
        begin: folder of ``inputs`` that is there as the result before the first run.
    """

    arguments: tuple[str, ...]
    whole: Callable[[Path], object]
    kills: int = 18
    begin: str = ""


def _controller(folder: Path) -> None:
    """All files of one controller, by the law that their heads name."""
    names = {path.name for path in folder.iterdir()}
    assert names == {
        *("amble_controller.h", "amble_controller.c", "replay.c", "CMakeLists.txt", "test_vectors.txt"),
        *("amble_law_D1.c", "amble_law_D2.c"),
    }
    assert all(path.read_text().endswith("\n") for path in folder.iterdir())


def _json(path: Path) -> Json:
    import json

    return json.loads(path.read_text())


def _page(path: Path) -> None:
    assert path.read_text().rstrip().endswith("</html>")


def _files(folder: Path) -> None:
    """Every file of a run is whole, whichever of them are there."""
    readers = {".json": _json, ".nc": load_trace, ".html": _page}
    for path in folder.rglob("*"):
        if path.is_file() and not any(part.startswith(".") for part in path.relative_to(folder).parts):
            assert path.stat().st_size > 0
            readers.get(path.suffix, Path.read_bytes)(path)


def _table(path: Path) -> None:
    rows = path.read_text().split("\n")
    assert rows[0].startswith("time,asked_speed,")
    assert len({row.count(",") for row in rows[:-1]}) == 1
    assert rows[-1] == ""


CASES = {
    "export": Case(("export", str(GAIT), "--law", "pinv", "--out"), _controller),
    "compare": Case(("compare", BIPED, "--law", "pinv", "--out"), _json),
    "simulate": Case(("simulate", BIPED, "--cycles", "2", "--out"), load_trace),
    "init": Case(("init", "astro", "--gait", "amble", "--speed", "0.2", "--out"), read_specification),
    "certify": Case(("certify", BIPED, "--out"), _json),
    "prove": Case(("prove", f"{WHEEL}:rolling", "--order", "14", "--basin", "0", "--out"), _json),
    "view": Case(("view", BIPED, "--cycles", "2", "--out"), _page),
    "import": Case(("import", "{inputs}/motion.npz", "--out"), load_gait),
    "validate": Case(("validate", str(GAIT), *SHORT, "--out"), _json),
    "report": Case(("report", "{inputs}", "--law", "pinv", "--out"), _files),
    "synthesize": Case(("synthesize", "{inputs}/spec.toml", "--out"), load_gait, kills=12),
    "stabilize": Case(("stabilize", BIPED, "--out"), load_gait, kills=12),
    "robustness": Case(("robustness", BIPED, "--trials", "2", "--cycles", "2", "--out"), _files, kills=6),
    "front": Case(("front", BIPED, "--out"), _files, kills=6),
    "library": Case(("library", "{inputs}/library.toml", "--out"), _files, kills=6),
    "transitions": Case(("transitions",), load_transitions, kills=6, begin="steerable"),
    "steer": Case(("steer", "{inputs}/steerable", *STEERED, "--out"), _table, kills=12),
    "reproduce": Case(("reproduce", "--spec", "{inputs}/spec.toml", "--cycles", "2", "--out"), _files, kills=9),
}
"""Every command that writes."""
SOME = ("export", "compare")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What commands read beside stored gaits: a motion, a run to report on, a coarse specification."""
    folder = tmp_path_factory.mktemp("inputs")
    shutil.copy(BIPED, folder / "gait.json")
    assert exit_code("export", BIPED, "--out", str(folder / "motion.npz")) == 0
    assert exit_code("simulate", BIPED, "--cycles", "2", "--out", str(folder / "trace.nc")) == 0
    text = (resources.files("amble.specifications") / "astro-amble.toml").read_text()
    coarse = re.sub(r"intervals = \d+", "intervals = 6\nrefinement = 1", text)
    (folder / "spec.toml").write_text(coarse)
    write_library(folder / "steerable", load_gait(GAIT))
    (folder / "commands.csv").write_text("time,speed\n0,0.2\n0.1,0.25\n")
    (folder / "library.toml").write_text(f"{coarse}\n[library.axes]\nspeed = {{ range = [0.18, 0.2], step = 0.02 }}\n")
    return folder


def run(case: Case, folder: Path, cache: Path, inputs: Path = GAIT.parent) -> subprocess.Popen[str]:
    code = "import os, signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    code += "from amble.cli import main; print('ready', flush=True); main()"
    environment = {**os.environ, "AMBLE_CACHE": str(cache), "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.Popen(
        [sys.executable, "-c", code, *(word.format(inputs=inputs) for word in case.arguments), "result"],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(case: Case, folder: Path, cache: Path, inputs: Path) -> float:
    """Run to the end and return the seconds it took."""
    started = time.monotonic()
    process = run(case, folder, cache, inputs)
    _, messages = process.communicate(timeout=600)
    assert process.returncode == 0, messages
    return time.monotonic() - started


def snapshot(path: Path) -> dict[str, bytes]:
    """Content of a file or folder."""
    files = [file for file in path.rglob("*") if file.is_file()] if path.is_dir() else [path]
    return {str(file): file.read_bytes() for file in files}


def kill(case: Case, folder: Path, cache: Path, inputs: Path, delay: float, number: signal.Signals) -> None:
    """Kill one run after a delay and look at its end and at the result."""
    before, left = snapshot(folder / "result"), debris(folder)  # of a run that was ended by SIGKILL
    process = run(case, folder, cache, inputs)
    assert process.stdout is not None
    process.stdout.readline()  # Python itself is up; before that nobody could say anything
    time.sleep(delay)
    process.send_signal(number)
    _, messages = process.communicate(timeout=300)
    case.whole(folder / "result")
    if process.returncode == 0:  # it was faster
        return
    assert "Traceback" not in messages, messages
    if number == signal.SIGKILL:
        assert process.returncode == -signal.SIGKILL
        return
    if snapshot(folder / "result") == before:
        assert process.returncode == 128 + number, messages
    assert messages.splitlines()[-1] == SENTENCE[number]
    # before it, nothing but how far the work was
    assert not any(re.match("error|Exception|.*Warning", line) for line in messages.splitlines()[:-1]), messages
    assert set(debris(folder)) <= set(left), "it could clean up, and did not"


def debris(*folders: Path) -> list[Path]:
    return [path for folder in folders for path in folder.rglob(".*")]


def second_name(source: str, target: str) -> None:
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache of its own: what the session has compiled, by a second name where the disk can."""
    cache = tmp_path_factory.mktemp("warm") / "cache"
    if cache_folder().is_dir():
        shutil.copytree(cache_folder(), cache, ignore=shutil.ignore_patterns(".amble-*"), copy_function=second_name)
    cache.mkdir(exist_ok=True)
    cache.chmod(0o700)
    return cache


def kill_often(name: str, folder: Path, cache: Path, inputs: Path, kills: int, seed: int) -> None:
    case, chance = CASES[name], random.Random(f"{name} {seed}")
    if case.begin:
        shutil.copytree(inputs / case.begin, folder / "result")
    finish(case, folder, cache, inputs)
    duration = finish(case, folder, cache, inputs)
    for index in range(kills):
        number = (signal.SIGKILL, signal.SIGINT, signal.SIGTERM)[index % 3]
        kill(case, folder, cache, inputs, chance.uniform(0.0, duration), number)
    finish(case, folder, cache, inputs)
    assert sorted(os.listdir(folder)) == ["result"]
    assert not debris(folder, cache)


@pytest.mark.parametrize(
    "name", ["simulate", *(pytest.param(n, marks=pytest.mark.slow) for n in ("export", "compare"))]
)
def test_some_kills(name: str, tmp_path: Path, warm: Path) -> None:
    """One of each signal."""
    kill_often(name, tmp_path, warm, GAIT.parent, kills=3, seed=0)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_many_kills(name: str, tmp_path: Path, warm: Path, inputs: Path) -> None:
    kill_often(name, tmp_path, warm, inputs, kills=CASES[name].kills, seed=1)


def test_every_command_that_writes_is_killed_often() -> None:
    silent = {"check", "robots", "doctor"}
    commands = {command.name or getattr(command.callback, "__name__", "") for command in app.registered_commands}
    assert commands - silent == set(CASES)
    assert sum(case.kills for case in CASES.values()) >= 200


@pytest.mark.parametrize(
    "number",
    [signal.SIGTERM, *(pytest.param(other, marks=pytest.mark.slow) for other in (signal.SIGKILL, signal.SIGINT))],
)
def test_a_kill_while_the_compiler_works(number: signal.Signals, tmp_path: Path) -> None:
    cache, folder = tmp_path / "cache", tmp_path / "work"
    folder.mkdir()
    process = run(Case(("simulate", str(GAIT), "--cycles", "2", "--out"), load_trace), folder, cache)
    assert process.stderr is not None
    while "compiling" not in (line := process.stderr.readline()):
        assert line, "it ended without compiling"
    time.sleep(0.5)
    process.send_signal(number)
    started = time.monotonic()
    messages = process.communicate(timeout=60)[1].splitlines()
    assert time.monotonic() - started < 10  # what is being compiled is not waited for
    assert not list(folder.iterdir())
    if number == signal.SIGKILL:
        assert debris(cache)
        from_next_run = "from amble.codegen.cache import writable_folder as w; w()"
        subprocess.run([sys.executable, "-c", from_next_run], env={**os.environ, "AMBLE_CACHE": str(cache)}, check=True)
    else:
        assert process.returncode == 128 + number
        assert messages[-1] == SENTENCE[number]
    assert not debris(cache)


IMPORT = """
import sys, signal, os

class Finder:
    # raises the signal at the n-th import after the program has begun
    def __init__(self): self.left, self.number = int(sys.argv.pop(1)), int(sys.argv.pop(1))
    def find_spec(self, *_):
        self.left -= 1
        if self.left == 0: os.kill(os.getpid(), self.number)

signal.signal(signal.SIGINT, signal.default_int_handler)
import amble.cli
sys.meta_path.insert(0, Finder())
amble.cli.main()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("at", [1, 100, 300, *(pytest.param(at, marks=pytest.mark.slow) for at in (20, 200, 500))])
def test_a_signal_during_imports_is_one_sentence(at: int, number: signal.Signals, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", IMPORT, str(at), str(int(number)), "compare", str(GAIT), "--out", "x.json"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    said = done.stderr.splitlines()
    assert (done.returncode, said[-1]) == (128 + number, SENTENCE[number])
    assert set(said[:-1]) <= {"comparing ..."}
    assert not list(tmp_path.iterdir())


def test_an_interruption_that_a_destructor_swallows_is_raised_again() -> None:
    code = """
import os, signal, time
from amble.cli.process import Endings

class Swallows:
    def __del__(self): os.kill(os.getpid(), signal.SIGTERM); time.sleep(0.01)

def work():
    held = Swallows()
    del held
    time.sleep(20)

with Endings(own_process=True) as endings:
    raise SystemExit(endings.ending(work))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=15)
    assert (done.returncode, done.stderr) == (143, f"{SENTENCE[signal.SIGTERM]}\n")
