"""Gait synthesis: cold and warm start, the plain way, compile time, time per iteration against the mesh."""

from __future__ import annotations

import functools
import os
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
from amble.synthesis.solve import SOLVERS, Start
from benchmarks.figures import Figure, show, timed
from benchmarks.plain import solve_plainly

TOLERANCE = 1e-6
PLAIN_SECONDS = 120.0
MESHES = (8, 16, 32, 64)
ITERATIONS = 12
"""Of the solver in a time per iteration."""

LINEAR_SOLVERS = {"structured": "ipopt", "MUMPS": "ipopt mumps"}
MANY = 100
"""Solves from which on compiling a program pays, however coarse its mesh."""
COMPILE = (
    "from benchmarks.synthesis import MANY, paper_problem; from amble.synthesis.program import build_program; "
    "import time; b = time.perf_counter(); build_program(paper_problem(), MANY); print(time.perf_counter() - b)"
)


def paper_problem(speed: float = 0.2, intervals: int = 15) -> GaitProblem:
    """Return the paper's problem: ASTRo's amble, half a cycle."""
    return gait_problem(catalogue.astro(), "amble", speed=speed, intervals=intervals)


def measure() -> list[Figure]:
    """Measure everything."""
    problem = paper_problem()
    build_program(problem, MANY)  # fills the compile cache
    cold, gait = timed(lambda: synthesize(problem, tolerance=TOLERANCE))
    report = gait.solver
    size = f"{report.variables} variables, {report.constraints} rows, {report.iterations} iterations"
    found = [
        Figure("gait, cold start", cold, "s", most=5.0, runs=3, note=f"with building, guess and rank; {size}"),
        Figure("gait, cold start, IPOPT alone", report.seconds, "s", note=f"last of the runs; {report.linear_solver}"),
        *_both(problem),
        _neighbour(problem, gait),
        _compile(),
    ]
    return [*found, *_plain(problem, cold), *_per_iteration()]


def _both(problem: GaitProblem) -> list[Figure]:
    """The same problem with either linear solver, in processor time, which does not see what else runs."""
    found, seconds, gaits = [], {}, {}
    for linear, solver in LINEAR_SOLVERS.items():
        run = functools.partial(synthesize, problem, tolerance=TOLERANCE, solver=solver)
        seconds[linear], gaits[linear] = timed(run, clock=time.process_time)
        report = gaits[linear].solver
        note = f"{report.iterations} iterations; {report.linear_solver}"
        found.append(Figure(f"gait, cold start, processor, {linear}", seconds[linear], "s", runs=3, note=note))
    ratio = seconds["MUMPS"] / seconds["structured"]
    apart = abs(gaits["structured"].solver.objective / gaits["MUMPS"].solver.objective - 1.0)
    return [
        *found,
        Figure("cold start, MUMPS over structured", ratio, "times", least=1.5),
        Figure("objectives of both, relative difference", apart, "", most=1e-6),
    ]


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
    found: list[Figure] = []
    per_interval: dict[tuple[str, int], float] = {}
    for intervals in MESHES:
        problem = paper_problem(intervals=intervals)
        program = build_program(problem, MANY)
        start = Start(initial_guess(problem, program.layout) / program.layout.scale)
        for linear, solver in LINEAR_SOLVERS.items():
            run = functools.partial(SOLVERS[solver], program, start, TOLERANCE, ITERATIONS, None)
            value, solution = timed(run, clock=time.process_time)
            value /= max(solution.report.iterations, 1)
            per_interval[linear, intervals] = value / intervals
            name = f"processor time an iteration, {linear}, {intervals} intervals"
            found.append(Figure(name, 1e3 * value, "ms", runs=3, note=solution.report.linear_solver or ""))
    growth = per_interval["structured", MESHES[-1]] / per_interval["structured", MESHES[0]]
    name = f"processor time an iteration and interval, {MESHES[-1]} over {MESHES[0]}"
    return [*found, Figure(name, growth, "times", most=1.1, note="1 is linear growth")]


def main() -> None:
    """Print what is measured."""
    show(measure())


if __name__ == "__main__":
    main()
