"""The check passes a gait that was solved finely enough, and names what is wrong with any other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.control import DropActuator
from amble.control.phase import DomainPhase
from amble.errors import InputError, WorkError
from amble.gait import DomainTrajectory, Gait
from amble.hybrid import Contacts
from amble.synthesis import GaitProblem, refine
from amble.types import Vector, frozen
from amble.verification import domain_rows
from amble.verification.check import check
from amble.verification.interpolation import fine_grid, interpolated
from amble.verification.output_dynamics import OutputDynamics, integrate
from amble.verification.residuals import CheckReport, limit, residuals
from amble.verification.stance_model import Motion, allocated, law_residuals, terms
from tests.grounds import on_friction
from tests.hostile import with_names

NO_TIMES = np.arange(3.0)


def changed(gait: Gait, number: int, **fields: object) -> Gait:
    """The gait with other fields in one domain."""
    domains = list(gait.domains)
    domains[number] = replace(domains[number], **fields)  # type: ignore[arg-type]
    return replace(gait, domains=tuple(domains))


def failed(report: CheckReport) -> set[str]:
    return {row.name for row in report.failed}


@pytest.fixture(scope="module")
def report(stabilised_gait: Gait) -> CheckReport:
    return check(stabilised_gait)


def test_fifteen_intervals_hold_between_the_nodes_too(report: CheckReport) -> None:
    assert report.passed, str(report)
    # measured 1.1e-6 for the rate of the coordinate that no output controls; 1e-5 passes
    assert report.worst["motion"].value == pytest.approx(0.0, abs=2e-6), str(report)


def test_names_are_no_templates(stabilised_gait: Gait, report: CheckReport) -> None:
    """A foot or joint whose name had braces was read as a format, and ended the check with a traceback."""
    gait = with_names(stabilised_gait, np.random.default_rng(12))
    for names in (gait.robot.foot_names, gait.robot.joint_names):
        assert any("{what}" in name for name in names)
    other = check(gait)
    assert [row.kind for row in other.rows] == [row.kind for row in report.rows]
    assert [row.value for row in other.rows] == [row.value for row in report.rows]


def test_a_finer_mesh_holds_between_its_nodes_too(walking_gait: Gait, small_problem: GaitProblem) -> None:
    finer = check(refine(replace(small_problem, limits=walking_gait.limits), walking_gait))
    assert finer.passed, str(finer)


def test_the_table_has_bounds_and_values_by_name(report: CheckReport, walking_gait: Gait) -> None:
    text = str(report)
    assert "lower |        value |        upper" in text
    assert "D1 motion rate of rl_hip_pitch" in text
    assert len({row.name for row in report.rows}) == len(report.rows)
    for name in ("D1 motion rr_knee", "D1->D2 impact momentum yaw", "D2 friction fr", "D2->D3 periodicity yaw"):
        assert name in {row.name for row in report.rows}
    nodes = sum(domain.times.size for domain in walking_gait.domains)
    assert report.points == 4 * (nodes - 2) + 2


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("coefficient", [0, 2, 4])
def test_a_bezier_coefficient_changed_by_one_percent_is_named(
    walking_gait: Gait, number: int, coefficient: int
) -> None:
    domain = walking_gait.domains[number]
    joint = int(np.argmax(np.abs(domain.coefficients[:, coefficient])))
    coefficients = np.array(domain.coefficients)
    coefficients[joint, coefficient] *= 1.01
    report = check(changed(walking_gait, number, coefficients=frozen(coefficients)), grid=1)
    name = walking_gait.outputs.of(domain.name).coordinates[joint]
    assert not report.passed
    assert f"{domain.name} output {name}" in failed(report)
    assert f"{domain.name} output {name}" in str(report)


@pytest.mark.parametrize(
    ("field", "names"),
    [
        ("torques", {"D1 torque fr_knee", "D1 dynamics fr_knee"}),
        ("forces", {"D1 force fr z", "D1 dynamics z"}),
        ("accelerations", {"D1 acceleration fr_knee", "D1 dynamics z", "D1 output dynamics fr_knee"}),
        ("velocities", {"D1 motion rate of fr_knee", "D1 output rate fr_knee"}),
        ("positions", {"D1 motion fr_knee", "D1 output fr_knee", "D1 drift fr z", "D1->D2 continuity fr_knee"}),
        ("impulse", {"D1->D2 impact impulse rr z", "D1->D2 impact momentum z"}),
    ],
)
def test_other_numbers_of_a_domain_are_named(walking_gait: Gait, field: str, names: set[str]) -> None:
    values = np.array(getattr(walking_gait.domains[0], field))
    values[0 if values.ndim == 1 else 1 :] *= 1.001
    assert names <= failed(check(changed(walking_gait, 0, **{field: frozen(values)}), grid=1))


def test_claims_about_the_whole_gait_are_named(walking_gait: Gait) -> None:
    other_speed = check(replace(walking_gait, speed=walking_gait.speed + 1e-3), grid=1)
    assert failed(other_speed) == {"mean speed less the speed asked for"}
    cheaper = replace(walking_gait.solver, objective=0.9 * walking_gait.solver.objective)
    assert failed(check(replace(walking_gait, solver=cheaper), grid=1)) == {
        "root mean square of the torques less the solver's"
    }


def test_the_law_is_checked(walking_gait: Gait) -> None:
    dropped = replace(walking_gait, law=DropActuator(("rl_hip_pitch", "rr_hip_pitch")))
    kinds = {row.kind for row in check(dropped, grid=1).failed}
    assert {"law", "torque", "force"} <= kinds
    assert "acceleration" not in kinds  # the law does not change the motion


def test_limits_are_checked(walking_gait: Gait) -> None:
    limits = walking_gait.limits
    tighter = replace(
        limits,
        durations={name: (0.01, 0.02) for name in limits.durations},
        normal_force=1e3,
        clearance=1.0,
        acceleration=0.1,
        torques=dict.fromkeys(limits.torques, 0.1),
        speeds=dict.fromkeys(limits.speeds, 0.01),
        positions={"z": (5.0, 6.0)},
        touchdown_velocity=((5.0, 6.0), (5.0, 6.0), (5.0, 6.0)),
    )
    kinds = {row.kind for row in check(on_friction(replace(walking_gait, limits=tighter), 0.01), grid=1).failed}
    assert kinds == {
        "duration",
        "normal force",
        "friction",
        "clearance",
        "position",
        "speed",
        "torque limit",
        "acceleration limit",
        "touchdown",
    }


def test_a_foot_that_hardly_carries_is_named(walking_gait: Gait) -> None:
    """Also where it carries more than the least normal force."""
    limits = walking_gait.limits
    heavy = replace(limits, standing_force=0.5 * walking_gait.robot.mass * walking_gait.robot.gravity)
    failed = check(replace(walking_gait, limits=heavy), grid=1).failed
    assert {row.kind for row in failed} == {"normal force"}
    assert all(row.name.endswith("over its bound") for row in failed)
    light = replace(limits, standing_force=limits.normal_force)
    assert {row.kind for row in check(replace(walking_gait, limits=light), grid=1).failed} == set()


@pytest.mark.parametrize(("share", "holds"), [(1.0, True), (0.05, False), (0.0, False)])
def test_a_foot_that_grazes_the_ground_is_named(walking_gait: Gait, share: float, holds: bool) -> None:
    """Whatever its limits say: those of former files allow a landing at rest. rr comes down at 0.20 sqrt(g l)."""
    forward, sideways, (fastest, slowest) = walking_gait.limits.touchdown_velocity
    assert slowest < 0.0
    limits = replace(walking_gait.limits, touchdown_velocity=(forward, sideways, (fastest, 0.0)))
    velocities = np.array(walking_gait.domains[0].velocities)
    velocities[-1] *= share
    report = check(changed(replace(walking_gait, limits=limits), 0, velocities=frozen(velocities)), grid=1)
    row = next(row for row in report.rows if row.name == "D1->D2 touchdown velocity rr z")
    assert row.passed is holds
    size = np.sqrt(walking_gait.robot.gravity * walking_gait.robot.leg_length)
    assert row.value == pytest.approx(-0.2026 * share * size, rel=1e-3)


def test_a_feedback_that_does_not_return_is_named(stabilised_gait: Gait, report: CheckReport) -> None:
    assert report.worst["feedback"].passed
    assert stabilised_gait.feedback is not None
    start = np.array(stabilised_gait.feedback.start)
    start[-1] += 1e-3
    moved = replace(stabilised_gait, feedback=replace(stabilised_gait.feedback, start=frozen(start)))
    kinds = {row.kind for row in check(moved, grid=1).failed}
    assert kinds == {"feedback"}


def test_a_motion_that_cannot_be_integrated_fails_by_name(walking_gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    def impossible(*_: object) -> None:
        raise WorkError("step size")

    monkeypatch.setattr(domain_rows, "integrate", impossible)
    report = check(walking_gait, grid=1)
    assert {row.kind for row in report.failed} == {"motion"}
    assert "D1 motion x" in failed(report)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        *(
            ({"grid": grid}, "points in every spacing of nodes were asked for; a whole number from 1 to 1,000 can be")
            for grid in (0, -1, 1001, 10**9, 10**20)
        ),
        ({"tolerance": 0.0}, "positive"),
    ],
)
def test_bad_arguments(walking_gait: Gait, arguments: dict[str, float], says: str) -> None:
    with pytest.raises(InputError, match=says):
        check(walking_gait, **arguments)  # type: ignore[arg-type]


def test_integration_is_accurate_where_the_answer_is_known(walking_gait: Gait) -> None:
    """With zero error at the start the outputs stay on their curves whatever the robot does."""
    domain, stance = walking_gait.domains[0], walking_gait.pattern.solved[0]
    names = walking_gait.outputs.of(domain.name).coordinates
    columns = [walking_gait.robot.coordinate_index(name) for name in names]
    weights = np.eye(walking_gait.robot.size)[columns][:, 3:]
    loop = OutputDynamics(
        weights=weights,
        references=weights.T @ domain.coefficients,
        duration=domain.duration,
        gains=walking_gait.gains,
        domain=DomainPhase(phase=walking_gait.outputs.phase, robot=walking_gait.robot, stance=stance),
        phase_numbers=domain.phase_numbers,
    )
    times = np.linspace(0.0, domain.duration, 5)
    q, v = integrate(walking_gait.pattern.contacts(stance), loop, domain.positions[0], domain.velocities[0], times)
    value, rate = loop.errors(times, q, v)
    np.testing.assert_allclose(value, 0.0, atol=1e-8)  # the entry itself is met to the solver's 1e-8
    np.testing.assert_allclose(rate, 0.0, atol=1e-7)


def test_in_flight_a_law_has_nothing_to_choose(walking_gait: Gait) -> None:
    robot, law = walking_gait.robot, walking_gait.law
    at = terms(Contacts(robot, ()), *np.random.default_rng(4).normal(0.0, 0.3, (2, 3, robot.size)))
    nothing, torques = np.zeros((3, 0)), np.ones((3, len(robot.joints)))
    assert law_residuals(at, torques, nothing, law).shape == (3, 0)
    assert allocated(at, Motion(np.zeros((3, robot.size)), torques, nothing), law).torques is torques


def polynomial(times: Vector, degree: int) -> DomainTrajectory:
    """A recorded motion q = t^degree in one coordinate."""
    power = np.arange(degree + 1) == degree
    series = np.polynomial.Polynomial(power.astype(float))
    q, v, a = (np.asarray(part(times))[:, None] for part in (series, series.deriv(), series.deriv(2)))
    empty = frozen(np.zeros((times.size, 0)))
    return DomainTrajectory(
        name="D1",
        duration=1.0,
        coefficients=empty,
        times=times,
        positions=q,
        velocities=v,
        accelerations=a,
        torques=empty,
        forces=empty,
        impulse=frozen([]),
    )


@pytest.mark.parametrize("degree", range(6))
def test_interpolation_is_exact_up_to_its_degree(degree: int) -> None:
    at = np.linspace(0.0, 1.0, 41)
    q, v = interpolated(polynomial(np.array([0.0, 0.2, 0.5, 0.8, 1.0]), degree), at)
    np.testing.assert_allclose(q[:, 0], at**degree, atol=1e-14)
    if degree <= 4:  # v is then a cubic
        np.testing.assert_allclose(v[:, 0], degree * at ** max(degree - 1, 0) * (degree > 0), atol=1e-14)


def test_fine_grid_holds_the_nodes() -> None:
    nodes = np.array([0.0, 0.1, 0.4])
    np.testing.assert_allclose(fine_grid(nodes, 1), nodes)
    np.testing.assert_allclose(fine_grid(nodes, 2), [0.0, 0.05, 0.1, 0.25, 0.4], atol=1e-15)


def test_a_residual_row_is_the_worst_point() -> None:
    rows = residuals("motion", ["a", "b"], np.array([[0.0, 1.0], [2.0, np.nan], [-4.0, 3.0]]), NO_TIMES, 1.0, 2.0)
    assert (rows[0].value, rows[0].time, rows[0].passed) == (-2.0, 2.0, False)
    assert np.isnan(rows[1].value)
    assert not rows[1].passed


@pytest.mark.parametrize(
    ("values", "slack", "value", "passed"),
    [
        ([0.0, 0.5, 1.0], 0.0, 1.0, True),
        ([0.0, 1.5, 1.0], 0.0, 1.5, False),
        ([0.0, 1.5, 1.0], 0.5, 1.5, True),
        ([0.0, -1.2, 1.1], 0.0, -1.2, False),
        ([0.0, np.nan, 1.0], 0.0, np.nan, False),
    ],
)
def test_a_limit_row_is_the_worst_point(values: list[float], slack: float, value: float, passed: bool) -> None:
    row = limit("speed", "a", np.array(values), NO_TIMES, (-1.0, 1.0), slack)
    np.testing.assert_equal(row.value, value)
    assert row.passed is passed
