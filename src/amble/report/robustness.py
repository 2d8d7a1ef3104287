"""One page on the robustness of a gait: how far each disturbance can go, predicted and measured."""

from __future__ import annotations

from collections import Counter
from math import degrees, inf
from pathlib import Path
from typing import TYPE_CHECKING

from amble.analysis.proportions import half_survives, wilson
from amble.io.storage import confined
from amble.report.figures import save
from amble.report.figures.robustness import predicted_measured, push_survival
from amble.report.hover import hover_figure
from amble.report.html import write_html
from amble.report.page import FigureFile, Page, write_page
from amble.report.results import write_results
from amble.report.tables import Table, number
from amble.stability.robustness import Robustness
from amble.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESULTS, PAGE, HTML, FIGURES = "robustness.json", "robustness.md", "robustness.html", "figures"
"""Names of what is written into the folder."""

PREDICTIONS = {"by_contact": "first contact lost", "by_metric": "1 / |b|_W"}
"""Predictions of the linearisation, in words."""

DIRECTIONS = {0.0: "forward", 90.0: "left", 180.0: "backward", 270.0: "right"}


def robustness_table(found: Robustness) -> Table:
    """Say of every error how far it can go with sound contacts, beside its gains from cycle to cycle."""
    gains = {gain.name: gain for gain in found.gains}
    rows = []
    for reach in found.reaches:
        gain, kind = gains[reach.disturbance.name], reach.disturbance
        size = "more than tried" if reach.size == inf else number(reach.sign * reach.size * kind.natural, 3)
        cells = (number(gain.direct, 3), number(gain.later, 3), number(gain.gain, 3))
        rows.append((kind.name, kind.unit, size, reach.ended or "-", *cells))
    header = ("error of the plant", "unit", "borne up to", "then", "|b|", "|A b|", "gamma")
    notes = (
        f"Borne: the largest that {found.settings.cycles} cycles of amble's own walk on ground with a friction of "
        f"{found.settings.friction:g} take with every contact sound, to 15 %. The orbit alone uses a friction of "
        f"{found.friction_used:.3f}.",
        "|b|, |A b|: what one natural unit of it (torques m g l, times sqrt(l/g), lengths l) does to the next entry "
        "and to the one after, in natural units, to first order; gamma: input-to-state gain with the certificate's W.",
    )
    return Table("How far errors of the plant can go", header, tuple(rows), notes)


def push_table(found: Robustness) -> Table:
    """Say how large pushes can be, by direction and engine."""
    rows = []
    for angle, label in DIRECTIONS.items():
        predicted = min(cell.by_contact for cell in found.cells if round(degrees(cell.direction)) == angle)
        cells = []
        for trials in found.trials.values():
            some = [one for one in trials if abs((degrees(one.direction) - angle + 180.0) % 360.0 - 180.0) <= 22.5]
            half = half_survives([one.impulse for one in some], [one.survived for one in some]) if some else None
            cells.append("more than tried" if half is None else number(half, 3))
        rows.append((label, number(predicted, 3), *cells))
    header = ("push", "first contact lost, linear (N s)", *(f"half walk on, {name} (N s)" for name in found.trials))
    note = (
        "Within 22.5 degrees of the direction, at every phase. The native engine ends a walk where a foot leaves its "
        "friction cone, MuJoCo lets it slide."
    )
    return Table("How far pushes can go", header, tuple(rows), (note,))


def outcome_table(found: Robustness) -> Table:
    """Count how the walks ended."""
    rows = []
    for name, trials in found.trials.items():
        for ended, count in Counter(trial.ended for trial in trials).most_common():
            low, high = wilson(count, len(trials))
            shares = (f"{100.0 * count / len(trials):.1f}", f"{100.0 * low:.1f} to {100.0 * high:.1f}")
            rows.append((name, ended, str(count), *shares))
    header = ("engine", "walk", "trials", "share (%)", "95 % interval, Wilson (%)")
    return Table("Walks after a push", header, tuple(rows))


def correlation_table(found: Robustness) -> Table:
    """Say how well predictions order what was measured."""
    rows = []
    for engine, pairs in found.correlations().items():
        for name, (value, count) in pairs.items():
            rows.append((engine, PREDICTIONS[name], "-" if value is None else f"{value:.2f}", str(count)))
    note = (
        "Spearman's, over cells of directions and phases in which fewer than half of the largest pushes are survived."
    )
    return Table(
        "Predicted against measured", ("engine", "prediction", "rank correlation", "cells"), tuple(rows), (note,)
    )


