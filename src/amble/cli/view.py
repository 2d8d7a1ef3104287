"""``amble view``: a motion that moves, in the browser or as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.console import progress
from amble.cli.output import result, show, wrote
from amble.defaults import SHOWN_CYCLES


def view(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    trace: Annotated[
        Path | None, typer.Option(help="Trace of its simulation, shown beside it.", show_default=False)
    ] = None,
    beside: Annotated[Path | None, typer.Option(help="Another gait, shown beside it.", show_default=False)] = None,
    robot: Annotated[
        Path | None,
        typer.Option(help="URDF file of the robot, whose shapes and meshes are drawn.", show_default=False),
    ] = None,
    cycles: Annotated[int, typer.Option(help="The most gait cycles to show, up to 1000.")] = SHOWN_CYCLES,
    out: Annotated[
        Path | None,
        typer.Option("--out", "--html", help="Write the page here (HTML) and open no browser.", show_default=False),
    ] = None,
    mp4: Annotated[
        Path | None,
        typer.Option(help="Write a film here at half speed, by MuJoCo's renderer and ffmpeg.", show_default=False),
    ] = None,
) -> None:
    """Replay a gait with its forces, friction cones, footholds and centre of mass, in one page without network."""
    from amble.errors import InputError
    from amble.gait.files import load_gait
    from amble.simulation import load_trace
    from amble.view import replay
    from amble.view.movie import write_movie

    if trace is not None and beside is not None:
        raise InputError("a page shows two motions side by side: give --trace or --beside, not both")
    walker = load_gait(gait)
    other = load_trace(trace) if trace is not None else None if beside is None else load_gait(beside)
    page = replay(walker, other, cycles, robot)
    result(replay=[{"label": each.label, "seconds": float(each.times[-1])} for each in page.replays])
    if out is not None:
        wrote(page.write(out))
    if mp4 is not None:
        with progress("filming") as notify:
            wrote(write_movie(page, mp4, notify))
    if out is not None or mp4 is not None:
        return
    place = page.write(_temporary())
    wrote(place)
    _open(place)
    show(f"opened in the browser: {page.title}")


def _temporary() -> Path:
    import tempfile

    return Path(tempfile.mkdtemp(prefix="amble-view-")) / "replay.html"


def _open(place: Path) -> None:
    """Open a page; errors say how to have it without a browser."""
    import webbrowser

    from amble.errors import WorkError

    if not webbrowser.open(place.as_uri()):
        raise WorkError(f"no browser could be opened; the page is '{place}', or write it with --html FILE")
