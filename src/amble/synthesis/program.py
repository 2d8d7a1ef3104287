"""The gait problem as a compiled program: speed, friction and bounds change without compiling again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.synthesis.assembly import Block, Program, assemble
from amble.synthesis.bounds import variable_bounds
from amble.synthesis.layout import Layout, build_layout
from amble.synthesis.link_blocks import defect_block, period_block, phase_block, switch_block
from amble.synthesis.node_block import node_block, parameter_values
from amble.synthesis.problem import GaitProblem


@dataclass(frozen=True, kw_only=True)
class GaitProgram:
    """A gait problem ready for a solver; variables are scaled by ``layout.scale``.

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


def build_program(problem: GaitProblem) -> GaitProgram:
    """Transcribe a gait problem; compiled code comes from the cache where the structure is known."""
    layout = build_layout(problem)
    program = assemble(_blocks(problem, layout), layout.scale, parameter_values(problem).size)
    lower, upper = variable_bounds(problem, layout)
    return GaitProgram(
        problem=problem,
        layout=layout,
        program=program,
        lower=lower / layout.scale,
        upper=upper / layout.scale,
        parameters=parameter_values(problem),
    )


def _blocks(problem: GaitProblem, layout: Layout) -> list[Block]:
    blocks: list[Block] = []
    for number, domain in enumerate(layout.domains):
        blocks += [
            node_block(problem, layout, domain),
            defect_block(problem, domain),
            switch_block(problem, layout, number),
        ]
        if domain.phase_numbers.size:
            blocks.append(phase_block(problem, domain))
    return [*blocks, period_block(layout)]
