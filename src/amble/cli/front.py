"""``amble front``: torque against robustness over several gaits, and a choice among them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.console import print_table, progress
from amble.cli.output import result, show, wrote
from amble.errors import InputError, shown
from amble.io.storage import confined


def front(
    gaits: Annotated[list[Path], typer.Argument(help="Stabilised gaits of one robot.", show_default=False)],
    friction: Annotated[float, typer.Option(help="Friction of the ground that all are walked on.")] = 0.8,
    bears: Annotated[
        float | None,
        typer.Option(help="Name the gait of least torque that bears this push, N s.", show_default=False),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the table (JSON) and the figure.")] = Path("front"),
) -> None:
    """Draw torque against the push that a gait bears, and say which gaits no other one beats in both."""
    from amble.gait.files import load_gait
    from amble.report import write_results
    from amble.report.figures import require_matplotlib, save, torque_push
    from amble.workflow.front import front as computed

    require_matplotlib()
    files = {path.stem: path for path in gaits}
    if len(files) < len(gaits):
        raise InputError("two of the gaits have files of one name; a front calls gaits by their files' names")
    if bears is not None and not 0.0 < bears < float("inf"):
        raise InputError(f"a push of {shown(bears)} N s cannot be borne; it must be a positive number")
    loaded = {name: load_gait(path) for name, path in files.items()}
    with progress("front") as notify:
        found = computed(loaded, friction, notify)
    rows = [
        (p.name, f"{p.rms_torque:.4g}", f"{p.push:.3g}", f"{p.radius:.3f}", f"{p.friction_used:.3f}", "yes" * p.best)
        for p in found.points
    ]
    header = ("gait", "RMS torque (N m)", "push (N s)", "radius", "friction used", "on the front")
    print_table(header, rows, right=(1, 2, 3, 4))
    drawn = torque_push(
        [p.rms_torque for p in found.points],
        [p.push for p in found.points],
        [p.name for p in found.points],
        [p.best for p in found.points],
    )
    with confined(out):
        for path in save(drawn, out / "front"):
            wrote(path)
        wrote(write_results(out / "front.json", {"front": found.to_dict()}))
    result(front=found.to_dict())
    if bears is not None:
        chosen = found.cheapest(bears)
        show(f"least torque that bears {bears:g} N s: {files[chosen.name]} ({chosen.rms_torque:.4g} N m)")
        result(chosen=str(files[chosen.name]))
