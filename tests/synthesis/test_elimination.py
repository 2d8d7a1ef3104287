"""The order of elimination: every variable and every equation once, as many rows as unknowns; what does not pair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.synthesis.elimination import NotSquareError, eliminations, jacobian_pattern
from amble.synthesis.layout import DomainLayout
from amble.synthesis.program import GaitProgram
from amble.synthesis.rows import RowKind


def test_unknowns_and_rows_are_eliminated_once_and_pair(small_program: GaitProgram) -> None:
    pattern = jacobian_pattern(small_program)
    domains = eliminations(small_program, pattern)
    for layout, d in zip(small_program.layout.domains, domains, strict=True):
        own = np.concatenate([getattr(layout, kind).ravel() for kind in ("q", "v", "a", "u", "force")])
        assert sorted(d.unknowns.ravel()) == sorted(own)
        assert d.explicit_rows.shape == d.explicit.shape
        assert d.implicit_rows.shape == d.implicit.shape
        assert d.defect_rows.size == d.states[1:].size
        assert d.stages == 2
    rows = np.concatenate([r.ravel() for d in domains for r in (d.explicit_rows, d.implicit_rows, d.defect_rows)])
    assert np.unique(rows).size == rows.size
    kinds = small_program.program.row_kinds[pattern.row_numbers[np.setdiff1d(np.arange(pattern.equalities - 1), rows)]]
    assert set(kinds) == {"impact", "continuity", "touchdown", "period"}  # the rows between domains are left


def test_what_follows_from_curves_is_explicit(small_program: GaitProgram) -> None:
    """Controlled coordinates with their rates; each row reads the duration and the coefficients of one coordinate."""
    d = eliminations(small_program, jacobian_pattern(small_program))[0]
    layout = small_program.layout.domains[0]
    outputs = len(small_program.problem.outputs.of(layout.stance.name).coordinates)
    assert d.explicit.shape[1] == 3 * outputs
    assert {curve.size for curve in d.curves} <= set(range(1, small_program.problem.outputs.order + 3))
    assert set(d.parameters[d.read]) == {int(layout.duration[0]), int(small_program.layout.period[0])}


def test_fixed_variables_have_rows_of_their_own(small_program: GaitProgram) -> None:
    pattern = jacobian_pattern(small_program)
    fixed = np.flatnonzero(small_program.lower == small_program.upper)
    assert fixed.size
    numbers = pattern.row_numbers[: pattern.equalities]
    assert list(-1 - numbers[numbers < 0]) == list(fixed)
    row = int(np.flatnonzero(pattern.row_numbers == -1 - fixed[0])[0])
    assert list(pattern.columns[pattern.rows == row]) == [fixed[0]]


def _node(layout: DomainLayout) -> str:
    return layout.place(3)


@pytest.mark.parametrize(
    ("kind", "says"), [(RowKind.LAW, "D1 node 3: 24 rows for 25 unknowns"), (RowKind.DEFECT, "the defect rows do not")]
)
def test_rows_that_do_not_pair_are_named(small_program: GaitProgram, kind: RowKind, says: str) -> None:
    """One row counts as one of another kind, so that it is missing."""
    nlp = small_program.program
    kinds = nlp.row_kinds.copy()
    place = _node(small_program.layout.domains[0]) if kind == RowKind.LAW else "D1 interval 1"
    kinds[[name.startswith(f"{place} {kind}") for name in nlp.row_names].index(True)] = RowKind.PERIOD
    changed = replace(small_program, program=replace(nlp, row_kinds=kinds))
    with pytest.raises(NotSquareError, match=says):
        eliminations(changed, jacobian_pattern(changed))
