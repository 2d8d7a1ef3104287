from __future__ import annotations

import itertools

import casadi as ca
import numpy as np
import pytest
from examples import simplest_walker

from amble.errors import FallError, NotSolvedError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.progress import ProgressReport
from amble.stability import fixed_point, poincare_map
from tests.hybrids import bouncing_ball, travelling, two_phases


def test_newton_converges_quadratically() -> None:
    found = fixed_point(two_phases(), np.array([0.0, 1.0, 0.2]))
    assert found.residual < 1e-12
    assert poincare_map(two_phases(), found.state) == pytest.approx(found.state, abs=1e-11)
    logs = np.log(np.array(found.history[:-1]))
    above = [pair for pair in itertools.pairwise(logs) if pair[0] < np.log(1e-1) and pair[1] > np.log(1e-11)]
    assert above
    assert all(second < 1.5 * first for first, second in above)


@pytest.mark.parametrize("mirror", [1, -1])
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_a_walker_that_moves_on_is_periodic_up_to_its_symmetries(turn: float, mirror: int) -> None:
    system = travelling(turn, mirror)
    guess = np.array([0.0, 0.3, 1.0, -2.0, 0.4])
    found = fixed_point(system, guess)
    assert found.residual < 1e-11
    assert set(found.shift) == {"x", "y", "heading"}
    # a Newton step has no part along the symmetries: the first of them keeps the heading of the guess
    assert found.state[4] == pytest.approx(guess[4], abs=0.1)
    moved = poincare_map(system, found.state) - found.state
    if mirror == 1:  # else the amounts also undo the mirror
        assert found.shift["heading"] == pytest.approx(moved[4], abs=1e-10)


def test_progress_is_reported() -> None:
    steps: list[ProgressReport] = []
    found = fixed_point(two_phases(), np.array([0.0, 1.0, 0.2]), progress=steps.append)
    assert [step.value for step in steps] == list(found.history[1:])
    assert [step.done for step in steps] == list(range(1, len(found.history)))


def test_no_fixed_point_ends_with_the_rows() -> None:
    system = _drifting()
    with pytest.raises(NotSolvedError, match=r"P\(x\) - x of far") as caught:
        fixed_point(system, np.array([0.5]))
    assert caught.value.rows[0].value == pytest.approx(2.0)


def _drifting() -> HybridSystem:
    """A cycle lasts 1 s and moves the state by 2: no fixed point, and no symmetry declared."""
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 1), ca.SX.sym("p", 0)
    field = ca.Function("field", [t, x, p], [ca.SX(2) * ca.SX.ones(1)], ["t", "x", "p"], ["r"])
    guard = ca.Function("guard", [t, x, p], [t - 1], ["t", "x", "p"], ["g"])
    reset = ca.Function("reset", [t, x, p], [x], ["t", "x", "p"], ["s"])
    return HybridSystem(
        [Domain(name="drift", field=field)],
        [Transition(source="drift", target="drift", guard=guard, reset=reset, direction=1)],
        (),
        ("far",),
    )


def test_a_guess_that_falls_says_so() -> None:
    with pytest.raises(FallError, match="fell"):
        fixed_point(bouncing_ball(0.5, floor=3.0), np.array([0.0, 1.0]))


def test_a_poor_guess_is_damped() -> None:
    walker = simplest_walker.simplest_walker()
    poor, good = (simplest_walker.find_orbit(walker, guess)[0] for guess in ((0.22, -0.215), simplest_walker.LONG_STEP))
    assert poor.state == pytest.approx(good.state, abs=1e-9)
    assert list(poor.history) == sorted(poor.history, reverse=True)


def test_a_residual_that_no_step_reduces_may_be_enough() -> None:
    """x + x^2 + 5e-10 has no fixed point, and nothing nearer to one than a residual of 5e-10, its slope there 1."""
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 1), ca.SX.sym("p", 0)
    names = ["t", "x", "p"], ["r"]
    passing = Transition(
        source="rest",
        target="rest",
        guard=ca.Function("guard", [t, x, p], [t - 1], *names),
        reset=ca.Function("reset", [t, x, p], [x + x**2 + 5e-10], *names),
        direction=1,
    )
    resting = Domain(name="rest", field=ca.Function("field", [t, x, p], [0 * x], *names))
    system = HybridSystem([resting], [passing], (), ("x",))
    for enough in (0.0, 4e-10):
        with pytest.raises(NotSolvedError, match="no Newton step reduces the residual"):
            fixed_point(system, np.array([0.01]), enough=enough)
    found = fixed_point(system, np.array([0.01]), enough=1e-9)
    assert found.residual * (1.0 + 1e-6) >= 5e-10
    assert found.residual <= 1e-9
