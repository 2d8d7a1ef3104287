"""Gait synthesis: cold and warm start, the plain way, compile time, time per iteration against the mesh."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace

from amble.gait import Gait
from amble.robot import catalogue
from amble.synthesis import GaitProblem, gait_problem, synthesize
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import build_program
from amble.synthesis.solve import Start, ipopt
from benchmarks.figures import Figure, show, timed
from benchmarks.plain import solve_plainly

TOLERANCE = 1e-6
PLAIN_SECONDS = 120.0
MESHES = (8, 16, 32, 64)
COMPILE = (
    "from benchmarks.synthesis import paper_problem; from amble.synthesis.program import build_program; "
    "import time; b = time.perf_counter(); build_program(paper_problem()); print(time.perf_counter() - b)"
)


def paper_problem(speed: float = 0.2, intervals: int = 15) -> GaitProblem:
    """Return the paper's problem: ASTRo's amble, half a cycle."""
    return gait_problem(catalogue.astro(), "amble", speed=speed, intervals=intervals)


def measure() -> list[Figure]:
    """Measure everything."""
    problem = paper_problem()
    build_program(problem)  # fills the compile cache
    cold, gait = timed(lambda: synthesize(problem, tolerance=TOLERANCE))
    report = gait.solver
    size = f"{report.variables} variables, {report.constraints} rows, {report.iterations} iterations"
    found = [
        Figure("gait, cold start", cold, "s", most=5.0, runs=3, note=f"with building, guess and rank; {size}"),
        Figure("gait, cold start, IPOPT alone", report.seconds, "s", note="last of the runs"),
        _neighbour(problem, gait),
        _compile(),
    ]
    return [*found, *_plain(problem, cold), *_per_iteration()]


def _neighbour(problem: GaitProblem, gait: Gait) -> Figure:
    """0.25 m/s from the solution at 0.2 m/s, multipliers included."""
    neighbour = replace(problem, speed=0.25)
    seconds, found = timed(lambda: synthesize(neighbour, start=gait, tolerance=TOLERANCE))
    note = f"0.2 -> 0.25 m/s, everything; {found.solver.iterations} iterations"
    return Figure("gait, from its neighbour", seconds, "s", most=1.5, runs=3, note=note)


def _compile() -> Figure:
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", COMPILE],
            env={**os.environ, "AMBLE_CACHE": folder},
            capture_output=True,
            text=True,
            check=True,
        )
    return Figure("gait program, compile from an empty cache", float(done.stdout), "s", most=60.0)


def _plain(problem: GaitProblem, ours: float) -> list[Figure]:
    plain = solve_plainly(problem, TOLERANCE, PLAIN_SECONDS)
    note = f"{plain.status}, {plain.iterations} iterations, objective {plain.objective:.4g}"
    bound = "" if plain.status == "Solve_Succeeded" else "; not solved, so the ratio is a lower bound"
    return [
        Figure("gait, the plain way", plain.seconds, "s", note=note),
        Figure("the plain way over ours", plain.seconds / ours, "times", least=8.0, note=f"same start{bound}"),
    ]


def _per_iteration() -> list[Figure]:
    """Time per iteration of the solver on finer meshes; linear growth is a constant time per interval."""
    found, per_interval = [], {}
    for intervals in MESHES:
        problem = paper_problem(intervals=intervals)
        program = build_program(problem)
        start = initial_guess(problem, program.layout) / program.layout.scale
        seconds = []
        for _ in range(3):
            began = time.perf_counter()
            solution = ipopt(program, Start(start), TOLERANCE, 12)
            seconds.append((time.perf_counter() - began) / max(solution.report.iterations, 1))
        value = statistics.median(seconds)
        per_interval[intervals] = value / intervals
        found.append(Figure(f"time per iteration, {intervals} intervals a domain", 1e3 * value, "ms", runs=3))
    growth = per_interval[MESHES[-1]] / per_interval[MESHES[0]]
    name = f"time per iteration and interval, {MESHES[-1]} over {MESHES[0]}"
    return [*found, Figure(name, growth, "times", most=1.0, note="1 is linear growth")]


def main() -> None:
    """Print what is measured."""
    show(measure())


if __name__ == "__main__":
    main()
