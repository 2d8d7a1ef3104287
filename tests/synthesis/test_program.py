"""The transcribed gait problem: layout, names, derivatives against differences, order of convergence, rank."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from amble.errors import NotSolvedError
from amble.gait import Gait
from amble.synthesis import GaitProblem
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import (
    COARSE,
    GaitProgram,
    build_program,
    on_coarse_mesh,
    require_full_rank,
    smallest_singular_value,
)
from amble.synthesis.refine import Split
from amble.synthesis.result import from_gait
from amble.synthesis.rows import RowKind
from amble.synthesis.violated_rows import variable_names
from amble.types import Vector
from amble.verification.domain_rows import sampled
from amble.verification.output_dynamics import integrate
from tests.grounds import on_friction


@pytest.fixture(scope="module")
def point(small_program: GaitProgram) -> Vector:
    """Scaled variables near the start of the solver, where no row is special."""
    natural = initial_guess(small_program.problem, small_program.layout)
    step = np.random.default_rng(0).uniform(-0.02, 0.02, natural.size)
    return np.asarray(natural / small_program.layout.scale + step)


def test_every_variable_has_one_place_and_one_name(small_program: GaitProgram) -> None:
    layout = small_program.layout
    kinds = ("q", "v", "a", "u", "force", "duration", "coefficients", "impulse")
    places = [getattr(domain, kind).ravel() for domain in layout.domains for kind in kinds]
    assert sorted(np.concatenate([*places, layout.period])) == list(range(layout.size))
    names = variable_names(small_program)
    assert len(set(names)) == layout.size
    assert "D1 node 0 rate of fr_knee" in names
    assert "D2 node 10 force rr z" in names
    assert "D1 coefficient fl_knee 2" in names
    assert "D1 impulse rr z" in names
    assert "period" in names


def test_coefficients_and_impulses_are_named_by_what_they_are(small_program: GaitProgram, walking_gait: Gait) -> None:
    """The name of a coefficient or an impulse is that of the number at its place in the gait's record."""
    layout, names = small_program.layout, variable_names(small_program)
    start = from_gait(small_program.problem, walking_gait, layout)
    outputs = walking_gait.outputs
    for domain, number in (("D1", 0), ("D2", 1)):
        record = walking_gait.domains[number]
        controlled = outputs.of(domain).coordinates
        feet = walking_gait.pattern.switches[number].target.feet
        expected = {
            f"{domain} coefficient {name} {k}": record.coefficients[row, k]
            for row, name in enumerate(controlled)
            for k in range(outputs.order + 1)
        }
        axes = [f"{domain} impulse {foot} {axis}" for foot in feet for axis in "xyz"]
        expected |= dict(zip(axes, record.impulse, strict=True))
        for name, value in expected.items():
            assert start[names.index(name)] == value


def test_every_row_has_a_kind_of_its_own_sort(small_program: GaitProgram) -> None:
    """Kinds are as many as the law of counting says: per node, foot, joint, output and switch."""
    program, problem = small_program.program, small_program.problem
    robot, nodes, intervals = problem.pattern.robot, 2 * problem.intervals + 1, problem.intervals
    outputs = sum(len(problem.outputs.of(d.stance.name).coordinates) for d in small_program.layout.domains)
    free = 2 * robot.size - outputs
    counts = {
        RowKind.DYNAMICS: 2 * nodes * robot.size,
        RowKind.CONTACT: 2 * nodes * 6,
        RowKind.OUTPUT: nodes * outputs,
        RowKind.OUTPUT_RATE: nodes * outputs,
        RowKind.OUTPUT_ACCELERATION: nodes * outputs,
        RowKind.LAW: 2 * nodes,
        RowKind.FRICTION: 2 * nodes * 2 * 4,
        RowKind.HEIGHT: 2 * nodes * 2,
        RowKind.NORMAL_FORCE: 0,  # these three are bounds of variables on level ground
        RowKind.BASE_HEIGHT: 0,
        RowKind.LIFT_OFF: 0,
        RowKind.PHASE_RATE: 0,  # time needs neither
        RowKind.PHASE: 0,
        RowKind.BETWEEN_NODES: 0,  # the default scheme has none
        RowKind.DEFECT: intervals * 4 * free,
        RowKind.CONTINUITY: 2 * robot.size,
        RowKind.IMPACT: 2 * (robot.size + 6),
        RowKind.TOUCHDOWN: 2 * 5,  # height, three velocities, depth
        RowKind.PERIOD: 1,
        RowKind.LANDING_ORDER: 2,  # one foot lands at a switch and one is released
        RowKind.LANDING_FORCE: 0,
        RowKind.PART_HEIGHT: 0,  # nobody asked for clearances or a motor
        RowKind.LEGS_APART: 0,
        RowKind.TORQUE_SPEED: 0,
    }
    found = {kind: int(np.sum(program.row_kinds == kind)) for kind in RowKind}
    assert found == counts
    assert sum(counts.values()) == len(program.row_names)


