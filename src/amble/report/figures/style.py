"""The look of all figures: a paper's column, 9 pt, colours that colour-blind readers can tell apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from amble.io.storage import replacing
from amble.optional import require
from amble.types import IntegerVector, Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMN = 3.5
"""Width of one column of a two-column paper, inch."""

PAGE = 7.16
"""Width of both columns, inch."""

BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE, GREY, RED = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#E69F00",
    "#56B4E9",
    "#CC79A7",
    "#7F7F7F",
    "#CC0000",
)
"""Colours of Okabe and Ito, a grey, and the red of initial values."""

LAW_COLOURS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, GREY)
LAW_STYLES = ("-", "--", "-.", ":", (0, (5, 1)), (0, (3, 1, 1, 1)), (0, (1, 1)))

LAW_LABELS: Mapping[str, str] = {
    "pinv": "pseudo-inverse (proposed)",
    "drop": "one actuator off (Ma et al. 2019)",
}

SETTINGS: Mapping[str, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.0,
    "legend.fontsize": 8.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#E0E0E0",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.0,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "savefig.dpi": 200,
    "pdf.fonttype": 42,
    "figure.constrained_layout.use": True,
}


def require_matplotlib() -> None:
    """Refuse to draw where matplotlib is not installed; commands ask before they work for minutes.

    Raises:
        MissingExtraError: where it is not installed.
    """
    require("matplotlib", "reproduce", "figures")


@contextmanager
def paper_style() -> Iterator[None]:
    """Draw and save in the style of a paper; other figures of the process keep theirs."""
    require_matplotlib()
    import matplotlib as mpl

    with mpl.rc_context(cast("Any", dict(SETTINGS))):
        yield


def panels(
    rows: int, columns: int, width: float, height: float, figure: Figure | None = None, **options: Any
) -> tuple[Figure, list[Axes]]:
    """Make a figure of rows times columns axes, listed row by row; sizes in inch.

    Args:
        rows: number of rows.
        columns: number of columns.
        width: of the figure, inch.
        height: of the figure, inch.
        figure: one to draw into instead, which keeps its own size.
        options: of ``Figure.subplots``, such as ``sharex``.
    """
    require_matplotlib()
    from matplotlib.figure import Figure

    if figure is None:
        figure = Figure(figsize=(width, height))
    if figure.get_layout_engine() is None:  # legends stand outside of the panels
        figure.set_layout_engine("constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    return figure, list(axes.ravel())


def save(figure: Figure, stem: str | Path) -> tuple[Path, Path]:
    """Write a figure as ``stem.png`` at 200 dpi and ``stem.pdf``; each file appears whole or not at all.

    The files hold no date, so that equal figures are equal files.

    Raises:
        InputError: where the place cannot be written.
        WorkError: where writing fails for another reason.
    """
    # not with_suffix: a stem may contain a dot
    png, pdf = Path(f"{stem}.png"), Path(f"{stem}.pdf")
    with paper_style():
        place(figure)
        with replacing(png) as temporary:
            figure.savefig(temporary, metadata={"Software": None})
        with replacing(pdf) as temporary:
            figure.savefig(temporary, metadata={"CreationDate": None})
    return png, pdf


def place(figure: Figure) -> None:
    """Find the places of all parts of a figure once and for all: each file would find them anew, for half its time."""
    require_matplotlib()
    import matplotlib as mpl

    if figure.get_layout_engine() is not None:
        figure.draw_without_rendering()
        with mpl.rc_context({"figure.constrained_layout.use": False, "figure.autolayout": False}):
            figure.set_layout_engine(None)


def legend_above(figure: Figure, axes: Axes, columns: int) -> None:
    """Put one legend for all panels above them, with the entries of one axes."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns)


def with_gaps(segments: IntegerVector, *values: Vector) -> tuple[Vector, ...]:
    """Insert a gap (not a number) where a new segment begins, so that no line is drawn across a jump.

    Args:
        segments: segment number of every sample, (n,).
        values: any number of quantities, (n,) each.

    Returns:
        The quantities with gaps, (n + number of jumps,) each.
    """
    jumps = np.flatnonzero(np.diff(segments)) + 1
    return tuple(np.insert(np.asarray(each, dtype=np.float64), jumps, np.nan) for each in values)


def plain_text(text: str) -> str:
    """Write a text that may come from anywhere, such as a name, for matplotlib: a dollar begins no formula."""
    return text.replace("$", r"\$")


def plain_number(value: float, _position: float | None = None) -> str:
    """Write a tick label without trailing zeros, so that narrow panels hold three of them."""
    return f"{value:.10g}".replace("-", "\N{MINUS SIGN}")
