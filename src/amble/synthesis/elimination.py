"""Order in which the unknowns of a gait program are eliminated from its KKT systems, read off its layout.

At a node every unknown that is no state of the collocation follows from a row there: the controlled coordinates each
from its curve, the others together. The states of an interval's later nodes follow from its defect rows. What is left,
the end, are the states at the entry of every domain, durations, curves, numbers of phases, impulses and the period,
with the rows between domains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.synthesis.layout import DomainLayout
from amble.synthesis.program import GaitProgram
from amble.synthesis.rows import INITIAL_VALUE, RowKind

Index = NDArray[np.int64]

NODE_KINDS = ("q", "v", "a", "u", "force")
FREE = -1
"""Node of what belongs to no node."""


class NotSquareError(Exception):
    """Rows and unknowns of a node or an interval do not pair; the message says where."""


@dataclass(frozen=True, kw_only=True)
class Pattern:
    """Nonzeros of the Jacobian, row by row and column by column; rows in IPOPT's order.

    Attributes:
        rows: row of every nonzero, column by column: equalities, fixed variables, inequalities.
        columns: its column.
        equalities: number of equalities, fixed variables among them.
        row_numbers: row of the program of every row; -1 - variable for a fixed one.
    """

    rows: Index
    columns: Index
    equalities: int
    row_numbers: Index


@dataclass(frozen=True, kw_only=True)
class DomainElimination:
    """Elimination of one domain; local order of a node: states, explicit, read parameters, implicit.

    Attributes:
        states: variables that defect rows determine, (nodes, n_s).
        explicit: variables of rows that read nothing else but parameters, (nodes, n_e).
        implicit: the other variables of a node, (nodes, n_y).
        explicit_rows: rows of the explicit variables, (nodes, n_e).
        implicit_rows: rows of the implicit variables, (nodes, n_y).
        defect_rows: rows of an interval, (intervals, n_s stages).
        parameters: the domain's own variables and the period, (n_t,).
        read: parameters that implicit rows or the Hessian of a node read, (n_h,) places in ``parameters``.
        curves: for every explicit row the parameters that it reads, places in ``parameters``.
        rates: what defect rows read beside states, (n_a,) places in ``unknowns``.
        shared: parameters that defect rows read, places in ``parameters``.
    """

    states: Index
    explicit: Index
    implicit: Index
    explicit_rows: Index
    implicit_rows: Index
    defect_rows: Index
    parameters: Index
    read: Index
    curves: tuple[Index, ...]
    rates: Index
    shared: Index

    @property
    def unknowns(self) -> Index:
        """Variables of the nodes in their local order, without the parameters, (nodes, n)."""
        return np.hstack([self.states, self.explicit, self.implicit])

    @property
    def places(self) -> Index:
        """Local place of each of ``unknowns``."""
        place = np.arange(self.unknowns.shape[1])
        place[self.states.shape[1] + self.explicit.shape[1] :] += self.read.size
        return place

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return int(self.states.shape[0])

    @property
    def intervals(self) -> int:
        """Number of intervals."""
        return int(self.defect_rows.shape[0])

    @property
    def stages(self) -> int:
        """Nodes of an interval but its first."""
        return (self.nodes - 1) // self.intervals

    @property
    def curve_starts(self) -> Index:
        """Where the parameters of every explicit row begin when those of all follow each other, and their end."""
        return np.cumsum([0, *(curve.size for curve in self.curves)])


def jacobian_pattern(program: GaitProgram) -> Pattern:
    """Return the pattern of the Jacobian as IPOPT sees it where fixed variables are held by rows of their own."""
    nlp = program.program
    equal = nlp.equalities
    fixed = np.flatnonzero(program.lower == program.upper)
    numbers = np.concatenate([np.flatnonzero(equal), -1 - fixed, np.flatnonzero(~equal)])
    place = np.zeros(equal.size, dtype=np.int64)
    listed = numbers >= 0
    place[numbers[listed]] = np.flatnonzero(listed)
    rows, columns = (np.array(part, dtype=np.int64) for part in nlp.jacobian.sparsity_out(1).get_triplet())
    rows = np.concatenate([place[rows], np.flatnonzero(~listed)])
    columns = np.concatenate([columns, fixed])
    order = np.lexsort((rows, columns))
    return Pattern(
        rows=rows[order], columns=columns[order], equalities=int(equal.sum()) + fixed.size, row_numbers=numbers
    )


def owners(program: GaitProgram) -> tuple[Index, Index]:
    """Return domain and node of every variable, (n_x,) each; ``FREE`` for what belongs to none."""
    domain, node = np.full((2, program.layout.size), FREE)
    for number, layout in enumerate(program.layout.domains):
        for kind in NODE_KINDS:
            places = getattr(layout, kind)
            domain[places] = number
            node[places] = np.arange(layout.nodes)[:, None]
    return domain, node


def eliminations(program: GaitProgram, pattern: Pattern) -> tuple[DomainElimination, ...]:
    """Return the elimination of every domain.

    Raises:
        NotSquareError: rows and unknowns do not pair.
    """
    domain, node = owners(program)
    rows = _Rows.of(pattern, domain, node)
    numbers = pattern.row_numbers[: pattern.equalities]
    kinds = np.where(numbers >= 0, program.program.row_kinds[numbers], "fixed")
    inside, defect = np.isin(kinds, INITIAL_VALUE), kinds == RowKind.DEFECT
    return tuple(
        _domain(
            program,
            rows,
            number,
            np.flatnonzero(inside & ~defect & (rows.domain == number)),
            np.flatnonzero(defect & (rows.domain == number)),
        )
        for number in range(len(program.layout.domains))
    )


@dataclass(frozen=True, kw_only=True)
class _Rows:
    """Columns of every equality row, and what follows from them.

    Attributes:
        start: first place of every row in ``columns``, and the end.
        columns: variables that the rows read, row by row.
        domain: domain of the nodes that a row reads, ``FREE`` where it reads none.
        first: first node that it reads.
        own: how many variables of nodes it reads.
        variable: the last of them.
    """

    start: Index
    columns: Index
    domain: Index
    first: Index
    own: Index
    variable: Index

    @classmethod
    def of(cls, pattern: Pattern, domain: Index, node: Index) -> _Rows:
        keep = pattern.rows < pattern.equalities
        order = np.argsort(pattern.rows[keep], kind="stable")
        counts = np.bincount(pattern.rows[keep], minlength=pattern.equalities)
        if not counts.all():
            raise NotSquareError("an equation reads no variable")
        start = np.concatenate([[0], np.cumsum(counts)])
        columns = pattern.columns[keep][order]
        at, inside = start[:-1], node[columns] != FREE
        return cls(
            start=start,
            columns=columns,
            domain=np.maximum.reduceat(domain[columns], at),
            first=np.minimum.reduceat(np.where(inside, node[columns], np.iinfo(np.int64).max), at),
            own=np.add.reduceat(inside.astype(np.int64), at),
            variable=np.maximum.reduceat(np.where(inside, columns, FREE), at),
        )

    def read(self, rows: Index) -> Index:
        """Variables that some rows read, row by row."""
        counts = self.start[rows + 1] - self.start[rows]
        offsets = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        return self.columns[np.repeat(self.start[rows], counts) + offsets]


def _domain(program: GaitProgram, rows: _Rows, number: int, inner: Index, defects: Index) -> DomainElimination:
    layout = program.layout.domains[number]
    parameters = np.concatenate([layout.duration, layout.coefficients, layout.phase_numbers, program.layout.period])
    at = np.full(program.layout.size, FREE)
    at[parameters] = np.arange(parameters.size)
    every = np.hstack([getattr(layout, kind) for kind in NODE_KINDS])
    read_by_defects = np.isin(every, rows.read(defects)).any(axis=0)
    is_state = read_by_defects & np.isin(every[0], np.hstack([layout.q[0], layout.v[0]]))
    states = every[:, is_state]
    explicit_rows = _explicit(rows, inner, states)
    explicit = rows.variable[explicit_rows]
    is_explicit = np.isin(every, explicit)
    if not (is_explicit == is_explicit[0]).all():
        raise NotSquareError(f"the nodes of {layout.stance.name} have different rows")
    explicit_rows = explicit_rows[np.argsort(explicit)].reshape(layout.nodes, -1)
    left = np.setdiff1d(inner, explicit_rows)
    left = left[np.argsort(rows.first[left], kind="stable")]
    is_implicit = ~is_state & ~is_explicit[0]
    counts, wanted = np.bincount(rows.first[left], minlength=layout.nodes), int(is_implicit.sum())
    if (counts != wanted).any():
        odd = int(np.argmax(counts != wanted))
        raise NotSquareError(f"{layout.place(odd)}: {counts[odd]} rows for {wanted} unknowns")
    local = np.concatenate([np.flatnonzero(part) for part in (is_state, is_explicit[0], is_implicit)])
    shared = np.unique(at[rows.read(defects)])
    return DomainElimination(
        states=states,
        explicit=every[:, is_explicit[0]],
        implicit=every[:, is_implicit],
        explicit_rows=explicit_rows,
        implicit_rows=left.reshape(layout.nodes, -1),
        defect_rows=_intervals(rows, defects, program.problem.intervals, (layout.nodes - 1) * states.shape[1]),
        parameters=parameters,
        read=_read(program, rows.read(left), every, at),
        curves=_curves(rows, explicit_rows, at, layout),
        rates=np.flatnonzero((read_by_defects & ~is_state)[local]),
        shared=shared[shared >= 0],
    )


def _explicit(rows: _Rows, inner: Index, states: Index) -> Index:
    """Rows of nodes that read one variable of the node, which is no state; one row a variable."""
    alone = inner[(rows.own[inner] == 1) & ~np.isin(rows.variable[inner], states)]
    return alone[np.unique(rows.variable[alone], return_index=True)[1]]


def _curves(rows: _Rows, explicit_rows: Index, at: Index, layout: DomainLayout) -> tuple[Index, ...]:
    """Parameters that each explicit row reads, the same at every node."""
    found = []
    for column in explicit_rows.T:
        places = at[rows.read(column)]
        places = places[places >= 0]
        if (
            places.size % layout.nodes
            or (places.reshape(layout.nodes, -1) != places[: places.size // layout.nodes]).any()
        ):
            raise NotSquareError(f"the nodes of {layout.stance.name} read different parameters")
        found.append(np.sort(places[: places.size // layout.nodes]))
    return tuple(found)


def _read(program: GaitProgram, by_rows: Index, every: Index, at: Index) -> Index:
    """Parameters that implicit rows, inequality rows or the Hessian of nodes read."""
    mine = np.zeros(at.size, dtype=bool)
    mine[every] = True
    rows, columns = (np.array(part) for part in program.program.hessian.sparsity_out(0).get_triplet())
    beside = np.concatenate([rows[mine[columns]], columns[mine[rows]]])
    rows, columns = (np.array(part) for part in program.program.jacobian.sparsity_out(1).get_triplet())
    touched = np.zeros(program.program.equalities.size, dtype=bool)
    touched[rows[mine[columns]]] = True
    by_inequalities = columns[(touched & ~program.program.equalities)[rows]]
    places = np.unique(at[np.concatenate([by_rows, beside, by_inequalities])])
    return np.asarray(places[places >= 0])


def _intervals(rows: _Rows, defects: Index, count: int, expected: int) -> Index:
    """Defect rows by interval, whose first node every one of them reads."""
    starts, sizes = np.unique(rows.first[defects], return_counts=True)
    if starts.size != count or (sizes * count != expected).any():
        raise NotSquareError(f"the defect rows do not pair with the states of {count} intervals")
    return defects[np.argsort(rows.first[defects], kind="stable")].reshape(count, -1)
