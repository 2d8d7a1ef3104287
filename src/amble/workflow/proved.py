"""The proof that lies beside a gait, if it is one of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from amble.errors import InputError, MissingExtraError
from amble.gait import Gait
from amble.report.proof import proof_results, proof_summary, proof_table
from amble.report.run import RunReport

if TYPE_CHECKING:
    from amble.proof import Proof

PROOF = "proof.json"


def proof_beside(folder: Path, gait: Gait) -> tuple[Proof | None, str]:
    """Return the proof in a folder that is of a gait, and why the one that lies there is left out, in a sentence.

    Its enclosures are not computed again: that is what ``amble.proof.verify`` does.

    Raises:
        InputError: the file is no proof.
    """
    place = folder / PROOF
    if not place.is_file():
        return None, ""
    try:
        from amble.proof import load_proof, require_same
    except MissingExtraError as error:
        return None, f"{PROOF} was left out: {error}"
    proof = load_proof(place)
    try:
        require_same(proof, gait)
    except InputError as error:
        return None, f"{PROOF} was left out: {error}"
    return proof, ""


def with_proof(report: RunReport, proof: Proof | None, left_out: str) -> RunReport:
    """Return a report that shows a proof beside the certificate, or says why there is none; see ``proof_beside``."""
    if proof is None:
        return replace(report, notes=(*report.notes, left_out)) if left_out else report
    stability = None if report.stability is None else report.stability.results
    return replace(
        report,
        tables=(proof_table(proof, stability), *report.tables),
        notes=(proof_summary(proof), *report.notes),
        extra={**report.extra, **proof_results(proof)},
    )
