"""The plan that the C code of the structured KKT solver works by: where every number of a KKT system goes.

Numbers are grouped into blocks: one a node, one an interval, one for the end. In each they have a place; the layout
of a block is that of structured_kkt.c.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amble.synthesis.elimination import FREE, DomainElimination, Pattern, eliminations, jacobian_pattern
from amble.synthesis.kkt_places import Places
from amble.synthesis.kkt_structures import INTEGERS, DomainPlan, KeptPlan, Plan
from amble.synthesis.program import GaitProgram, Structure

Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


def build_plan(program: GaitProgram) -> KeptPlan:
    """Return the plan of a program, built once for all of its structure.

    Raises:
        NotSquareError: rows and unknowns of a node or an interval do not pair.
    """
    return _plan(Structure.of(program))


@lru_cache(maxsize=16)
def _plan(structure: Structure) -> KeptPlan:
    program = structure.program
    pattern = jacobian_pattern(program)
    domains = eliminations(program, pattern)
    return _Builder(program, pattern, domains).build()


class _Builder:
    """Fills a plan, part by part; lives only while it is built."""

    def __init__(self, program: GaitProgram, pattern: Pattern, domains: tuple[DomainElimination, ...]) -> None:
        self.pattern, self.domains = pattern, domains
        self.places = Places.of(program, domains)
        self.hessian = tuple(np.array(x, np.int64) for x in program.program.hessian.sparsity_out(0).get_triplet())
        inner = [rows.ravel() for d in domains for rows in (d.explicit_rows, d.implicit_rows, d.defect_rows)]
        self.end_rows = np.setdiff1d(np.arange(pattern.equalities), np.concatenate(inner))
        self.end_variables = int(self.places.end.max()) + 1
        self.end_size = self.end_variables + self.end_rows.size
        self.nodes, self.intervals = (sum(getattr(d, what) for d in domains) for what in ("nodes", "intervals"))
        self.plan = Plan()
        self.arrays: list[Any] = []

    def build(self) -> KeptPlan:
        plan, places = self.plan, self.places
        plan.variables, plan.equalities = places.end.size, self.pattern.equalities
        plan.inequalities = self.pattern.row_numbers.size - self.pattern.equalities
        plan.end_variables, plan.end_rows = self.end_variables, self.end_rows.size
        self._domains()
        self._hessian_and_jacobian()
        pure = (places.node == FREE) & (places.end >= 0)
        self._put(
            plan,
            end_index=np.where(pure, places.end, FREE),
            end_row=self.end_rows,
            variable_node=places.node,
            variable_place=places.local,
        )
        return KeptPlan(plan, self.arrays)

    def _put(self, target: ctypes.Structure, **arrays: Index) -> None:
        for name, array in arrays.items():
            kept = np.ascontiguousarray(array, dtype=np.int32).ravel()
            self.arrays.append(kept)
            setattr(target, name, kept.ctypes.data_as(INTEGERS))

    def _domains(self) -> None:
        plans = (DomainPlan * len(self.domains))()
        for target, d in zip(plans, self.domains, strict=True):
            target.nodes, target.intervals, target.stages = d.nodes, d.intervals, d.stages
            target.ns, target.ne, target.ny = d.states.shape[1], d.explicit.shape[1], d.implicit.shape[1]
            target.nh, target.nt, target.na, target.nd = d.read.size, d.parameters.size, d.rates.size, d.shared.size
            self._put(
                target,
                end=self.places.end[np.concatenate([d.states[0], d.parameters])],
                read=d.read,
                c_start=d.curve_starts,
                c_column=_joined(d.curves),
                defect=d.shared,
                rate=d.places[d.rates],
                variable=d.unknowns,
                explicit_row=d.explicit_rows,
                implicit_row=d.implicit_rows,
                defect_row=d.defect_rows,
            )
        self.arrays.append(plans)
        self.plan.domains, self.plan.domain = len(plans), plans

    def _hessian_and_jacobian(self) -> None:
        """Place both; what goes over unknowns of nodes into the end is kept in lists, which share the tips."""
        rows, columns = self.pattern.rows, self.pattern.columns
        block, place = np.full((2, rows.size), FREE)
        h_block, h_place, crosses = self._hessian()
        self._inner_rows(block, place)
        nodal, others = self._inequalities()
        link = np.isin(rows, self.end_rows) & (self.places.end[columns] < 0)
        over = np.isin(rows, others) & (self.places.end[columns] < 0)
        first = np.unique(crosses[0])
        second = crosses[1][self.places.end[crosses[1]] < 0]
        tips = np.concatenate([first, np.setdiff1d(_joined([second, columns[link], columns[over]]), first)])
        at = np.full(self.places.end.size, FREE)
        at[tips] = np.arange(tips.size)
        plan, end = self.plan, self.places.end
        plan.tips, plan.cross_tips, plan.crosses, plan.links = tips.size, first.size, crosses[0].size, int(link.sum())
        plan.end_inequalities = others.size
        whole = self.end_size**2
        row_at = np.full(self.pattern.row_numbers.size, FREE)
        row_at[self.end_rows] = np.arange(self.end_rows.size)
        direct = np.isin(rows, self.end_rows) & ~link
        place[direct] = end[columns[direct]] * self.end_size + self.end_variables + row_at[rows[direct]]
        place[link] = whole + plan.crosses + np.arange(plan.links)
        block[direct | link] = self.end_block
        self._place_inequalities(block, place, nodal, others, whole + plan.crosses + plan.links, at)
        self._put(
            plan,
            tip_variable=tips,
            cross_tip=at[crosses[0]],
            cross_other=np.where(end[crosses[1]] >= 0, -1 - end[crosses[1]], at[crosses[1]]),
            link_row=row_at[rows[link]],
            link_tip=at[columns[link]],
            jacobian_start=_starts(columns, end.size),
            jacobian_row=rows,
            jacobian_block=block,
            jacobian_place=place,
            hessian_start=_starts(self.hessian[1], end.size),
            hessian_row=self.hessian[0],
            hessian_block=h_block,
            hessian_place=h_place,
        )

    @property
    def end_block(self) -> int:
        """Number of the block of the end."""
        return self.nodes + self.intervals

    def _widths(self) -> Index:
        """Width of the local order of every domain."""
        return np.array([d.unknowns.shape[1] + d.read.size for d in self.domains])

    def _hessian(self) -> tuple[Index, Index, tuple[Index, Index]]:
        """Blocks and places of the Hessian's nonzeros and the diagonal, and the pairs that cross."""
        p, (rows, columns), size = self.places, self.hessian, self.end_size
        of_row, of_column = p.domain[rows], p.domain[columns]
        number = np.maximum(of_row, of_column)
        a, b = p.in_node(number, rows), p.in_node(number, columns)
        node = np.maximum(p.node[rows], p.node[columns])
        alone = (p.node[rows] == p.node[columns]) | (np.minimum(p.node[rows], p.node[columns]) == FREE)
        nodal = (number != FREE) & alone & (a >= 0) & (b >= 0)
        ends = ~nodal & (p.end[rows] >= 0) & (p.end[columns] >= 0)
        cross = ~nodal & ~ends
        block = np.where(nodal, node, self.end_block)
        width = self._widths()[number]
        place = np.where(nodal, np.minimum(a, b) * width + np.maximum(a, b), FREE)
        low, high = np.minimum(p.end[rows], p.end[columns]), np.maximum(p.end[rows], p.end[columns])
        place[ends] = (low * size + high)[ends]
        place[cross] = size**2 + np.arange(cross.sum())
        everything = np.arange(p.end.size)
        of_node = p.node >= 0
        self._put(
            self.plan,
            diagonal_block=np.where(of_node, p.node, self.end_block),
            diagonal_place=np.where(of_node, p.local[everything] * (self._widths()[p.domain] + 1), p.end * (size + 1)),
        )
        one, other = rows[cross], columns[cross]
        swap = (p.end[one] >= 0) | ((p.end[other] < 0) & (p.stage[other] > p.stage[one]))
        return block, place, (np.where(swap, other, one), np.where(swap, one, other))

    def _inner_rows(self, block: Index, place: Index) -> None:
        """Place the nonzeros of the equality rows of nodes and intervals."""
        p, rows, columns = self.places, self.pattern.rows, self.pattern.columns
        node, interval = 0, self.nodes
        for number, d in enumerate(self.domains):
            width, implicit = self._widths()[number], d.implicit.shape[1]
            at, index = _index(rows, d.implicit_rows)
            block[at] = node + index // max(implicit, 1)
            place[at] = width**2 + p.in_node(np.array(number), columns[at]) * implicit + index % max(implicit, 1)
            at, index = _index(rows, d.explicit_rows)
            count = d.explicit.shape[1]
            block[at] = node + index // max(count, 1)
            place[at] = width**2 + implicit * width + self._in_curves(d, columns[at], index % max(count, 1))
            at, index = _index(rows, d.defect_rows)
            size = d.defect_rows.shape[1]
            which = index // size
            block[at] = interval + which
            place[at] = self._defect_columns(d, columns[at], which) * size + index % size
            node += d.nodes
            interval += d.intervals

    def _in_curves(self, d: DomainElimination, columns: Index, row: Index) -> Index:
        """Places in a node's explicit rows: their diagonal first, then what they read of the parameters."""
        count, at = d.explicit.shape[1], np.full(self.places.end.size, FREE)
        at[d.parameters] = np.arange(d.parameters.size)
        table = np.full((count, d.parameters.size + 1), FREE)
        table[np.repeat(np.arange(count), np.diff(d.curve_starts)), _joined(d.curves)] = np.arange(d.curve_starts[-1])
        return np.where(at[columns] < 0, row, count + table[row, at[columns]])

    def _defect_columns(self, d: DomainElimination, columns: Index, interval: Index) -> Index:
        """Columns of an interval's defect rows: states and rates, stage by stage, then parameters."""
        p, ns, na = self.places, d.states.shape[1], d.rates.size
        rate = np.full(int(d.places.max()) + 1, FREE)
        rate[d.places[d.rates]] = np.arange(na)
        at = np.full(p.end.size, FREE)
        at[d.parameters[d.shared]] = np.arange(d.shared.size)
        stage, local = p.stage[columns] - d.stages * interval, p.local[columns]
        state = (local >= 0) & (local < ns)
        found = np.where(state, stage * ns + local, (d.stages + 1) * ns + stage * na + rate[local])
        return np.where(local >= 0, found, (d.stages + 1) * (ns + na) + at[columns])

    def _inequalities(self) -> tuple[Index, Index]:
        """Inequalities that one node holds, node by node, and the others; rows of the pattern."""
        p, rows, columns, first = self.places, self.pattern.rows, self.pattern.columns, self.pattern.equalities
        count = self.pattern.row_numbers.size
        node, domain, least = np.full(count, FREE), np.full(count, FREE), np.full(count, self.nodes)
        np.maximum.at(node, rows, p.node[columns])
        np.maximum.at(domain, rows, p.domain[columns])
        inside = p.node[columns] >= 0
        np.minimum.at(least, rows[inside], p.node[columns[inside]])
        fits = np.ones(count, dtype=bool)
        np.logical_and.at(fits, rows, p.in_node(domain[rows], columns) >= 0)
        nodal = fits & (node >= 0) & (node == least)
        every = np.arange(first, count)
        held = every[nodal[first:]]
        return held[np.argsort(node[held], kind="stable")], every[~nodal[first:]]

    def _place_inequalities(
        self, block: Index, place: Index, nodal: Index, others: Index, offset: int, tips: Index
    ) -> None:
        p, rows, columns, first = self.places, self.pattern.rows, self.pattern.columns, self.pattern.equalities
        at, counts = _by_rows(rows, nodal)
        starts, ends = _cumulated(counts), np.cumsum(counts)
        node = np.full(nodal.size, FREE)
        np.maximum.at(node, np.repeat(np.arange(nodal.size), counts), p.node[columns[at]])
        number = np.searchsorted(_cumulated([d.nodes for d in self.domains])[1:], node, side="right")
        bounds = np.searchsorted(node, np.arange(self.nodes + 1))
        before = np.concatenate([[0], ends])[bounds[node]]
        base = np.array([self._node_size(d) for d in self.domains])[number]
        entry = np.repeat(np.arange(nodal.size), counts)
        block[at] = node[entry]
        place[at] = (base - before)[entry] + np.arange(at.size)
        over, over_counts = _by_rows(rows, others)
        block[over], place[over] = self.end_block, offset + np.arange(over.size)
        end = p.end[columns[over]]
        self._put(
            self.plan,
            node_inequality=bounds,
            inequality_row=nodal - first,
            inequality_start=starts,
            inequality_place=p.in_node(number[entry], columns[at]),
            end_inequality_row=others - first,
            end_inequality_start=_cumulated(over_counts),
            end_inequality_column=np.where(end >= 0, -1 - end, tips[columns[over]]),
        )

    def _node_size(self, d: DomainElimination) -> int:
        """Numbers of a node before its inequalities."""
        width = d.unknowns.shape[1] + d.read.size
        return int(width**2 + d.implicit.shape[1] * width + d.explicit.shape[1] + d.curve_starts[-1])


def _joined(parts: Iterable[Index]) -> Index:
    return np.concatenate([np.zeros(0, dtype=np.int64), *parts])


def _cumulated(counts: Index | Sequence[int]) -> Index:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def _starts(columns: Index, size: int) -> Index:
    return _cumulated(np.bincount(columns, minlength=size))


def _index(rows: Index, wanted: Index) -> tuple[Index, Index]:
    """Nonzeros whose row is among those wanted, and which of them (counted through the array) it is."""
    flat = wanted.ravel()
    number = np.full(int(rows.max()) + 1, FREE)
    number[flat] = np.arange(flat.size)
    at = np.flatnonzero(number[rows] >= 0)
    return at, number[rows[at]]


def _by_rows(rows: Index, wanted: Index) -> tuple[Index, Index]:
    """Nonzeros of some rows, row by row, and how many each row has."""
    at, number = _index(rows, wanted)
    order = np.argsort(number, kind="stable")
    return at[order], np.bincount(number, minlength=wanted.size)
