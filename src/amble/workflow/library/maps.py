"""Maps of a library: cost of transport, radius and robustness over its axes, as figures."""

from __future__ import annotations

import importlib.util
import logging
from pathlib import Path

from amble.io.storage import confined
from amble.report.figures import gait_map, save
from amble.workflow.library.axes import UNITS
from amble.workflow.library.files import Library, LibraryEntry

logger = logging.getLogger("amble")

TITLES = {
    "cost_of_transport": "cost of transport",
    "radius": "spectral radius of a cycle",
    "returns_from": "size of disturbances that it returns from",
}
"""Beginning of a number's name in the index -> what it is."""


def write_maps(library: Library) -> tuple[Path, ...]:
    """Draw a map of every number that has a title; none, and a notice, where matplotlib is not installed."""
    if importlib.util.find_spec("matplotlib") is None:
        logger.warning("no maps are drawn: they need matplotlib (pip install 'amble[reproduce]')")
        return ()
    keys = dict.fromkeys(
        key
        for title in TITLES
        for entry in library.certified
        for key in entry.numbers
        if key == title or (title == "cost_of_transport" and key.startswith(title))
    )
    written: list[Path] = []
    for key in keys:
        title = next(text for name, text in TITLES.items() if key.startswith(name))
        suffix = key.removeprefix("cost_of_transport").strip("_") if key.startswith("cost_of_transport") else ""
        with confined(library.folder):
            figure = gait_map(
                [entry.values for entry in library.entries],
                [_number(entry, key) for entry in library.entries],
                f"{title} ({suffix})" if suffix else title,
                UNITS,
            )
            written += save(figure, library.folder / f"map-{key}")
    return tuple(written)


def _number(entry: LibraryEntry, key: str) -> float | None:
    """What a certified gait has under a name; None where that is no number, as in a record from elsewhere."""
    value = entry.numbers.get(key) if entry.certified else None
    return None if isinstance(value, bool | str) else value
