"""Proofs as files: what was proved is verified, what was altered is refused."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from examples import rimless_wheel
from flint import arb

from amble.errors import InputError
from amble.proof import Proof, ProofError, Settings, load_proof, prove, record, save_proof, verify
from amble.proof.arithmetic import decimals
from amble.types import Json
from tests.proof.forged import forged

SETTINGS = Settings(order=14, tolerance=1e-22, radius=1e-15, basin=1e-3)


@pytest.fixture(scope="module")
def proof() -> Proof:
    return prove(*rimless_wheel.rolling(), SETTINGS)


def test_a_proof_is_verified_from_its_file(proof: Proof, tmp_path: Path) -> None:
    path = save_proof(tmp_path / "proof.json", proof)
    again = load_proof(path)
    assert again == proof
    verify(again, rimless_wheel.rolling()[0])
    assert proof.stable
    assert proof.proved.basin_rate is not None
    low, high = map(Fraction, proof.proved.state["rate"])
    assert low < high < low + Fraction(1, 10**16)


@pytest.mark.parametrize(
    ("part", "key", "change", "reason"),
    [
        ("found", "rate", lambda rate: 0.999 * rate, "bound .* of the spectral radius does not follow"),
        ("found", "weight", lambda weight: np.eye(len(weight)).tolist(), "of the spectral radius does not follow"),
        ("found", "basin_size", lambda size: 4 * size, "basin|enclosure|guard|domain"),
        ("found", "basin_weight", lambda weight: (np.array(weight)[::-1, ::-1]).tolist(), "basin|domain"),
        ("proved", "basin_rate", lambda rate: 0.3 * rate, "contraction on the basin does not follow"),
        ("proved", "basin_extent", lambda extent: [2 * value for value in extent], "does not reach as far"),
    ],
)
def test_claims_that_do_not_follow_are_refused(proof: Proof, part: str, key: str, change: object, reason: str) -> None:
    tree = proof.model_dump(mode="json")
    tree[part][key] = change(tree[part][key])  # type: ignore[operator]
    with pytest.raises(ProofError, match=reason):
        verify(Proof.model_validate_json(json.dumps(tree)), rimless_wheel.rolling()[0])


def test_a_proof_of_another_system_is_refused(proof: Proof) -> None:
    with pytest.raises(InputError, match="of another system"):
        verify(proof, rimless_wheel.rimless_wheel(slope=float(np.nextafter(rimless_wheel.SLOPE, 1))))


def test_a_reach_beyond_every_number_is_refused(proof: Proof) -> None:
    """Of W times 2^-1030 the inverse of floating point overflows; compared with infinity any reach held."""
    tree = json.loads(proof.model_dump_json())
    tree["found"]["basin_weight"] = (np.array(tree["found"]["basin_weight"]) * 2.0**-1030).tolist()
    tree["found"]["basin_size"] *= 2.0**-515
    tree["proved"]["basin_extent"] = [1000.0 for _ in tree["proved"]["basin_extent"]]
    with pytest.raises((ProofError, InputError)):
        verify(Proof.model_validate_json(json.dumps(tree)), rimless_wheel.rolling()[0])


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"format": "amble gait"}, "format"),
        ({"version": 3}, "the format 3 of the proof is not read, only 4: prove again"),
        ({"version": True}, "the format True of the proof is not read"),
        ({"version": "4"}, "of another kind"),
        ({"extra": 1}, "extra"),
        ({"system": 5}, "system"),
    ],
)
def test_other_files_are_one_sentence(proof: Proof, change: Json, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "proof.json"
    path.write_text(json.dumps({**proof.model_dump(mode="json"), **change}), encoding="utf-8")
    with pytest.raises(InputError, match=reason) as refused:
        load_proof(path)
    assert "\n" not in str(refused.value)


def test_numbers_for_another_number_of_states_are_refused(proof: Proof) -> None:
    tree = proof.model_dump(mode="json")
    tree["found"]["radii"] = tree["found"]["radii"][:1]
    with pytest.raises(InputError, match="another number of states"):
        verify(Proof.model_validate_json(json.dumps(tree)), rimless_wheel.rolling()[0])


@pytest.mark.parametrize(
    ("part", "change"),
    [
        ("found", {"basin_size": None}),
        ("found", {"basin_size": 0.0}),
        ("found", {"basin_size": -1e-3}),
        ("found", {"basin_weight": []}),
        ("found", {"basin_weight": [[0.0]]}),
        ("found", {"basin_weight": [[-1.0]]}),
        ("found", {"basin_weight": [[1.0, 2.0]]}),
        ("found", {"basin_steps": []}),
        ("found", {"steps": [["1p-40"] * 19_999]}),
        ("found", {"steps": [["-1p-6", "1p-6"]]}),
        ("found", {"steps": [["0p0"]]}),
        ("proved", {"basin_rate": -0.9}),
        ("proved", {"basin_rate": None}),
        ("proved", {"basin_rate": 1.0}),
        ("proved", {"basin_extent": []}),
        ("proved", {"basin_extent": [-1.0, -1.0]}),
        ("proved", {"basin_extent": [1e-9] * 10}),
    ],
)
def test_no_whole_basin_and_no_steps_are_refused(proof: Proof, part: str, change: Json, tmp_path: Path) -> None:
    """Without a size nothing of the basin was looked at, so any could be claimed."""
    tree = proof.model_dump(mode="json")
    tree[part] |= change
    path = tmp_path / "proof.json"
    path.write_text(json.dumps(tree), encoding="utf-8")
    with pytest.raises((InputError, ProofError)) as refused:
        verify(load_proof(path), rimless_wheel.rolling()[0])
    assert "\n" not in str(refused.value)


def test_a_file_that_asks_for_endless_work_is_refused_as_it_is_read(proof: Proof, tmp_path: Path) -> None:
    """2,000 steps in 1,024 bits are as many as one domain may have; of a gait they would take a day."""
    tree, path = proof.model_dump(mode="json"), tmp_path / "proof.json"
    for changes, reason in (
        ({"steps": [["1p-11"] * 2000], "bits": 1024, "order": 40}, "steps of order 40 in 1024 bits are more work"),
        ({"basin_steps": [["1p-11"] * 2000], "bits": 200}, "steps of order 14 in 200 bits are more work"),
        ({"steps": [["1p-3"]] * 1001}, "at most 1000 items"),
        ({"centre": ["0p0"] * 1001}, "at most 1000 items"),
        ({"weight": [[0.0] * 1001]}, "at most 1000 items"),
    ):
        path.write_text(json.dumps({**tree, "found": {**tree["found"], **changes}}), encoding="utf-8")
        with pytest.raises(InputError, match=reason) as refused:
            load_proof(path)
        assert "\n" not in str(refused.value)
    tree["proved"]["multipliers"] = tree["proved"]["multipliers"] * 1001
    path.write_text(json.dumps(tree), encoding="utf-8")
    with pytest.raises(InputError, match="at most 1000 items"):
        load_proof(path)


def test_a_proof_that_would_not_be_read_back_ends_with_a_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(record, "MOST_WORK", 1e4)
    with pytest.raises(ProofError, match=r"steps of order 14 in 128 bits are more work .* \(--order\)"):
        prove(*rimless_wheel.rolling(), replace(SETTINGS, basin=0.0))


def test_more_digits_than_two_hundred_are_read_back(tmp_path: Path) -> None:
    """Numbers of 700 bits have 211 digits; the file took 200, and the command ended with a traceback."""
    system, start = rimless_wheel.rolling()
    path = save_proof(tmp_path / "proof.json", prove(system, start, replace(SETTINGS, bits=700, basin=0.0)))
    verify(load_proof(path), system)


def test_a_key_twice_and_a_long_one_are_refused(proof: Proof, tmp_path: Path) -> None:
    path = save_proof(tmp_path / "proof.json", proof)
    text = path.read_text()
    for key, reason in ((f'"{"k" * 100_000}"', "Extra inputs"), ('"half"', "the key 'half' twice")):
        path.write_text(text.replace("{", f"{{{key}: false,", 1))
        with pytest.raises(InputError, match=reason) as refused:
            load_proof(path)
        assert len(str(refused.value)) < 500


def leaves(tree: Json, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Places of all numbers of a proof, written as text or not."""
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in entries:
        if isinstance(value, dict | list):
            yield from leaves(value, (*path, key))
        elif value is not None and not isinstance(value, bool):
            yield (*path, key)


