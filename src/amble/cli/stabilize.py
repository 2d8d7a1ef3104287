"""``amble stabilize``: output weights that make a gait's orbit attractive."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli.console import wrote
from amble.cli.progress import progress
from amble.optional import require

if TYPE_CHECKING:
    from collections.abc import Sequence

    from amble.gait import Gait
    from amble.stability.stabilize import Stabilized

BASE = ("roll", "pitch", "yaw")
TARGET, STEPS = 0.2, 25


class Method(StrEnum):
    """What chooses the weights."""

    DESCENT = "descent"
    BILINEAR = "bilinear"


METHOD_HELP = "What chooses the weights: descent, or bilinear for the paper's matrix inequalities."


def stabilize(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    free: Annotated[
        list[str] | None, typer.Option(help="Coordinate with free weights.", show_default="roll, pitch, yaw")
    ] = None,
    method: Annotated[Method, typer.Option(help=METHOD_HELP)] = Method.DESCENT,
    target: Annotated[float, typer.Option(help="Stop at this spectral radius of a whole cycle.")] = TARGET,
    steps: Annotated[int, typer.Option(min=1, help="The most steps.")] = STEPS,
    out: Annotated[Path, typer.Option(help="Where to write the stabilised gait.")] = Path("gait.json"),
) -> None:
    """Weight the outputs of a gait until its orbit is exponentially stable."""
    from amble.gait.files import load_gait, save_gait

    require_method(method)
    found = stabilized(load_gait(gait), free or BASE, method, target, steps)
    wrote(save_gait(found.gait, out))


def require_method(method: Method) -> None:
    """Refuse a method whose library is not installed, before any work.

    Raises:
        MissingExtraError: where it is not installed.
    """
    if method is Method.BILINEAR:
        require("cvxpy", "lmi", "matrix inequalities")


def stabilized(
    gait: Gait, free: Sequence[str] = BASE, method: Method = Method.DESCENT, target: float = TARGET, steps: int = STEPS
) -> Stabilized:
    """Stabilise a gait with progress, and say how it went."""
    from amble.stability.stabilize import stabilization

    with progress("stabilising") as update:
        found = stabilization(
            gait,
            tuple(free),
            method.value,
            target,
            steps,
            lambda step: update(
                f"step {step.number}, spectral radius {step.radius:.4g}, step length {step.length:.2g}"
            ),
            update,
        )
    typer.echo(
        f"spectral radius of the full cycle {found.initial:.4g} -> {found.radius:.4g} in {len(found.steps) - 1} "
        f"steps and {found.seconds:.1f} s ({found.parameters} weights, {found.method}): {found.reason}"
    )
    return found