def fast_table(found: Robustness) -> Table:
    """Say how fast the loop is with the feet pinned and where one is lost."""
    pinned, lost = found.fast.delay_limits
    rows = (
        ("all stance feet pinned", number(found.fast.pinned, 3), number(1e3 * pinned, 3)),
        ("one stance foot lost", number(found.fast.lost, 3), number(1e3 * lost, 3)),
        ("all lost", number(found.fast.flight, 3), number(1e3 * lost, 3)),
    )
    note = f"Largest growth rate without delay: {found.fast.growth:.3g} 1/s."
    return Table("Fastest mode of the velocity loop", ("contact", "rate (1/s)", "delay limit (ms)"), rows, (note,))


def robustness_figures(found: Robustness) -> dict[str, tuple[Figure, str]]:
    """Draw all figures: file stem -> figure and caption."""
    trials = {
        name: ([one.impulse for one in done], [one.survived for one in done]) for name, done in found.trials.items()
    }
    groups = {}
    correlations = found.correlations()
    for engine in found.trials:
        for name, words in PREDICTIONS.items():
            known = [cell for cell in found.cells if cell.measured[engine] is not None]
            value, count = correlations[engine][name]
            told = "none" if value is None else f"{value:.2f}"
            predicted = [float(getattr(cell, name)) for cell in known]
            measured = [float(cell.measured[engine] or 0.0) for cell in known]
            groups[f"{engine}, {words}: rank correlation {told} ({count})"] = predicted, measured
    labels = ("predicted (N s)", "half survive (N s)")
    return {
        "push_survival": (
            push_survival(trials),
            "Share of pushed walks that go on, over the impulse of the push, with 95 % intervals (Wilson).",
        ),
        "predictions": (
            predicted_measured(groups, labels),
            "Impulse that half of the walks survive, against what the linearisation predicts, by direction and phase; "
            "with W up to a factor that is not known. Cells whose threshold is zero count in the rank correlation and "
            "have no place on the axes.",
        ),
    }


def write_robustness(folder: str | Path, found: Robustness) -> tuple[Path, ...]:
    """Write robustness.json, the figures, robustness.md and robustness.html; every file whole or not at all.

    Returns:
        The paths that were written, the numbers first.

    Raises:
        InputError: where the place cannot be written.
    """
    place = Path(folder)
    with confined(place):
        written = [write_results(place / RESULTS, {"robustness": found.to_dict()})]
        figures, drawn = [], []
        for stem, (figure, caption) in robustness_figures(found).items():
            written += save(figure, place / FIGURES / stem)
            figures.append(FigureFile(f"{FIGURES}/{stem}", caption))
            drawn.append((hover_figure(figure), caption))
        page = _page(found, tuple(figures))
        written.append(write_page(place / PAGE, page))
        written.append(write_html(place / HTML, page, drawn, ()))
    return tuple(written)


def _page(found: Robustness, figures: tuple[FigureFile, ...]) -> Page:
    gait, settings = found.gait, found.settings
    walked = "; ".join(
        f"{name}: {sum(one.survived for one in done)} of {len(done)} pushed walks go on"
        for name, done in found.trials.items()
    )
    return Page(
        title=f"Robustness of {gait.robot.name}: {gait.pattern.name} at {gait.speed:g} m/s",
        summary=(
            f"Spectral radius of the full cycle {found.radius:.4f}, contraction bound {found.rate:.4f}. {walked}.",
            f"A push of {settings.largest:g} m sqrt(g l) at most, horizontal, at any phase and in any direction of the "
            f"first of {settings.cycles} cycles; small pushes are likelier.",
        ),
        tables=(
            robustness_table(found),
            push_table(found),
            outcome_table(found),
            correlation_table(found),
            fast_table(found),
        ),
        figures=figures,
        settings={
            "seed": str(settings.seed),
            "cycles of a trial": str(settings.cycles),
            "friction": f"{settings.friction:g}",
            "largest push (m sqrt(g l))": f"{settings.largest:g}",
            "control law": "input-output linearisation" if gait.control is None else gait.control.name,
            **{f"trials, {name}": str(len(done)) for name, done in found.trials.items()},
        },
        versions={"amble": __version__},
    )
