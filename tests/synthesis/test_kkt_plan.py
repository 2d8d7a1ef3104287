"""The plan: every number of the Jacobian and the Hessian has one place, and programs of one structure share a plan."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from amble.synthesis.elimination import jacobian_pattern
from amble.synthesis.kkt_plan import build_plan
from amble.synthesis.kkt_structures import KeptPlan
from amble.synthesis.program import GaitProgram


def _listed(kept: KeptPlan, what: str, count: int) -> list[tuple[int, int]]:
    block, place = (getattr(kept.plan, f"{what}_{name}")[:count] for name in ("block", "place"))
    return list(zip(block, place, strict=True))


def test_every_number_has_one_place(small_program: GaitProgram) -> None:
    """The diagonal shares those of the Hessian's own diagonal; nothing else does."""
    kept, nlp = build_plan(small_program), small_program.program
    hessian = nlp.hessian.sparsity_out(0)
    jacobian = _listed(kept, "jacobian", jacobian_pattern(small_program).rows.size)
    curved = _listed(kept, "hessian", hessian.nnz())
    diagonal = _listed(kept, "diagonal", small_program.layout.size)
    assert max(Counter(jacobian + curved).values()) == 1
    assert max(Counter(jacobian + diagonal).values()) == 1
    assert min(number for pair in jacobian + curved + diagonal for number in pair) >= 0
    rows, columns = (np.array(part) for part in hessian.get_triplet())
    shared = {curved[k] for k in np.flatnonzero(rows == columns)}
    assert set(curved) & set(diagonal) == shared


def test_programs_of_one_structure_share_a_plan(small_program: GaitProgram) -> None:
    plan = build_plan(small_program)
    free = small_program.lower < small_program.upper
    wider = np.where(free, small_program.upper + 1.0, small_program.upper)
    assert build_plan(replace(small_program, upper=wider)) is plan
    fixed = small_program.lower.copy()
    torque = small_program.layout.domains[0].u[3, 0]
    fixed[torque] = small_program.upper[torque]
    assert build_plan(replace(small_program, lower=fixed)) is not plan
