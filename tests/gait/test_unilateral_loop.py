"""The closed loop on ground that pushes only: the gait's own walk as it is, and what pushes make of it."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import start_state
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.gait.plant_errors import PlantErrors
from amble.gait.schedule_tables import impedance_schedule
from amble.gait.unilateral_loop import LIGHT, SLID, unilateral_loop
from amble.gait.unilateral_state import Push, unilateral_start, unilateral_units
from amble.hybrid import HybridSystem
from amble.robot import Robot, kinematics
from amble.robot.natural_units import natural_units
from amble.simulation import Trace, simulate
from amble.simulation.simulate import perturbed
from amble.types import Vector
from tests.conftest import DATA


@pytest.fixture(scope="module")
def system(stabilised_gait: Gait) -> HybridSystem:
    return unilateral_loop(stabilised_gait)


def momentum(robot: Robot) -> ca.Function:
    """(q, v) -> linear momentum, (3,), from the centres of mass of the links, whose poses are in the base's frame."""
    q, v = ca.SX.sym("q", robot.size), ca.SX.sym("v", robot.size)
    poses = zip(robot.links, kinematics.link_poses(robot, q), strict=True)
    moments = sum(link.mass * (origin + turn @ link.center) for link, (turn, origin) in poses)
    whole = robot.mass * q[:3] + kinematics.base_rotation(q) @ moments
    return ca.Function("momentum", [q, v], [ca.jtimes(whole, q, v)])


def test_a_sound_walk_is_the_same(stabilised_gait: Gait, system: HybridSystem) -> None:
    """Where every foot pushes within its cone nothing is released and nothing touches out of turn."""
    usual = simulate(stabilised_gait, cycles=1, tolerance=1e-10, samples=3)
    found = simulate(system, unilateral_start(stabilised_gait), 1, 1e-10, samples=3)
    assert [event.transition for event in found.events] == [event.transition for event in usual.events]
    np.testing.assert_allclose(found.section[:, :36], usual.section, atol=1e-8)
    np.testing.assert_allclose(found.signals["force"], usual.signals["force"], atol=1e-5)


def pushed(gait: Gait, system: HybridSystem, push: Push, longest: float = 1.0) -> Trace:
    return simulate(system, unilateral_start(gait, push=push), 1, 1e-9, samples=41, time_limit=longest)


def test_a_robot_that_is_pulled_up_flies(stabilised_gait: Gait) -> None:
    """Feet are released one after the other where their force is zero; in flight gravity and the push alone act."""
    system = unilateral_loop(stabilised_gait, errors=PlantErrors(friction=100.0))  # no cone is left first
    robot, push = stabilised_gait.robot, Push(force=(0.0, 0.0, 3000.0), begin=0.002, end=0.5)
    trace = pushed(stabilised_gait, system, push, 0.005)
    assert [event.transition.split("->")[1] for event in trace.events[:2]] == ["D1 released", "D1 released"]
    rows = np.flatnonzero(trace.signals["contact"].sum(axis=1) == 0.0)
    assert len(rows) > 15
    change = np.asarray(momentum(robot)(trace.state[rows, :18].T, trace.state[rows, 18:36].T)).T
    time = trace.time[rows] - trace.time[rows[0]]
    expected = np.outer(time, np.array(push.force) - [0.0, 0.0, robot.mass * robot.gravity])
    np.testing.assert_allclose(change - change[0], expected, atol=1e-5)
    assert not trace.signals["force"][rows].any()
    first = np.flatnonzero(trace.time == trace.events[0].time)[0]
    last = trace.signals["force"][first].reshape(4, 3)[trace.signals["contact"][first] > 0.5, 2]
    assert last.min() == pytest.approx(0.0, abs=1e-6)


def test_a_foot_that_leaves_its_cone_ends_the_motion(stabilised_gait: Gait, system: HybridSystem) -> None:
    """Pushed sideways where it stands: at the end one foot's load is friction times its normal force."""
    trace = pushed(stabilised_gait, system, Push(force=(400.0, 0.0, 0.0), begin=0.03, end=0.3))
    assert SLID in trace.ended
    assert trace.cycles == 0
    force, weight = trace.signals["force"][-1].reshape(4, 3), stabilised_gait.robot.mass * 9.81
    reserve = 0.6 * np.maximum(force[:, 2], LIGHT * weight) - np.hypot(force[:, 0], force[:, 1])
    standing = trace.signals["contact"][-1] > 0.5
    assert reserve[standing].min() == pytest.approx(0.0, abs=1.0)
    assert np.all(trace.signals["force"].reshape(-1, 4, 3)[..., 2] > -1e-6)


