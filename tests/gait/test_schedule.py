"""Gain scheduling: weights that reproduce what is affine, and laws between gaits that are means of the gaits' own."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait import schedule_tables as scheduling
from amble.gait.files import load_gait
from amble.gait.impedance import HOLD, Impedance, references
from amble.gait.landing_stances import landings
from amble.gait.orbit import OrbitArc, orbit_arcs
from amble.gait.schedule import Schedule
from amble.gait.schedule_tables import impedance_schedule
from amble.gait.unfolding import unfolded
from amble.gait.unilateral_state import within_window
from amble.numerics.pieces import Pieces
from amble.types import Matrix, Vector, frozen
from tests.conftest import DATA

SHARES = np.concatenate([np.random.default_rng(7).uniform(0.0, 1.04, 40), [0.0, 1.0]])


@lru_cache
def written(size: int, joints: int) -> ca.Function:
    t, p = ca.SX.sym("t"), ca.SX.sym("p", size)
    return ca.Function("references", [t, p], list(references(p, joints, t)))


def references_at(packed: Vector, clock: float, joints: int) -> Matrix:
    """q_d, q_d' and u_d, (3, n_joints)."""
    return np.array([np.asarray(part).ravel() for part in written(packed.size, joints)(clock, packed)])


@pytest.fixture(scope="module")
def gait(stabilised_gait: Gait) -> Gait:
    return replace(stabilised_gait, control=Impedance())


@pytest.fixture(scope="module")
def arcs(gait: Gait) -> tuple[OrbitArc, ...]:
    return orbit_arcs(gait, gait.law)


def slower(arc: OrbitArc, factor: float, cut: float) -> OrbitArc:
    """The same curves over a longer time, the torques doubled, in other pieces."""

    def stretched(pieces: Pieces, gain: float = 1.0) -> Pieces:
        return Pieces(breaks=frozen(factor * pieces.breaks), coefficients=frozen(gain * pieces.coefficients))

    there = frozen([cut * factor * arc.duration])
    return replace(
        arc,
        duration=factor * arc.duration,
        states=stretched(arc.states).cut(there),
        torques=stretched(arc.torques, 2.0).cut(there),
    )


@pytest.fixture(scope="module")
def schedule(gait: Gait, arcs: tuple[OrbitArc, ...]) -> Schedule:
    """From a gait at 0.2 m/s to one with other durations, torques, gains and pieces at 0.4 m/s."""
    stiff = replace(gait, control=Impedance(stance_stiffness=300.0))
    other = tuple(slower(arc, 1.5, 0.2) for arc in arcs)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scheduling, "orbit_arcs", lambda *given: arcs if given[0] is gait else other)
        return impedance_schedule({(0.2,): gait, (0.4,): stiff}, ("speed",))


def test_weights_reproduce_what_is_affine(gait: Gait) -> None:
    rng, values = np.random.default_rng(0), ((0.0, 0.1, 0.4), (-1.0, 0.0, 2.0, 3.0))
    place = Schedule(gait=gait, axes=("speed", "yaw_rate"), values=values, tables=np.zeros(0), starts=np.zeros(0))
    for _ in range(200):
        command = [rng.uniform(row[0], row[-1]) for row in values]
        found = place.weights(command)
        assert all(0.0 < weight <= 1.0 for weight in found.values())
        assert sum(found.values()) == pytest.approx(1.0, abs=1e-14)
        for axis in range(2):
            mean = sum(weight * values[axis][at[axis]] for at, weight in found.items())
            assert mean == pytest.approx(command[axis], abs=1e-14)
    assert place.weights((0.1, 3.0)) == {(1, 3): 1.0}
    for outside in ((-0.01, 0.0), (0.2, 3.1), (float("nan"), 0.0)):
        with pytest.raises(InputError, match="outside"):
            place.weights(outside)


