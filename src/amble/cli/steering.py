"""Commands between the gaits of a library: ``amble transitions`` finds out how, ``amble steer`` walks so."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.console import progress
from amble.cli.output import result, show, wrote
from amble.errors import FallError

LIBRARY = typer.Argument(help="Folder of a library (amble library).", show_default=False)


def transitions(
    library: Annotated[Path, LIBRARY],
    friction: Annotated[
        float | None,
        typer.Option(help="Of the ground, where the gaits were solved for less.", show_default="that of the gaits"),
    ] = None,
) -> None:
    """Make one law of a library's gaits that follows commands between them, and find out how fast these may change."""
    from amble.workflow.library import transitions as found_out
    from amble.workflow.library.between import FOLDER, HEADER

    with progress("transitions") as notify:
        found = found_out(library, friction=friction, progress=notify)
    wrote(library / FOLDER / HEADER)
    for axis, row, change in zip(found.axes, found.schedule.values, found.changes, strict=True):
        show(f"{axis} {row[0]:g} to {row[-1]:g}, {len(row)} gaits; the command may move by {change:.4g} a step")
    result(transitions={"axes": list(found.axes), "changes": list(found.changes)})


def steer(
    library: Annotated[Path, LIBRARY],
    commands: Annotated[
        Path, typer.Option(help="Commands over time: CSV with the head time,speed (s, m/s).", show_default=False)
    ],
    duration: Annotated[float, typer.Option(help="How long to walk, s.")] = 10.0,
    out: Annotated[Path, typer.Option(help="Where to write a row for every step (CSV).")] = Path("steered.csv"),
) -> None:
    """Walk under commands of speed on ground that pushes only; exits 1 where it falls or slips."""
    from amble.simulation.steering import check_duration
    from amble.workflow.library import load_transitions
    from amble.workflow.library import steer as walk
    from amble.workflow.library.commands import read_commands, write_steered

    check_duration(duration)
    found = load_transitions(library)
    asked = read_commands(commands, found.axes)
    with progress("steering") as notify:
        walked = walk(found, asked, duration, progress=notify)
    wrote(write_steered(walked, out))
    show(f"{len(walked.steps)} steps, {walked.time:.3f} s under {len(asked)} commands")
    irregular = sum(step.irregular for step in walked.steps)
    show(f"feet that would have pulled were released, and others touched, {irregular} times in all")
    result(steering={"steps": len(walked.steps), "time_s": walked.time, "ended": walked.ended, "irregular": irregular})
    if not walked.completed:
        raise FallError(walked.ended)
