"""Tables: alignment, escaping, numbers."""

import numpy as np
import pytest

from amble.analysis import Comparison, samples_of_gait
from amble.control.actuator import ACTUATORS
from amble.errors import InputError
from amble.report import Table, law_table, solver_table
from amble.report.page import FigureFile, Page, page_text
from amble.report.tables import number
from tests.hostile import allowed, hostile_name
from tests.synthetic import measured, synthetic_gait


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    samples = samples_of_gait(synthetic_gait())
    return measured([samples.motion({"drop": 1.25 * samples.torques, "pinv": samples.torques})], ACTUATORS.entries)


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_markdown_lines_up_and_escapes() -> None:
    table = Table("T", ("name", "value"), (("a|b", "1.5"), ("long name", "-20")), ("A note.",))
    lines = table.markdown().splitlines()
    assert lines[0] == "**T**"
    body = lines[2:6]
    assert len({len(line) for line in body}) == 1
    assert body[1].endswith("----: |")
    assert body[2].startswith("| a\\|b ")
    assert lines[7] == "A note."


def test_text_lines_up_and_keeps_brackets() -> None:
    table = Table("T", ("name", "value"), (("a [b]", "1.50"), ("c", "-20.00")))
    lines = table.text().splitlines()
    values = [line for line in lines if line.rstrip().endswith("0")]
    assert "a [b]" in values[0]
    assert len(values[0]) == len(values[1])
    assert all(line == line.rstrip() for line in lines)


def test_any_text_is_shown_as_it_is_in_a_terminal() -> None:
    """rich read "[/red]" in a header as the end of a markup that had not begun, and ":x:" as a picture."""
    random = np.random.default_rng(8)
    names = [*filter(allowed, (hostile_name(random) for _ in range(200))), "[red]", "[/red]", ":leg:", "a\\"]
    for name in names:
        table = Table(name, (name, "b"), ((name, "1"),), (name,))
        assert table.text(1000).count(name) == 4


def test_any_text_is_shown_as_it_is_in_markdown() -> None:
    """A parser of Markdown gives back every cell: no link, no tag, no cell more, no line more."""
    from markdown_it import MarkdownIt

    random = np.random.default_rng(9)
    names = [*filter(allowed, (hostile_name(random) for _ in range(200))), "a\\|b", "![a](b)", "<script>", "*a*"]
    page = Page(
        title=names[0],
        summary=(),
        tables=(),
        figures=(FigureFile("figure", names[0]),),
        settings=dict.fromkeys(names, "a\nb"),
        versions={},
    )
    inline = [token for token in MarkdownIt().enable("table").parse(page_text(page)) if token.type == "inline"]
    shown = ["".join(part.content for part in token.children or ()) for token in inline]
    kinds = {part.type for token in inline for part in token.children or ()}
    assert kinds <= {
        "text",
        "text_special",
        "image",
        "em_open",
        "em_close",
        "strong_open",
        "strong_close",
        "link_open",
        "link_close",
    }
    assert shown[0] == names[0]
    cells = shown[shown.index("value") + 1 : shown.index("Versions")]
    assert cells == [text for name in dict.fromkeys(names) for text in (name, "a\\nb")]


def test_ragged_rows_are_refused() -> None:
    with pytest.raises(InputError, match="1 cells, not 2"):
        Table("T", ("a", "b"), (("1",),))


@pytest.mark.parametrize(
    ("value", "text"),
    [(4.532, "4.532"), (66.55, "66.55"), (100.0, "100.0"), (0.0, "0"), (1e-9, "1.000e-09"), (4523.0, "4523")],
)
def test_numbers_keep_their_digits(value: float, text: str) -> None:
    assert number(value) == text


def test_law_table(comparison: Comparison) -> None:
    table = law_table(comparison, "nominal", ["paper", "datasheet"])
    assert [row[0] for row in table.rows] == ["drop", "pinv"]
    assert table.header[1:3] == ("CoT (paper)", "CoT (datasheet)")
    assert float(table.rows[1][2]) == pytest.approx(comparison.of("pinv", "nominal", "datasheet").cot, rel=1e-3)


def test_solver_table() -> None:
    rows = dict(solver_table(synthetic_gait().solver, "W").rows)
    assert (rows["iterations"], rows["variables"], rows["status"]) == ("39", "4", "Solve_Succeeded")


def test_a_notebook_shows_a_table_and_its_notes_as_text() -> None:
    shown = Table("a <title>", ("x", "y"), (("<b>", "1"),), ("a & b",))._repr_html_()
    assert "<caption>a &lt;title&gt;</caption>" in shown
    assert "<td>&lt;b&gt;</td><td>1</td>" in shown
    assert shown.endswith("<p>a &amp; b</p>")
