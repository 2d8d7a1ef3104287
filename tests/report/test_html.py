"""report.html: everything of the page, in one file, with values under the pointer."""

from __future__ import annotations

import base64
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from amble.gait import Gait
from amble.report.hover import HoverFigure, hover_figure
from amble.report.html import html_text, write_html
from amble.report.page import Page
from amble.report.tables import Table
from amble.view import replay
from tests.browser import document, screenshot, share_of_ink

X = np.linspace(0.0, 2.0, 50)


@pytest.fixture(scope="module")
def figure() -> HoverFigure:
    drawn = Figure(figsize=(4.0, 3.0))
    axes = drawn.add_subplot()
    axes.plot(X, X**2, color="#0072B2", label=r"a $\tau$ & more")
    axes.scatter([0.5], [3.5], color="#CC0000")
    axes.axhline(1.0)
    axes.set_xlim(0.0, 2.0)
    axes.set_ylim(0.0, 4.0)
    return hover_figure(drawn)


@pytest.fixture(scope="module")
def page() -> Page:
    first = Table("costs <of> all", ("law", "N m"), (("pinv", "1.25"), ("<b>", "2.5")), ("a note",))
    second = Table("contact", ("row", "value"), (("slip", "0"),))
    return Page(
        title="astro: <amble>",
        summary=("It walks & stands.",),
        tables=(first, second),
        figures=(),
        settings={"tolerance": "1e-8"},
        versions={"amble": "0.1"},
    )


def test_values_lie_where_they_are_drawn(figure: HoverFigure) -> None:
    """Axes are linear here, so a value's place follows from the corners of the panel."""
    (panel,) = figure.panels
    left, top, right, bottom = panel["box"]
    line, point = panel["lines"]  # the straight mark is none
    assert line["name"] == "a tau & more"
    assert line["colour"] == "#0072b2"
    assert point["colour"] == "#cc0000"
    assert len(line["points"]) == len(X)
    for a, b, x, y in [*line["points"], *point["points"]]:
        assert a == pytest.approx(left + (right - left) * x / 2.0, abs=0.02)
        assert b == pytest.approx(bottom - (bottom - top) * y / 4.0, abs=0.02)
    np.testing.assert_allclose([row[3] for row in line["points"]], X**2, rtol=1e-4)
    assert 0.0 < left < right < figure.size[0] == 288.0


def test_a_figure_is_the_same_file_twice() -> None:
    def once() -> str:
        drawn = Figure(figsize=(2.0, 2.0))
        drawn.add_subplot().plot(X, X)
        return hover_figure(drawn).picture

    assert once() == once()
    assert b"<svg" in base64.b64decode(once())


def test_the_page_holds_everything_and_asks_for_nothing(page: Page, figure: HoverFigure, stabilised_gait: Gait) -> None:
    text = html_text(page, [(figure, "a caption")], replay(stabilised_gait, cycles=1).replays)
    assert text.index("It walks &amp; stands.") < text.index("costs &lt;of&gt; all") < text.index('id="motion"')
    assert text.index('id="motion"') < text.index("a caption") < text.index("<summary>contact</summary>")
    for part in ("astro: &lt;amble&gt;", "&lt;b&gt;", "a note", "1e-8", "<summary>Versions</summary>"):
        assert part in text
    assert "<b>" not in text
    assert text.count("<details>") == 3
    addresses = re.findall(r"""(?:src|href)\s*=\s*["']([^"']{0,20})""", text)
    assert addresses == ["data:image/svg+xml;b"]
    assert not re.search(r"@import|url\(|https?:|fetch\(|XMLHttpRequest|import\(", text)


def test_the_pointer_is_told_the_value(page: Page, figure: HoverFigure, tmp_path: Path) -> None:
    """A pointer is moved to the middle of the curve, by a program that the test adds to the page."""
    place = write_html(tmp_path / "report.html", page, [(figure, "a caption")], ())
    (panel,) = figure.panels
    a, b, x, y = panel["lines"][0]["points"][25]
    move = f"""<script>
    const plot = document.querySelector(".plot"), frame = plot.getBoundingClientRect();
    plot.dispatchEvent(new PointerEvent("pointermove", {{
      clientX: frame.left + {a / figure.size[0]} * frame.width, clientY: frame.top + {b / figure.size[1]} * frame.height
    }}));
    </script></body>"""
    place.write_text(place.read_text(encoding="utf-8").replace("</body>", move), encoding="utf-8")
    tip = re.search(r'<div class="tip"[^>]*>([^<]*)</div>', document(place, tmp_path))
    assert tip is not None
    assert tip.group(1) == f"a tau &amp; more: {x:g}, {y:g}"


def test_it_is_seen(page: Page, figure: HoverFigure, tmp_path: Path) -> None:
    place = write_html(tmp_path / "report.html", page, [(figure, "a caption")], ())
    for size in ((1200, 900), (420, 900)):
        assert share_of_ink(screenshot(place, tmp_path, size=size)) > 0.02