def test_at_a_gait_the_law_is_its_own(gait: Gait, schedule: Schedule) -> None:
    """Pieces that are cut for another gait lose nothing: rounding of sums of 12 powers, torques of some 10 N m."""
    joints = len(gait.robot.joints)
    for own, here in zip(Impedance().numbers(gait, None), schedule.law([0.2]).entries, strict=True):
        for share in (*SHARES, 1.2, 1.6):
            clock = share * float(own.parameters[1]) / HOLD
            np.testing.assert_allclose(
                references_at(here.parameters, clock, joints), references_at(own.parameters, clock, joints), atol=1e-9
            )
        ends_and_gains = slice(0, 2 + 2 * joints)
        np.testing.assert_allclose(here.parameters[ends_and_gains], own.parameters[ends_and_gains], rtol=1e-14)


def test_between_gaits_it_is_their_mean_over_the_share_of_the_duration(
    gait: Gait, arcs: tuple[OrbitArc, ...], schedule: Schedule
) -> None:
    joints, entries = len(gait.robot.joints), schedule.law([0.25]).entries
    for stance, arc, entry in zip(gait.pattern.solved, arcs, entries, strict=True):
        T = 0.75 * arc.duration + 0.25 * 1.5 * arc.duration
        assert entry.parameters[1] == pytest.approx(HOLD * T, rel=1e-14)
        stiffness = [law.joint_gains(gait.robot, stance)[0] for law in (Impedance(), Impedance(stance_stiffness=300.0))]
        np.testing.assert_allclose(entry.parameters[2 : 2 + joints], 0.75 * stiffness[0] + 0.25 * stiffness[1])
        for share in SHARES:
            found = references_at(entry.parameters, share * T, joints)
            (angle, rate), (torque, _) = (
                curve(np.array([share * arc.duration])) for curve in (arc.joints, arc.torques)
            )
            expected = angle[0], rate[0] * arc.duration / T, (0.75 + 0.25 * 2.0) * torque[0]
            np.testing.assert_allclose(found, np.array(expected), atol=1e-9)
        assert list(entry.breakpoints) == sorted(entry.breakpoints)
        assert entry.breakpoints[-1] == pytest.approx(HOLD * T, rel=1e-14)


def test_the_window_of_lift_offs_is_that_of_the_plan_at_the_command(gait: Gait, schedule: Schedule) -> None:
    """The other gait's stances last 1.5 times as long: at a command between them the plan is the mean."""
    stance, feedback = gait.pattern.stances[-1], gait.feedback  # a mirrored one
    assert feedback is not None
    name = gait.pattern.solved[-1].name
    for command, factor in ((0.2, 1.0), (0.25, 1.125), (0.4, 1.5)):
        law = schedule.law((command,))
        crossing, clock, p = ca.MX.sym("crossing"), ca.MX.sym("clock"), ca.MX.sym("p", law.entries[-1].parameters.size)
        guard = within_window(replace(gait, control=law), stance, crossing, clock, p)
        function = ca.Function("guard", [crossing, clock, p], [guard])
        ended = [
            float(function(carries, share * factor * feedback.durations[name], law.entries[-1].parameters)) <= 0.0
            for carries, share in ((-1.0, 0.49), (-1.0, 0.51), (1.0, 1.19), (1.0, 1.21))
        ]
        assert ended == [False, True, False, True]


class OwnWindow(Impedance):
    """Another window than the default one."""

    lift_offs = 0.25, 1.0 + 1.0 / 3.0


def test_the_window_of_lift_offs_is_that_of_the_gaits_laws(gait: Gait) -> None:
    other = replace(gait, control=OwnWindow())
    found = impedance_schedule({(0.2,): other, (0.4,): other}, ("speed",))
    assert found.law((0.3,)).lift_offs == OwnWindow.lift_offs
    with pytest.raises(InputError, match="different windows of lift-offs"):
        impedance_schedule({(0.2,): gait, (0.4,): other}, ("speed",))


