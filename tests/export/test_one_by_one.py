"""The exported C where feet land one by one: a stance of its own for every set of feet that have landed."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from amble.codegen import compiler
from amble.export import Exported, export_controller, exported_loop
from amble.export.vectors import CONTACT_FLAGS, OK
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.hybrid import HybridSystem
from amble.hybrid.system import numeric
from amble.robot.natural_units import natural_units
from amble.simulation import simulate
from amble.simulation.simulate import perturbed
from tests.export.test_controller import STRICT, Controller

GAIT = Path(__file__).parents[1] / "data" / "stabilised-trot-one-by-one.json"

pytestmark = pytest.mark.skipif(compiler() is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def gait() -> Gait:
    return load_gait(GAIT)


@pytest.fixture(scope="module")
def system(gait: Gait) -> HybridSystem:
    """Interpreted: compiling takes longer than these few evaluations."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")
        return closed_loop(gait)


@pytest.fixture(scope="module")
def exported(gait: Gait, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """A folder with strictly compiled objects beside the sources."""
    written = export_controller(gait, None, tmp_path_factory.mktemp("one_by_one"))
    tool = compiler()
    assert tool is not None
    names = [path.name for path in (*written.sources, written.folder / "replay.c")]
    subprocess.run([tool.path, *STRICT, "-fPIC", "-c", *names], cwd=written.folder, check=True)
    return written


def link(exported: Exported, *arguments: str) -> None:
    tool = compiler()
    assert tool is not None
    objects = [path.with_suffix(".o").name for path in exported.sources]
    subprocess.run([tool.path, *arguments, *objects, "-lm"], cwd=exported.folder, check=True)


@pytest.fixture
def controller(exported: Exported) -> Controller:
    link(exported, "-shared", "-o", "controller.so")
    return Controller(exported.folder / "controller.so")


def flags(gait: Gait, feet: set[str]) -> tuple[int, ...]:
    return tuple(int(foot in feet) for foot in gait.robot.foot_names)


def test_the_vectors_of_every_stance_are_reproduced(exported: Exported) -> None:
    """Two stances of the gait and four between landings; the program holds every difference against 1e-12."""
    link(exported, "-o", "replay", "replay.o")
    done = subprocess.run(
        ["./replay", "test_vectors.txt"], cwd=exported.folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"{20 * 6 + 5} vectors, 0 wrong")


@pytest.mark.parametrize("source", [0, 1])
@pytest.mark.parametrize("turn", [0, 1])
@pytest.mark.parametrize("share", [0.1, 0.45, 1.0])
def test_feet_land_in_every_order(
    gait: Gait, system: HybridSystem, controller: Controller, source: int, turn: int, share: float
) -> None:
    """The first to land leads between the landings, the torques are those of the simulation, the last to the stance.

    However early: a foot lands where it comes to the ground after it was off it, as in the simulation.
    """
    pattern = gait.pattern
    switch = pattern.all_switches[source]
    first, second = list(permutations(switch.landing))[turn]
    draw = np.random.default_rng(2 * source + turn)
    state = start_state(gait) + draw.normal(0.0, 1e-2, 2 * gait.robot.size)
    q, v = state[: gait.robot.size], state[gait.robot.size :]
    assert controller.enter(source, 1.0) == OK
    controller.step(1.001, q, v, flags(gait, {*switch.source.feet, first}))  # it still touches from the stance before
    assert controller.stance == source
    controller.step(1.002, q, v, flags(gait, set(switch.source.feet)))
    assert gait.feedback is not None
    lands = 1.0 + share * next(iter(gait.feedback.durations.values()))
    between = next(step.target for step in pattern.steps if step.source == switch.source and step.landing == (first,))
    domain = system.domain(between.name)
    expected = dict(zip(domain.signals.name_out(), domain.signals(0.0, state, domain.parameters), strict=True))
    for time in (lands, lands + 0.001, lands + 0.002):
        # the feet that were released may still touch
        assert not controller.step(time, q, v, flags(gait, {first, *switch.source.feet})) & CONTACT_FLAGS
        assert pattern.visited[controller.stance] == between
        torques = numeric(expected["torque"])
        np.testing.assert_allclose(controller.torques, torques, atol=1e-10 * np.abs(torques).max())
        forces = numeric(expected["force"])
        np.testing.assert_allclose(controller.forces, forces, atol=1e-10 * np.abs(forces).max())
    assert not controller.step(lands + 0.003, q, v, flags(gait, {second, first})) & CONTACT_FLAGS
    assert pattern.visited[controller.stance] == switch.target
    following = system.domain(switch.target.name)
    torques = numeric(following.signals(0.0, state, following.parameters)[0])
    np.testing.assert_allclose(controller.torques, torques, atol=1e-10 * np.abs(torques).max())


def test_feet_that_land_in_the_same_tick_pass_both_switches(gait: Gait, controller: Controller) -> None:
    state = start_state(gait)
    q, v = state[: gait.robot.size], state[gait.robot.size :]
    assert controller.enter(0, 0.0) == OK
    controller.step(0.01, q, v, flags(gait, set(gait.pattern.stances[0].feet)))
    controller.step(0.15, q, v, flags(gait, set(gait.pattern.stances[1].feet)))
    assert gait.pattern.visited[controller.stance] == gait.pattern.stances[1]


@pytest.fixture(scope="module")
def native(gait: Gait) -> HybridSystem:
    return closed_loop(gait)


@pytest.mark.slow
@pytest.mark.parametrize(("share", "size"), [(0.0, 3e-3), (0.85, 1e-2)])
def test_the_stances_are_those_of_simulated_walks(
    gait: Gait, native: HybridSystem, controller: Controller, share: float, size: float
) -> None:
    """The flags of simulated walks, tick by tick, lead through the domains of the simulation, at the same ticks.

    A walk that starts at 85 % of the first stance may land in the first half of the plan, in both orders.
    """
    scale, start = natural_units(gait.robot, gait.robot.leg_length), start_state(gait)
    if share:
        first = simulate(native, start, 1, samples=201)
        start = first.state[int(share * 200)]
    numbers = {stance.name: number for number, stance in enumerate(gait.pattern.visited)}
    orders = set()
    for seed in range(24):
        changed = start + scale * perturbed(np.zeros(start.size), size, seed)
        trace = simulate(native, changed, 1, samples=9)
        assert gait.feedback is not None
        if not share or trace.events[0].time < 0.5 * gait.feedback.durations["D1"]:
            orders.add(trace.events[0].transition)
        controller.enter(0, 0.0)
        for time, number, state in zip(trace.time, trace.domain, trace.state, strict=True):
            here = trace.domains[number]
            feet = set(gait.pattern.visited[numbers[here]].feet)
            q, v = np.split(state, 2)
            controller.step(float(time), q, v, flags(gait, feet))
            assert controller.stance == numbers[here], (seed, time)
    assert orders == {step.source.name + "->" + step.target.name for step in gait.pattern.steps[:2]}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_the_exported_walk_is_that_of_the_closed_loop(gait: Gait, native: HybridSystem, seed: int) -> None:
    """From a changed start, with feet that land in both orders."""
    start = start_state(gait)
    start = start + natural_units(gait.robot, gait.robot.leg_length) * perturbed(np.zeros(start.size), 1e-2, seed)
    model, exported = (simulate(loop, start, 3, samples=5) for loop in (native, exported_loop(gait)))
    assert model.completed
    assert [event.transition for event in exported.events] == [event.transition for event in model.events]
    assert any(" " in event.transition for event in model.events)
    # C cuts torques at the limits of the motors, which these starts do not reach
    assert np.max(np.abs(exported.state - model.state)) <= 1e-6
    for name in ("torque", "force"):
        values = model.signals[name]
        assert np.max(np.abs(exported.signals[name] - values)) <= 1e-5 * np.max(np.abs(values)), name


@pytest.mark.slow
@pytest.mark.parametrize("control", [None, Impedance()], ids=["linearisation", "impedance"])
def test_every_domain_has_the_torques_of_the_closed_loop(gait: Gait, control: Impedance | None) -> None:
    """Under any control law: at states near the gait, the rates of all six domains."""
    under = replace(gait, control=control)
    model, native = closed_loop(under), exported_loop(under)
    draw = np.random.default_rng(3)
    assert len(model.domains) == len(native.domains) == 6
    for domain in model.domains:
        state = start_state(gait) + draw.normal(0.0, 1e-2, 2 * gait.robot.size)
        for clock in (0.0, 0.1):
            fields = (native.domain(domain.name).field, domain.field)
            rates = [numeric(field(clock, state, domain.parameters)) for field in fields]
            np.testing.assert_allclose(rates[0], rates[1], atol=1e-9 * np.abs(rates[1]).max())
