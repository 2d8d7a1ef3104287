"""``amble prove`` as a user runs it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.cli.run import exit_code

WHEEL = str(Path(__file__).parents[2] / "examples" / "rimless_wheel.py")
AMBLE, TROT = (str(Path(__file__).parents[1] / "data" / name) for name in ("stabilised-amble.json", "trot.json"))


def test_prove_and_verify(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "proof.json"
    arguments = ("prove", f"{WHEEL}:rolling", "--out", str(out), "--order", "14", "--basin", "1e-4")
    assert exit_code(*arguments) == 0
    said = capsys.readouterr().out
    assert "exactly one periodic orbit" in said
    assert "exponentially stable, spectral radius of a cycle at most 0.25" in said
    assert "attracts from a ball" in said
    assert exit_code("prove", f"{WHEEL}:rolling", "--verify", str(out)) == 0
    assert "holds" in capsys.readouterr().out
    tree = json.loads(out.read_text(encoding="utf-8"))
    tree["found"]["rate"] = 0.2
    out.write_text(json.dumps(tree), encoding="utf-8")
    assert exit_code("prove", f"{WHEEL}:rolling", "--verify", str(out)) == 1
    assert "does not follow" in capsys.readouterr().err
    tree["found"] |= {"steps": [["1p-11"] * 2000], "bits": 1024}
    out.write_text(json.dumps(tree), encoding="utf-8")
    assert exit_code("prove", f"{WHEEL}:rolling", "--verify", str(out)) == 2
    refused = capsys.readouterr().err
    assert "are more work than is begun on" in refused
    assert "Traceback" not in refused


@pytest.mark.parametrize(
    ("system", "reason"),
    [
        ("gait.json", "gait.json"),
        ("nowhere", "is not MODULE:NAME"),
        ("no_such_module:name", "cannot be loaded"),
        (f"{WHEEL}:nothing", "cannot be loaded"),
        (f"{WHEEL}:SPOKES", "is no pair"),
        (f"{WHEEL}:rolling --control impedance", "another feedback law of a gait"),
        (f"{TROT} --control impedance", "does not hold its closed loop's own orbit|land at once"),
        (f"{AMBLE} --control impedances", "impedances"),
    ],
)
def test_what_is_no_system_is_one_sentence(system: str, reason: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("prove", *system.split(" ")) == 2
    error = capsys.readouterr().err
    assert re.search(reason, error)
    assert "Traceback" not in error
