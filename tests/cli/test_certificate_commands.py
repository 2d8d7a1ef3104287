"""``amble check`` and ``amble certify`` on a stabilised amble of ASTRo that ``amble reproduce`` wrote."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.run import exit_code

GAIT = Path(__file__).parents[1] / "data" / "stabilised-amble.json"
BIPED = GAIT.with_name("biped-of-small-basin.json")


@pytest.fixture(scope="module")
def slippery(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same gait where the ground gives less friction than the motion uses, 0.594."""
    tree = json.loads(GAIT.read_text())
    friction = tree["ground"]["parameters"]["friction"]
    assert friction["value"] > 0.5
    friction["value"] = 0.5
    path = tmp_path_factory.mktemp("gait") / "slippery.json"
    path.write_text(json.dumps(tree))
    return path


def test_the_gait_holds(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("check", str(GAIT)) == 0
    assert "rows hold at" in capsys.readouterr().out


def test_the_gait_is_certified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "certificate.json"
    assert exit_code("certify", str(GAIT), "--out", str(out)) == 0
    captured = capsys.readouterr()
    assert f"wrote {out}" in captured.out
    assert captured.err.startswith("certifying ...\ncertifying: ")
    tree = json.loads(out.read_text())
    assert tree["certified"] is True
    assert tree["spectral_radius"] + tree["spectral_radius_error"] < 0.5
    assert all(row["holds"] for row in tree["conditions"])
    assert "grows by the factor" in captured.out
    assert "WARNING" not in captured.out
    assert "it does not say: torque limits (50 to 50 N m) or" in captured.out
    assert "feet on the ground within 0.88 mm" in captured.out
    assert any("no proof of a basin" in line for line in tree["does_not_say"])
    assert tree["held_against"]["ground_m"] == pytest.approx(8.76e-4, rel=1e-3)
    assert tree["warnings"] == []
    assert tree["disturbance"]["basin"]["returns_from"] == 0.001
    assert 10.0 < tree["disturbance"]["growth"]["factor"] < 100.0


def test_a_gait_of_small_basin_is_certified_with_a_warning(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "certificate.json"
    assert exit_code("certify", str(BIPED), "--out", str(out)) == 0
    assert "WARNING: small basin: a start with every state changed by" in capsys.readouterr().out
    tree = json.loads(out.read_text())
    assert tree["certified"] is True
    assert tree["spectral_radius"] == pytest.approx(0.93601, abs=1e-4)
    (warning,) = tree["warnings"]
    assert tree["disturbance"]["basin"]["failed"]["reason"] in warning


@pytest.mark.slow
def test_the_json_object_has_what_the_file_says_of_disturbances(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "certificate.json"
    assert exit_code("certify", str(BIPED), "--out", str(out), "--json") == 0
    said, tree = json.loads(capsys.readouterr().out), json.loads(out.read_text())
    for key in ("held_against", "does_not_say"):
        assert said[key] == tree[key]
    for key in ("disturbance", "warnings"):
        assert said["certificate"][key] == tree[key]
    assert tree["warnings"]


def test_friction_that_the_motion_exceeds_is_refused_with_the_row(
    slippery: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "certificate.json"
    out.write_text('{"certified": true}')
    assert exit_code("certify", str(slippery), "--out", str(out)) == 1
    captured = capsys.readouterr()
    assert "error: no certificate" in captured.err
    assert "D2 fr friction" in captured.err
    assert "spectral radius of the full cycle" not in captured.out
    tree = json.loads(out.read_text())
    assert tree["certified"] is False
    failed = {row["name"]: row for row in tree["conditions"] if not row["holds"]}
    assert all(name.endswith("friction") for name in failed)
    assert failed["D2 fr friction"]["upper"] == 0.5
    assert failed["D2 fr friction"]["value"] == pytest.approx(0.594, abs=1e-3)  # as `amble reproduce` reports it


def test_friction_that_the_motion_exceeds_fails_the_check(slippery: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("check", str(slippery)) == 1
    captured = capsys.readouterr()
    assert "friction" in captured.out
    assert "the gait does not hold" in captured.err


def test_a_gait_without_an_orbit_is_refused_in_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tree = json.loads(GAIT.read_text())
    tree["feedback"]["start"]["value"][2] += 1.0  # a metre above the ground: there is nothing to step on
    (tmp_path / "gait.json").write_text(json.dumps(tree))
    out = tmp_path / "certificate.json"
    assert exit_code("certify", str(tmp_path / "gait.json"), "--out", str(out)) == 1
    last = capsys.readouterr().err.splitlines()[-1]
    tree = json.loads(out.read_text())
    assert tree["certified"] is False
    assert last.removeprefix("error: ") in tree["refused_because"]


def test_what_a_gait_is_held_against_is_printed_and_an_absurd_bound_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tree = json.loads(BIPED.read_text())
    tree["ground"]["parameters"]["friction"]["value"] = 100.0
    tree["limits"]["torques"]["left_knee"]["value"] = 1e-9
    path, out = tmp_path / "gait.json", tmp_path / "certificate.json"
    path.write_text(json.dumps(tree))
    assert exit_code("certify", str(path), "--out", str(out)) == 1
    captured = capsys.readouterr()
    assert "held against: friction 100" in captured.out
    assert "torque limits (1e-09 to 150 N m)" in captured.out
    assert "ABSURD: friction coefficient, torque limit of 'left_knee'" in captured.out
    assert "sensible friction coefficient" in captured.err
    assert exit_code("certify", str(path), "--out", str(out), "--allow-absurd-limits") == 0
    assert "ABSURD" in capsys.readouterr().out
    tree = json.loads(out.read_text())
    assert tree["certified"] is True
    assert tree["held_against"]["absurd"] == ["friction coefficient", "torque limit of 'left_knee'"]
