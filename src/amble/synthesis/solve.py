"""Solving a gait problem, with IPOPT where nothing else is named; a failure names the rows that are violated."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, replace
from typing import Any, Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.gait import LagrangeMultipliers, SolverReport
from amble.io.registry import Lookup
from amble.progress import Progress
from amble.residual import Residual
from amble.synthesis.program import GaitProgram
from amble.synthesis.structured_kkt import UnavailableError, structured_kkt
from amble.synthesis.violated_rows import violated_rows
from amble.synthesis.watch import Watch, single_threaded
from amble.types import Vector, frozen

logger = logging.getLogger("amble")

NLP_OPTIONS = {"no_nlp_grad": True, "calc_lam_p": False, "print_time": False, "error_on_fail": False}
"""Of casadi's interface, whatever the solver."""

MUMPS_OPTIONS: dict[str, Any] = {
    "linear_solver": "mumps",
    "mumps_scaling": 0,  # the program is scaled; MUMPS's own cost time (docs/theory/transcription.md, section 8)
    "mumps_permuting_scaling": 0,
}

IPOPT_OPTIONS: dict[str, Any] = {
    "mu_strategy": "adaptive",  # a third fewer iterations than the monotone one (docs/performance.md)
    "print_level": 0,
    "sb": "yes",
}

SOLVED = ("Solve_Succeeded",)
ROUNDING = 1e-9
"""How far a scaled start value may lie outside its bounds without being counted as moved."""

MOST_ITERATIONS = 1_000_000


@dataclass(frozen=True)
class Start:
    """Where a solver starts: scaled variables, (n_x,), and where they solve a neighbouring problem its multipliers."""

    variables: Vector
    multipliers: LagrangeMultipliers | None = None


@dataclass(frozen=True, kw_only=True)
class Solution:
    """The end of a solver's run: scaled variables with their multipliers, and the report.

    Attributes:
        variables: scaled variables, (n_x,).
        multipliers: those of its bounds and rows, where a solver found them.
        report: status and cost.
        rows: violated rows and bounds, worst first; empty where solved.
        solved: whether the solver reports success.
        warm: whether it started from a neighbour's solution and multipliers.
        projected: how many start values lay outside their bounds and were moved onto them.
        refused: why the structured solver refused a KKT system and so ended the run; empty where it did not.
    """

    variables: NDArray[np.float64]
    multipliers: LagrangeMultipliers | None
    report: SolverReport
    rows: tuple[Residual, ...]
    solved: bool
    warm: bool = False
    projected: int = 0
    refused: str = ""


class Solver(Protocol):
    """What solves a gait program; a function such as ``ipopt``."""

    def __call__(
        self,
        program: GaitProgram,
        start: Start,
        tolerance: float,
        most_iterations: int,
        progress: Progress | None,
    ) -> Solution:
        """Solve from a start; arguments are those of ``ipopt``, and ``finished`` makes the solution."""


SOLVERS: Lookup[Solver] = Lookup("solver")
"""The solvers that specifications and ``synthesize`` can name."""


def ipopt(
    program: GaitProgram,
    start: Start,
    tolerance: float = 1e-8,
    most_iterations: int = 500,
    progress: Progress | None = None,
) -> Solution:
    """Solve by IPOPT; what of the start lies outside its bounds is moved onto them, and counted.

    Args:
        program: the transcribed problem.
        start: the start; where it has multipliers, they are used.
        tolerance: IPOPT's overall tolerance on the scaled problem.
        most_iterations: give up after so many.
        progress: called after every iteration.

    KKT systems are solved by their structure (``structured_kkt``). Where that is not possible, or a system is refused
    on the way, IPOPT starts again with MUMPS; the report says which it was, and why. Its iterations are those of the
    last run, its seconds those of both.

    Raises:
        KeyboardInterrupt: Ctrl-C arrived; the solver has stopped at the end of its iteration.
    """
    first = ipopt_structured(program, start, tolerance, most_iterations, progress)
    if not first.refused:
        return first
    found = ipopt_mumps(program, start, tolerance, most_iterations, progress, first.refused)
    return replace(found, report=replace(found.report, seconds=found.report.seconds + first.report.seconds))


def ipopt_structured(
    program: GaitProgram,
    start: Start,
    tolerance: float = 1e-8,
    most_iterations: int = 500,
    progress: Progress | None = None,
) -> Solution:
    """Solve as ``ipopt`` does, but end unsolved where a system is refused: MUMPS takes many times as long for each.

    Only where the structured solver cannot be used at all MUMPS solves. A refusal mostly means that IPOPT restores
    feasibility, whose systems have regularised equality rows: from this start it found no step that keeps them.
    """
    try:
        with structured_kkt(program) as kkt:
            found = _run(program, start, {**kkt.options, **_limits(tolerance, most_iterations)}, progress)
            return replace(_reported(found, "structured"), refused=kkt.refusal)
    except UnavailableError as error:
        return ipopt_mumps(program, start, tolerance, most_iterations, progress, str(error))


