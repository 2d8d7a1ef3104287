"""``amble certify``: the stability certificate of a gait, computed from its file alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.lines import tell_bounds, tell_certified
from amble.cli.progress import progress
from amble.errors import WorkError


def certify(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    out: Annotated[Path, typer.Option(help="Where to write the certificate (JSON).")] = Path("certificate.json"),
    allow_absurd_limits: Annotated[
        bool,
        typer.Option(
            "--allow-absurd-limits",
            help="Certify even with friction above 2, torque limits below 1 % of weight times leg length, or gravity "
            "outside 0.5 to 30 m/s^2.",
        ),
    ] = False,
) -> None:
    """Certify that a gait is exponentially stable; where that is refused, exits 1 and the file says so with reasons."""
    from amble.gait.files import load_gait
    from amble.workflow.certify import certify_into

    walker = load_gait(gait)
    try:
        with progress("certifying") as tell:
            certificate = certify_into(walker, out, allow_absurd_limits=allow_absurd_limits, progress=tell)
    except WorkError:
        tell_bounds(walker)
        raise
    tell_certified(walker, certificate)
