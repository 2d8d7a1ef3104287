"""Proofs of periodic orbits by enclosures (docs/theory/proof.md): what is said holds in real arithmetic."""

from amble.optional import require

require("flint", "proof", "proofs")

from amble.proof.errors import ProofError  # noqa: E402
from amble.proof.proving import GAIT_SETTINGS, Settings, prove, prove_gait  # noqa: E402
from amble.proof.record import Proof, load_proof, save_proof  # noqa: E402
from amble.proof.verification import require_same, verify  # noqa: E402

__all__ = [
    "GAIT_SETTINGS",
    "Proof",
    "ProofError",
    "Settings",
    "load_proof",
    "prove",
    "prove_gait",
    "require_same",
    "save_proof",
    "verify",
]
