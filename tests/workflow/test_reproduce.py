"""A reproduction as a library call: one reading of its specification, and no file of another gait beside its own.

The whole of it runs in ``tests/cli/test_reproduce.py``; here the slow steps are replaced by a stored gait.
"""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amble.errors import CertificateError, WorkError
from amble.gait import Gait
from amble.progress import ProgressReport
from amble.report.run import run_files
from amble.residual import Residual
from amble.workflow import Run, reproduce
from amble.workflow.specified import PosedProblem, pose, solve
from tests.workflow import stored
from tests.workflow.stored import hand_out

certification: Any = importlib.import_module("amble.workflow.certify")


@pytest.fixture
def posed() -> PosedProblem:
    return pose(None)


@pytest.fixture
def quick(stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    """Synthesis and stabilisation hand out the stored gait."""
    hand_out(stabilised_gait, monkeypatch)


def earlier_run(folder: Path) -> list[Path]:
    """Files as a run on another gait left them, and one that is the user's own."""
    names = ("synthesized.json", "gait.json", "certificate.json", "trace.nc", "perturbed.nc")
    left = [*(folder / name for name in names), *run_files(folder)]
    for path in left:
        path.parent.mkdir(exist_ok=True)
        path.write_text("of another gait")
    (folder / "notes.txt").write_text("mine")
    return left


@pytest.mark.usefixtures("quick", "unrendered")
def test_a_refusal_leaves_nothing_of_an_earlier_run(
    posed: PosedProblem, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object, **__: object) -> None:
        raise CertificateError([Residual("friction", 0.0, 0.7, 0.6)])

    monkeypatch.setattr(certification, "certify", refused)
    earlier_run(tmp_path)
    told: list[ProgressReport] = []
    with pytest.raises(CertificateError):
        reproduce(posed, tmp_path, progress=told.append)
    kept = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert kept == {"synthesized.json", "gait.json", "certificate.json", "notes.txt"}
    assert json.loads((tmp_path / "certificate.json").read_text())["certified"] is False
    assert {each.file.name for each in told if each.file is not None} == kept - {"notes.txt"}


def test_a_failed_synthesis_leaves_the_earlier_run_whole(
    posed: PosedProblem, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failed(*_: object, **__: object) -> Gait:
        raise WorkError("no gait")

    monkeypatch.setattr(stored.module, "solve", failed)
    left = earlier_run(tmp_path)
    with pytest.raises(WorkError, match="no gait"):
        reproduce(posed, tmp_path)
    assert all(path.read_text() == "of another gait" for path in left)


@pytest.mark.slow  # tests/cli/test_reproduce.py runs the same steps
@pytest.mark.usefixtures("quick", "unrendered")
def test_a_run_is_a_record_and_writes_only_where_told(
    posed: PosedProblem, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    run = reproduce(posed, cycles=3)
    assert isinstance(run, Run)
    assert run.files == ()
    assert not list(tmp_path.iterdir())
    assert run.gait.feedback is not None
    assert run.synthesized.feedback is None
    assert run.certificate.radius < 1.0
    assert run.trace.cycles == run.perturbed.cycles == 3
    assert run.report.settings["specification"] == "astro-amble.toml"
    assert set(run.report.seconds) == {"synthesis", "stabilisation", "certificate", "simulation", "measurement"}


@pytest.mark.slow
def test_the_gait_is_what_it_was(posed: PosedProblem) -> None:
    """Objective and torques as they were before records, readers and hybrid core were made anew."""
    gait = solve(posed)
    assert gait.solver.objective == pytest.approx(335.6710043788579, rel=1e-8)
    assert gait.period == pytest.approx(2 * (0.10813643181658195 + 0.061752230294531654), abs=1e-7)
    for domain, peak in zip(gait.domains, (12.640768013659118, 12.350006521474652), strict=True):
        assert np.abs(domain.torques).max() == pytest.approx(peak, abs=1e-5)
