"""What errors say."""

from __future__ import annotations

import pytest

from amble.errors import NotSolvedError, UnknownNameError, listed
from amble.residual import Residual


def test_a_failed_solver_without_rows_says_nothing_of_rows() -> None:
    assert str(NotSolvedError("no factor")) == "not solved: no factor"


def test_rows_that_all_hold_are_said_to_hold() -> None:
    assert str(NotSolvedError("stopped early", [])) == "not solved: stopped early\nno row is violated"


def test_the_worst_rows_come_first() -> None:
    error = NotSolvedError("stopped", [Residual("a", 0.0, 1.5, 1.0), Residual("b", 0.0, 3.0, 1.0)], most=1)
    lines = str(error).splitlines()
    assert lines[1].endswith("b  (violated by 2)")
    assert lines[2] == "... and 1 more"
    assert error.rows[0].violation == pytest.approx(2.0)


def test_a_list_of_names_is_as_long_as_a_sentence_may_be() -> None:
    assert listed(["a", "b\n"]) == "a, b\\n"
    assert listed([]) == ""
    many = [f"link {number}" for number in range(3000)]
    text = str(UnknownNameError("link", "x", many))
    assert len(text) < 2200
    count = text.count("link ") - 1  # the kind is one of them
    assert text.endswith(f" and {3000 - count} more")
