"""The gait problem as a compiled program: speed, friction and bounds change without compiling again.

The rank of its equality rows is checked before a solver starts: dependent rows ruin interior-point methods.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.codegen import compiler
from amble.errors import NotSolvedError
from amble.numerics.collocation import HERMITE_SIMPSON
from amble.residual import Residual
from amble.synthesis.assembly import Program, assemble
from amble.synthesis.between_nodes import between_nodes
from amble.synthesis.block import Block
from amble.synthesis.form import Form
from amble.synthesis.landing_rows import landing_blocks
from amble.synthesis.layout import Layout, build_layout, resampled, variable_bounds
from amble.synthesis.link_blocks import defect_block, period_block, phase_block, switch_block
from amble.synthesis.node_block import node_block, parameter_values
from amble.synthesis.problem import GaitProblem
from amble.synthesis.rows import ROW_SIZES

SMALLEST = 1e-7
"""Smallest singular value of the scaled equality Jacobian, its rows normalised, below which rows count as dependent."""

COARSE = 4
"""Hermite-Simpson intervals of the mesh that is coarse enough."""

STEPS = (0.05, 0.005, 0.0005)
"""Largest steps off the start, in scaled variables."""

SHIFT = 1e-12
"""Regularisation of the normal equations, far below SMALLEST squared."""


@dataclass(frozen=True, kw_only=True)
class GaitProgram:
    """A gait problem ready for a solver; variables are scaled by ``layout.scale``, rows and cost by ``program``'s own.

    Attributes:
        problem: the problem.
        layout: where every variable stands.
        program: the compiled functions and the bounds of the rows.
        lower: lower bounds of the scaled variables, (n_x,).
        upper: upper bounds of the scaled variables, (n_x,).
        parameters: values of the program's parameters.
    """

    problem: GaitProblem
    layout: Layout
    program: Program
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    parameters: NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Structure:
    """What programs have in common that differ in parameters and in values of bounds; structures compare by it.

    Attributes:
        jacobian: the program's function.
        hessian: the same.
        marks: which rows are equations, their kinds, and which variables are fixed.
        program: one of these programs.
    """

    jacobian: ca.Function
    hessian: ca.Function
    marks: bytes
    program: GaitProgram = field(compare=False)

    @classmethod
    def of(cls, program: GaitProgram) -> Structure:
        """Return the structure of a program."""
        nlp = program.program
        marks = (nlp.equalities, nlp.row_kinds, program.lower == program.upper)
        return cls(
            jacobian=nlp.jacobian,
            hessian=nlp.hessian,
            marks=b" ".join(array.tobytes() for array in marks),
            program=program,
        )


EXPECTED = 100.0
"""Iterations to a gait: real quadrupeds need 25 to 170."""


def build_program(problem: GaitProblem, solves: int = 1) -> GaitProgram:
    """Transcribe a gait problem; compiled code comes from the cache where the structure is known.

    Args:
        problem: the problem.
        solves: how many problems of its structure will be solved: whether compiling pays.
    """
    form, iterations = Form.of(problem), EXPECTED * solves
    if form is None:
        layout, program = _written(problem, iterations)
    else:
        layout, program = _written_once(form, iterations, repr(compiler()))
    lower, upper = variable_bounds(problem, layout)
    return GaitProgram(
        problem=problem,
        layout=layout,
        program=program,
        lower=lower / layout.scale,
        upper=upper / layout.scale,
        parameters=parameter_values(problem),
    )


@lru_cache(maxsize=16)
def _written_once(form: Form, iterations: float, tool: str) -> tuple[Layout, Program]:
    """What problems of one form have in common, as one compiler makes it."""
    del tool
    return _written(form.problem, iterations)


def _written(problem: GaitProblem, iterations: float) -> tuple[Layout, Program]:
    """Write layout and rows; of the problem they read what ``Form`` compares."""
    layout = build_layout(problem)
    units = layout.units

    def row_size(unit: str) -> float:
        return ROW_SIZES.get(unit, 1.0) * units.size(unit)

    cost_scale = units.size(problem.cost.unit)
    blocks, count = _blocks(problem, layout), parameter_values(problem).size
    return layout, assemble(blocks, layout.scale, count, row_size, cost_scale, iterations)


def _blocks(problem: GaitProblem, layout: Layout) -> list[Block]:
    blocks: list[Block] = []
    for number, domain in enumerate(layout.domains):
        blocks += [
            node_block(problem, layout, domain),
            defect_block(problem, layout, domain),
            *between_nodes(problem, domain),
            switch_block(problem, layout, number),
            *landing_blocks(problem, layout, number),
        ]
        if domain.phase_numbers.size:
            blocks.append(phase_block(problem, domain))
    return [*blocks, period_block(layout)]


def smallest_singular_value(program: GaitProgram, variables: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """Return the smallest singular value of the normalised equality Jacobian and its left singular vector.

    By inverse iteration on J J^T with a sparse factor; at most a second where a dense decomposition takes minutes.
    Where rows are no numbers it is nan, and the vector marks those rows.

    Args:
        program: the transcribed problem.
        variables: scaled variables at which to look, (n_x,).
    """
    from scipy.sparse import diags, identity
    from scipy.sparse.linalg import splu

    nlp = program.program
    _, whole = nlp.linearised(variables, program.parameters)
    free = program.lower < program.upper
    equal = whole[nlp.equalities][:, free]
    if not np.isfinite(equal.data).all():
        return float("nan"), np.asarray(~np.isfinite(equal.sum(axis=1))).ravel().astype(float)
    lengths = np.sqrt(np.asarray(equal.multiply(equal).sum(axis=1)).ravel())
    normal = diags(1.0 / np.maximum(lengths, 1e-300)) @ equal
    gram = (normal @ normal.T + SHIFT * identity(normal.shape[0])).tocsc()
    factor = splu(gram, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0)
    vector = np.random.default_rng(0).normal(size=normal.shape[0])
    for _ in range(8):
        vector = factor.solve(vector)
        vector /= np.linalg.norm(vector)
    return float(np.linalg.norm(normal.T @ vector)), vector


def on_coarse_mesh(program: GaitProgram, natural: NDArray[np.float64]) -> tuple[GaitProgram, NDArray[np.float64]]:
    """Return the same problem on few intervals and the scaled variables there; whether rows repeat shows there too.

    Args:
        program: the transcribed problem.
        natural: unscaled variables, (n_x,).
    """
    few = replace(program.problem, intervals=COARSE, scheme=HERMITE_SIMPSON)
    if program.problem.nodes <= few.nodes:
        return program, natural / program.layout.scale
    coarse = build_program(few)
    thin = np.zeros(coarse.layout.size)
    for here, there in zip(program.layout.domains, coarse.layout.domains, strict=True):
        for kind in ("q", "v", "a", "u", "force"):
            thin[getattr(there, kind)] = resampled(natural[getattr(here, kind)], here.phases, there.phases)
        for kind in ("duration", "coefficients", "phase_numbers", "impulse"):
            thin[getattr(there, kind)] = natural[getattr(here, kind)]
        for ours, theirs in zip(here.landings, there.landings, strict=True):
            thin[theirs.index] = natural[ours.index]
    thin[coarse.layout.period] = natural[program.layout.period]
    return coarse, thin / coarse.layout.scale


def require_full_rank(program: GaitProgram, variables: NDArray[np.float64]) -> float:
    """Return the smallest singular value; raise where equality rows depend on each other.

    The point is moved off the given variables by a small fixed random step: a standing robot is a special pose at
    which rows may be dependent that are not so anywhere near. Where rows look dependent after the step, shorter ones
    are tried: rows that depend on each other do so everywhere, but a step may also lead far outside the range of a
    phase of the configuration.

    Raises:
        NotSolvedError: names the rows that depend on each other, or that are no numbers.
    """
    direction = np.random.default_rng(1).uniform(-1.0, 1.0, variables.size)
    inside = np.clip(variables, program.lower, program.upper)  # as the solver's start; far outside all rows look alike
    for step in STEPS:
        value, vector = smallest_singular_value(program, inside + step * direction)
        if value >= SMALLEST:
            return value
    nlp = program.program
    names = np.array(nlp.row_names)[nlp.equalities]
    worst = np.argsort(-np.abs(vector))[:8]
    rows = [Residual(f"{names[i]} (weight {vector[i]:.2f})", 0.0, 0.0, 0.0) for i in worst if vector[i]]
    if np.isnan(value):
        raise NotSolvedError("slopes of equality rows are no numbers where the solver starts", rows)
    raise NotSolvedError(f"equality rows depend on each other (smallest singular value {value:.1e})", rows)
