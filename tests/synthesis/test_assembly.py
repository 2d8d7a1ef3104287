"""A program of small blocks against casadi's derivatives of the whole, written without blocks."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from amble.synthesis.assembly import Program, assemble
from amble.synthesis.block import Block, Label

COUNT = 7
GENERATOR = np.random.default_rng(0)
SCALE = GENERATOR.uniform(0.2, 5.0, COUNT)
ROW_SIZES, COST_SCALE = {"m": 0.3, "N": 7.0, "1": 2.0}, 0.11
CONSTANTS = GENERATOR.normal(size=(COUNT - 2, 2))


def pair_block() -> Block:
    """Rows of two neighbours and of the shared last variable, repeated along a chain."""
    w, c, p = ca.SX.sym("w", 3), ca.SX.sym("c", 2), ca.SX.sym("p", 2)
    instances = COUNT - 2
    chain = np.arange(instances)
    return Block(
        name="pair",
        variables=w,
        constants=c,
        parameters=p,
        rows=ca.vertcat(ca.sin(w[0]) * w[1] - c[0], w[1] ** 2 * w[2] + p[0] * w[0]),
        cost=c[1] * (w[0] - w[1]) ** 2 * ca.exp(w[2]) + p[1] * w[0] ** 4,
        labels=(Label("wave", "sine", "m"), Label("power", "square", "N")),
        columns=np.column_stack([chain, chain + 1, np.full(instances, COUNT - 1)]),
        values=CONSTANTS,
        places=tuple(f"link {k}" for k in chain),
        lower=np.zeros((instances, 2)),
        upper=np.tile([0.0, np.inf], (instances, 1)),
    )


def end_block() -> Block:
    """One row without cost or constants."""
    w = ca.SX.sym("w", 2)
    return Block(
        name="end",
        variables=w,
        constants=ca.SX(0, 1),
        parameters=ca.SX.sym("p", 2),
        rows=ca.vertcat(w[0] * w[1] ** 3),
        cost=ca.SX(1, 1),
        labels=(Label("power", "product"),),
        columns=np.array([[0, COUNT - 1]]),
        values=np.zeros((1, 0)),
        places=("end",),
        lower=np.array([[-1.0]]),
        upper=np.array([[1.0]]),
    )


@pytest.fixture(scope="module")
def program() -> Program:
    return assemble([pair_block(), end_block()], SCALE, 2, ROW_SIZES.__getitem__, COST_SCALE, 1e9)


@pytest.fixture(scope="module")
def whole() -> ca.Function:
    """(x, p) -> f, g, gradient, Jacobian, and (x, p, sigma, lam) -> Hessian, written plainly."""
    x, p = ca.SX.sym("x", COUNT), ca.SX.sym("p", 2)
    sigma, lam = ca.SX.sym("sigma"), ca.SX.sym("lam", 2 * (COUNT - 2) + 1)
    z, f, g = x * SCALE, 0, []
    for k in range(COUNT - 2):
        a, b, last = z[k], z[k + 1], z[COUNT - 1]
        g += [(ca.sin(a) * b - CONSTANTS[k, 0]) / 0.3, (b**2 * last + p[0] * a) / 7.0]
        f += CONSTANTS[k, 1] * (a - b) ** 2 * ca.exp(last) + p[1] * a**4
    g.append(z[0] * z[COUNT - 1] ** 3 / 2.0)
    f = f / COST_SCALE
    rows = ca.vertcat(*g)
    hessian = ca.triu(ca.hessian(sigma * f + ca.dot(lam, rows), x)[0])
    parts = [f, rows, ca.gradient(f, x), ca.jacobian(rows, x), hessian]
    return ca.Function("whole", [x, p, sigma, lam], [ca.densify(part) for part in parts])


@pytest.mark.parametrize("seed", range(5))
def test_values_and_derivatives(program: Program, whole: ca.Function, seed: int) -> None:
    generator = np.random.default_rng(seed)
    x, p = generator.normal(0.0, 0.3, COUNT), generator.normal(size=2)
    sigma, lam = generator.normal(), generator.normal(size=2 * (COUNT - 2) + 1)
    f, g, gradient, jacobian, hessian = (np.asarray(part) for part in whole(x, p, sigma, lam))
    ours = [
        (program.nlp(x, p)[0], f),
        (program.nlp(x, p)[1], g),
        (program.gradient(x, p)[0], f),
        (program.gradient(x, p)[1], gradient),
        (program.jacobian(x, p)[0], g),
        (program.jacobian(x, p)[1].full(), jacobian),
        (program.hessian(x, p, sigma, lam).full(), hessian),
    ]
    for value, expected in ours:
        # the same formulas, summed in another order
        np.testing.assert_allclose(np.asarray(value), expected, rtol=1e-12, atol=1e-12)


def test_rows_are_named_and_bounded_in_order(program: Program) -> None:
    assert program.row_names[:3] == ("link 0 sine", "link 0 square", "link 1 sine")
    assert program.row_names[-1] == "end product"
    assert list(program.row_kinds[:3]) == ["wave", "power", "wave"]
    assert list(program.row_instances) == [*np.repeat(np.arange(COUNT - 2), 2), 0]
    assert program.lower[-1] == -0.5
    assert program.row_units[:2].tolist() == ["m", "N"]
    assert program.row_scale[[0, 1, -1]].tolist() == [0.3, 7.0, 2.0]
    assert program.upper[1] == np.inf
    assert len(program.row_names) == program.lower.size == program.upper.size == program.nlp.numel_out(1)


def test_the_hessian_is_an_upper_triangle_without_repeated_places(program: Program) -> None:
    rows, columns = program.hessian.sparsity_out(0).get_triplet()
    assert all(row <= column for row, column in zip(rows, columns, strict=True))
    assert len(set(zip(rows, columns, strict=True))) == len(rows)


def test_programs_that_differ_in_bounds_alone_share_their_functions(program: Program) -> None:
    """Constants and places of variables make others; bounds and names do not."""

    def build(**changes: object) -> Program:
        blocks = [replace(pair_block(), **changes), end_block()]
        return assemble(blocks, SCALE, 2, ROW_SIZES.__getitem__, COST_SCALE, 1e9)

    same = build(lower=np.full((COUNT - 2, 2), -1.0), places=tuple("abcde"))
    assert same.jacobian is program.jacobian
    assert same.lower[0] == pytest.approx(-1.0 / ROW_SIZES["m"])
    assert same.row_names[0] == "a sine"
    assert build(values=2.0 * CONSTANTS).jacobian is not program.jacobian
    assert build(columns=pair_block().columns[::-1]).jacobian is not program.jacobian
    other = assemble([pair_block(), end_block()], 2.0 * SCALE, 2, ROW_SIZES.__getitem__, COST_SCALE, 1e9)
    assert other.jacobian is not program.jacobian
