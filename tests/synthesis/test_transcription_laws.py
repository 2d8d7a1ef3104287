"""Rows of the gait problem against Pinocchio and polynomials, over foreign robots and stances of every kind of gait."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np
import pytest

from amble.numerics.collocation import HERMITE_SIMPSON, STAGES
from amble.synthesis import GaitProblem, gait_problem
from amble.synthesis.block import Block
from amble.synthesis.layout import build_layout
from amble.synthesis.link_blocks import defect_block
from amble.synthesis.node_block import node_block, parameter_values
from tests.oracle import oracle
from tests.robots import FOREIGN_QUADRUPEDS, random_states, robot

GAITS = ("trot", "bound", "walk", "pronk")
"""Stances of two feet on a diagonal and on a lateral line, of three and four, of none and four."""

SLOW = [pytest.param(each.values[0], gait, marks=each.marks) for each in FOREIGN_QUADRUPEDS for gait in GAITS]
CASES = [("go2", "walk"), ("anymal_b", "pronk"), *SLOW, pytest.param("bolt", "walk", marks=pytest.mark.slow)]
"""A robot of every file for `make slow`; solo8 has two joints a leg."""


@lru_cache(maxsize=2)
def posed(name: str, gait: str, scheme: str = HERMITE_SIMPSON) -> GaitProblem:
    return gait_problem(robot(name), gait, speed=0.1, intervals=2, scheme=scheme)


def rows(problem: GaitProblem, block: Block, variables: np.ndarray) -> dict[str, float]:
    function = ca.Function("rows", [block.variables, block.constants, block.parameters], [block.rows])
    values = np.asarray(function(variables, [0.3, 1.0], parameter_values(problem))).ravel()
    return dict(zip((label.name for label in block.labels), values, strict=True))


@pytest.mark.parametrize(("name", "gait"), CASES)
def test_dynamics_and_contacts_of_every_stance_equal_pinocchio(name: str, gait: str) -> None:
    """D a + h - S' u - J' lambda, and J a + dJ/dt v, at random nodes; swing feet by their heights."""
    problem = posed(name, gait)
    model, theirs, generator = problem.pattern.robot, oracle(name), np.random.default_rng(1)
    layout = build_layout(problem)
    (q,), (v,) = random_states(model, 1, seed=2)
    a, u = 10.0 * generator.normal(size=model.size), generator.normal(0.0, 20.0, len(model.joints))
    for domain in layout.domains:
        block = node_block(problem, layout, domain)
        feet = domain.stance.feet
        force = generator.normal(0.0, 50.0, 3 * len(feet))
        rest = generator.normal(0.3, 0.1, block.variables.numel() - 3 * model.size - u.size - force.size)
        found = rows(problem, block, np.concatenate([q, v, a, u, force, rest]))
        columns = [3 * model.foot_names.index(foot) + axis for foot in feet for axis in range(3)]
        J, bias = theirs.jacobian(q)[columns], theirs.jacobian_bias(q, v)[columns]
        balance = theirs.inverse_dynamics(q, v, a) - np.concatenate([np.zeros(6), u]) - J.T @ force
        ours = np.array([found[f"dynamics {coordinate}"] for coordinate in model.coordinate_names])
        np.testing.assert_allclose(ours, balance, atol=1e-10 * np.abs(balance).max())
        contact = [found[f"contact {foot} {axis}"] for foot in feet for axis in "xyz"]
        np.testing.assert_allclose(contact, J @ a + bias, atol=1e-10 * np.abs(a).max() * 10.0)
        heights = theirs.positions(q)[:, 2]
        for place, foot in enumerate(model.foot_names):
            assert (foot in feet) != (f"height {foot}" in found)
            if foot not in feet:
                assert found[f"height {foot}"] == pytest.approx(heights[place], abs=1e-12)
    if gait == "pronk":
        assert any(not domain.stance.feet for domain in layout.domains)


@pytest.mark.parametrize("scheme", STAGES)
@pytest.mark.parametrize(("name", "gait"), CASES)
def test_defects_vanish_on_what_the_scheme_integrates_exactly(name: str, gait: str, scheme: str) -> None:
    """Rates of degree s - 1 in time; not of degree s + 1."""
    problem = posed(name, gait, scheme)
    most, nodes = problem.collocation.stages - 1, problem.collocation.nodes
    layout, generator, duration = build_layout(problem), np.random.default_rng(3), 0.4
    for domain in layout.domains:
        block = defect_block(problem, layout, domain)
        function = ca.Function("rows", [block.variables, block.constants, block.parameters], [block.rows])
        free = (block.variables.numel() - 1) // (3 * nodes.size)
        coefficients, power = generator.normal(size=(free, most + 3)), np.arange(most + 3)
        for degree, exact in ((most, True), (most + 2, False)):
            c = np.where(power <= degree, coefficients, 0.0)
            times = duration / problem.intervals * nodes[:, None]
            v, q = times**power @ c.T, (times ** (power + 1) / (power + 1)) @ c.T
            a = (power[1:] * times ** (power[1:] - 1)) @ c[:, 1:].T
            variables = np.concatenate([q.ravel(), v.ravel(), a.ravel(), [duration]])
            found = np.asarray(function(variables, 1.0 / problem.intervals, parameter_values(problem)))
            assert bool(np.abs(found).max(initial=0.0) < 1e-12) == (exact or not free)