def put(tree: Json, path: tuple[str | int, ...], value: object) -> None:
    for key in path[:-1]:
        tree = tree[key]
    tree[path[-1]] = value


TEXTS = ("1e99999", "1e301", "-1e301", "9" * 200 + "e150", "1e999", "-1e999", "0e999", "1e-999", "-1", "0")
EXPONENTS = ("1p99999", "-1p99999", "1p1000", "1p-99999", "9" * 200 + "p900", "0p0")


def refuses(proof: Proof, path: tuple[str | int, ...], value: object, folder: Path) -> None:
    """One sentence, whether it is refused or a claim that is weaker and holds."""
    tree = proof.model_dump(mode="json")
    put(tree, path, value)
    place = folder / "proof.json"
    place.write_text(json.dumps(tree), encoding="utf-8")
    said = ""
    try:
        verify(load_proof(place), rimless_wheel.rolling()[0])
    except (InputError, ProofError) as refused:
        said = str(refused)
    assert "\n" not in said


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("proved", "durations", 0, 1), "1e99999"),
        (("proved", "durations", 0, 1), "9" * 200 + "e150"),
        (("found", "centre", 0), "1p99999"),
    ],
)
def test_a_number_beyond_all_others_is_a_sentence(
    proof: Proof, path: tuple[str | int, ...], value: object, tmp_path: Path
) -> None:
    tree = proof.model_dump(mode="json")
    put(tree, path, value)
    place = tmp_path / "proof.json"
    place.write_text(json.dumps(tree), encoding="utf-8")
    with pytest.raises((InputError, ProofError)) as refused:
        verify(load_proof(place), rimless_wheel.rolling()[0])
    assert "\n" not in str(refused.value)


@pytest.mark.slow
def test_extreme_numbers_everywhere_are_sentences(proof: Proof, tmp_path: Path) -> None:
    """Every number of a proof replaced in turn by the largest, the smallest, and what is none."""
    tree = proof.model_dump(mode="json")
    for path in leaves({"found": tree["found"], "proved": tree["proved"]}):
        here = tree
        for key in path:
            here = here[key]
        usual = (1e308, -1e308, 5e-324, 0.0) if isinstance(here, float) else (10**30, -1, 0)
        for value in usual if not isinstance(here, str) else EXPONENTS if "p" in here else TEXTS:
            refuses(proof, path, value, tmp_path)


def test_a_bound_below_all_that_is_written_is_rounded_outward() -> None:
    tiny = arb(2) ** -4000
    assert decimals(tiny) == ("0e-999", "1e-999")
    assert decimals(-tiny) == ("-1e-999", "0e-999")


def test_a_ball_whose_ends_are_exchanged_is_refused() -> None:
    with pytest.raises(ValueError, match="lower end of a ball is above its upper one"):
        forged(proved={"durations": [("2e0", "1e0"), ("1e0", "1e0")]})