def test_a_rougher_ground_holds_longer(stabilised_gait: Gait) -> None:
    push = Push(force=(60.0, 0.0, 0.0), begin=0.05, end=0.08)
    loops = [unilateral_loop(stabilised_gait, errors=PlantErrors(friction=friction)) for friction in (0.6, 1.2)]
    times = [pushed(stabilised_gait, loop, push).time[-1] for loop in loops]
    assert times[0] < times[1]


def test_nothing_lands_on_a_step_from_below(stabilised_gait: Gait) -> None:
    """A low step is landed on; one that is higher than the foot is lifted is not passed by landing in the air."""
    foot, found = stabilised_gait.pattern.all_switches[1].landing[0], {}
    for height in (1e-4, 0.3):
        loop = unilateral_loop(stabilised_gait, errors=PlantErrors(friction=1e6, steps={foot: height}))
        start = unilateral_start(stabilised_gait)
        found[height] = simulate(loop, start, 1, 1e-8, samples=2, time_limit=0.5).completed
    assert found == {1e-4: True, 0.3: False}


def test_a_gait_is_simulated_so_by_name(stabilised_gait: Gait) -> None:
    """Of a changed start coordinates and rates are changed, not which feet are in contact."""
    trace = simulate(stabilised_gait, cycles=1, samples=2, perturbation=1e-6, seed=3, unilateral=True)
    np.testing.assert_allclose(np.abs(trace.state[0, :36] - start_state(stabilised_gait)), 1e-6, rtol=1e-6)
    np.testing.assert_array_equal(trace.state[0, 36:], unilateral_start(stabilised_gait)[36:])
    assert set(trace.state_names) | set(trace.signals) <= set(unilateral_units(stabilised_gait))


@pytest.mark.parametrize(("change", "seed", "first"), [(0.0, 0, "fr"), (1e-2, 1, "fr"), (1e-2, 2, "rl")])
def test_feet_land_one_by_one_in_every_order(change: float, seed: int, first: str) -> None:
    """Where every contact is sound it is the closed loop's walk, whichever foot of a pair comes down first."""
    trot = load_gait(DATA / "stabilised-trot-one-by-one.json")
    units = natural_units(trot.robot, trot.robot.leg_length)
    start = start_state(trot) + units * perturbed(np.zeros(36), change, seed)
    usual = simulate(trot, start, 2, 1e-8, samples=2)
    # disturbed, a foot uses more friction than the gait's ground has
    system = unilateral_loop(trot, errors=PlantErrors(friction=100.0))
    found = simulate(system, unilateral_start(trot, start), 2, 1e-8, samples=2)
    assert found.completed
    assert found.events[0].transition == f"D1->D2 {first}"
    assert [event.transition for event in found.events] == [event.transition for event in usual.events]
    np.testing.assert_allclose(found.section[:, :36], usual.section, atol=1e-7)


def test_what_it_cannot_do_is_refused(stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="own contacts"):
        simulate(stabilised_gait, unilateral=True, loop=lambda gait, _: unilateral_loop(gait))
    with pytest.raises(InputError, match="or unilateral contact"):
        simulate(unilateral_loop(stabilised_gait), np.zeros(47), unilateral=True)  # type: ignore[call-overload]


@pytest.mark.parametrize("law", ["linearising", "impedance", "schedule"])
def test_feet_lift_near_the_plan_under_impedance(
    stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch, law: str
) -> None:
    """The amble with its first switch at the lift-off alone, as in the test of the exported code.

    Up or not, a stance is not left before half of its plan, and at 1.2 of it in any case; elsewhere by force alone.
    """
    window = law != "linearising"
    gait = replace(stabilised_gait, control=Impedance() if window else None)
    control = impedance_schedule({(0.2,): gait, (0.3,): gait}, ("speed",)).law((0.25,)) if law == "schedule" else None
    steps = tuple(replace(step, landing=()) if step.source.name == "D1" else step for step in gait.pattern.steps)
    monkeypatch.setattr(type(gait.pattern), "steps", steps)
    system = unilateral_loop(gait, control=control)
    out = next(each for each in system.transitions if (each.source, each.target) == ("D1", "D2"))
    assert gait.feedback is not None
    carrying = unilateral_start(gait)
    lifted = np.array(carrying)
    lifted[37 + gait.robot.foot_names.index(steps[0].lifting[0])] = 0.0
    assert lifted.sum() == carrying.sum() - 1.0

    def crossed(state: Vector, share: float) -> bool:
        at = np.array(state)
        at[36] = share * gait.feedback.durations["D1"] if gait.feedback else np.nan
        return float(out.guard(0.0, at, system.domain("D1").parameters)) <= 0.0

    assert [crossed(lifted, share) for share in (0.0, 0.49, 0.51, 1.21)] == [not window, not window, True, True]
    assert [crossed(carrying, share) for share in (0.0, 0.51, 1.19, 1.21)] == [False, False, False, window]
