"""Steps that several commands take: what is computed, said and written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from amble.cli.console import progress
from amble.cli.lines import show_bounds, show_certified
from amble.errors import WorkError

if TYPE_CHECKING:
    from amble.control import AllocationLaw
    from amble.gait import Gait


def certified(gait: Gait, out: Path, *, allow_absurd_limits: bool = False, law: AllocationLaw | None = None) -> None:
    """Certify a gait, write the certificate or its refusal, and say what it was held against."""
    from amble.workflow.certify import certify_into

    try:
        with progress("certifying") as notify:
            certificate = certify_into(gait, out, allow_absurd_limits=allow_absurd_limits, law=law, progress=notify)
    except WorkError:
        show_bounds(gait)
        raise
    show_certified(gait, certificate)
