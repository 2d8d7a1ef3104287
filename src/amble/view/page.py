"""The page of a replay: one HTML file with its numbers, its program and its style, which asks no network for anything.

Numbers are little-endian float32 in base64: a ten-cycle walk of thirteen links takes about half a megabyte.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from amble.errors import InputError, printable
from amble.io.storage import atomic_write
from amble.types import Json
from amble.view.replay import Replay

MOST = 2
"""Motions on one page."""

HEIGHT = 620
"""Height of a replay inside a notebook, pixels."""

PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
html, body {{ height: 100%; margin: 0; }}
</style>
</head>
<body>
{fragment}
</body>
</html>
"""

FRAGMENT = """<style>
{style}
</style>
<div class="amble-replay {place}" id="{name}"></div>
<script type="application/json" id="{name}-motion">{payload}</script>
<script>
{program}
ambleReplay("{name}");
</script>"""


@dataclass(frozen=True, kw_only=True)
class ReplayPage:
    """One or two motions as a page.

    Attributes:
        title: of the page.
        replays: the motions, from left to right.
    """

    title: str
    replays: tuple[Replay, ...]

    def html(self) -> str:
        """Return the page, whole and self-contained."""
        fragment = replay_fragment(self.replays, "replay", whole_page=True)
        return PAGE.format(title=escape(printable(self.title)), fragment=fragment)

    def write(self, path: str | Path) -> Path:
        """Write the page, whole or not at all.

        Raises:
            InputError: where it cannot be written there.
        """
        return atomic_write(path, self.html())

    def _repr_html_(self) -> str:
        """Show the replay in a notebook, apart from the notebook's own page."""
        return (
            f'<iframe srcdoc="{escape(self.html())}" width="100%" height="{HEIGHT}" '
            f'style="border: 0" title="{escape(printable(self.title))}"></iframe>'
        )


def replay_fragment(replays: Sequence[Replay], name: str, whole_page: bool = False) -> str:
    """Return a replay as a piece of HTML for a larger page.

    Args:
        replays: one or two motions, from left to right.
        name: identifier of the element, a word that no other element of the page has.
        whole_page: whether the replay fills the window.

    Raises:
        InputError: where there is no motion, or more than two.
    """
    if not 1 <= len(replays) <= MOST:
        raise InputError(f"a replay shows one motion or two side by side, not {len(replays)}")
    payload = json.dumps({"motions": [_payload(replay) for replay in replays]}, allow_nan=False)
    return FRAGMENT.format(
        style=_resource("replay.css"),
        place="amble-whole" if whole_page else "amble-part",
        name=name,
        payload=payload.replace("<", "\\u003c"),  # no text in it ends the script element
        program=_resource("replay.js"),
    )


@cache
def _resource(name: str) -> str:
    return files("amble.view").joinpath(name).read_text(encoding="utf-8")


def _payload(replay: Replay) -> Json:
    robot, ground = replay.robot, replay.ground
    return {
        "label": printable(replay.label),
        "duration": float(replay.times[-1]),
        "frames": len(replay.times),
        "cycles": replay.cycles,
        "length": robot.leg_length,
        "weight": robot.mass * robot.gravity,
        "friction": replay.friction,
        "links": [link.name for link in robot.links],
        "feet": list(robot.foot_names),
        "domainNames": list(replay.domain_names),
        "shapes": [
            [shape.kind, shape.link, *map(float, shape.first), *map(float, shape.second), shape.radius]
            for shape in replay.shapes
        ],
        "meshes": [[mesh.link, _packed(mesh.vertices), _packed(mesh.faces, "<u2")] for mesh in replay.meshes],
        "footholds": [[hold.foot, hold.start, hold.end, *map(float, hold.point)] for hold in replay.footholds],
        "ground": {
            "origin": list(map(float, ground.origin)),
            "cell": ground.cell,
            "counts": list(ground.heights.shape),
            "heights": _packed(ground.heights),
        },
        "poses": _packed(replay.links),
        "footPoints": _packed(replay.feet),
        "forces": _packed(replay.forces),
        "normals": _packed(replay.normals),
        "center": _packed(replay.center),
        "stance": _packed(replay.stance, "u1"),
        "domains": _packed(replay.domains, "<u2"),
    }


def _packed(values: Any, kind: str = "<f4") -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")
