"""The example of a feedback law: torques as written, motion as numpy's dense equations say, a walk of a few cycles."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from examples.extending.control_joint_pd import JointImpedance

from amble.control import PseudoInverse
from amble.errors import InputError
from amble.export.law import stance_laws
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.control_law import CONTROL_LAWS
from amble.gait.files import content_hash, load_gait, save_gait
from amble.gait.linearising_law import InputOutputLinearisation
from amble.hybrid import HybridSystem
from amble.simulation import simulate
from amble.verification.stance_model import terms
from tests.cli.run import exit_code

LAW = JointImpedance(300.0, 8.0)


@pytest.fixture(scope="module")
def system(walking_gait: Gait) -> HybridSystem:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")  # a few cycles are shorter than compiling
        return closed_loop(walking_gait, control=LAW)


def test_it_moves_as_dense_equations_say(walking_gait: Gait, system: HybridSystem) -> None:
    """[D -J'; J 0] (a, lambda) = (B u - h, -Jdot v) with u written out here from the recorded nodes."""
    of, generator = walking_gait.robot, np.random.default_rng(0)
    for domain, motion in zip(system.domains, walking_gait.domains, strict=False):
        contacts = walking_gait.pattern.contacts(walking_gait.pattern.stance(domain.name))
        for node in (3, 11, 20):
            q = motion.positions[node] + generator.normal(0.0, 0.01, of.size)
            v = motion.velocities[node] + generator.normal(0.0, 0.1, of.size)
            # the curves pass the recorded nodes to about 1e-4, so their own values are taken from the undisturbed state
            state, clock = np.concatenate([q, v]), float(motion.times[node])
            rest = np.concatenate([motion.positions[node], motion.velocities[node]])
            torque = np.asarray(domain.signals(clock, state, domain.parameters)[0]).ravel()
            nominal = np.asarray(domain.signals(clock, rest, domain.parameters)[0]).ravel()
            np.testing.assert_allclose(nominal, motion.torques[node], atol=0.5)
            moved = 300.0 * (q - motion.positions[node])[6:] + 8.0 * (v - motion.velocities[node])[6:]
            np.testing.assert_allclose(torque - nominal, -moved, atol=1e-9)
            at = terms(contacts, q[None], v[None])
            D, h, J, bias = at.mass[0], at.bias[0], at.jacobian[0], at.contact_bias[0]
            equations = np.block([[D, -J.T], [J, np.zeros((len(J), len(J)))]])
            push = np.concatenate([np.zeros(6), torque]) - h
            expected = np.linalg.solve(equations, np.concatenate([push, -bias]))[: of.size]
            rate = np.asarray(domain.field(clock, state, domain.parameters)).ravel()
            np.testing.assert_allclose(rate[of.size :], expected, atol=1e-8 * np.abs(expected).max())


def test_its_slope_is_that_of_differences(walking_gait: Gait, system: HybridSystem) -> None:
    domain, motion = system.domains[0], walking_gait.domains[0]
    state, clock, step = np.concatenate([motion.positions[5], motion.velocities[5]]), float(motion.times[5]), 1e-6
    direction = np.random.default_rng(1).normal(0.0, 1.0, state.size)
    ends = [
        np.asarray(domain.field(clock, state + sign * step * direction, domain.parameters)).ravel()
        for sign in (1.0, -1.0)
    ]
    slope = np.asarray(domain.jacobian(clock, state, domain.parameters)) @ direction
    np.testing.assert_allclose(slope, (ends[0] - ends[1]) / (2.0 * step), atol=1e-6 * np.abs(slope).max())


def test_it_walks(walking_gait: Gait, system: HybridSystem) -> None:
    trace = simulate(system, start_state(walking_gait), 2, 1e-6)
    assert trace.completed
    distance = trace.state[-1, 0] - trace.state[0, 0]
    assert distance / trace.time[-1] == pytest.approx(walking_gait.speed, rel=0.1)
    assert [symmetry.name for symmetry in system.symmetries] == ["x", "y", "yaw"]


def test_the_gains_of_the_gait_are_its_own_law(walking_gait: Gait) -> None:
    stiff = replace(walking_gait, gains=(150.0, 25.0))
    ours, theirs = closed_loop(walking_gait, control=InputOutputLinearisation(150.0, 25.0)), closed_loop(stiff)
    for one, other in zip(ours.domains, theirs.domains, strict=True):
        np.testing.assert_array_equal(one.parameters, other.parameters)
        assert one.breakpoints == other.breakpoints
    assert CONTROL_LAWS.build(
        "input-output linearisation", {"position_gain": 1.0, "velocity_gain": 2.0}
    ).parameters == {
        "position_gain": 1.0,
        "velocity_gain": 2.0,
    }


def test_a_gait_file_holds_it(walking_gait: Gait, tmp_path: Path) -> None:
    under = replace(walking_gait, control=LAW)
    again = load_gait(save_gait(under, tmp_path / "gait.json"))
    assert again.control == LAW
    assert content_hash(again) == content_hash(under) != content_hash(walking_gait)


def test_it_is_exported_as_written(walking_gait: Gait) -> None:
    """The exported function of a stance against the signals of the closed loop, at a disturbed state."""
    under, generator = replace(walking_gait, control=LAW), np.random.default_rng(3)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")
        domains = closed_loop(under).domains
    for law, domain, motion in zip(stance_laws(under, None), domains, under.domains, strict=False):
        state = np.concatenate([motion.positions[4], motion.velocities[4]]) + generator.normal(0.0, 0.01, 36)
        torque, force = (np.asarray(part).ravel() for part in law.function(0.02, state, law.parameters)[:2])
        expected = [np.asarray(part).ravel() for part in domain.signals(0.02, state, domain.parameters)[:2]]
        np.testing.assert_allclose(torque, expected[0], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(force, expected[1], rtol=1e-9, atol=1e-9)
    with pytest.raises(InputError, match="takes no allocation law"):
        stance_laws(under, PseudoInverse())


def test_its_gains_can_be_chosen(walking_gait: Gait) -> None:
    places = LAW.gains(walking_gait, "D1")
    packed = LAW.packed(walking_gait, "D1")
    assert {label: packed[place] for label, place in places.items()} == {"stiffness": 300.0, "damping": 8.0}
    assert LAW.with_gains({"stiffness": 250.0, "damping": 7.0}) == JointImpedance(250.0, 7.0)


def test_it_takes_no_allocation_law(walking_gait: Gait) -> None:
    with pytest.raises(
        InputError, match="control law 'joint impedance' gives the torques itself; it takes no allocation"
    ):
        closed_loop(walking_gait, PseudoInverse(), control=LAW)
    with pytest.raises(InputError, match="must not be negative"):
        CONTROL_LAWS.build("joint impedance", {"stiffness": -1.0})


def test_the_command_line_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """On a biped: its six joints are sooner set up than twelve."""
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    file = str(Path(__file__).parents[1] / "data" / "biped-of-small-basin.json")
    words = ["simulate", file, "--cycles", "1", "--tolerance", "1e-5", "--json", "--out", str(tmp_path / "trace.nc")]
    plugin = ["--plugin", "examples.extending.control_joint_pd"]
    assert exit_code(*words, "--control", "joint impedance:stiffness=300,damping=8", *plugin) == 0
    assert json.loads(capsys.readouterr().out)["simulation"]["ended"] == "completed"
    assert exit_code(*words, "--control", "servo") == 2
    assert "unknown control law 'servo'; known: impedance, input-output linearisation" in capsys.readouterr().out
