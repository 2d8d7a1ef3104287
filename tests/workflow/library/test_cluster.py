"""Chains as tasks of HyperQueue: a server with two workers on this machine, lost on the way and started again."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from amble.errors import InputError, MissingExtraError
from amble.workflow.library import build_library
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


CLUSTER = """
import pathlib, sys
from hyperqueue.cluster import LocalCluster, WorkerConfig
cluster = LocalCluster(sys.argv[1])
for _ in range(2):
    cluster.start_worker(WorkerConfig(cores=1))
pathlib.Path(sys.argv[2]).touch()
sys.stdin.read()
"""


def started(server: Path, sign: Path) -> subprocess.Popen[bytes]:
    """A server with two workers, in a process."""
    command = [sys.executable, "-c", CLUSTER, str(server), str(sign)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
    while not sign.exists():
        assert process.poll() is None
        time.sleep(0.1)
    return process


def ended(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.communicate()


@pytest.mark.slow
def test_a_library_is_complete_after_its_cluster_was_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Six gaits that have no time, so that it is the tasks that are tested: five chains, three of which wait."""
    pytest.importorskip("hyperqueue")
    spec, out, server = specification(tmp_path, limit=0.05), tmp_path / "out", tmp_path / "server"
    monkeypatch.setenv("HQ_SERVER_DIR", str(server))
    cluster = started(server, tmp_path / "first")
    command = [sys.executable, "-m", "amble", "library", str(spec), "--out", str(out), "--workers", "hyperqueue"]
    submitted = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.monotonic() + 300.0
    while not stamps(out):
        assert time.monotonic() < until
        assert submitted.poll() is None
        time.sleep(0.1)
    ended(cluster)  # server, workers and what they were at
    submitted.kill()
    submitted.wait()
    known = stamps(out)
    again = started(server, tmp_path / "second")
    try:
        found = build_library(spec, out, workers="hyperqueue")
    finally:
        ended(again)
    assert len(found.entries) == 6
    assert {entry.reason for entry in found.entries} == {"it took more than 0.05 s"}
    there = stamps(out)
    assert {name: there[name] for name in known} == known
    assert (out / "failures.csv").exists()
