"""A proof in the folder of a run: shown where it is of the gait, left out with a sentence where it is not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from amble.errors import InputError, MissingExtraError
from amble.gait import Gait
from amble.gait.files import save_gait
from amble.optional import require
from amble.proof import save_proof, verification
from amble.proof.identity import system_hash
from amble.simulation import save_trace
from amble.workflow import rewrite_report
from amble.workflow.proved import proof_beside
from tests.proof.forged import forged
from tests.synthetic import THREE, synthetic_trace, three_footed_gait


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    save_gait(three_footed_gait(), tmp_path / "gait.json")
    save_trace(synthetic_trace(3, stances=THREE), tmp_path / "trace.nc", {})
    return tmp_path


@pytest.mark.usefixtures("unrendered")
def test_a_proof_of_the_gait_is_shown(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save_proof(folder / "proof.json", forged())
    monkeypatch.setattr("amble.proof.require_same", lambda *_: None)
    rewrite_report(folder)
    for page in ("report.md", "report.html"):
        text = (folder / page).read_text(encoding="utf-8")
        assert "Certificate and proof" in text
        assert "a report does not: exactly one periodic orbit of half a cycle, mirrored, up to x in a box" in text
        assert "at most 0.250001" in text
    assert json.loads((folder / "results.json").read_text())["proof"]["rate"] == 0.5


@pytest.mark.usefixtures("unrendered")
def test_a_proof_of_another_gait_is_left_out(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save_proof(folder / "proof.json", forged())

    def other(*_: object) -> None:
        raise InputError("the proof is of another system: the hashes of the expressions differ")

    monkeypatch.setattr("amble.proof.require_same", other)
    rewrite_report(folder)
    text = (folder / "report.md").read_text(encoding="utf-8")
    assert "proof.json was left out: the proof is of another system" in text
    assert "Certificate and proof" not in text


def test_what_is_no_proof_is_refused(tmp_path: Path) -> None:
    assert proof_beside(tmp_path, three_footed_gait()) == (None, "")
    (tmp_path / "proof.json").write_text("{}", encoding="utf-8")
    with pytest.raises(InputError, match=r"proof.json"):
        proof_beside(tmp_path, three_footed_gait())


@pytest.mark.slow
def test_whose_proof_it_is_is_seen_by_its_expressions(stabilised_gait: Gait) -> None:
    """Of a gait whose loop is known: the hash of its expressions; any other is refused, and other numbers are."""
    identity = system_hash(verification._prepared(stabilised_gait, 20))
    with pytest.raises(InputError, match="another number of states"):
        verification.require_same(forged(identity), stabilised_gait)
    with pytest.raises(InputError, match="of another system"):
        verification.require_same(forged(), stabilised_gait)


def test_a_missing_extra_is_a_sentence_in_the_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports need no proof: without its library the page says that a file was not read."""
    (tmp_path / "proof.json").write_text("{}", encoding="utf-8")

    def absent(name: str, *rest: object) -> object:
        if name == "amble.proof":
            require("no_such_library", "proof", "proofs")
        return real(name, *rest)

    import builtins

    real = builtins.__import__
    monkeypatch.setattr(builtins, "__import__", absent)
    proof, why = proof_beside(tmp_path, three_footed_gait())
    assert proof is None
    assert "proof.json was left out" in why
    assert MissingExtraError.__name__ not in why
