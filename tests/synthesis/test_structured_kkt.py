"""The structured KKT solver through MA27's interface: inertia and residual against a dense factor; what it refuses."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from examples.extending.phase_configuration import ConfigurationPhase
from scipy.linalg import ldl

from amble.hybrid import Plane, gait_pattern
from amble.synthesis import GaitProblem, gait_problem
from amble.synthesis import structured_kkt as module
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import GaitProgram, build_program
from amble.synthesis.structured_kkt import StructuredKkt, UnavailableError, structured_kkt
from amble.types import Vector
from benchmarks.kkt import SINGULAR, KktSystem, Ma27, kkt_system
from tests.hybrid.test_gaits import _biped, _six
from tests.robots import robot
from tests.synthetic import THREE

RESIDUAL = 1e-11
"""Bound of |b - K x| over |K| |x| + |b|: the solver refines until it is met."""


def _problem(gait: str, speed: float = 0.2, slope: float = 0.0, yaw_rate: float = 0.0) -> GaitProblem:
    walker = {"run": _biped, "tripod": _six}.get(gait, lambda: robot("astro"))()
    ground = Plane(friction=0.6, slope=slope) if slope else None
    return gait_problem(walker, gait, speed=speed, ground=ground, yaw_rate=yaw_rate, intervals=2)


def _of_scheme(scheme: str) -> GaitProblem:
    return replace(_problem("trot"), scheme=scheme)


def _by_state() -> GaitProblem:
    problem = _problem("trot")
    return replace(problem, outputs=replace(problem.outputs, phase=ConfigurationPhase({"D1": {"x": 1.0, "roll": 0.5}})))


def _one_by_one() -> GaitProblem:
    problem = _problem("trot")
    return replace(problem, pattern=replace(problem.pattern, landing_rule="one by one"))


PROBLEMS: dict[str, Callable[[], GaitProblem]] = {
    "trot, half a cycle of one domain": lambda: _problem("trot"),
    "phase of the configuration": _by_state,
    "flight on a slope": lambda: _problem("running trot", slope=0.1),
    "feet that land one by one": _one_by_one,
    "five nodes an interval": lambda: _of_scheme("lobatto-5"),
    "seven nodes an interval": lambda: _of_scheme("lobatto-7"),
    "two feet": lambda: _problem("run", speed=0.5),
    "six feet": lambda: _problem("tripod"),
    "turning": lambda: _problem("trot", yaw_rate=0.3),
    "four feet": lambda: _problem("walking trot"),
    "two domains": lambda: _problem("amble"),
    "three feet": lambda: gait_problem(
        robot("astro"), gait_pattern(robot("astro"), THREE, mirrored=True, name="three"), speed=0.1, intervals=2
    ),
}
QUICK = 3
"""The first of them; the others are for `make slow`."""

KINDS = [*PROBLEMS][:QUICK] + [pytest.param(name, marks=pytest.mark.slow) for name in [*PROBLEMS][QUICK:]]


@cache
def _program(name: str) -> tuple[GaitProgram, Vector]:
    """A program on the coarsest mesh, interpreted, and a point near its start."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")
        problem = PROBLEMS[name]()
        program = build_program(problem)
        start = initial_guess(problem, program.layout) / program.layout.scale
    step = 0.01 * np.random.default_rng(0).uniform(-1.0, 1.0, start.size)
    return program, np.clip(start, program.lower, program.upper) + step


@dataclass(frozen=True)
class Case:
    """A program with its solver."""

    program: GaitProgram
    point: Vector
    solver: StructuredKkt

    def system(self, seed: int = 0, **how: float) -> KktSystem:
        """A random KKT system."""
        return kkt_system(self.program, self.point, np.random.default_rng(seed), **how)


@pytest.fixture
def case() -> Iterator[Case]:
    program, point = _program("trot, half a cycle of one domain")
    with structured_kkt(program) as solver:
        yield Case(program, point, solver)


def _negative(matrix: np.ndarray) -> int:
    """Negative eigenvalues of the block diagonal factor of L D L'; scaled on both sides, which keeps the inertia."""
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(matrix)), 1.0))
    _, blocks, _ = ldl(scale[:, None] * matrix * scale)
    diagonal, beside = np.diag(blocks), np.append(np.diag(blocks, -1), 0.0)
    pairs = np.flatnonzero(beside)
    alone = np.setdiff1d(np.arange(diagonal.size), np.concatenate([pairs, pairs + 1]))
    both = np.array([[[diagonal[i], beside[i]], [beside[i], diagonal[i + 1]]] for i in pairs]).reshape(-1, 2, 2)
    return int(np.sum(diagonal[alone] < 0.0) + np.sum(np.linalg.eigvalsh(both) < 0.0))


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize(
    "how",
    [{}, {"barrier": 1e-3, "shift": 1.0}, {"barrier": 1e-6}, {"barrier": 0.01, "active": 3}, {"shift": 1e7}],
    ids=["curved", "shifted", "active bounds", "late", "much regularised"],
)
def test_inertia_and_solution_are_those_of_the_whole_matrix(name: str, how: dict[str, float]) -> None:
    program, point = _program(name)
    random = np.random.default_rng(len(name))
    system = kkt_system(program, point, random, **how)
    right = random.normal(size=system.size)
    with structured_kkt(program) as solver:
        ma27 = Ma27(solver, system)
        flag, negative = ma27.factor()
        found = ma27.solve(right)
        assert solver.refusal == ""
    assert flag == 0
    whole = system.dense()
    assert negative == _negative(whole)
    assert _residual(whole, found, right) <= RESIDUAL


