"""A figure as SVG with the values of its lines and points, for a page that tells them under the pointer."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from amble.report.figures.style import paper_style, require_matplotlib
from amble.types import Json

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINTS = 240
"""The most values of one line: hovering finds every one that a screen can tell apart."""

LINES = 40
"""The most lines of one panel that tell their values."""

POINT = 72.0
"""Points an inch, the unit of SVG files from matplotlib."""

LARGEST_SVG = 400_000
"""Bytes above which a figure is shown as its picture: lines of hundreds of cycles are larger as text."""


@dataclass(frozen=True, kw_only=True)
class HoverFigure:
    """A figure for an HTML page.

    Attributes:
        kind: media type of the picture.
        picture: the picture, base64.
        size: width and height, points.
        panels: for every panel its box (left, top, right, bottom; points) and its lines: name, colour, and a row of
            place and value (left, top, x, y) for every point.
    """

    kind: str
    picture: str
    size: tuple[float, float]
    panels: tuple[Json, ...]


def hover_figure(figure: Figure) -> HoverFigure:
    """Draw a figure without background, and collect the values of its lines and points.

    Raises:
        MissingExtraError: where matplotlib is not installed.
    """
    require_matplotlib()
    import matplotlib as mpl

    # the same figure gives the same file: no date, no random names
    with paper_style(), mpl.rc_context({"svg.hashsalt": "amble", "svg.fonttype": "path"}):
        kind, content = "image/svg+xml", _drawn(figure, "svg", {"Date": None})
        if len(content) > LARGEST_SVG:
            kind, content = "image/png", _drawn(figure, "png", {"Software": None})
    width, height = (POINT * float(inches) for inches in figure.get_size_inches())
    panels = tuple(panel for axes in figure.axes if (panel := _panel(figure, axes, height))["lines"])
    return HoverFigure(
        kind=kind, picture=base64.b64encode(content).decode("ascii"), size=(width, height), panels=panels
    )


def _drawn(figure: Figure, kind: str, metadata: dict[str, str | None]) -> bytes:
    buffer = BytesIO()
    figure.savefig(buffer, format=kind, metadata=metadata, transparent=True)
    return buffer.getvalue()


def _panel(figure: Figure, axes: Axes, height: float) -> Json:
    scale = POINT / figure.dpi
    box = axes.get_window_extent()
    lines = []
    artists: list[Any] = [*axes.lines, *axes.collections]
    for artist in artists:
        is_line = hasattr(artist, "get_xydata")
        transform = artist.get_transform() if is_line else artist.get_offset_transform()
        if not transform.contains_branch(axes.transData):
            continue
        values = np.asarray(artist.get_xydata() if is_line else artist.get_offsets(), dtype=np.float64)
        values = values[np.all(np.isfinite(values), axis=1)]
        if len(values) < (3 if is_line else 1):  # straight marks, such as the limits of a panel, say nothing new
            continue
        values = values[np.unique(np.linspace(0, len(values) - 1, POINTS).astype(int))]
        places = scale * axes.transData.transform(values)
        rows = np.column_stack([places[:, 0], height - places[:, 1], values])
        name = str(artist.get_label())
        lines.append(
            {
                "name": "" if name.startswith("_") else _plain(name),
                "colour": _colour(artist),
                "points": [[round(float(a), 2), round(float(b), 2), _short(c), _short(d)] for a, b, c, d in rows],
            }
        )
    return {
        "box": [scale * box.x0, height - scale * box.y1, scale * box.x1, height - scale * box.y0],
        "title": _plain(axes.get_title()),
        "lines": lines[:LINES],
    }


def _colour(artist: Any) -> str:
    require_matplotlib()
    from matplotlib.colors import to_hex

    colour = artist.get_color() if hasattr(artist, "get_color") else artist.get_edgecolor()[:1]
    return to_hex(colour if isinstance(colour, str) else np.asarray(colour).reshape(-1, np.size(colour))[0])


def _short(value: float) -> float:
    return float(f"{value:.5g}")


def _plain(text: str) -> str:
    """A label without the marks of a formula."""
    return text.replace(r"\$", "\0").replace("$", "").replace("\0", "$").replace("\\", "")
