"""Steps of fields whose accelerations solve linear equations, against exact motions and points in 60 digits."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from flint import arb, arb_mat

from amble.control.loop_equations import LoopEquations
from amble.proof.arithmetic import column, exact_matrix, working_precision
from amble.proof.loop_field import LoopField
from amble.proof.loop_tapes import LoopTapes
from amble.proof.step import Step, StepError
from amble.types import Matrix, Vector
from tests.proof.points import moved

GRAVITY, ORDER = 9.8125, 20


def field(matrix: ca.SX, right: ca.SX, x: ca.SX, t: ca.SX) -> LoopField:
    loop = LoopEquations(
        matrix=matrix, right=ca.densify(right), load=1.0, accelerations=x.shape[0] // 2, torques=0, forces=0
    )
    return LoopField(LoopTapes.of(loop, [t, x, ca.SX.sym("p", 0)], np.zeros(0)))


def double_pendulum() -> LoopField:
    """Two unit masses on unit rods, angles from below, hinge torque sin(3 t)."""
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 4)
    a, b, u, v = ca.vertsplit(x)
    matrix = ca.vertcat(ca.horzcat(2, ca.cos(a - b)), ca.horzcat(ca.cos(a - b), 1))
    right = ca.vertcat(
        -(v**2) * ca.sin(a - b) - 2 * GRAVITY * ca.sin(a) + ca.sin(3 * t),
        u**2 * ca.sin(a - b) - GRAVITY * ca.sin(b),
    )
    return field(matrix, right, x, t)


def pendulum_rate(t: arb, x: list[arb]) -> list[arb]:
    """The same with the accelerations written out by Cramer's rule."""
    a, b, u, v = x
    s, c = (a - b).sin(), (a - b).cos()
    first = -(v**2) * s - 2 * arb(GRAVITY) * a.sin() + (3 * t).sin()
    second = u**2 * s - arb(GRAVITY) * b.sin()
    size = 2 - c**2
    return [u, v, (first - c * second) / size, (2 * second - c * first) / size]


def after(start: Vector, length: arb) -> list[arb]:
    """Where a point comes to, with the rounding of the integrator: about 1e-36 by doubling its columns."""
    end = moved(pendulum_rate, arb(CLOCK), [arb(float(value)) for value in start], length, 2)
    return [value + arb(0, 1e-33) for value in end]


START, RADIUS, CLOCK, LENGTH = np.array([0.5, -0.25, 1.5, -2.0]), 2.0**-30, 0.125, 2.0**-6


def pendulum_step(radius: float, length: float = LENGTH) -> Step:
    centre = [arb(float(value)) for value in START]
    return double_pendulum().step(arb(CLOCK), centre, [value + arb(0, radius) for value in centre], arb(length), ORDER)


def test_random_starts_land_in_the_image() -> None:
    """Points of the box, whose accelerations are solved by hand; the slope holds for all of them."""
    draws = np.random.default_rng(0)
    with working_precision(128):
        done = pendulum_step(RADIUS)
        centre = after(START, arb(LENGTH))
        assert all(ball.overlaps(value) for ball, value in zip(done.image, centre, strict=True))
        assert max(float(ball.rad()) for ball in done.image) < 1e-18
        assert max(float(ball.rad()) for ball in done.slope.entries()) < 1e-5
        for _ in range(10):
            offset = RADIUS * draws.integers(-(2**15), 2**15 + 1, 4) / 2**15  # exact when added
            reached = (done.slope * column([arb(float(value)) for value in offset])).entries()
            image = [at + extra for at, extra in zip(done.image, reached, strict=True)]
            assert all(
                ball.overlaps(value) for ball, value in zip(image, after(START + offset, arb(LENGTH)), strict=True)
            )


def test_parts_hold_the_motion_its_rate_and_the_solution() -> None:
    with working_precision(128):
        done = pendulum_step(RADIUS)
        assert float(done.parts[0].during.lower()) <= CLOCK
        assert float(done.parts[-1].during.upper()) >= CLOCK + LENGTH
        for before, later in zip(done.parts[:-1], done.parts[1:], strict=True):
            assert before.during.overlaps(later.during)
        for part in done.parts:
            state = after(START + RADIUS, (part.during.mid() - CLOCK).mid())
            rate = pendulum_rate(part.during.mid(), state)
            assert all(ball.contains(value) for ball, value in zip(part.box, state, strict=True))
            assert all(ball.contains(value) for ball, value in zip(part.rate, rate, strict=True))
            assert part.solution == part.rate[2:]


@pytest.mark.parametrize(("size", "seed"), [(2, 0), (4, 1)])
def test_linear_systems_against_the_matrix_exponential(size: int, seed: int) -> None:
    """M q'' = -K q - D v: flow and slope are exp(h A); Arb's exponential is another algorithm."""
    draws = np.random.default_rng(seed)
    mass = (draws.normal(size=(size, size)) + 4.0 * np.eye(size)).round(3)
    rest = draws.normal(size=(size, 2 * size)).round(3)

    def exact(mass: Matrix, rest: Matrix) -> arb_mat:
        lower = exact_matrix(mass).solve(exact_matrix(rest)).tolist()
        upper = np.hstack([np.zeros((size, size)), np.eye(size)]).tolist()
        return arb_mat([*upper, *lower])

    with working_precision(128):
        x = ca.SX.sym("x", 2 * size)
        linear = field(ca.SX(ca.DM(mass)), ca.DM(rest) @ x, x, ca.SX.sym("t"))
        centre = [arb(float(value)) for value in draws.normal(size=2 * size)]
        done = linear.step(arb(0), centre, [value + arb(0, 1e-9) for value in centre], arb(0.125), ORDER)
        flow = (exact(mass, rest) * done.length).exp()
        image = (flow * column(centre)).entries()
        assert all(ball.overlaps(value) for ball, value in zip(done.image, image, strict=True))
        assert max(float(ball.rad()) for ball in done.image) < 1e-20
        assert all(ball.overlaps(value) for ball, value in zip(done.slope.entries(), flow.entries(), strict=True))
        assert max(float(ball.rad()) for ball in done.slope.entries()) < 1e-12


def test_defects_of_several_equations_do_not_cancel() -> None:
    """Bounds of both defects are as 8 to 9, so that C = ((1, -8/9), (0, 1)) takes them to 0; what they miss adds up.

    A push cos 3 t on the first mass, its contrary with a spring on the second: the first goes on as the second does.
    """
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 4)
    push = ca.cos(3 * t)
    pushed = field(ca.SX(ca.DM([[1, 8 / 9], [0, 1]])), ca.vertcat(push, -push - x[1]), x, t)
    with working_precision(128):
        centre, length = [arb(0)] * 4, arb(0.125)
        done = pushed.step(arb(0), centre, centre, length, 4)
        once, thrice = length.cos(), (3 * length).cos()
        first, second = 2 * (1 - thrice) / 9 - (1 - once) / 9, (thrice - once) / 8
        assert done.image[0].overlaps(first + arb(0, 1e-16))  # 8/9 is a double
        assert done.image[1].contains(second.mid())


def test_a_step_that_is_too_long_is_refused() -> None:
    with working_precision(128), pytest.raises(StepError, match=r"too long|invertible|stay in the tube"):
        pendulum_step(RADIUS, 2.0)


def test_a_matrix_that_may_be_singular_is_refused() -> None:
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 2)
    fading = field(ca.SX(1 - t), x[:1], x, t)
    with working_precision(128), pytest.raises(StepError):
        fading.step(arb(0), [arb(1), arb(0)], [arb(1), arb(0)], arb(1.5), ORDER)
