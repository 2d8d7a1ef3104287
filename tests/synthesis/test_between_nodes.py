"""Accelerations between nodes: the same curves as at the nodes, at instants that are near each other."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from examples.extending.phase_configuration import ConfigurationPhase

from amble.numerics.bezier import evaluate
from amble.synthesis import GaitProblem, gait_problem
from amble.synthesis.between_nodes import WIDEST, between_nodes, instants_between
from amble.synthesis.layout import MARGIN, build_layout
from amble.synthesis.node_block import parameter_values
from tests.robots import robot


@pytest.fixture(scope="module")
def problem() -> GaitProblem:
    return gait_problem(robot("astro"), "amble", speed=0.2, scheme="lobatto-5")


def test_rows_are_second_derivatives_of_the_curves(problem: GaitProblem) -> None:
    """By central differences of the curves over time, at random coefficients."""
    layout, random = build_layout(problem), np.random.default_rng(4)
    for domain in layout.domains:
        (block,) = between_nodes(problem, domain)
        function = ca.Function("rows", [block.variables, block.constants, block.parameters], [block.rows])
        alpha, T = random.normal(size=(block.rows.shape[0], problem.outputs.order + 1)), 0.3
        for share in block.values[::7, 0]:
            times = np.array([share - 1e-3, share, share + 1e-3])
            before, at, after = evaluate(alpha, times)[0]
            wanted = (before - 2.0 * at + after) / (1e-3 * T) ** 2
            found = function([T, *alpha.ravel(order="F")], share, parameter_values(problem))
            size = np.abs(wanted).max()
            np.testing.assert_allclose(np.asarray(found).ravel(), wanted, atol=1e-5 * size)  # the fourth derivative
        most = problem.limits.acceleration
        np.testing.assert_array_equal(block.upper, np.full(block.upper.shape, most))
        np.testing.assert_array_equal(block.lower, -block.upper)
        (held,) = between_nodes(replace(problem, node_margins=True), domain)
        np.testing.assert_allclose(held.upper, most * (1.0 - MARGIN))


@pytest.mark.parametrize(("scheme", "intervals"), [("lobatto-5", 2), ("lobatto-5", 5), ("lobatto-7", 3)])
def test_no_two_instants_are_far_apart(problem: GaitProblem, scheme: str, intervals: int) -> None:
    nodes = build_layout(replace(problem, scheme=scheme, intervals=intervals)).domains[0].phases
    more = instants_between(nodes)
    assert np.diff(np.sort([*nodes, *more])).max() <= WIDEST * (1.0 + 1e-12)
    assert not np.isin(np.round(more, 12), np.round(nodes, 12)).any()
    spacing = np.diff(nodes).max()
    assert more.size <= (nodes.size - 1) * np.ceil(spacing / WIDEST)


def test_where_there_is_nothing_to_bound(problem: GaitProblem) -> None:
    """The default scheme, no limit, curves over the configuration, nodes that are near each other."""
    by_state = replace(problem.outputs, phase=ConfigurationPhase({"D1": {"x": 1.0}, "D2": {"x": 1.0}}))
    for other in (
        replace(problem, scheme="hermite-simpson"),
        replace(problem, limits=replace(problem.limits, acceleration=np.inf)),
        replace(problem, outputs=by_state),
        replace(problem, intervals=20),
    ):
        for domain in build_layout(other).domains:
            assert between_nodes(other, domain) == []
