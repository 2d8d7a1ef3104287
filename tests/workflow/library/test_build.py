"""Libraries of a few gaits of ASTRo: complete, certified, the same after kills, nothing done twice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from amble.errors import InputError
from amble.stability import certify
from amble.verification.check import check
from amble.workflow.library import Library, build_library, load_library
from amble.workflow.library.axes import read_library
from amble.workflow.library.build import chains

SPEC = """
[robot]
name = "astro"
[gait]
name = "amble"
speed = "0.2 m/s"
[limits]
duration = ["10 ms", "200 ms"]
normal_force = "5 N"
clearance = "20 mm"
[limits.base]
z = [0.32, 0.36]
[library]
time_limit = "{limit} s"
[library.axes]
speed = {{ range = [0.2, 0.24], step = 0.02 }}
height = {{ range = [0.34, {top}], step = 0.01 }}
"""


def specification(folder: Path, limit: float = 600.0, top: float = 0.35) -> Path:
    path = folder / "library.toml"
    path.write_text(SPEC.format(limit=limit, top=top), encoding="utf-8")
    return path


def stamps(folder: Path) -> dict[str, int]:
    return {path.stem: path.stat().st_mtime_ns for path in (folder / "records").glob("*.json")}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Library:
    """Six gaits, by a run that is killed five times and then left alone."""
    folder = tmp_path_factory.mktemp("library")
    spec, out = specification(folder), folder / "out"
    known: dict[str, int] = {}
    command = [sys.executable, "-m", "amble", "library", str(spec), "--out", str(out), "--workers", "2"]
    for _ in range(5):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        until = len(known) + 1
        while process.poll() is None and len(stamps(out)) < until:
            time.sleep(0.05)
        process.kill()
        process.wait()
        there = stamps(out)
        assert {name: there[name] for name in known} == known  # nothing lost, nothing twice
        known = there
    found = build_library(spec, out, workers=2)
    assert {name: stamp for name, stamp in stamps(out).items() if name in known} == known
    return found


@pytest.mark.slow
def test_all_are_certified(library: Library) -> None:
    assert len(library.entries) == len(library.certified) == 6
    assert {path.name for path in library.folder.iterdir()} >= {"index.csv", "failures.csv", "map-radius.png"}
    for entry in library.certified:
        assert entry.numbers["radius"] < 1.0
        assert set(entry.seconds) == {"solve", "check", "stabilise", "certify"}
    starts = {entry.label: entry.start for entry in library.entries}
    assert starts["speed_0.2-height_0.34"] is None
    assert starts["speed_0.24-height_0.35"] == "speed_0.24-height_0.34"
    assert load_library(library.folder) == library


@pytest.mark.slow
def test_files_hold_what_the_index_says(library: Library) -> None:
    entry = library.certified[-1]
    gait = library.gait(entry)
    assert check(gait).passed
    assert certify(gait).radius == pytest.approx(entry.numbers["radius"], rel=1e-9)
    assert gait.speed == entry.values["speed"]


@pytest.mark.slow
def test_another_run_in_the_folder_is_refused(library: Library) -> None:
    fcntl = pytest.importorskip("fcntl")
    lock = os.open(library.folder / "library.json", os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX)
    with pytest.raises(InputError, match="another run is at work"):
        build_library(specification(library.folder.parent), library.folder)
    os.close(lock)


@pytest.mark.slow
def test_a_complete_library_starts_no_process(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(subprocess, "Popen", refuse)
    again = build_library(specification(library.folder.parent), library.folder)
    assert again.entries == library.entries


@pytest.mark.slow
def test_gaits_that_take_too_long_or_lose_their_process_are_failures(tmp_path: Path) -> None:
    """A time limit that no gait keeps to: every one is told of, none keeps the others waiting."""
    found = build_library(specification(tmp_path, limit=0.05, top=0.34), tmp_path / "out")
    assert len(found.failures) == 3
    assert {entry.reason for entry in found.failures} == {"it took more than 0.05 s"}


def test_chains_part_the_library(tmp_path: Path) -> None:
    """The first gait, its row of speeds, and from each of the three speeds a column of heights."""
    library = read_library(specification(tmp_path))
    assert chains(library) == ((0, 0), (0, 1), (1, 0), (1, 1), (2, 1))
    with pytest.raises(InputError, match="no chain 5; the library has chains 0 to 4"):
        build_library(specification(tmp_path), tmp_path / "out", chain=5)


@pytest.mark.skipif(sys.platform != "linux", reason="the system ends a child with its parent")
@pytest.mark.slow
def test_workers_end_with_the_process_that_started_them(tmp_path: Path) -> None:
    spec, out = specification(tmp_path), tmp_path / "out"
    command = [sys.executable, "-m", "amble", "library", str(spec), "--out", str(out)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    children: list[int] = []
    while not children:
        time.sleep(0.1)
        listing = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text(encoding="ascii")
        children = [int(number) for number in listing.split()]
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    until = time.monotonic() + 60.0  # its imports end first, on a busy machine
    while any(alive(number) for number in children):
        assert time.monotonic() < until
        time.sleep(0.1)
    assert not stamps(out)


def alive(number: int) -> bool:
    try:
        return Path(f"/proc/{number}/stat").read_text(encoding="ascii").split(") ")[1][0] != "Z"
    except OSError:
        return False
