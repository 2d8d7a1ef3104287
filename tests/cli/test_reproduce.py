"""``amble reproduce`` for few cycles: the long steps hand out a stored gait; `make slow` does them (coarse mesh)."""

from __future__ import annotations

import json
import re
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from amble.gait import Gait
from amble.gait.files import content_hash, load_gait
from amble.simulation import load_trace
from tests.cli.run import exit_code
from tests.conftest import leave_unrendered
from tests.workflow.stored import hand_out

METRICS = ("cot", "peak_torque", "rms_torque")
FILES = (
    *("gait.json", "trace.nc", "certificate.json", "synthesized.json", "perturbed.nc"),
    *("results.json", "report.md", "report.html"),
)


@pytest.fixture(scope="module", params=["stored", pytest.param("whole", marks=pytest.mark.slow)])
def folder(request: pytest.FixtureRequest, stabilised_gait: Gait, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("reproduce")
    specification = (resources.files("amble.specifications") / "astro-amble.toml").read_text()
    out = place / "run"
    with pytest.MonkeyPatch.context() as monkeypatch:
        if request.param == "stored":
            hand_out(stabilised_gait, monkeypatch)
            leave_unrendered(monkeypatch)
        else:
            specification = re.sub(r"intervals = \d+", "intervals = 6\nrefinement = 1", specification)
        (place / "spec.toml").write_text(specification)
        assert exit_code("reproduce", "--spec", str(place / "spec.toml"), "--cycles", "3", "--out", str(out)) == 0
    return out


@pytest.fixture(scope="module")
def results(folder: Path) -> dict[str, Any]:
    tree: dict[str, Any] = json.loads((folder / "results.json").read_text())
    return tree


def test_every_file_is_there_and_nothing_else(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} == {*FILES, "figures"}
    figures = {path.name for path in (folder / "figures").iterdir()}
    for stem in ("base_portraits", "joint_portraits", "footfall", "torques", "multipliers", "section_distance"):
        assert {f"{stem}.png", f"{stem}.pdf"} <= figures


def test_the_results_have_what_they_promise(results: dict[str, Any]) -> None:
    assert results["robot"] == "astro"
    assert results["cycles"] == 3
    assert results["speed_achieved"] == pytest.approx(results["speed_desired"], rel=0.05)
    for methods in ("methods", "methods_datasheet"):
        for law in ("drop", "pinv"):
            for motion in ("nominal", "simulated"):
                assert all(results[methods][law][motion][metric] > 0.0 for metric in METRICS)
    assert set(METRICS) <= set(results["reduction"])
    assert {"min_normal_force", "max_friction", "max_penetration"} <= set(results["contact"])
    assert {"status", "iterations", "seconds", "variables", "constraints"} <= set(results["solver"])
    assert {"seconds", "steps", "parameters"} <= set(results["stabilization"])
    assert {"amble", "python", "casadi", "numpy", "scipy", "C compiler"} <= set(results["versions"])
    assert results["stability_versions"] == results["versions"]
    assert results["settings"]["specification"] == "spec.toml"
    assert results["settings"]["intervals of a domain"] in {"6", "15"}
    assert set(results["seconds"]) == {"synthesis", "stabilisation", "certificate", "simulation", "measurement"}
    assert all(seconds > 0.0 for seconds in results["seconds"].values())
    assert results["perturbed"]["ended"] == "completed"
    assert {"size", "seed", "sound_from_cycle", "before_sound"} <= set(results["perturbed"])


@pytest.mark.usefixtures("unrendered")
def test_report_writes_the_same_again(folder: Path, tmp_path: Path) -> None:
    assert exit_code("report", str(folder), "--out", str(tmp_path)) == 0
    for name in ("results.json", "report.md"):
        assert (tmp_path / name).read_text() == (folder / name).read_text()


def test_the_orbit_is_stable_and_the_certificate_says_so(folder: Path, results: dict[str, Any]) -> None:
    radius = results["spectral_radius"]
    assert radius["initial"] > 1.0
    assert radius["stabilized"] + radius["error"] < 0.5
    certificate = json.loads((folder / "certificate.json").read_text())
    assert certificate["spectral_radius"] == radius["stabilized"]
    assert certificate["certified"] is True
    assert certificate["gait"]["content_hash"] == content_hash(load_gait(folder / "gait.json"))
    names = [row["name"] for row in certificate["conditions"] if row["holds"]]
    assert len(names) == len(certificate["conditions"])
    assert {"D1 rl friction", "D3 rr normal force", "contraction of the leading mode in simulation"} <= set(names)
    # on the orbit to begin with, so that only the integrator's error remains, tolerance 1e-8
    assert results["section_error"] < 1e-5


def test_the_minimum_norm_needs_less_torque_on_the_same_motion(results: dict[str, Any]) -> None:
    for motion in ("nominal", "simulated"):
        pinv, drop = (results["methods"][law][motion] for law in ("pinv", "drop"))
        assert pinv["rms_torque"] < drop["rms_torque"]
    assert results["reduction"]["rms_torque"] > 0.0


def test_the_files_read_back(folder: Path) -> None:
    gait = load_gait(folder / "gait.json")
    assert gait.feedback is not None
    assert load_gait(folder / "synthesized.json").feedback is None
    assert load_trace(folder / "trace.nc").cycles == 3
    page = (folder / "report.md").read_text()
    assert "the paper's Table 1 beside ours" in page
    assert "because they belong to another orbit" in page
    assert "**Stability**" in page
    assert "perturbed start, contacts sound from cycle" in page
