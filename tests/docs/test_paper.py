"""The draft of the software paper: the form that the journal asks for, and sources that exist."""

from __future__ import annotations

import re
from pathlib import Path

PAPER = Path(__file__).parents[2] / "paper"


def test_what_is_cited_is_in_the_bibliography_and_the_other_way_round() -> None:
    text = (PAPER / "paper.md").read_text(encoding="utf-8")
    body = text.split("---", 2)[2]
    cited = set(re.findall(r"@(\w+)", body))
    assert cited == set(re.findall(r"^@\w+\{(\w+),", (PAPER / "paper.bib").read_text(encoding="utf-8"), re.MULTILINE))


def test_it_has_the_sections_of_the_journal_and_its_figures() -> None:
    text = (PAPER / "paper.md").read_text(encoding="utf-8")
    headings = re.findall(r"^# (.+)$", text, re.MULTILINE)
    assert {"Summary", "Statement of need", "State of the field", "References"} <= set(headings)
    for figure in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text):
        assert (PAPER / figure).is_file()
    assert 250 <= len(text.split("---", 2)[2].split()) <= 1750
