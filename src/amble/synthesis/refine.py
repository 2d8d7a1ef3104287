"""A gait on a finer mesh: the same motion, its transcription error divided by the refinement to the scheme's order.

Nothing is optimised again. First every domain is an initial value problem, solved by Newton on the rows of the gait
problem. What is then left at the switches is the error of the coarse mesh; entries, curves and durations take the
smallest change that removes it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from amble.amounts import check_amount
from amble.errors import NotSolvedError
from amble.gait import Gait
from amble.progress import Progress, ProgressReport, silent
from amble.synthesis.layout import DomainLayout
from amble.synthesis.problem import MOST_INTERVALS, GaitProblem
from amble.synthesis.program import GaitProgram, build_program
from amble.synthesis.result import from_gait, to_gait
from amble.synthesis.rows import AT_ENTRY, INITIAL_VALUE
from amble.synthesis.solve import Solution
from amble.synthesis.violated_rows import violated_rows
from amble.types import Matrix, Vector

TOLERANCE = 1e-9
"""Largest residual of an equality row that is left, in the scaled problem."""

NEAR = 1e-6
"""Residual of the initial value problems below which entries, curves and durations may change as well."""

MOST_STEPS = 20

Index = NDArray[np.int64]


def refine(problem: GaitProblem, gait: Gait, factor: int = 2, progress: Progress | None = None) -> Gait:
    """Return the gait with ``factor`` times as many intervals.

    Limits are not imposed again: where the gait runs along one, a new node may lie outside by as much as the motion
    did between the old ones. The solver's report and multipliers stay those of the optimisation, but for objective and
    violation.

    Args:
        problem: the problem that the gait solves.
        gait: the gait.
        factor: how many new intervals for each old one, at least 2.
        progress: called after every Newton step.

    Raises:
        InputError: the factor is less than 2, or the mesh has more than 10,000 intervals a domain.
        NotSolvedError: Newton does not converge; the error names the rows.
    """
    check_amount("new intervals for each old one", factor, 2, MOST_INTERVALS)
    intervals = gait.domains[0].intervals
    program = build_program(replace(problem, intervals=factor * intervals, scheme=gait.scheme))
    x = from_gait(program.problem, gait, program.layout) / program.layout.scale
    split, notify = Split.of(program), progress or silent
    for number in range(MOST_STEPS):
        step, worst = _step(program, split, x)
        notify(ProgressReport(what="finer mesh, step", done=number, quantity="residual", value=worst))
        if worst < TOLERANCE:
            return to_gait(program.problem, program.layout, _solution(program, gait, x))
        x = x - step
    values = np.asarray(program.program.nlp(x, program.parameters)[1]).ravel()
    raise NotSolvedError("the finer mesh does not converge", violated_rows(program, x, values))


@dataclass(frozen=True)
class Split:
    """The equality rows and the free variables, each in two parts.

    Attributes:
        inner_rows: rows of the nodes and intervals: as many as there are inner variables.
        inner: everything at the nodes but the entries, so that the inner rows are initial value problems.
        outer_rows: rows of entries, switches and the period.
        outer: entries, curves, durations and impulses.
    """

    inner_rows: Index
    inner: Index
    outer_rows: Index
    outer: Index

    @classmethod
    def of(cls, program: GaitProgram) -> Split:
        """Split the rows of a program by their kinds."""
        nlp = program.program
        # Where the entry lies on the curves is a matter of the entry; the accelerations there belong to the node.
        at_entry = np.isin(nlp.row_kinds, AT_ENTRY) & (nlp.row_instances == 0)
        inside = np.isin(nlp.row_kinds, INITIAL_VALUE) & ~at_entry
        inner = np.concatenate([_inner_variables(domain) for domain in program.layout.domains])
        free = np.flatnonzero(program.lower < program.upper)
        return cls(
            inner_rows=np.flatnonzero(inside & nlp.equalities),
            inner=inner,
            outer_rows=np.flatnonzero(~inside & nlp.equalities),
            outer=np.setdiff1d(free, inner),
        )


def _inner_variables(domain: DomainLayout) -> Index:
    kinds = (domain.q[1:], domain.v[1:], domain.a, domain.u, domain.force)
    return np.concatenate([places.ravel() for places in kinds])


def _step(program: GaitProgram, split: Split, x: Vector) -> tuple[Vector, float]:
    """Return a Newton step and the largest residual; with J = [A B; C E] in inner and outer parts, by elimination.

    The outer step is the smallest solution of (E - C A^-1 B) d = r_outer - C A^-1 r_inner.
    """
    from scipy.sparse.linalg import splu

    residual, rows = program.program.linearised(x, program.parameters)
    upper, lower = rows[split.inner_rows].tocsc(), rows[split.outer_rows].tocsc()
    # shorthand
    A, B = splu(upper[:, split.inner]), upper[:, split.outer].toarray()
    C, E = lower[:, split.inner], lower[:, split.outer].toarray()
    inner, outer = residual[split.inner_rows], residual[split.outer_rows]

    step, change = np.zeros(x.size), A.solve(inner)
    if np.abs(inner).max() < NEAR:
        spread: Matrix = A.solve(B)
        step[split.outer] = np.linalg.lstsq(E - C @ spread, outer - C @ change, rcond=None)[0]
        change = change - spread @ step[split.outer]
    step[split.inner] = change
    return step, float(max(np.abs(inner).max(), np.abs(outer).max()))


def _solution(program: GaitProgram, gait: Gait, x: Vector) -> Solution:
    nlp = program.program
    cost, rows = nlp.nlp(x, program.parameters)
    values = np.asarray(rows).ravel()
    equal = nlp.equalities
    report = replace(
        gait.solver,
        violation=float(np.abs(values[equal] - nlp.lower[equal]).max()),
        objective=nlp.cost_scale * float(cost),
    )
    rows = violated_rows(program, x, values)
    return Solution(variables=x, multipliers=gait.multipliers, report=report, rows=rows, solved=True)
