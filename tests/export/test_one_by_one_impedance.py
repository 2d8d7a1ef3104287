"""The impedance law where feet land one by one: references and gains of its own between two landings, in C as here."""

from __future__ import annotations

import ctypes
from dataclasses import replace
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from amble.control.landing import landing_plant, stopping
from amble.errors import UnknownNameError
from amble.export import export_controller
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.files import load_gait
from amble.gait.impedance import HOLD, Impedance
from amble.gait.landing_stances import landings
from amble.hybrid import HybridSystem
from amble.hybrid.system import numeric
from tests.export.test_impedance import CONTACT_FLAGS, LATE, Command, Controller, Numbers, built

GAIT = Path(__file__).parents[1] / "data" / "stabilised-trot-one-by-one.json"
LAW = Impedance(stiffness={"D1 fl fl_knee": 77.0})
TICK = 0.001


@pytest.fixture(scope="module")
def gait() -> Gait:
    return replace(load_gait(GAIT), control=LAW)


@pytest.fixture(scope="module")
def system(gait: Gait) -> HybridSystem:
    """Interpreted: compiling takes longer than these few evaluations."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")
        return closed_loop(gait)


@pytest.fixture(scope="module")
def library(gait: Gait, tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder = export_controller(gait, None, tmp_path_factory.mktemp("export") / "controller").folder
    return ctypes.CDLL(str(built(folder, folder.parent / "c.so", "-shared", "-fPIC")))


class Ticks:
    """Ticks of one controller at one state."""

    def __init__(self, library: ctypes.CDLL, gait: Gait, stance: int, state: np.ndarray) -> None:
        self.library, self.c, self.out, self.gait = library, Controller(), Command(), gait
        angles, rates = state[6:18], state[24:]
        self.q, self.qd = Numbers(*angles), Numbers(*rates)
        assert library.amble_enter(ctypes.byref(self.c), stance) == 0

    def __call__(self, feet: set[str], ticks: int) -> int:
        flags = (ctypes.c_ubyte * 4)(*(foot in feet for foot in self.gait.robot.foot_names))
        status = 0
        for _ in range(ticks):
            status = self.library.amble_step(
                ctypes.byref(self.c), ctypes.c_double(TICK), self.q, self.qd, flags, ctypes.byref(self.out)
            )
        return int(status)

    @property
    def stance(self) -> str:
        return self.gait.pattern.visited[self.c.stance].name


@pytest.mark.parametrize("source", [0, 1])
@pytest.mark.parametrize("turn", [0, 1])
@pytest.mark.parametrize("share", [0.1, 1.0])
def test_feet_land_in_every_order(
    gait: Gait, system: HybridSystem, library: ctypes.CDLL, source: int, turn: int, share: float
) -> None:
    """C leads through the stances of the simulation with its torques, its gains and its clock, however early."""
    switch = gait.pattern.all_switches[source]
    first, second = list(permutations(switch.landing))[turn]
    between = next(
        step.target for step in gait.pattern.steps if step.source == switch.source and step.landing == (first,)
    )
    draw = np.random.default_rng(2 * source + turn)
    state = start_state(gait) + draw.normal(0.0, 1e-2, 2 * gait.robot.size)
    walk = Ticks(library, gait, source, state)

    def same(name: str, clock: float) -> None:
        domain = system.domain(name)
        expected = numeric(domain.signals(clock, state, domain.parameters)[0])
        np.testing.assert_allclose(list(walk.out.sum), expected, rtol=1e-10, atol=1e-10)

    assert gait.feedback is not None
    planned = gait.feedback.durations["D1"]
    walk({*switch.source.feet, first}, 4)  # it still touches from the stance before
    assert walk.stance == switch.source.name
    walk(set(switch.source.feet), max(2, int(share * planned / TICK)))
    walk({*switch.source.feet, first}, 2)
    assert walk.stance == between.name
    for ticks in (0, 7, int(0.6 * planned / TICK)):
        status = walk({*switch.source.feet, first}, ticks)  # those released may still touch
        assert not status & CONTACT_FLAGS
        same(between.name, walk.c.clock)
    assert bool(status & LATE)  # the references stand still, 0.5 of the plan after the first landing
    assert not any(walk.out.rate)
    assert not walk({first, second}, 2) & CONTACT_FLAGS
    assert (walk.stance, walk.c.clock) == (switch.target.name, 0.0)
    same(switch.target.name, 0.0)


def test_the_orbit_lands_under_the_rule_of_any_law(gait: Gait, system: HybridSystem) -> None:
    """Where all feet land at once, accelerations, torques, forces are those of eq. 22 with the next stance's torques.

    On the orbit of this file the feet land half a microsecond apart, so that states differ by 8e-5.
    """
    robot = gait.robot
    for stance, following in landings(gait):
        domain, entered = system.domain(stance.name), system.domain(following.name)
        last = gait.pattern.solved[gait.pattern.solved.index(following) - 1]
        assert gait.feedback is not None
        time, x = gait.feedback.durations[last.name], start_state(gait)
        loop = system.domain(last.name)
        before = solve_ivp(
            lambda t, y, loop=loop: numeric(loop.field(t, y, loop.parameters)), (0.0, time), x, rtol=1e-10, atol=1e-10
        ).y[:, -1]
        before = robot.mirror.state(before)
        landed = numeric(stopping(gait.pattern.contacts(stance))(before))
        all_landed = numeric(stopping(gait.pattern.contacts(following))(before))
        u = numeric(entered.signals(0.0, all_landed, entered.parameters)[0])
        late = tuple(foot for foot in following.feet if foot not in stance.feet)
        rate, force, torque = (numeric(part) for part in landing_plant(gait.pattern.contacts(stance), late)(landed, u))
        np.testing.assert_allclose(
            numeric(domain.field(0.0, landed, domain.parameters)), rate, atol=3e-4 * np.abs(rate).max()
        )
        values = domain.signals(0.0, landed, domain.parameters)
        np.testing.assert_allclose(numeric(values[0]), torque, atol=3e-4 * np.abs(torque).max())
        np.testing.assert_allclose(numeric(values[1]), force, atol=3e-4 * np.abs(force).max())


def test_gains_of_their_own(gait: Gait) -> None:
    """A joint of a leg that has landed is stiff as in stance, one of a late leg as in swing, and each can be named."""
    stance = next(stance for stance, _ in landings(gait) if stance.name == "D1 fl")
    stiffness, _ = Impedance().joint_gains(gait.robot, stance)
    usual = Impedance().joint_gains(gait.robot, gait.pattern.solved[0])[0]
    names = list(gait.robot.joint_names)
    assert stiffness[names.index("fl_knee")] == usual[names.index("fl_knee")]
    assert stiffness[names.index("rr_knee")] < usual[names.index("rr_knee")]
    own = Impedance(stiffness={"D1 fl rr_knee": 77.0})
    assert own.joint_gains(gait.robot, stance)[0][names.index("rr_knee")] == 77.0
    found = own.landing_numbers(gait, None)["D1 fl"].parameters
    assert found[2 + names.index("rr_knee")] == 77.0
    assert found[1] == pytest.approx((HOLD - 1.0) * gait.feedback.durations["D1"])  # type: ignore[union-attr]
    with pytest.raises(
        UnknownNameError, match="unknown domain with a gain of its own 'D9 fl'; known: D1, D1 fl, D1 rr"
    ):
        Impedance(stiffness={"D9 fl rr_knee": 77.0}).numbers(gait, None)