def test_every_row_has_its_own_name(small_program: GaitProgram) -> None:
    names = small_program.program.row_names
    assert len(set(names)) == len(names) == small_program.program.lower.size
    for name in (
        "D1 node 0 dynamics x",
        "D1 node 10 contact rl z",
        "D2 node 3 output fl_knee",
        "D1 node 7 law pinv 0",
        "D2 node 4 friction fr +x",
        "D1 interval 4 defect rate of yaw stage 2",
        "D1 node 0 output rate of fr_knee",
        "D1->D2 impact x",
        "D2->D3 touchdown height fl",
        "period sum of durations",
    ):
        assert name in names


def test_first_derivatives_equal_central_differences(small_program: GaitProgram, point: Vector) -> None:
    nlp, p, step = small_program.program, small_program.parameters, 1e-6
    generator = np.random.default_rng(1)
    gradient = np.asarray(nlp.gradient(point, p)[1]).ravel()
    jacobian = nlp.jacobian(point, p)[1]
    for _ in range(5):
        direction = generator.normal(size=point.size)
        sides = [nlp.nlp(point + sign * step * direction, p) for sign in (1.0, -1.0)]
        slope = float(sides[0][0] - sides[1][0]) / (2.0 * step)
        # rounding 1e-16 / step relative to the cost's size of 1e3, truncation step^2
        assert gradient @ direction == pytest.approx(slope, rel=1e-6)
        rows = np.asarray(sides[0][1] - sides[1][1]).ravel() / (2.0 * step)
        ours = np.asarray(jacobian @ direction).ravel()
        np.testing.assert_allclose(ours, rows, atol=1e-6 * np.abs(rows).max())


def test_second_derivatives_equal_central_differences(small_program: GaitProgram, point: Vector) -> None:
    nlp, p, step = small_program.program, small_program.parameters, 1e-6
    generator = np.random.default_rng(2)
    sigma, lam = 0.7, generator.normal(size=nlp.lower.size)
    upper = nlp.hessian(point, p, sigma, lam)
    hessian = ca.triu2symm(upper)

    def slope(x: Vector) -> Vector:
        return np.asarray(sigma * nlp.gradient(x, p)[1] + nlp.jacobian(x, p)[1].T @ lam).ravel()

    for _ in range(3):
        direction = generator.normal(size=point.size)
        expected = (slope(point + step * direction) - slope(point - step * direction)) / (2.0 * step)
        ours = np.asarray(hessian @ direction).ravel()
        np.testing.assert_allclose(ours, expected, atol=1e-6 * np.abs(expected).max())


def test_parameters_change_no_structure(small_problem: GaitProblem, small_program: GaitProgram) -> None:
    other = build_program(on_friction(replace(small_problem, speed=0.3, gains=(50.0, 10.0)), 0.4))
    assert other.program.row_names == small_program.program.row_names
    np.testing.assert_array_equal(other.parameters, [0.3, 0.0, 0.0, 0.4])
    assert other.program.jacobian.sparsity_out(1) == small_program.program.jacobian.sparsity_out(1)


