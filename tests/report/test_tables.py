"""Tables: alignment, escaping, the paper's numbers."""

import numpy as np
import pytest

from amble.analysis import Comparison, ContactBounds, contact_report, samples_of_gait
from amble.control.actuator import ACTUATORS
from amble.errors import InputError, UnknownNameError
from amble.report import Table, contact_rows, contact_summary, law_table, paper_table, solver_table
from amble.report.page import FigureFile, Page, page_text
from amble.report.paper_table import PAPER_REDUCTION, PAPER_ROWS, WHY_DIFFERENT
from amble.report.tables import number
from tests.hostile import allowed, hostile_name
from tests.synthetic import amble_pattern, measured, synthetic_gait, synthetic_trace


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


def test_published_reductions_follow_from_the_published_rows() -> None:
    """The paper's own percentages, so that a mistyped constant shows."""
    for name in ("cot", "peak_torque", "rms_torque"):
        before, after = (getattr(PAPER_ROWS[law], name) for law in ("drop", "pinv"))
        assert 100.0 * (before - after) / before == pytest.approx(getattr(PAPER_REDUCTION, name), abs=0.05)


def test_paper_table_has_every_number_with_its_actuator(comparison: Comparison) -> None:
    table = paper_table(comparison, ["nominal"], ["paper", "datasheet"])
    rows = {(row[0][:5], row[1], row[2]): row[3:] for row in table.rows}
    assert len(rows) == len(table.rows) == 9
    assert rows["Ma et", "paper", "paper"] == ("6.389", "83.97", "9.659")
    assert rows["propo", "paper", "paper"] == ("4.532", "66.55", "7.932")
    assert rows["reduc", "paper", "paper"] == ("29.1", "20.7", "17.9")
    for actuator in ("paper", "datasheet"):
        entry = comparison.of("pinv", "nominal", actuator)
        assert float(rows["propo", "ours, nominal", actuator][0]) == pytest.approx(entry.cot, rel=1e-3)
        # all torques are a quarter larger
        assert rows["reduc", "ours, nominal", actuator][1:] == ("20.0", "20.0")
    assert table.notes == (WHY_DIFFERENT,)
    assert WHY_DIFFERENT.count(". ") == 0
    with pytest.raises(UnknownNameError, match="unknown motion"):
        paper_table(comparison, ["simulated"], ["paper"])


def test_law_table(comparison: Comparison) -> None:
    table = law_table(comparison, "nominal", ["paper", "datasheet"])
    assert [row[0] for row in table.rows] == ["drop", "pinv"]
    assert table.header[1:3] == ("CoT (paper)", "CoT (datasheet)")
    assert float(table.rows[1][2]) == pytest.approx(comparison.of("pinv", "nominal", "datasheet").cot, rel=1e-3)


def test_contact_tables() -> None:
    trace = synthetic_trace(3)
    force = trace.signals["force"].copy()
    pattern = amble_pattern()
    row = int(np.flatnonzero((trace.domain == 1) & (trace.cycle == 1))[3])
    force[row, 3 * pattern.robot.foot_names.index("fr") + 2] = -3.5
    trace.signals["force"] = force
    report = contact_report(trace, pattern, ContactBounds.of_gait(synthetic_gait()))
    summary = contact_summary(report)
    assert summary.rows[0] == ("smallest normal force of a stance foot (N)", "-3.500")
    assert "from cycle 2 on" in summary.notes[0]
    violated = contact_rows(report, only_violations=True)
    assert [each[0] for each in violated.rows] == ["D2 fr friction", "D2 fr normal force"]  # no friction holds a pull
    assert violated.rows[0][1:5] == ("0", "inf", "0.6000", "inf")
    assert violated.rows[1][1:5] == ("0", "-3.500", "-", "3.500")
    assert violated.rows[1][6] == "1"
    assert len(contact_rows(report).rows) == len(report.rows)


def test_solver_table() -> None:
    rows = dict(solver_table(synthetic_gait().solver, "W").rows)
    assert (rows["iterations"], rows["variables"], rows["status"]) == ("39", "4588", "Solve_Succeeded")
