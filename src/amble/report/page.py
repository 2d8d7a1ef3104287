"""report.md: one page with everything a run found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from amble.gait import SolverReport
from amble.io.storage import atomic_write
from amble.report.tables import Table, markdown_text, number


@dataclass(frozen=True)
class FigureFile:
    """A figure of the page: path relative to the page, without suffix, and its caption."""

    stem: str
    caption: str


@dataclass(frozen=True, kw_only=True)
class Page:
    """What the page says.

    Attributes:
        title: headline.
        summary: paragraphs at the top.
        tables: in the order of the page.
        figures: in the order of the page; the PNG is shown, the PDF linked.
        settings: name -> value, of the run.
        versions: library -> version.
    """

    title: str
    summary: tuple[str, ...]
    tables: tuple[Table, ...]
    figures: tuple[FigureFile, ...]
    settings: Mapping[str, str]
    versions: Mapping[str, str]


def solver_table(report: SolverReport, unit: str) -> Table:
    """How the gait was found, as a table; the objective has the unit of the gait's cost."""
    rows = (
        ("solver", report.solver),
        ("linear solver", report.linear_solver or "not recorded"),
        ("status", report.status),
        ("iterations", str(report.iterations)),
        ("wall time (s)", number(report.seconds, 3)),
        ("variables", str(report.variables)),
        ("constraints", str(report.constraints)),
        ("largest violation", number(report.violation, 3)),
        (f"objective ({unit})", number(report.objective)),
    )
    return Table("Gait optimisation", ("what", "value"), rows)


def page_text(page: Page) -> str:
    """Return the page as Markdown."""
    parts = [f"# {markdown_text(page.title)}", *map(markdown_text, page.summary)]
    parts += [table.markdown().rstrip() for table in page.tables]
    if page.figures:
        parts.append("## Figures")
    for figure in page.figures:
        caption = markdown_text(figure.caption)
        parts.append(f"![{caption}]({figure.stem}.png)")
        parts.append(f"*{caption}* ([PDF]({figure.stem}.pdf))")
    parts.append("## Settings")
    parts.append(_pairs("Settings", ("setting", "value"), page.settings))
    parts.append("## Versions")
    parts.append(_pairs("Versions", ("library", "version"), page.versions))
    return "\n\n".join(parts) + "\n"


def write_page(path: str | Path, page: Page) -> Path:
    """Write the page, whole or not at all.

    Raises:
        InputError: where the place cannot be written.
    """
    return atomic_write(path, page_text(page))


def _pairs(title: str, header: Sequence[str], values: Mapping[str, str]) -> str:
    return Table(title, tuple(header), tuple(values.items())).markdown().rstrip()
