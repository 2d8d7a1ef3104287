"""``amble library``: gaits over axes such as speed and height, each certified."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

import typer

from amble.cli.console import progress
from amble.cli.output import plugins, result, show
from amble.errors import InputError, WorkError, shown


def library(
    spec: Annotated[
        Path, typer.Argument(help="Specification with a table [library.axes], a TOML file.", show_default=False)
    ],
    out: Annotated[Path, typer.Option(help="Folder of the gaits; one that was begun is completed.")] = Path("library"),
    workers: Annotated[
        str, typer.Option(help="Processes on this machine; or hyperqueue: the chains run on the cluster of its server.")
    ] = "1",
    again: Annotated[bool, typer.Option("--again", help="Try again what failed.")] = False,
    chain: Annotated[
        int | None,
        typer.Option(min=0, help="Only this chain of neighbours; tables and maps are left out.", show_default=False),
    ] = None,
) -> None:
    """Find gaits over ranges of speed, turn rate, height, slope, friction or payload; each is checked and certified."""
    from amble.workflow import build_library

    with progress("building the library") as notify:
        found = build_library(
            spec, out, workers=_workers(workers), again=again, plugins=plugins(), progress=notify, chain=chain
        )
    stages = Counter(entry.stage for entry in found.failures)
    spent = sum(sum(entry.seconds.values()) for entry in found.entries)
    failed = ", ".join(f"{count} at '{stage}'" for stage, count in stages.items())
    show(
        f"{len(found.certified)} of {len(found.entries)} gaits certified{f'; failed: {failed}' if failed else ''}; "
        f"{spent / max(len(found.entries), 1):.1f} s of processor time a gait"
    )
    result(certified=len(found.certified), failed=dict(stages), processor_seconds=spent, tried=len(found.entries))
    if chain is None and not found.certified:
        raise WorkError(f"no gait of the library is certified; its failures.csv says why ({failed})")


def _workers(text: str) -> int | Literal["hyperqueue"]:
    if text == "hyperqueue":
        return "hyperqueue"
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise InputError(f"--workers is a number of processes or hyperqueue, not '{shown(text)}'")
    return int(text)
