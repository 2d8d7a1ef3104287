"""Solve rate over a grid of speeds, base heights and frictions; neighbours start from each other."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from dataclasses import replace

from amble.hybrid import Plane
from amble.synthesis import GaitProblem, Outcome, sweep
from benchmarks.figures import Figure, show
from benchmarks.synthesis import paper_problem

SPEEDS = (0.05, 0.1, 0.2, 0.3, 0.4)
HEIGHTS = ((0.30, 0.34), (0.32, 0.36), (0.34, 0.38), (0.36, 0.40))
"""Ranges that the base keeps to, m; within its hip pitch limit a level ASTRo reaches 0.39 m."""

FRICTIONS = (0.5, 0.6, 0.8)


def grid() -> Iterator[GaitProblem]:
    """Go through the grid so that every problem differs from the one before it by one step in one direction."""
    base = paper_problem()
    for h, height in enumerate(HEIGHTS):
        for f, friction in enumerate(FRICTIONS if h % 2 == 0 else FRICTIONS[::-1]):
            for speed in SPEEDS if (h * len(FRICTIONS) + f) % 2 == 0 else SPEEDS[::-1]:
                positions = {**base.limits.positions, "z": height}
                pattern = replace(base.pattern, ground=Plane(friction=friction))
                yield replace(base, pattern=pattern, speed=speed, limits=replace(base.limits, positions=positions))


def measure() -> list[Figure]:
    """Solve the grid."""
    outcomes = []
    for outcome in sweep(list(grid())):
        outcomes.append(outcome)
        print(_line(outcome), flush=True)
    solved = [outcome for outcome in outcomes if outcome.gait is not None]
    failures = [_line(outcome) for outcome in outcomes if outcome.gait is None]
    warm = sum(outcome.warm for outcome in solved)
    return [
        Figure(
            "solve rate over the grid",
            100.0 * len(solved) / len(outcomes),
            "%",
            least=95.0,
            note=f"{len(solved)} of {len(outcomes)}, {warm} from a neighbour; failed: {'; '.join(failures) or 'none'}",
        ),
        Figure("time a gait of the grid, median", statistics.median(o.seconds for o in outcomes), "s"),
    ]


def _line(outcome: Outcome) -> str:
    low, high = outcome.problem.limits.positions["z"]
    friction = outcome.problem.pattern.ground.friction
    return (
        f"{outcome.problem.speed:g} m/s, height {low:g} to {high:g} m, friction {friction:g}: "
        f"{outcome.status}, {outcome.iterations} iterations, {outcome.seconds:.1f} s"
    )


def main() -> None:
    """Print what is measured."""
    show(measure())


if __name__ == "__main__":
    main()
