"""``amble certify``: the stability certificate of a gait, computed from its file alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli.console import wrote
from amble.cli.progress import progress
from amble.errors import WorkError

if TYPE_CHECKING:
    from amble.gait import Gait
    from amble.stability import Certificate


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

    certified(load_gait(gait), out, allow_absurd_limits)


def certified(gait: Gait, out: Path, allow_absurd_limits: bool = False) -> Certificate:
    """Certify a gait, say what was found and write it.

    A refusal is written too, in the same place: an older certificate would look as if it belonged to this gait.
    """
    from amble.report.results import write_results
    from amble.stability.gait_certificate import bounds_sentences, certificate_tree, certify_gait, refusal_tree

    try:
        with progress("certifying") as update:
            certificate = certify_gait(gait, update, allow_absurd_limits)
    except WorkError as error:
        typer.echo("\n".join(bounds_sentences(gait)))
        wrote(write_results(out, refusal_tree(gait, error)))
        raise
    typer.echo(
        f"spectral radius of the full cycle {certificate.radius:.6f} (estimated error {certificate.error:.1e}), "
        f"fixed point to {certificate.residual:.1e}, period {certificate.period:.6f} s"
    )
    typer.echo(f"{certificate.disturbance}")
    typer.echo("\n".join(bounds_sentences(gait)))
    for warning in certificate.warnings:
        typer.echo(f"WARNING: {warning}")
    wrote(write_results(out, certificate_tree(gait, certificate)))
    return certificate