def test_bounds_follow_the_limits(small_problem: GaitProblem, small_program: GaitProgram) -> None:
    layout, limits = small_program.layout, small_problem.limits
    lower, upper = small_program.lower * layout.scale, small_program.upper * layout.scale
    robot = small_problem.pattern.robot
    for domain in layout.domains:
        assert (lower[domain.duration], upper[domain.duration]) == limits.durations[domain.stance.name]
        for name, bounds in limits.positions.items():
            column = domain.q[:, robot.coordinate_index(name)]
            np.testing.assert_allclose(lower[column], bounds[0], rtol=1e-15)
            np.testing.assert_allclose(upper[column], bounds[1], rtol=1e-15)
        assert np.all(upper[domain.v[:, 6:]] < 4.0)  # inside the speed limit, which the nodes must not touch
        assert np.all(upper[domain.u] < 50.0)
        np.testing.assert_allclose(
            lower[domain.a], -np.tile(list(limits.accelerations(robot).values()), (domain.nodes, 1))
        )
        np.testing.assert_allclose(lower[domain.force[:, 2::3]], limits.normal_force)
        assert np.all(np.isinf(lower[domain.force[:, 0::3]]))
    first = layout.domains[0].q[0]
    assert lower[first[0]] == upper[first[0]] == 0.0
    assert np.isinf(lower[first[1]])  # the mirror fixes the lateral place


INTERVALS = (4, 8, 16)


def test_order_of_convergence_of_the_transcription(walking_gait: Gait, small_problem: GaitProblem) -> None:
    """One domain as an initial value problem, solved by Newton on the program's own rows, against DOP853."""
    domain = sampled(walking_gait, 0, 1)
    start = domain.positions[0], domain.velocities[0]
    ends = np.array([0.0, domain.trajectory.duration])
    exact = np.hstack(integrate(domain.contacts, domain.loop, *start, ends))[-1]
    errors = []
    for intervals in INTERVALS:
        program = build_program(replace(small_problem, intervals=intervals))
        errors.append(np.abs(_end_of_first_domain(program, walking_gait) - exact).max())
    slope = np.polyfit(np.log(1.0 / np.array(INTERVALS)), np.log(errors), 1)[0]
    assert slope == pytest.approx(4.0, abs=0.3), errors  # coarse meshes are not quite in the asymptotic range


def _end_of_first_domain(program: GaitProgram, gait: Gait) -> Vector:
    """(q, v) at the end of D1 where its entry, duration and curves are the gait's and its equality rows hold."""
    layout, nlp, split = program.layout, program.program, Split.of(program)
    domain = layout.domains[0]
    x = from_gait(program.problem, gait, layout) / layout.scale
    for _ in range(12):
        values, slopes = nlp.linearised(x, program.parameters)
        if np.abs(values[split.inner_rows]).max() < 1e-10:
            break
        x[split.inner] -= spsolve(slopes[split.inner_rows][:, split.inner].tocsc(), values[split.inner_rows])
    else:
        pytest.fail("Newton does not converge")
    natural = x * layout.scale
    return np.concatenate([natural[domain.q[-1]], natural[domain.v[-1]]])


def test_the_equality_rows_are_independent(small_program: GaitProgram) -> None:
    natural = initial_guess(small_program.problem, small_program.layout)
    value = require_full_rank(small_program, natural / small_program.layout.scale)
    assert value > 1e-6


def test_a_repeated_row_is_named(small_program: GaitProgram) -> None:
    """A row that repeats another up to its scale is found, whatever its name."""
    nlp = small_program.program
    copied = nlp.row_names.index("D2->D3 touchdown height fl")
    x, p = ca.MX.sym("x", small_program.layout.size), ca.MX.sym("p", small_program.parameters.size)
    g, jacobian = nlp.jacobian(x, p)
    outputs = [ca.vertcat(g, 3.0 * g[copied]), ca.vertcat(jacobian, 3.0 * jacobian[copied, :])]
    twice = replace(
        nlp,
        jacobian=ca.Function("twice", [x, p], outputs),
        row_names=(*nlp.row_names, "the same again"),
        row_kinds=np.append(nlp.row_kinds, "touchdown"),
        row_instances=np.append(nlp.row_instances, 0),
        lower=np.append(nlp.lower, 0.0),
        upper=np.append(nlp.upper, 0.0),
    )
    point = initial_guess(small_program.problem, small_program.layout) / small_program.layout.scale
    with pytest.raises(NotSolvedError, match="depend on each other") as raised:
        require_full_rank(replace(small_program, program=twice), point)
    worst = {row.name.split(" (")[0] for row in raised.value.rows[:2]}
    assert worst == {"the same again", "D2->D3 touchdown height fl"}


