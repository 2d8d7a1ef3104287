"""Gains of pushes and errors of the plant, against the variational equations and the equations of motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

from amble.errors import FallError, InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.files import load_gait
from amble.gait.plant_errors import PlantErrors
from amble.gait.unilateral_loop import on_unilateral_ground
from amble.gait.unilateral_state import Push, unilateral_start
from amble.hybrid.unilateral import base_jacobian
from amble.robot import dynamics
from amble.simulation.walk import walk
from amble.stability import push_response
from amble.stability.fast_mode import fast_mode
from amble.stability.input_gains import STICKY, CycleMap, disturbances, entered
from amble.stability.monodromy import monodromy
from amble.stability.push_response import impulse_unit
from amble.types import Vector
from tests.conftest import DATA


@pytest.fixture(scope="module")
def cycle(stabilised_gait: Gait) -> CycleMap:
    return CycleMap.of(stabilised_gait)


def test_w_bounds_what_is_left_of_a_deviation(cycle: CycleMap) -> None:
    """|xi| <= |xi|_W, and |A xi|_W <= r |xi|_W: what the input-to-state gain rests on."""
    generator = np.random.default_rng(1)
    for deviation in generator.normal(size=(200, len(cycle.metric))):
        moved = cycle.spectrum.matrix @ deviation
        assert np.linalg.norm(cycle.change @ deviation) <= cycle.weighted(deviation) * (1.0 + 1e-9)
        assert cycle.weighted(moved) <= cycle.rate * cycle.weighted(deviation) * (1.0 + 1e-6)


def jump_of(cycle: CycleMap, impulse: Vector) -> Vector:
    """What an impulse on the base does to the state at once, N J' p: (2 n_q,)."""
    gait, n = cycle.gait, cycle.gait.robot.size
    contacts = gait.pattern.contacts(gait.pattern.stances[0])
    q = ca.SX.sym("q", n)
    parts = [dynamics.mass_matrix(gait.robot, q), contacts.jacobian(q), base_jacobian(contacts, q)]
    terms = ca.Function("terms", [q], [ca.densify(part) for part in parts])
    D, J, base = (np.asarray(part) for part in terms(cycle.state[:n]))
    rows = np.block([[D, -J.T], [J, np.zeros((6, 6))]])
    jump = np.linalg.solve(rows, np.concatenate([base.T @ impulse, np.zeros(6)]))[:n]
    return np.concatenate([np.zeros(n), jump])


def test_an_orbit_at_the_edge_of_its_contacts_has_no_response(cycle: CycleMap, monkeypatch: pytest.MonkeyPatch) -> None:
    """A walk whose landing leaves a foot without load ended in a traceback: walks with small pushes had more arcs."""
    sizes = iter([42, 42, 63])
    monkeypatch.setattr(push_response, "_walked", lambda *_: SimpleNamespace(section=np.zeros((3, 47))))
    monkeypatch.setattr(push_response, "_reserves", lambda *_: np.zeros(next(sizes)))
    with pytest.raises(FallError, match="changes which feet are let go or touch"):
        push_response.push_response(cycle, 0.8)


@pytest.fixture(scope="module")
def trot() -> Iterator[CycleMap]:
    """Feet that land one by one; interpreted, since compiling takes longer than these few cycles."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")
        yield CycleMap.of(load_gait(DATA / "stabilised-trot-one-by-one.json"))


@pytest.mark.slow
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_push_is_carried_by_the_order_of_landing_that_it_makes(trot: CycleMap, sign: float) -> None:
    """One W serves the derivative of every order over the whole cycle; those of a push to either side differ."""
    gait, lasting = trot.gait, 1e-4
    impulse = sign * np.array([3e-5, 6e-5, 0.0]) * impulse_unit(gait.robot)
    push = Push(force=tuple(impulse / lasting), end=lasting)
    walked = walk(trot.walker, unilateral_start(gait, trot.state, push), 1, 1e-9, 2, 10.0)
    first = {
        switch.name: event.transition
        for switch, event in zip(gait.pattern.all_switches, walked.events[::2], strict=True)
    }
    order = {
        switch.name: tuple(sorted(switch.landing, key=lambda foot, name=switch.name: not first[name].endswith(foot)))
        for switch in gait.pattern.all_switches
    }
    matrix = monodromy(closed_loop(gait, orders=order), trot.state, 1e-8).matrix
    for deviation in np.random.default_rng(1).normal(size=(20, len(trot.metric))):
        moved = trot.reduced(matrix @ trot.spectrum.basis @ deviation)
        assert trot.weighted(moved) <= trot.rate * trot.weighted(deviation) * (1.0 + 1e-6)
    found = (walked.events[-1].after - trot.usual.events[-1].after)[: trot.state.size]
    expected = matrix @ jump_of(trot, impulse)
    # on the stored orbit the feet land 0.5 us apart, after this push 12 us
    np.testing.assert_allclose(found, expected, atol=0.1 * np.abs(expected).max())
    other = closed_loop(gait, orders={switch: feet[::-1] for switch, feet in order.items()})
    elsewhere = monodromy(other, trot.state, 1e-8).matrix @ jump_of(trot, impulse)
    assert np.abs(found - elsewhere).max() > 0.2 * np.abs(expected).max()


def test_a_short_push_is_a_jump_of_the_rates(cycle: CycleMap) -> None:
    """To first order a push changes the rates by N J' p, N the inverse mass of the standing robot; then dP/dx."""
    gait, lasting = cycle.gait, 1e-6
    impulse = np.array([1e-4, 2e-4, 0.0]) * impulse_unit(gait.robot)
    expected = monodromy(cycle.loop, cycle.state).matrix @ jump_of(cycle, impulse)
    images = [
        entered(gait, cycle.walker, cycle.state, Push(force=tuple(sign * impulse / lasting), end=lasting))
        for sign in (1.0, -1.0)
    ]
    found = (images[0] - images[1]) / 2.0
    np.testing.assert_allclose(found, expected, atol=3e-3 * np.abs(expected).max())


