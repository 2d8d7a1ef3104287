"""Chains as tasks of HyperQueue: a server with two workers on this machine, lost on the way and started again."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from amble.errors import InputError, MissingExtraError
from amble.workflow.library import build_library, load_library
from tests.robots import PLANAR, path
from tests.test_optional import without
from tests.workflow.library.test_build import specification, stamps


def test_without_the_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "hyperqueue")
    with pytest.raises(MissingExtraError, match=r"amble\[cluster\]"):
        build_library(specification(tmp_path), tmp_path / "out", workers="hyperqueue")


def test_without_a_server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("hyperqueue")
    monkeypatch.setenv("HQ_SERVER_DIR", str(tmp_path / "nowhere"))
    with pytest.raises(InputError, match="no HyperQueue server can be reached"):
        build_library(specification(tmp_path), tmp_path / "out", workers="hyperqueue")


SPEC = """
[robot]
file = "biped.urdf"
feet = {{ l = "l_foot", r = "r_foot" }}
[gait]
stances = [["l"], ["r"]]
mirrored = true
speed = "0.63 m/s"
[solver]
intervals = 16
[library.axes]
friction = {{ range = [0.6, {rough}], step = 0.01 }}
speed = {{ range = [0.63, {fast}], step = 0.005 }}
"""
"""A walk of five links in the plane, of which a neighbour costs a second."""

MEMBER = """
import pathlib, sys
from hyperqueue.cluster import LocalCluster, WorkerConfig
server, own, sign = map(pathlib.Path, sys.argv[1:])
cluster = LocalCluster(str(own))
if own != server:
    (own / "hq-current").unlink()
    (own / "hq-current").symlink_to(server / "hq-current")
    cluster.start_worker(WorkerConfig(cores=1))
sign.touch()
sys.stdin.read()
"""
"""A server, or a worker: HyperQueue's Python package starts workers of a server of the same process only, and tells
them where it is by a link in its folder; led to another's, they are that one's, and can be killed alone."""


class Cluster:
    """A server and its workers on this machine, a process each."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.members = folder, list[subprocess.Popen[bytes]]()
        self.add("server")

    def add(self, name: str) -> None:
        own, sign = self.folder / name, self.folder / f"{name} is there"
        own.mkdir(parents=True)
        command = [sys.executable, "-c", MEMBER, str(self.folder / "server"), str(own), str(sign)]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
        while not sign.exists():
            assert process.poll() is None
            time.sleep(0.1)
        self.members.append(process)

    def kill(self, *numbers: int) -> None:
        """Kill members, which have no time for anything."""
        for number in numbers or range(len(self.members)):
            self.members[number].kill()
            self.members[number].communicate()


def awaited(process: subprocess.Popen[bytes], out: Path, known: dict[str, int], count: int) -> dict[str, int]:
    """Watch records until there are so many, or the process is through: none is written a second time or lost."""
    until = time.monotonic() + 3600.0
    while len(known) < count and process.poll() is None:
        assert time.monotonic() < until
        time.sleep(0.2)
        there = stamps(out)
        assert {name: there.get(name) for name in known} == known
        known = there
    return known


@pytest.mark.slow
def test_a_library_is_complete_after_a_worker_and_then_all_were_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two hundred gaits by two workers, one of which is killed; later the server, all workers and the command are."""
    pytest.importorskip("hyperqueue")
    (tmp_path / "biped.urdf").write_bytes(path(PLANAR).read_bytes())
    spec, out = tmp_path / "biped.toml", tmp_path / "out"
    spec.write_text(SPEC.format(rough=0.69, fast=0.725), encoding="utf-8")
    command = [sys.executable, "-m", "amble", "library", str(spec), "--out", str(out), "--workers", "hyperqueue"]

    def submitted(cluster: Cluster) -> subprocess.Popen[bytes]:
        monkeypatch.setenv("HQ_SERVER_DIR", str(cluster.folder / "server"))
        cluster.add("worker 1")
        cluster.add("worker 2")
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    first = Cluster(tmp_path / "first")
    try:
        run = submitted(first)
        known = awaited(run, out, {}, 40)
        assert run.poll() is None
        first.kill(1)
        known = awaited(run, out, known, 100)
        assert run.poll() is None  # the other worker went on
    finally:
        first.kill()
    run.kill()
    run.wait()
    again = Cluster(tmp_path / "again")
    try:
        run = submitted(again)
        known = awaited(run, out, known, 10**6)
    finally:
        again.kill()
    assert run.returncode == 0
    found = load_library(out)
    assert len(known) == len(found.entries) == 200
    assert len(found.certified) >= 150  # on a busy machine some are given up
    assert (out / "index.csv").exists()
