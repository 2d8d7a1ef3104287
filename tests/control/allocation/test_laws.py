"""Every closed form against a conic solver at random states, two, three and four feet; limits active and not."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import cvxpy as cp
import numpy as np
import pytest

from amble.control import (
    BoundedMinimumNorm,
    DropActuator,
    MinimumPeak,
    MinimumPower,
    PseudoInverse,
    Redundancy,
    WeightedMinimumNorm,
)
from amble.control.actuator import ACTUATORS, PAPER
from amble.errors import InputError
from amble.hybrid import Contacts
from amble.types import Vector
from tests import robots
from tests.control.allocation.solvers import (
    PAPER_HEAT,
    Program,
    bounded_program,
    efforts,
    peak_program,
    power_program,
)
from tests.control.allocation.stances import FRICTION, NAMES, NORMAL, PARTS, Sample, allocate, samples, stance_feet

# 200 states a stance miss a fault of one state in a hundred once in seven times, and there are nine stances
STATES = [200, pytest.param(1000, marks=pytest.mark.slow)]
STANCES = [(name, count) for name in NAMES for count in (2, 3, 4)]
BOUNDED = BoundedMinimumNorm(FRICTION, NORMAL)

# Law and solver agree to 1e-7 of the objective's own size. Torques are compared with the effort limits as unit; where a
# multiplier is nearly zero, a gap of 1e-11 of the solver leaves the root of that open.
OBJECTIVE, TORQUE = 1e-7, 1e-5


def chosen(name: str, count: int, law: object, sample: Sample) -> Vector:
    return allocate(name, count, law, sample)[0]  # type: ignore[arg-type]


def power(sample: Sample, s: Vector, heat: Vector | float = PAPER_HEAT) -> float:
    u = sample.torques + sample.torque_basis @ s
    return float(np.sum(np.maximum(u * sample.speeds, 0.0) + heat * u**2))


def peak(name: str, sample: Sample, s: Vector) -> float:
    steered = np.any(sample.torque_basis != 0.0, axis=1)
    return float(np.max(np.abs((sample.torques + sample.torque_basis @ s) / efforts(name))[steered]))


def relative_difference(name: str, sample: Sample, one: Vector, other: Vector) -> float:
    return float(np.max(np.abs(sample.torque_basis @ (one - other)) / efforts(name)))


@pytest.mark.parametrize("states", STATES)
@pytest.mark.parametrize(("name", "count"), STANCES)
def test_minimum_power_is_the_solution_of_its_program(name: str, count: int, states: int) -> None:
    for sample in samples(name, count, states, seed=1):
        s = chosen(name, count, MinimumPower("paper"), sample)
        x, status = power_program(sample).solve()
        assert status in ("Solved", "AlmostSolved")
        best = power(sample, x[12:])
        assert abs(power(sample, s) - best) <= OBJECTIVE * best
        assert relative_difference(name, sample, s, x[12:]) <= TORQUE


@pytest.mark.parametrize("count", [2, 3])
def test_minimum_power_counts_every_joint_with_its_own_motor(count: int) -> None:
    """Against the program, at half of whose joints a squared torque costs up to nine times as much."""
    joints = robots.robot("astro").joint_names
    own = {name: replace(PAPER, gear_ratio=6.0 / (1.0 + 0.4 * number)) for number, name in enumerate(joints[1::2])}
    model = replace(PAPER, name="many", joints=own)
    heat = model.heat_coefficients(joints)
    assert heat.max() / heat.min() == pytest.approx(9.0)
    for sample in samples("astro", count, 40, seed=1):
        s = chosen("astro", count, MinimumPower(model), sample)
        x, status = power_program(sample, heat).solve()
        assert status in ("Solved", "AlmostSolved")
        best = power(sample, x[12:], heat)
        assert abs(power(sample, s, heat) - best) <= OBJECTIVE * best
        assert power(sample, chosen("astro", count, MinimumPower(PAPER), sample), heat) > best


@pytest.mark.parametrize("states", STATES)
@pytest.mark.parametrize(("name", "count"), STANCES)
def test_minimum_peak_is_the_solution_of_its_program(name: str, count: int, states: int) -> None:
    # with three feet one leg alone may set the peak; then the rest is free, so only the peak is compared
    for sample in samples(name, count, states, seed=2):
        s = chosen(name, count, MinimumPeak(), sample)
        x, status = peak_program(name, sample).solve()
        assert status in ("Solved", "AlmostSolved")
        assert abs(peak(name, sample, s) - x[0]) <= OBJECTIVE * max(x[0], 1.0)


@pytest.mark.parametrize("states", STATES)
@pytest.mark.parametrize(("name", "count"), STANCES)
def test_bounded_minimum_norm_is_the_solution_of_its_program(name: str, count: int, states: int) -> None:
    active = inactive = missed = unsure = 0
    for sample in samples(name, count, states, seed=3):
        s = chosen(name, count, BOUNDED, sample)
        program = bounded_program(name, sample)
        x, status = program.solve()
        if "Infeasible" in status:
            missed += 1
            continue
        if status not in ("Solved", "AlmostSolved"):
            unsure += 1
            continue
        assert relative_difference(name, sample, s, x) <= TORQUE
        assert _objective(program, s) - _objective(program, x) <= OBJECTIVE * float(sample.torques @ sample.torques)
        clipped = relative_difference(name, sample, s, _least_norm(sample)) > TORQUE
        active, inactive = active + clipped, inactive + (not clipped)
    # where a cone is barely touched the solver itself may give up
    assert unsure <= states // 200
    assert min(active, missed) > states // 20
    assert inactive > 0 or count > 2  # more feet carry random forces too far outside for the plain minimum norm


def _objective(program: Program, s: Vector) -> float:
    return float(0.5 * s @ program.P @ s + program.c @ s)


def _least_norm(sample: Sample) -> Vector:
    return np.linalg.lstsq(sample.torque_basis, -sample.torques, rcond=None)[0]


@pytest.mark.parametrize(("name", "count"), STANCES)
def test_bounded_minimum_norm_satisfies_its_optimality_conditions(name: str, count: int) -> None:
    """Stationarity with non-negative multipliers of the limits that are active; a solver-free check."""
    checked = 0
    for sample in samples(name, count, 100, seed=4, spread=0.15):
        s = chosen(name, count, BOUNDED, sample)
        program = bounded_program(name, sample)
        rows, slack = _gradients(program, s)
        if slack.min() < -1e-9:
            continue
        tight = rows[slack < 1e-6]
        gradient = program.P @ s + program.c
        multipliers = _nonnegative_fit(tight, -gradient)
        # the slack that counts as tight, times multipliers of up to 100 N m
        assert np.linalg.norm(gradient + tight.T @ multipliers) <= 1e-5 * (1.0 + np.linalg.norm(program.c))
        checked += 1
    assert checked > 20


def _gradients(program: Program, s: Vector) -> tuple[np.ndarray, Vector]:
    """Rows and slacks of the limits, cones linearised at s."""
    value = program.b - program.A @ s
    if len(s) > 1:
        return program.A, value
    linear = program.cones[0].dim
    rows, slack = [program.A[:linear]], [value[:linear]]
    for at in range(linear, len(value), 3):
        size = np.hypot(*value[at + 1 : at + 3])
        weights = np.array([1.0, *(-value[at + 1 : at + 3] / size)])
        rows.append(weights[None] @ program.A[at : at + 3])
        slack.append(np.array([value[at] - size]))
    return np.vstack(rows), np.concatenate(slack)


def _nonnegative_fit(rows: np.ndarray, target: Vector) -> Vector:
    from scipy.optimize import nnls

    return nnls(rows.T, target)[0] if len(rows) else np.zeros(0)


@pytest.mark.parametrize("name", NAMES)
def test_missed_limits_are_reported_by_how_much(name: str) -> None:
    missed = 0
    for sample in samples(name, 2, 300, seed=5):
        s, margin = allocate(name, 2, BOUNDED, sample)
        u, forces = sample.torques + sample.torque_basis @ s, (sample.forces + sample.force_basis @ s).reshape(2, 3)
        expected = [
            1.0 - np.max(np.abs(u) / efforts(name)),
            np.min(FRICTION * forces[:, 2] - np.hypot(forces[:, 0], forces[:, 1])),
            np.min(forces[:, 2]) - NORMAL,
        ]
        assert margin == pytest.approx(expected, abs=1e-10)
        if margin.min() < -1e-6:
            missed += 1
            assert "Infeasible" in bounded_program(name, sample).solve()[1] or margin[0] < 0.0
            _assert_torques_come_first(name, sample, s)
    assert missed > 20


def _assert_torques_come_first(name: str, sample: Sample, s: Vector) -> None:
    """Steered torques keep their limits wherever any choice does, else their relative peak is the smallest."""
    least = peak_program(name, sample).solve()[0][0]
    assert peak(name, sample, s) <= max(1.0, least) + 1e-7


@pytest.mark.parametrize(("name", "count"), [(name, count) for name in NAMES for count in (3, 4)])
def test_limits_beyond_reach_are_missed_as_little_as_possible(name: str, count: int) -> None:
    found = 0
    for sample in samples(name, count, 60, seed=6):
        program = bounded_program(name, sample)
        s = chosen(name, count, BOUNDED, sample)
        violation = cp.Variable()
        variable = cp.Variable(sample.torque_basis.shape[1])
        rows = program.A @ variable - violation * np.ones(len(program.b)) <= program.b
        least = float(cp.Problem(cp.Minimize(violation), [rows]).solve(solver=cp.CLARABEL))
        if least > 1e-6:
            found += 1
            # limits are widened by one percent beyond the least (``LOOSER``)
            assert np.max(program.A @ s - program.b) <= 1.011 * least + 1e-7
    assert found > 5


@pytest.mark.parametrize(("name", "count"), STANCES)
def test_programs_say_the_same_as_cvxpy(name: str, count: int) -> None:
    """The oracle itself, written a second time the way a textbook would."""
    for sample in samples(name, count, 3, seed=7, spread=0.1):
        s = cp.Variable(sample.torque_basis.shape[1])
        u = sample.torques + sample.torque_basis @ s
        heat = cp.Minimize(cp.sum(cp.pos(cp.multiply(u, sample.speeds))) + PAPER_HEAT * cp.sum_squares(u))
        best = cp.Problem(heat).solve(solver=cp.CLARABEL)
        assert power(sample, power_program(sample).solve()[0][12:]) == pytest.approx(best, rel=1e-6)
        steered = np.any(sample.torque_basis != 0.0, axis=1)
        relative = cp.multiply(u[steered], 1.0 / efforts(name)[steered])
        best = cp.Problem(cp.Minimize(cp.norm_inf(relative))).solve(solver=cp.CLARABEL)
        assert peak_program(name, sample).solve()[0][0] == pytest.approx(best, rel=1e-6)
        limits = [cp.abs(relative) <= 1.0]
        for foot in range(count):
            force = sample.forces[3 * foot : 3 * foot + 3] + sample.force_basis[3 * foot : 3 * foot + 3] @ s
            limits.append(force[2] >= NORMAL)
            side = cp.norm(force[:2]) if count == 2 else np.sqrt(2.0) * cp.norm_inf(force[:2])
            limits.append(side <= FRICTION * force[2])
        problem = cp.Problem(cp.Minimize(cp.sum_squares(u)), limits)
        problem.solve(solver=cp.CLARABEL)
        x, status = bounded_program(name, sample).solve()
        if problem.status != cp.OPTIMAL:
            assert "Infeasible" in status
            continue
        # cvxpy's default accuracy; where a cone is nearly tangent to the line, its root
        assert relative_difference(name, sample, np.asarray(s.value), x) <= 3e-3


@pytest.mark.parametrize(("name", "count"), STANCES)
def test_weighted_minimum_norm_is_a_least_squares_solution(name: str, count: int) -> None:
    generator = np.random.default_rng(8)
    weights = dict(zip(robots.robot(name).joint_names, generator.uniform(0.1, 10.0, 12), strict=True))
    root = np.sqrt(np.array(list(weights.values())))
    law = WeightedMinimumNorm(weights)
    for sample in samples(name, count, 100, seed=8):
        found = np.asarray(_choose_unhashed(name, count, law, sample)).ravel()
        best = np.linalg.lstsq(root[:, None] * sample.torque_basis, -root * sample.torques, rcond=None)[0]
        assert relative_difference(name, sample, found, best) <= 1e-10


def _choose_unhashed(name: str, count: int, law: WeightedMinimumNorm, sample: Sample) -> object:
    """The law on numbers, as casadi constants: a mapping of weights cannot key a cache of functions."""
    robot = robots.robot(name)
    parts = sample.parts()
    return ca.DM(
        law.allocate(
            Redundancy(
                contacts=Contacts(robot, stance_feet(robot, count)),
                points=ca.SX(3 * count, 1),
                **{name: ca.SX(ca.DM(part)) for name, part in parts.items()},
            )
        )
    )


@pytest.mark.parametrize(("name", "count"), STANCES)
def test_rows_of_the_gait_problem_vanish_where_the_controller_stays(name: str, count: int) -> None:
    """One law, two uses: the torques that ``allocate`` gives fulfil ``rows``."""
    robot = robots.robot(name)
    for law in (PseudoInverse(), WeightedMinimumNorm({robot.joint_names[0]: 5.0, robot.joint_names[7]: 0.3})):
        for sample in samples(name, count, 10, seed=13):
            parts = {"contacts": Contacts(robot, stance_feet(robot, count)), "points": ca.SX(3 * count, 1)}
            parts |= {name: ca.SX(ca.DM(part)) for name, part in sample.parts().items() if name != "torques"}
            least = sample.torques + sample.torque_basis @ _least_norm(sample)
            found = Redundancy(torques=ca.SX(ca.DM(least)), **parts)
            u = ca.SX(ca.DM(least)) + found.torque_basis @ law.allocate(found)
            rows = ca.DM(law.optimality_conditions(Redundancy(torques=u, **parts)))
            assert (
                np.max(np.abs(rows.full())) <= 1e-10 * np.linalg.norm(least) * np.abs(sample.torque_basis).max() * 5.0
            )


@pytest.mark.parametrize(("name", "count"), STANCES)
def test_no_law_has_smaller_torques_than_the_minimum_norm(name: str, count: int) -> None:
    for sample in samples(name, count, 100, seed=9):
        least = np.linalg.norm(sample.torques + sample.torque_basis @ _least_norm(sample))
        for law in (MinimumPower("paper"), MinimumPower("datasheet"), MinimumPeak(), BOUNDED):
            u = sample.torques + sample.torque_basis @ chosen(name, count, law, sample)
            assert np.linalg.norm(u) >= least * (1.0 - 1e-12)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("model", ["paper", "datasheet"])
def test_minimum_power_beats_every_other_choice_on_the_line(name: str, model: str) -> None:
    heat = ACTUATORS[model].heat_coefficient
    for sample in samples(name, 2, 50, seed=10):
        s = chosen(name, 2, MinimumPower(model), sample)
        values = s + np.linspace(-300.0, 300.0, 2001)
        u = sample.torques[:, None] + sample.torque_basis * values
        total = np.sum(np.maximum(u * sample.speeds[:, None], 0.0) + heat * u**2, axis=0)
        assert total[1000] <= total.min() * (1.0 + 1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_the_bounded_law_is_continuous_along_a_line_of_states(name: str) -> None:
    """Torques of close states are close, also where the active limit changes."""
    first, last = samples(name, 2, 2, seed=11)
    steps = 4000
    found = []
    for share in np.linspace(0.0, 1.0, steps):
        parts = [(1.0 - share) * getattr(first, part) + share * getattr(last, part) for part in PARTS]
        sample = Sample(*parts)
        found.append(sample.torques + sample.torque_basis @ chosen(name, 2, BOUNDED, sample))
    jumps = np.max(np.abs(np.diff(found, axis=0)), axis=1)
    # a jump would not shrink with the step: halving the step must halve the largest difference
    coarse = np.max(np.abs(np.diff(found[::2], axis=0)), axis=1)
    assert jumps.max() <= 0.6 * coarse.max()


@pytest.mark.parametrize("law", [MinimumPower(), MinimumPeak(), BOUNDED])
def test_laws_with_kinks_close_no_gait_problem(law: MinimumPower) -> None:
    with pytest.raises(InputError, match="not smooth"):
        law.optimality_conditions(None)  # type: ignore[arg-type]


@pytest.mark.parametrize("law", [PseudoInverse(), DropActuator(()), MinimumPower(), MinimumPeak(), BOUNDED])
def test_one_foot_leaves_nothing_to_choose(law: PseudoInverse) -> None:
    nothing = ca.SX(12, 0)
    robot = robots.robot("astro")
    redundancy = Redundancy(
        contacts=Contacts(robot, ("fl",)),
        points=ca.SX(3, 1),
        torques=ca.SX.ones(12),
        torque_basis=nothing,
        forces=ca.SX.ones(3),
        force_basis=ca.SX(3, 0),
        speeds=ca.SX.ones(12),
    )
    assert law.allocate(redundancy).numel() == 0
