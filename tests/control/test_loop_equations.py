"""The closed loop as linear equations: their solution is what the eliminated formulas give."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from examples.extending.phase_configuration import ConfigurationPhase

from amble.control import AllocationLaw, DropActuator, MinimumPeak, PseudoInverse, WeightedMinimumNorm
from amble.control.driven_loop import driven_motion
from amble.control.linearisation import linearise
from amble.control.loop_equations import LoopEquations, driven_equations, law_rows, linearised_equations
from amble.control.phase import Phase, TimePhase
from amble.control.virtual_constraints import VirtualConstraints, output_null_space
from amble.errors import InputError
from amble.hybrid import Contacts, Stance
from tests.control.allocation.stances import random_postures
from tests.robots import robot

ORDER = 4
TWO = ("fr", "rl")
WEIGHTED = WeightedMinimumNorm({"fr_hip_pitch": 3.0, "rl_knee": 0.5})
SWAYING = ConfigurationPhase({"S": {"y": -1.0, "roll": 0.5}})
SLOW = pytest.mark.slow
CASES = [
    pytest.param("astro", (), 12, PseudoInverse(), TimePhase(), marks=SLOW),
    pytest.param("astro", ("rl",), 12, PseudoInverse(), TimePhase(), marks=SLOW),
    ("astro", TWO, 11, PseudoInverse(), TimePhase()),
    ("astro", TWO, 11, WEIGHTED, TimePhase()),
    ("astro", TWO, 11, DropActuator(("rl_hip_pitch",)), TimePhase()),
    ("astro", TWO, 11, PseudoInverse(), SWAYING),
    pytest.param("astro", ("fl", "fr", "rl", "rr"), 6, PseudoInverse(), TimePhase(), marks=SLOW),
    pytest.param("go2", ("fl", "fr", "rl"), 9, PseudoInverse(), TimePhase(), marks=SLOW),
    pytest.param("anymal_b", TWO, 11, PseudoInverse(), TimePhase(), marks=SLOW),
]


def agree(loop: LoopEquations, arguments: list[ca.SX], expected: list[ca.SX], values: list[np.ndarray]) -> None:
    """Both sides round at 1e-16 times the condition of M; 50 of that, relative to the largest number."""
    parts = [loop.matrix, loop.right, *expected]
    matrix, right, *others = ca.Function("both", arguments, [ca.densify(part) for part in parts])(*values)
    solution = ca.SX(ca.DM(np.linalg.solve(np.asarray(matrix), np.asarray(right))))
    rounding = 50.0 * np.finfo(float).eps * np.linalg.cond(np.asarray(matrix))
    assert rounding < 1e-7  # else the state tests nothing
    for found, other in zip(loop.parts(solution), others, strict=True):
        size = max(1.0, float(np.abs(np.asarray(other)).max(initial=0.0)))
        np.testing.assert_allclose(np.asarray(ca.evalf(found)), np.asarray(other), atol=rounding * size)


@pytest.mark.parametrize(("name", "feet", "outputs", "law", "phase"), CASES)
def test_their_solution_is_the_closed_loop(
    name: str, feet: tuple[str, ...], outputs: int, law: AllocationLaw, phase: Phase
) -> None:
    model, random = robot(name), np.random.default_rng(0)
    contacts, stance = Contacts(model, feet), Stance("S", feet)
    q, v, t = ca.SX.sym("q", model.size), ca.SX.sym("v", model.size), ca.SX.sym("t")
    constraints = VirtualConstraints.symbols(outputs, model.size - 3, ORDER, phase)
    rates = constraints.phase_rates(model, stance, t, q, v)
    loop = linearised_equations(contacts, law, (q, v), rates, constraints)
    closed = linearise(contacts, law, q, v, rates, constraints)
    expected = [closed.acceleration, closed.torques, closed.forces]
    for at, moving in zip(*random_postures(name, 5, 1), strict=True):
        references = at[3:, None] + random.normal(0.0, 0.1, (model.size - 3, ORDER + 1))
        kernel = output_null_space(random.normal(size=(outputs, model.size - 3)))
        numbers = random.uniform(0.5, 1.0, len(phase.numbers))
        p = np.concatenate([[0.2], numbers, [100.0, 20.0], references.ravel("F"), kernel.ravel("F")])
        agree(loop, [q, v, t, constraints.packed()], expected, [at, moving, np.array(0.1), p])


@pytest.mark.parametrize("name", ["astro", pytest.param("go2", marks=SLOW)])
def test_driven_loops_solve_theirs(name: str) -> None:
    model, random = robot(name), np.random.default_rng(1)
    contacts, gains = Contacts(model, TWO), random.normal(size=(len(model.joints), 2 * model.size))

    def torques(_: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        return ca.DM(gains) @ ca.vertcat(q, v) + t + p

    symbols, motion = driven_motion(contacts, torques, 1)
    loop = driven_equations(contacts, motion.torques, (symbols[1][: model.size], symbols[1][model.size :]))
    for at, moving in zip(*random_postures(name, 5, 2), strict=True):
        expected = [motion.acceleration, motion.torques, motion.forces]
        agree(loop, symbols, expected, [np.array(0.3), np.concatenate([at, moving]), np.array(0.7)])


def test_a_law_with_breakpoints_has_no_rows() -> None:
    model = robot("astro")
    q, v = ca.SX.sym("q", model.size), ca.SX.sym("v", model.size)
    with pytest.raises(InputError, match="do not solve linear equations"):
        law_rows(Contacts(model, TWO), MinimumPeak(), q, v)


def test_the_number_of_outputs_must_fit() -> None:
    model = robot("astro")
    q, v, t = ca.SX.sym("q", model.size), ca.SX.sym("v", model.size), ca.SX.sym("t")
    constraints = VirtualConstraints.symbols(10, model.size - 3, ORDER)
    rates = constraints.phase_rates(model, Stance("S", TWO), t, q, v)
    with pytest.raises(InputError, match="exactly 11 outputs"):
        linearised_equations(Contacts(model, TWO), PseudoInverse(), (q, v), rates, constraints)