def _residual(whole: np.ndarray, found: np.ndarray, right: np.ndarray) -> float:
    """In long double, whose rounding does not count here."""
    rows = whole.astype(np.longdouble)
    return float(np.abs(right - rows @ found).max() / (np.abs(rows) @ np.abs(found) + np.abs(right)).max())


def test_a_wrong_inertia_is_told(case: Case) -> None:
    """Negative curvature beyond what the barrier holds: more negative eigenvalues than rows."""
    system = case.system(curvature=-50.0, shift=1e-3)
    flag, negative = Ma27(case.solver, system).factor()
    assert flag == 0
    assert negative == _negative(system.dense()) > system.size - system.primal


def test_an_independent_system_of_many_solutions_is_singular(case: Case) -> None:
    """The row of the period reads nothing: the end has a row of zeros."""
    system = case.system()
    values = system.values.copy()
    period = [n.endswith("sum of durations") for n in case.program.program.row_names].index(True)
    row = int(case.program.program.equalities[:period].sum()) + system.primal
    values[(system.rows == row + 1) & (system.columns <= system.primal)] = 0.0
    assert Ma27(case.solver, replace(system, values=values)).factor()[0] == SINGULAR
    assert case.solver.refusal != ""  # it has solved nothing


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("regularised", "regularises the equality rows"),
        ("law", "dependent rows"),
        ("weight", "dependent rows"),
        ("slack", "another structure"),
    ],
)
def test_what_it_cannot_factor_is_refused(case: Case, what: str, says: str) -> None:
    """Regularised rows; a node's row of zeros; a weight below zero; slacks that are scaled. Once refused, always."""
    system = case.system(regularised=1e-8 if what == "regularised" else 0.0)
    values, extra = system.values.copy(), system.primal - case.program.layout.size
    own = system.rows <= system.primal
    if what == "law":
        law = [" law " in name for name in case.program.program.row_names].index(True)
        row = int(case.program.program.equalities[:law].sum()) + system.primal
        values[system.rows == row + 1] = 0.0
    if what == "weight":
        values[own & (system.rows > case.program.layout.size)] = -1.0
    if what == "slack":
        values[(system.rows > system.size - extra) & (values == -1.0) & (system.columns > system.primal - extra)] = -2.0
    ma27 = Ma27(case.solver, replace(system, values=values))
    assert ma27.factor()[0] < SINGULAR
    assert says in case.solver.refusal
    again = Ma27(case.solver, case.system())
    assert again.flag != 0
    assert not again.solve(np.ones(system.size)).any()


def test_a_place_that_the_program_does_not_have_is_refused(case: Case) -> None:
    system, torques = case.system(), case.program.layout.domains[0].u[:, 0]
    rows, columns = system.rows.copy(), system.columns.copy()
    rows[0], columns[0] = torques[[-1, 0]] + 1  # the Hessian has nothing between torques of two nodes
    assert Ma27(case.solver, replace(system, rows=rows, columns=columns)).flag != 0
    assert "another structure" in case.solver.refusal


def test_a_matrix_of_another_size_is_refused(case: Case) -> None:
    assert Ma27(case.solver, replace(case.system(), size=10)).flag != 0


def test_a_solution_beyond_its_bound_is_zero(case: Case) -> None:
    """The right side is beyond what doubles hold, so that no refinement can meet the bound."""
    system = case.system()
    ma27 = Ma27(case.solver, system)
    assert ma27.factor()[0] == 0
    assert not ma27.solve(np.full(system.size, 1e308)).any()
    assert case.solver.refusal == "a residual is too large"
    assert ma27.factor()[0] < SINGULAR


def test_two_systems_in_turn_keep_apart(case: Case) -> None:
    """As IPOPT does, whose restoration has a solver of its own."""
    systems = [case.system(seed, barrier=0.01) for seed in (1, 2)]
    solvers = [Ma27(case.solver, system) for system in systems]
    right = np.random.default_rng(0).normal(size=systems[0].size)
    for ma27 in solvers:
        assert ma27.factor()[0] == 0
    for ma27, system in zip(solvers, systems, strict=True):
        assert _residual(system.dense(), ma27.solve(right), right) <= RESIDUAL


def test_scipys_blas_serves_as_well(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    system = case.system(barrier=0.01)
    right = np.random.default_rng(0).normal(size=system.size)
    first = Ma27(case.solver, system)
    first.factor()
    monkeypatch.setattr(module, "loaded_blas", lambda: None)
    module._blas.cache_clear()
    try:
        with structured_kkt(case.program) as solver:
            second = Ma27(solver, system)
            second.factor()
            found = second.solve(right)
    finally:
        module._blas.cache_clear()
    case.solver.library.amble_kkt_use(case.solver.handle)
    assert _residual(system.dense(), found, right) <= RESIDUAL


def test_without_a_compiler_it_is_not_available(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    with pytest.raises(UnavailableError, match="no C compiler found"), structured_kkt(case.program):
        pass


def test_a_solver_outside_its_block_is_not_called(case: Case) -> None:
    """IPOPT would get an error, as where the library is used by nobody."""
    case.solver.library.amble_kkt_use(None)
    assert Ma27(case.solver, case.system()).flag != 0
    case.solver.library.amble_kkt_use(case.solver.handle)
