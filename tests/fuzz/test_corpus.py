"""Inputs that failed once: each is read now, or refused as it should be."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzz.worker import verdict_of

CORPUS = Path(__file__).parents[2] / "fuzz" / "corpus"
FILES = sorted(CORPUS.iterdir())
REFUSED = (
    "urdf-",
    "law-whole-friction",
    "walker-force",
    "walker-gravity-upwards",
    "walker-no-gravity",
    "specification-",
    "npz-",
    "csv-",
    "mat-",
)
"""Names of inputs that are refused begin with these; the others load."""


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_what_failed_once_does_not_fail(file: Path, tmp_path: Path) -> None:
    verdict = verdict_of(file.name.partition("-")[0], file.read_bytes(), tmp_path)
    assert verdict.outcome == ("refused" if file.name.startswith(REFUSED) else "loaded"), verdict.reason
