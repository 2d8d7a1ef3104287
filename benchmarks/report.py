"""One JSON file and one Markdown table of everything that was measured in a run."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from amble.io.storage import atomic_write
from benchmarks.figures import Figure

FOLDER = Path(__file__).parents[1] / "build" / "benchmarks"


def write_report(machine: str, figures: Mapping[str, Sequence[Figure]], texts: Mapping[str, str]) -> list[Path]:
    """Write ``benchmarks.json`` and ``benchmarks.md``; returns where.

    Args:
        machine: description of machine and versions.
        figures: benchmark -> what it measured.
        texts: benchmark -> what it printed, for those that print tables of their own.
    """
    tree = {
        "machine": machine.splitlines(),
        "figures": {
            name: [{**asdict(figure), "verdict": figure.verdict} for figure in found] for name, found in figures.items()
        },
        "texts": {name: text.splitlines() for name, text in texts.items()},
    }
    lines = ["# Benchmarks", "", *(f"- {line}" for line in machine.splitlines()), ""]
    lines += [
        "| benchmark | what | value | unit | limit | verdict | runs | note |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, found in figures.items():
        for f in found:
            cells = [name, f.name, f"{f.value:.4g}", f.unit, f.limit, f.verdict, str(f.runs), f.note]
            lines.append("| " + " | ".join(cells) + " |")
    for name, text in texts.items():
        lines += ["", f"## {name}", "", "```", *text.splitlines(), "```"]
    FOLDER.mkdir(parents=True, exist_ok=True)
    paths = [FOLDER / "benchmarks.json", FOLDER / "benchmarks.md"]
    atomic_write(paths[0], json.dumps(tree, indent=1) + "\n")
    atomic_write(paths[1], "\n".join(lines) + "\n")
    return paths