def test_the_smallest_singular_value_is_numpys(small_problem: GaitProblem) -> None:
    program = build_program(replace(small_problem, intervals=2))
    nlp, generator = program.program, np.random.default_rng(3)
    point = initial_guess(program.problem, program.layout) / program.layout.scale
    point += generator.uniform(-0.02, 0.02, point.size)
    value, vector = smallest_singular_value(program, point)
    dense = nlp.jacobian(point, program.parameters)[1].full()
    dense = dense[nlp.lower == nlp.upper][:, program.lower < program.upper]
    dense /= np.linalg.norm(dense, axis=1, keepdims=True)
    expected = np.linalg.svd(dense, compute_uv=False)[-1]
    # a Rayleigh quotient is never below; inverse iteration parts close singular values slowly
    assert expected * (1.0 - 1e-9) <= value < 1.05 * expected
    assert np.linalg.norm(vector) == pytest.approx(1.0)


def test_a_fine_mesh_is_thinned_to_the_same_walk(small_problem: GaitProblem) -> None:
    fine = build_program(replace(small_problem, intervals=2 * COARSE))
    natural = initial_guess(fine.problem, fine.layout)
    coarse, variables = on_coarse_mesh(fine, natural)
    assert coarse.problem == replace(fine.problem, intervals=COARSE)
    thin = variables * coarse.layout.scale
    for here, there in zip(fine.layout.domains, coarse.layout.domains, strict=True):
        # every second node of the fine mesh is a node of the coarse one
        for kind in ("q", "v", "a", "u", "force"):
            np.testing.assert_allclose(thin[getattr(there, kind)], natural[getattr(here, kind)][::2], atol=1e-12)
        np.testing.assert_array_equal(thin[there.coefficients], natural[here.coefficients])
    assert require_full_rank(coarse, variables) > 1e-6


def test_a_coarse_mesh_stays(small_problem: GaitProblem) -> None:
    program = build_program(replace(small_problem, intervals=COARSE))
    natural = initial_guess(program.problem, program.layout)
    same, variables = on_coarse_mesh(program, natural)
    assert same is program
    np.testing.assert_allclose(variables * program.layout.scale, natural, rtol=1e-15)


@pytest.mark.parametrize("speed", [0.05, 0.2, 1.0, 20.0])
def test_no_speed_makes_rows_dependent(small_problem: GaitProblem, speed: float) -> None:
    """A speed that no robot walks must fail in the solver, with the rows that it violates, not here."""
    program = build_program(replace(small_problem, speed=speed))
    require_full_rank(*on_coarse_mesh(program, initial_guess(program.problem, program.layout)))


def test_a_shorter_step_is_tried_where_rows_look_dependent(
    small_program: GaitProgram, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A long step may leave the range of a phase; rows that depend on each other do so at every step."""
    inside = np.clip(np.zeros(small_program.lower.size), small_program.lower, small_program.upper)
    found: list[float] = []

    def measured(program: GaitProgram, variables: np.ndarray) -> tuple[float, np.ndarray]:
        found.append(float(np.abs(variables - inside).max()))
        equal = int((program.program.lower == program.program.upper).sum())
        return (1e-3 if found[-1] < limit else 1e-9), np.zeros(equal)

    monkeypatch.setattr("amble.synthesis.program.smallest_singular_value", measured)
    limit = 0.01
    assert require_full_rank(small_program, inside) == 1e-3
    assert len(found) == 2
    limit = 0.0
    with pytest.raises(NotSolvedError, match="equality rows depend on each other"):
        require_full_rank(small_program, inside)
