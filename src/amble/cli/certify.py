"""``amble certify``: the stability certificate of a gait, computed from its file alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli.console import wrote
from amble.cli.progress import progress

if TYPE_CHECKING:
    from amble.gait import Gait
    from amble.stability import Certificate


def certify(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    out: Annotated[Path, typer.Option(help="Where to write the certificate (JSON).")] = Path("certificate.json"),
) -> None:
    """Certify that a gait is exponentially stable; exits 1, without a file, where that is refused."""
    from amble.gait.files import load_gait

    wrote(write_certificate(certified(load_gait(gait)), out))


def write_certificate(certificate: Certificate, out: Path) -> Path:
    """Write a certificate as JSON and return the path."""
    from amble.storage import atomic_write

    return atomic_write(out, json.dumps(certificate.to_json(), indent=2, allow_nan=False) + "\n")


def certified(gait: Gait) -> Certificate:
    """Certify a gait and say what was found."""
    from amble.report.certification import certify_gait

    with progress("certifying"):
        certificate = certify_gait(gait)
    typer.echo(
        f"spectral radius of the full cycle {certificate.radius:.6f} (error bar {certificate.error:.1e}), "
        f"fixed point to {certificate.residual:.1e}, period {certificate.period:.6f} s"
    )
    return certificate
