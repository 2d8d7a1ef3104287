"""``amble stabilize``: output weights that make a gait's orbit attractive."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli.console import wrote
from amble.cli.progress import progress

if TYPE_CHECKING:
    from collections.abc import Sequence

    from amble.gait import Gait
    from amble.stability.stabilize import Stabilized

BASE = ("roll", "pitch", "yaw")


class Method(StrEnum):
    """What chooses the weights."""

    BILINEAR = "bilinear"


METHOD_HELP = "What chooses the weights: the paper's bilinear matrix inequalities."


def stabilize(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    free: Annotated[
        list[str] | None, typer.Option(help="Coordinate with free weights.", show_default="roll, pitch, yaw")
    ] = None,
    method: Annotated[Method, typer.Option(help=METHOD_HELP)] = Method.BILINEAR,  # noqa: ARG001  (there is one)
    out: Annotated[Path, typer.Option(help="Where to write the stabilised gait.")] = Path("gait.json"),
) -> None:
    """Weight the outputs of a gait until its orbit is exponentially stable."""
    from amble.gait.files import load_gait, save_gait

    found = stabilized(load_gait(gait), free or BASE)
    wrote(save_gait(found.gait, out))


def stabilized(gait: Gait, free: Sequence[str] = BASE) -> Stabilized:
    """Stabilise a gait with progress, and say how it went."""
    from amble.stability.stabilize import stabilize

    with progress("stabilising") as update:
        found = stabilize(
            gait,
            tuple(free),
            lambda step: update(f"step {step.number}, spectral radius {step.radius:.4g}, bound {step.bound:.4g}"),
            update,
        )
    typer.echo(
        f"spectral radius of the full cycle {found.initial:.4g} -> {found.radius:.4g}, contraction bound "
        f"{found.bound:.4g}, in {len(found.steps) - 1} steps and {found.seconds:.1f} s ({found.parameters} weights): "
        f"{found.reason}"
    )
    return found