def test_what_cannot_be_interpolated_is_refused(gait: Gait, stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="one value"):
        impedance_schedule({(0.2,): gait}, ("speed",))
    with pytest.raises(
        InputError, match=r"1 of 4 gaits of the grid are not there, the first at speed 0\.3, height 0\.4"
    ):
        impedance_schedule({(0.2, 0.3): gait, (0.2, 0.4): gait, (0.3, 0.3): gait}, ("speed", "height"))
    half = replace(gait.pattern, name="another")
    with pytest.raises(InputError, match="differ in robot, stances, landing rule or ground"):
        impedance_schedule({(0.2,): gait, (0.3,): replace(gait, pattern=half)}, ("speed",))
    with pytest.raises(InputError, match="control law 'impedance'"):
        impedance_schedule({(0.2,): stabilised_gait, (0.3,): stabilised_gait}, ("speed",))


@pytest.mark.slow
def test_between_landings_the_law_is_interpolated_too() -> None:
    """At a gait it is the gait's own, also between two landings, in pieces that are never reached more."""
    trot = replace(load_gait(DATA / "stabilised-trot-one-by-one.json"), control=Impedance())
    stiff = replace(trot, control=Impedance(swing_stiffness=150.0))
    found = impedance_schedule({(0.2,): trot, (0.4,): stiff}, ("speed",))
    joints = len(trot.robot.joints)
    own, other = (Impedance.landing_numbers(gait.control, gait, None) for gait in (trot, stiff))  # type: ignore[arg-type]
    law = found.law((0.25,))
    assert list(law.between) == list(own) == [stance.name for stance, _ in landings(trot)]
    for name, numbers in law.between.items():
        hold = float(own[name].parameters[1])
        assert numbers.breakpoints == pytest.approx((hold,))
        for clock in (0.0, 0.3 * hold, 1.5 * hold):
            expected = references_at(own[name].parameters, clock, joints)
            np.testing.assert_allclose(references_at(numbers.parameters, clock, joints), expected, atol=1e-12)
        gains = slice(2, 2 + 2 * joints)
        mean = 0.75 * own[name].parameters[gains] + 0.25 * other[name].parameters[gains]
        np.testing.assert_allclose(numbers.parameters[gains], mean, rtol=1e-13)


def test_mirror_images_are_the_laws_of_mirrored_motions(gait: Gait, stabilised_gait: Gait) -> None:
    """Of a gait that is its own image written out, the image is the gait itself; of stiffer legs on one side it has
    the other side's."""
    whole = replace(unfolded(stabilised_gait), control=Impedance())
    lame = replace(whole, control=Impedance(stiffness={"D1 fl_hip_pitch": 333.0}))
    grid = {(0.0,): whole, (0.3,): lame}
    found = impedance_schedule(grid, ("yaw_rate",), images=True)
    assert found.values == ((-0.3, 0.0, 0.3),)
    joints, curves = gait.robot.joint_names, slice(2 + 2 * len(gait.robot.joints), None)
    straight, left, right = found.tables[1], found.tables[2], found.tables[0]
    size = np.abs(straight).clip(max=1e3).max()
    np.testing.assert_allclose(right[:, curves], straight[:, curves], atol=1e-9 * size)
    np.testing.assert_array_equal(left[:, curves], straight[:, curves])
    stiff = 2 + joints.index("fr_hip_pitch")
    assert right[2, stiff] == 333.0  # D3 is the mirror image of D1
    np.testing.assert_allclose(np.delete(right[2], stiff), np.delete(straight[2], stiff), atol=1e-9 * size)
    robot = gait.robot
    moved = robot.mirror.state(orbit_arcs(whole, whole.law)[2].states(np.zeros(1))[0][0])
    np.testing.assert_allclose(np.delete(found.starts[0], [0, 1]), np.delete(moved, [0, 1]), atol=1e-9)


def test_a_landing_rule_is_no_matter_where_single_feet_land(gait: Gait) -> None:
    """Gaits of before and after the default changed are steered together."""
    other = replace(gait, pattern=replace(gait.pattern, landing_rule="one by one"))
    assert gait.pattern != other.pattern
    found = impedance_schedule({(0.2,): gait, (0.3,): other}, ("speed",))
    np.testing.assert_array_equal(found.tables[0], found.tables[1])
