"""One record for every checked quantity: violation, slack, order and text."""

from __future__ import annotations

from math import inf, nan

import numpy as np
import pytest

from amble.errors import CertificateError, NotSolvedError
from amble.residual import Residual, listing, worst_first, worst_of_kinds


@pytest.mark.parametrize(
    ("value", "violation", "passed"),
    [(-1.0, 0.0, True), (2.0, 0.0, True), (2.5, 0.5, True), (2.75, 0.75, False), (-4.0, 3.0, False), (nan, inf, False)],
)
def test_a_value_passes_within_bounds_and_slack(value: float, violation: float, passed: bool) -> None:
    residual = Residual("force", -1.0, value, 2.0, slack=0.5)
    assert residual.violation == violation
    assert residual.passed is passed
    assert residual.widened().passed is passed


def test_worst_first_sorts_by_failure_and_violation() -> None:
    generator = np.random.default_rng(5)
    drawn = [
        Residual(str(k), np.sort(generator.normal(size=2)).round(1)[0], generator.normal(), 1.0, slack=slack)
        for k, slack in enumerate(generator.choice([0.0, 0.5], 60))
    ]
    ordered = worst_first(drawn)
    assert sorted(drawn, key=lambda r: int(r.name)) == sorted(ordered, key=lambda r: int(r.name))
    fails = [not residual.passed for residual in ordered]
    assert fails == sorted(fails, reverse=True)
    failing = [residual.violation for residual in ordered if not residual.passed]
    assert len(failing) > 5
    assert failing == sorted(failing, reverse=True)
    assert worst_first([*drawn, Residual("none", 0.0, nan, 1.0)])[0].name == "none"


def test_of_those_that_pass_the_nearest_to_its_bounds_is_worst() -> None:
    rows = [
        Residual("far", -2.0, 0.5, 2.0, kind="rate"),
        Residual("near", -4.0, -3.9, 4.0, kind="rate"),
        Residual("only", 0.0, 1.0, inf, kind="force"),
    ]
    assert {kind: row.name for kind, row in worst_of_kinds(rows).items()} == {"rate": "near", "force": "only"}


def test_the_text_has_bounds_value_place_and_violation() -> None:
    residual = Residual("D1 friction fl", 0.0, 0.75, 0.5, time=0.125, cycle=3)
    assert str(residual).split() == (
        [
            "0",
            "|",
            "0.75",
            "|",
            "0.5",
            "D1",
            "friction",
            "fl",
            "at",
            "0.1250",
            "s,",
            "cycle",
            "3",
            "(violated",
            "by",
            "0.25)",
        ]
    )
    assert str(Residual("a", 0.0, 0.1, 0.5)).endswith("   a")
    assert listing([residual] * 5, 2).splitlines()[-1] == "... and 3 more"


def test_a_failure_without_rows_claims_nothing_about_rows() -> None:
    """A failed solver that told no rows was said to violate none."""
    assert str(NotSolvedError("Invalid_Number")) == "not solved: Invalid_Number"
    rows = [Residual("small", 0.0, 1.0, 0.5), Residual("large", 0.0, 3.0, 0.5)]
    error = NotSolvedError("Infeasible", rows)
    assert [row.name for row in error.rows] == ["large", "small"]
    assert str(error).splitlines()[1] == str(rows[1])


def test_a_certificate_counts_what_fails_beyond_its_slack() -> None:
    rows = [Residual("a", 0.0, 1.1, 1.0, slack=0.2), Residual("b", 0.0, 1.3, 1.0, slack=0.2)]
    error = CertificateError(rows)
    assert "1 of 2 conditions fail" in str(error)
    assert error.rows == tuple(rows)
