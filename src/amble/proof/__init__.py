"""Proofs of periodic orbits by enclosures (docs/theory/proof.md): what is said holds in real arithmetic."""

from amble.optional import require

require("flint", "proof", "proofs")

from amble.proof.leg import ProofError  # noqa: E402
from amble.proof.record import Proof, Settings, load_proof, prove, save_proof  # noqa: E402
from amble.proof.verification import verify  # noqa: E402

__all__ = ["Proof", "ProofError", "Settings", "load_proof", "prove", "save_proof", "verify"]
