"""Gaits that turn: their return map modulo the turn, by means that share nothing with the reset that turns back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.analysis import ContactBounds, contact_report
from amble.control.outputs import selection_matrix
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.gait.unilateral_loop import unilateral_loop
from amble.proof.gait_map import require_provable
from amble.robot import kinematics
from amble.robot.turn import turned
from amble.simulation import Trace, simulate
from amble.simulation.world_axes import in_cycle_axes
from amble.stability.monodromy import monodromy
from amble.stability.poincare import poincare_map
from amble.stability.spectrum import multipliers
from amble.types import Vector
from amble.verification.check import check

GAIT = Path(__file__).parents[1] / "data" / "turning-trot.json"


@pytest.fixture(scope="module", autouse=True)
def _interpreted() -> Iterator[None]:
    """A few cycles take less than compiling."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")
        yield


@pytest.fixture(scope="module")
def gait() -> Gait:
    """Stabilised: forward 0.2 m/s, to the left 0.05 m/s, 0.5 rad/s."""
    return load_gait(GAIT)


@pytest.fixture(scope="module")
def blind(gait: Gait) -> Gait:
    """The same under the outputs of the gait problem, which do not see the heading."""
    assert gait.feedback is not None
    weights = {part.name: selection_matrix(gait.robot, gait.outputs.of(part.name)) for part in gait.domains}
    return replace(gait, feedback=replace(gait.feedback, weights=weights))


def facing(state: Vector, angle: float) -> Vector:
    """The state turned about the vertical."""
    half = len(state) // 2
    return np.concatenate([part[0] for part in turned(state[None, :half], state[None, half:], angle)])


def never_turned_back(gait: Gait, state: Vector) -> Vector:
    """A cycle of the same closed loop in the world's axes, turned back afterwards."""
    return facing(poincare_map(closed_loop(replace(gait, yaw_rate=0.0)), state, 1e-12), -gait.turn)


def test_the_return_map_is_that_of_the_world_turned_back(gait: Gait) -> None:
    state = start_state(gait) + 1e-4 * np.random.default_rng(0).choice([-1.0, 1.0], 2 * gait.robot.size)
    np.testing.assert_allclose(poincare_map(closed_loop(gait), state), never_turned_back(gait, state), atol=1e-10)


def test_the_derivative_is_that_of_the_world_turned_back(gait: Gait) -> None:
    """Along random directions, by differences of simulated cycles."""
    state, rng = start_state(gait), np.random.default_rng(1)
    exact = monodromy(closed_loop(gait), state).matrix
    for _ in range(2):
        along = rng.normal(size=len(state))
        along /= np.linalg.norm(along)
        ahead, behind = (never_turned_back(gait, state + sign * 1e-4 * along) for sign in (1.0, -1.0))
        expected = exact @ along
        np.testing.assert_allclose((ahead - behind) / 2e-4, expected, atol=1e-4 * float(np.linalg.norm(exact, 2)))


@pytest.mark.parametrize("angle", [2.5])
def test_the_initial_heading_does_not_matter(blind: Gait, angle: float) -> None:
    """Where no output sees it; the same multipliers, symmetric in yaw."""
    state, system = start_state(blind), closed_loop(blind)
    assert [symmetry.name for symmetry in system.symmetries] == ["x", "y", "yaw"]
    there = facing(state, angle)
    np.testing.assert_allclose(poincare_map(system, there), facing(poincare_map(system, state), angle), atol=1e-9)
    here, turned_there = multipliers(system, state), multipliers(system, there)
    assert turned_there.radius == pytest.approx(here.radius, rel=1e-6)
    assert max(symmetry.residual for symmetry in turned_there.neutral) < 1e-7
    yaw = next(symmetry for symmetry in turned_there.neutral if symmetry.name == "yaw")
    assert yaw.multiplier == pytest.approx(1.0, abs=1e-7)


def test_it_walks_on_a_circle_with_sound_contacts(gait: Gait) -> None:
    trace = simulate(gait, cycles=8, perturbation=1e-4, seed=1)
    assert trace.completed
    report = contact_report(trace, gait.pattern, ContactBounds.of_gait(gait))
    assert report.sound_from is not None
    assert report.max_drift < 1e-3  # a stance that is cut by the turn back would have moved by its radius
    _in_the_world(gait, trace)
    apart = in_cycle_axes(gait, trace.section)[:, 2 : gait.robot.size] - start_state(gait)[2 : gait.robot.size]
    assert np.abs(apart[-1]).max() < 1e-5  # 1e-4 at the start, and the radius is 0.35


def _in_the_world(gait: Gait, trace: Trace) -> None:
    """No jump between samples; the heading and the place are those commanded; feet are where the state has them."""
    q = trace.state[:, : gait.robot.size]
    same = np.diff(trace.time) == 0.0
    np.testing.assert_allclose(q[1:][same], q[:-1][same], atol=1e-9)
    cycles = trace.cycles
    x, y, angle = gait.command.way(gait.period)
    assert trace.section[-1, 5] - trace.section[0, 5] == pytest.approx(cycles * angle, abs=1e-3)
    steps = np.diff(trace.section[-5:, :2], axis=0)
    np.testing.assert_allclose(np.linalg.norm(steps, axis=1), np.hypot(x, y), rtol=1e-3)
    feet = trace.signals["foot"].reshape(len(q), -1, 3)
    for row in np.random.default_rng(2).choice(len(q), 20):
        for place, foot in enumerate(gait.robot.foot_names):
            expected = np.asarray(kinematics.foot_position(gait.robot, foot, q[row])).ravel()
            np.testing.assert_allclose(feet[row, place], expected, atol=1e-9)


@pytest.mark.slow
def test_its_check_integrates_the_feedback_around_the_turn(gait: Gait) -> None:
    rows = [row for row in check(gait).rows if "feedback returns" in row.name]
    assert rows
    assert all(row.passed for row in rows)
    assert gait.feedback is not None
    other = replace(gait, feedback=replace(gait.feedback, start=gait.feedback.start + 1e-3))
    assert not all(row.passed for row in check(other).rows if "feedback returns" in row.name)


@pytest.mark.slow
def test_impedance_walks_and_turns(gait: Gait) -> None:
    """It sees joints alone, so it is a law of the turning robot as it is of one that goes straight."""
    driven = replace(gait, control=Impedance())
    trace, own = simulate(driven, cycles=1), simulate(gait, cycles=1)
    np.testing.assert_allclose(trace.section[1, 2:], own.section[1, 2:], atol=1e-5)


def test_what_stays_refused_says_so(gait: Gait) -> None:
    with pytest.raises(InputError, match="turns has no unilateral simulation"):
        unilateral_loop(gait)
    with pytest.raises(InputError, match="the gait turns"):
        require_provable(gait)