def test_a_step_moves_the_landing(cycle: CycleMap) -> None:
    """A foot that lands h higher lands earlier by h over its speed; the last switch is followed by nothing else."""
    gait, h = cycle.gait, 1e-6
    foot = gait.pattern.all_switches[-1].landing[0]
    images = [
        entered(
            gait,
            on_unilateral_ground(gait, cycle.loop, PlantErrors(friction=STICKY, steps={foot: sign * h})),
            cycle.state,
        )
        for sign in (1.0, -1.0)
    ]
    found = (images[0] - images[1]) / (2.0 * h)
    usual = cycle.usual
    last = usual.arcs[-1].arc
    domain = cycle.loop.domain(gait.pattern.stances[-1].name)
    transition = next(t for t in cycle.loop.transitions if t.source == domain.name)
    clock, before = float(last.clock[-1]), last.state[-1, : cycle.state.size]
    rate = np.asarray(domain.field(clock, before, domain.parameters)).ravel()
    ahead, behind = (
        np.asarray(transition.reset(clock, before + sign * 1e-6 * rate, domain.parameters)).ravel()
        for sign in (1.0, -1.0)
    )
    speeds = [float(transition.guard(clock, before + sign * 1e-6 * rate, domain.parameters)) for sign in (1.0, -1.0)]
    sinking = (speeds[0] - speeds[1]) / 2e-6
    expected = (ahead - behind) / 2e-6 / sinking
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


def test_every_error_is_of_the_robots_size(cycle: CycleMap) -> None:
    robot = cycle.gait.robot
    kinds = {kind.name: kind for kind in disturbances(robot)}
    assert kinds["dry friction of the joints"].natural == pytest.approx(robot.mass * robot.gravity * robot.leg_length)
    assert kinds["mass of the base link"].errors(0.1, None).trunk == pytest.approx(1.1)
    assert kinds["step under fl"].errors(-0.01, None).steps == {"fl": pytest.approx(-0.01 * robot.leg_length)}


def test_the_fastest_mode_is_that_of_the_whole_equations(cycle: CycleMap) -> None:
    """At the start, feet pinned: eigenvalues of the map v -> acceleration from [D -J'; J 0] with u = K v alone."""
    found = fast_mode(cycle)
    gait, n = cycle.gait, cycle.gait.robot.size
    stance = gait.pattern.stances[0]
    domain, contacts = cycle.loop.domain(stance.name), gait.pattern.contacts(stance)
    q = ca.SX.sym("q", n)
    terms = ca.Function("terms", [q], [dynamics.mass_matrix(gait.robot, q), contacts.jacobian(q)])
    D, J = (np.asarray(ca.DM(part)) for part in terms(cycle.state[:n]))
    place = domain.signals.name_out().index("torque")

    def torque(rates: np.ndarray) -> np.ndarray:
        state = np.concatenate([cycle.state[:n], rates])
        return np.asarray(domain.signals(0.0, state, domain.parameters)[place]).ravel()

    rates = cycle.state[n:]
    K = np.column_stack([(torque(rates + 1e-5 * e) - torque(rates - 1e-5 * e)) / 2e-5 for e in np.eye(n)])
    right = np.vstack([np.zeros((6, n)), K, np.zeros((6, n))])
    moved = np.linalg.solve(np.block([[D, -J.T], [J, np.zeros((6, 6))]]), right)[:n]
    here = np.abs(np.linalg.eigvals(moved)).max()
    assert here <= found.pinned * (1.0 + 1e-6)
    assert found.pinned < 2.0 * here
    assert found.lost > 10.0 * found.pinned
    assert found.delay_limits[1] == pytest.approx(np.pi / 2.0 / max(found.lost, found.flight))


def test_only_a_stable_orbit_has_gains(stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="stabilise it first"):
        CycleMap.of(replace(stabilised_gait, feedback=None))
