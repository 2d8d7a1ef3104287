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
) -> None:
    """Certify that a gait is exponentially stable; where that is refused, exits 1 and the file says so with reasons."""
    from amble.gait.files import load_gait

    certified(load_gait(gait), out)


def certified(gait: Gait, out: Path) -> Certificate:
    """Certify a gait, say what was found and write it.

    A refusal is written too, in the same place: an older certificate would look as if it belonged to this gait.
    """
    from amble.report.certification import certificate_tree, certify_gait, refusal_tree
    from amble.report.results import write_results

    try:
        with progress("certifying") as update:
            certificate = certify_gait(gait, update)
    except WorkError as error:
        wrote(write_results(out, refusal_tree(gait, error)))
        raise
    typer.echo(
        f"spectral radius of the full cycle {certificate.radius:.6f} (estimated error {certificate.error:.1e}), "
        f"fixed point to {certificate.residual:.1e}, period {certificate.period:.6f} s"
    )
    wrote(write_results(out, certificate_tree(gait, certificate)))
    return certificate
