"""The structured KKT solver against an independent one, feral-solver: inertia and residual on 200 random systems."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from amble.hybrid import Plane
from amble.robot import catalogue
from amble.synthesis import gait_problem
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import GaitProgram, build_program
from amble.synthesis.structured_kkt import structured_kkt
from benchmarks.figures import Figure, show
from benchmarks.kkt import KktSystem, Ma27, kkt_system

INTERVALS = 6
SYSTEMS = 25
"""Of every kind."""

KINDS: dict[str, dict[str, Any]] = {
    "amble": {},
    "trot": {},
    "pace": {},
    "bound": {},
    "crawl": {"speed": 0.1},
    "walking trot": {},
    "running trot": {"ground": Plane(friction=0.6, slope=0.1)},
    "turning trot": {"gait": "trot", "yaw_rate": 0.3},
}
"""ASTRo's gaits: two, three and four feet, flight, a slope, a turn."""

HOWS: tuple[dict[str, Any], ...] = (
    {},
    {"barrier": 1e-3, "shift": 1.0},
    {"barrier": 1e-6},
    {"barrier": 0.01, "active": 3},
    {"curvature": -50.0, "shift": 1e-3},
)
"""Barriers, regularisations, active bounds; the last has more negative eigenvalues than rows."""


@dataclass(frozen=True, kw_only=True)
class Compared:
    """What both made of one system.

    Attributes:
        kind: of the gait.
        agrees: whether the numbers of negative eigenvalues are equal.
        residual: of the structured solution, |b - K x| over |K| |x| + |b|, in long double.
        ours: processor time of a factorisation, s.
        theirs: the same of feral-solver, its symbolic analysis kept.
    """

    kind: str
    agrees: bool
    residual: float
    ours: float
    theirs: float


def programs() -> Iterator[tuple[str, GaitProgram, Any]]:
    """Yield the kinds with a point near their start."""
    robot, rng = catalogue.astro(), np.random.default_rng(0)
    for kind, options in KINDS.items():
        asked = {"gait": kind, "speed": 0.2, **options}
        program = build_program(gait_problem(robot, intervals=INTERVALS, **asked))
        start = initial_guess(program.problem, program.layout) / program.layout.scale
        yield kind, program, np.clip(start, program.lower, program.upper) + 0.01 * rng.uniform(-1.0, 1.0, start.size)


def compared() -> Iterator[Compared]:
    """Factor and solve the systems by both."""
    from feral import Solver

    for kind, program, point in programs():
        theirs, ma27 = Solver(), None
        with structured_kkt(program) as solver:
            for seed in range(SYSTEMS):
                rng = np.random.default_rng(seed)
                system = kkt_system(program, point, rng, **HOWS[seed % len(HOWS)])
                ma27, right = ma27 or Ma27(solver, system), rng.normal(size=system.size)  # one structure, one analysis
                ma27.system = system
                began = time.process_time()
                flag, negative = ma27.factor()
                ours = time.process_time() - began
                found = ma27.solve(right) if flag == 0 else None
                matrix = _matrix(system)
                began = time.process_time()
                theirs.factor(matrix)
                spent = time.process_time() - began
                yield Compared(
                    kind=kind,
                    agrees=flag == 0 and negative == theirs.num_negative_eigenvalues,
                    residual=np.inf if found is None else _residual(system, found, right),
                    ours=ours,
                    theirs=spent,
                )


def _matrix(system: KktSystem) -> Any:
    """The lower triangle, as feral takes it; repeated triplets are added first."""
    from feral import CscMatrix
    from scipy.sparse import coo_matrix

    low, high = np.minimum(system.rows, system.columns) - 1, np.maximum(system.rows, system.columns) - 1
    whole = coo_matrix((system.values, (high, low)), shape=(system.size, system.size)).tocsc().tocoo()
    return CscMatrix.from_triplet(
        system.size, whole.row.astype(np.int64), whole.col.astype(np.int64), whole.data.astype(np.float64)
    )


def _residual(system: KktSystem, found: Any, right: Any) -> float:
    i, j, x = system.rows - 1, system.columns - 1, found.astype(np.longdouble)
    values, beside = system.values.astype(np.longdouble), i != j
    left, size = np.zeros(system.size, np.longdouble), np.abs(right).astype(np.longdouble)
    for row, column, entry in ((i, j, values), (j[beside], i[beside], values[beside])):
        np.add.at(left, row, entry * x[column])
        np.add.at(size, row, np.abs(entry * x[column]))
    return float(np.abs(right - left).max() / size.max())


def measure() -> list[Figure]:
    """Compare on all systems."""
    found = list(compared())
    wrong = [entry.kind for entry in found if not entry.agrees]
    return [
        Figure(
            "KKT systems on which the inertia is feral-solver's",
            100.0 * (1.0 - len(wrong) / len(found)),
            "%",
            least=100.0,
            note=f"{len(found) - len(wrong)} of {len(found)}; others: {', '.join(wrong) or 'none'}",
        ),
        Figure(
            "largest residual of their solutions, in long double",
            max(entry.residual for entry in found),
            "1",
            most=1e-11,
        ),
        Figure("factorisation, structured, median", 1e3 * statistics.median(entry.ours for entry in found), "ms"),
        Figure("the same by feral-solver", 1e3 * statistics.median(entry.theirs for entry in found), "ms"),
    ]


def main() -> None:
    """Print what is measured."""
    show(measure())


if __name__ == "__main__":
    main()
