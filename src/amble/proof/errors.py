"""What a proof says when it does not succeed."""

from __future__ import annotations

from amble.errors import WorkError


class ProofError(WorkError):
    """A proof does not succeed: the step of it that fails, where along the orbit, and by how much."""