def ipopt_mumps(
    program: GaitProgram,
    start: Start,
    tolerance: float = 1e-8,
    most_iterations: int = 500,
    progress: Progress | None = None,
    reason: str = "",
) -> Solution:
    """Solve by IPOPT with MUMPS alone; see ``ipopt``. The report names the reason, where there is one."""
    if reason:
        logger.info("MUMPS solves the KKT systems: %s", reason)
    found = _run(program, start, {**MUMPS_OPTIONS, **_limits(tolerance, most_iterations)}, progress)
    return _reported(found, f"MUMPS ({reason})" if reason else "MUMPS")


SOLVERS.register("ipopt", ipopt)
SOLVERS.register("ipopt mumps", ipopt_mumps)


def _limits(tolerance: float, most_iterations: int) -> dict[str, Any]:
    return {"tol": tolerance, "max_iter": most_iterations}


def _reported(found: Solution, linear_solver: str) -> Solution:
    """Add the linear solver."""
    return replace(found, report=replace(found.report, linear_solver=linear_solver))


def _run(program: GaitProgram, start: Start, more: dict[str, Any], progress: Progress | None) -> Solution:
    """One run of IPOPT with further options."""
    nlp = program.program
    inside, projected = _projected(program, start.variables)
    watch, warm = Watch(program, progress, projected), start.multipliers
    derivatives = {"grad_f": nlp.gradient, "jac_g": nlp.jacobian, "hess_lag": nlp.hessian}
    ipopt_options = {**IPOPT_OPTIONS, **more, **_warm_options(warm)}
    options = {**NLP_OPTIONS, **derivatives, "iteration_callback": watch, "ipopt": ipopt_options}
    solver = ca.nlpsol("gait", "ipopt", nlp.nlp, options)
    began = time.perf_counter()
    arguments = {
        "x0": inside,
        "p": program.parameters,
        "lbx": program.lower,
        "ubx": program.upper,
        "lbg": nlp.lower,
        "ubg": nlp.upper,
    }
    if warm is not None:
        arguments |= {"lam_x0": warm.bounds, "lam_g0": warm.rows}
    with single_threaded(), watch.keeping_interrupts():
        result = solver(**arguments)
    seconds = time.perf_counter() - began
    stats = solver.stats()
    status = str(stats["return_status"])
    found = finished(
        program,
        np.array(result["x"]).ravel(),
        solver="ipopt",
        status=status,
        solved=status in SOLVED,
        iterations=int(stats["iter_count"]),
        seconds=seconds,
        multipliers=(np.array(result["lam_x"]).ravel(), np.array(result["lam_g"]).ravel()),
    )
    return replace(found, warm=warm is not None, projected=projected)


def finished(
    program: GaitProgram,
    variables: NDArray[np.float64],
    *,
    solver: str,
    status: str,
    solved: bool,
    iterations: int,
    seconds: float,
    multipliers: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
) -> Solution:
    """Return the end of a solver's run, with objective, violation and violated rows as the program has them there.

    Args:
        program: the program.
        variables: scaled variables, (n_x,).
        solver: name of the solver.
        status: what it says of its end.
        solved: whether that is success.
        iterations: how many it took.
        seconds: its wall time, s.
        multipliers: of the bounds, (n_x,), and the rows, (n_g,), signed as casadi's: positive at upper bounds.
    """
    objective, values = (np.asarray(part).ravel() for part in program.program.nlp(variables, program.parameters))
    report = SolverReport(
        solver=solver,
        status=status,
        iterations=iterations,
        seconds=seconds,
        variables=variables.size,
        constraints=values.size,
        violation=float(np.max(program.program.excess(values))),
        objective=program.program.cost_scale * float(objective[0]),
    )
    kept = None if multipliers is None or not solved else LagrangeMultipliers(*map(_rounded, multipliers))
    rows = violated_rows(program, variables, values)
    return Solution(variables=variables, multipliers=kept, report=report, rows=rows, solved=solved)


def _projected(program: GaitProgram, variables: Vector) -> tuple[Vector, int]:
    """Return the nearest variables within the bounds, and how many had to move by more than rounding."""
    inside = np.clip(variables, program.lower, program.upper)
    return inside, int(np.sum(np.abs(inside - variables) > ROUNDING))


def _rounded(values: NDArray[np.float64]) -> Vector:
    """Six digits start a neighbour as well as sixteen, in half the size of a file."""
    text = "%.6g " * values.size % tuple(values.tolist())
    return frozen(np.array(text.split(), dtype=np.float64))


def _warm_options(warm: LagrangeMultipliers | None) -> dict[str, Any]:
    if warm is None:
        return {}
    pushes = ("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac", "mult_bound_push")
    return {
        "warm_start_init_point": "yes",
        "mu_max": 3e-3,  # without a limit the adaptive barrier rises and forgets the start
        **{f"warm_start_{push}": 1e-2 for push in pushes},
    }
