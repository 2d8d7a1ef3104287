"""The worked examples of extending amble, each one file and one registration: built, evaluated, written to a file."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from examples.extending.contact_torsional import TorsionalContact
from examples.extending.ground_sine import SineGround

from amble.control import BoundedMinimumNorm, PseudoInverse, joint_outputs
from amble.control.linearisation import linearise
from amble.control.phase import DomainPhase, TimePhase
from amble.control.virtual_constraints import VirtualConstraints, pack
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.files import load_gait, save_gait
from amble.hybrid import CONTACTS, Contacts, Plane, constrained_dynamics, impact
from amble.hybrid.gaits import amble
from amble.robot import kinematics
from amble.simulation import simulate
from amble.synthesis import GaitProblem, gait_problem
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import build_program
from amble.types import frozen
from amble.verification.output_dynamics import OutputDynamics
from amble.verification.stance_model import allocated, terms
from tests.control.allocation.stances import random_postures
from tests.grounds import on_ground
from tests.robots import robot

WAVES = SineGround(amplitude=2e-3, wavelength=0.3)
TORSIONAL = TorsionalContact(0.02)


def test_a_gait_on_the_new_ground_is_written_and_read(walking_gait: Gait, tmp_path: Path) -> None:
    gait = on_ground(walking_gait, WAVES)
    read = load_gait(save_gait(gait, tmp_path / "waves.json"))
    assert read.pattern.ground == WAVES
    assert read.pattern == gait.pattern


def test_steps_on_the_new_ground_end_on_its_surface(stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")  # one cycle is shorter than compiling
    gait = on_ground(stabilised_gait, WAVES)
    system = closed_loop(gait)
    assert [symmetry.name for symmetry in system.symmetries] == ["y"]
    trace = simulate(system, start_state(gait), 1)
    assert trace.ended == "completed"
    heights = []
    names = [stance.name for stance in gait.pattern.stances]
    for event, switch in zip(trace.events, gait.pattern.all_switches, strict=True):
        before = (trace.time <= event.time) & (trace.domain == names.index(switch.source.name))
        state = trace.state[np.flatnonzero(before)[-1], : gait.robot.size]
        foot = np.asarray(kinematics.foot_position(gait.robot, switch.landing[0], state)).ravel()
        assert WAVES.gap(foot) == pytest.approx(0.0, abs=1e-9)  # the event is located to the integrator's tolerance
        heights.append(foot[2])
    assert np.ptp(heights) > 1e-4  # so the ground is not level where feet land


def test_waves_allow_no_periodic_gait_problem(small_problem: GaitProblem) -> None:
    with pytest.raises(InputError, match="ground that stays the same along x; ground 'sine' does not"):
        on_ground(small_problem, WAVES)


@pytest.mark.parametrize("ground", [Plane(), Plane(slope=0.2), SineGround(amplitude=0.05, wavelength=0.7)])
def test_the_new_contact_moves_as_dense_equations_say(ground: Plane | SineGround) -> None:
    """Its row is the angular velocity about the normal: Jacobian, bias by differences, dynamics and impact by numpy."""
    of = robot("astro")
    contacts = Contacts(of, ("rl", "fr"), TORSIONAL, ground)
    assert (contacts.size, contacts.internal_force_count) == (8, 2)
    assert contacts.labels[3::4] == ("rl twist", "fr twist")
    q, v, u = ca.SX.sym("q", of.size), ca.SX.sym("v", of.size), ca.SX.sym("u", 12)
    motion = constrained_dynamics(contacts, q, v)
    N, W = contacts.torque_null_space(q)
    acceleration = motion.free_acceleration + motion.input_map @ u
    parts = [acceleration, motion.free_force + motion.force_map @ u, *impact(contacts, q, v), motion.input_map @ N, W]
    function = ca.Function("torsional", [q, v, u], [ca.densify(part) for part in parts])
    generator = np.random.default_rng(1)
    for pose, rate in zip(*random_postures("astro", 10, seed=5), strict=True):
        at = terms(contacts, pose[None], rate[None])
        D, h, J, bias = at.mass[0], at.bias[0], at.jacobian[0], at.contact_bias[0]
        for row, foot in enumerate(contacts.feet):
            np.testing.assert_allclose(J[4 * row + 3] @ rate, _spin(contacts, foot, pose, rate), atol=1e-7)
        step = 1e-6
        ahead, behind = (terms(contacts, (pose + s * rate)[None], rate[None]).jacobian[0] for s in (step, -step))
        np.testing.assert_allclose((ahead - behind) @ rate / (2.0 * step), bias, atol=1e-6 * (1.0 + np.abs(bias).max()))
        torque = generator.normal(0.0, 10.0, 12)
        system = np.block([[D, -J.T], [J, np.zeros((8, 8))]])
        expected = np.linalg.solve(system, np.concatenate([-h + np.concatenate([np.zeros(6), torque]), -bias]))
        stopped = np.linalg.solve(system, np.concatenate([D @ rate, np.zeros(8)]))
        found = [np.asarray(part.full()) for part in function.call([pose, rate, torque])]
        ours, theirs = [part.ravel() for part in found[:4]], [*np.split(expected, [18]), *np.split(stopped, [18])]
        for mine, their in zip(ours, theirs, strict=True):
            np.testing.assert_allclose(mine, their, atol=1e-9 * np.abs(their).max())
        null, basis = found[4:]
        np.testing.assert_allclose(null, 0.0, atol=1e-8)
        np.testing.assert_allclose(basis.T @ basis, np.eye(2), atol=1e-12)


def _spin(contacts: Contacts, foot: str, q: np.ndarray, v: np.ndarray) -> float:
    """Angular velocity of a foot about the ground's normal, by differences of its orientation."""
    link, step = contacts.robot.foot(foot).link, 1e-6
    ends = [np.asarray(kinematics.link_pose(contacts.robot, link, q + s * v)[0]) for s in (-step, step)]
    skew = (ends[1] - ends[0]) / (2.0 * step) @ np.asarray(kinematics.link_pose(contacts.robot, link, q)[0]).T
    normal = contacts.ground.normal(np.asarray(kinematics.foot_position(contacts.robot, foot, q)).ravel())
    return float(normal @ [skew[2, 1], skew[0, 2], skew[1, 0]])


@pytest.mark.parametrize("law", [PseudoInverse(), BoundedMinimumNorm(0.6, 5.0)])
def test_the_closed_loop_on_the_new_contact_moves_as_numpy_says(law: PseudoInverse) -> None:
    of = robot("astro")
    pattern = amble(of, Plane(slope=0.1), TORSIONAL)
    free = {"D1": ["rl_hip_pitch", "fr_hip_yaw"], "D2": ["rr_hip_pitch", "fr_hip_yaw"]}
    outputs = joint_outputs(pattern, free=free).of("D1")
    contacts = pattern.contacts(pattern.stance("D1"))
    assert len(outputs.coordinates) == 10
    q, v, t = ca.SX.sym("q", of.size), ca.SX.sym("v", of.size), ca.SX.sym("t")
    constraints = VirtualConstraints.symbols(10, of.size - 3, 4)
    loop = linearise(contacts, law, q, v, constraints.phase_rates(of, pattern.stance("D1"), t, q, v), constraints)
    parts = [loop.acceleration, loop.torques, loop.forces]
    function = ca.Function("loop", [q, v, t, constraints.packed()], [ca.densify(part) for part in parts])
    generator = np.random.default_rng(2)
    weights = np.eye(of.size)[[of.coordinate_index(name) for name in outputs.coordinates]][:, 3:]
    for pose, rate in zip(*random_postures("astro", 5, seed=6), strict=True):
        references = pose[3:, None] + generator.normal(0.0, 0.02, (of.size - 3, 5))
        dense = OutputDynamics(
            weights=weights,
            references=references,
            duration=0.2,
            gains=(100.0, 20.0),
            domain=DomainPhase(phase=TimePhase(), robot=of, stance=pattern.stance("D1")),
            phase_numbers=frozen([]),
        )
        at = terms(contacts, pose[None], 0.1 * rate[None])
        motion = allocated(at, dense.solve(at, np.array([0.1]), pose[None], 0.1 * rate[None]), law)
        found = function.call([pose, 0.1 * rate, 0.1, pack(0.2, (100.0, 20.0), references, weights)])
        for mine, theirs in zip(found, (motion.accelerations, motion.torques, motion.forces), strict=True):
            # the program of the bounded law is solved to 1e-6 of the torques, from two bases of the same directions
            tolerance = 1e-8 if law.name == "pinv" else 1e-4
            np.testing.assert_allclose(
                np.asarray(mine.full()).ravel(), theirs[0], atol=tolerance * np.abs(theirs).max()
            )


def test_the_gait_problem_holds_the_new_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    pattern = amble(robot("astro"), Plane(slope=0.1), TORSIONAL)
    free = {"D1": ["rl_hip_pitch", "fr_hip_yaw"], "D2": ["rr_hip_pitch", "fr_hip_yaw"]}
    program = build_program(
        gait_problem(pattern.robot, pattern, speed=0.2, outputs=joint_outputs(pattern, free=free), intervals=2)
    )
    names = program.program.row_names
    for name in ("D1 node 0 contact rl twist", "D1->D2 impact rr twist", "D2 node 1 friction fr +x-twist"):
        assert name in names
    guess = initial_guess(program.problem, program.layout)
    values, slopes = program.program.jacobian(guess / program.layout.scale, program.parameters)
    assert np.all(np.isfinite(np.asarray(values)))
    # derivatives of the new rows by differences
    new = [row for row, name in enumerate(names) if "twist" in name]
    generator = np.random.default_rng(8)
    at, direction, step = guess / program.layout.scale, generator.normal(size=guess.size), 1e-6
    ends = [np.asarray(program.program.nlp(at + s * direction, program.parameters)[1]).ravel() for s in (-step, step)]
    expected = (ends[1] - ends[0])[new] / (2.0 * step)
    ours = np.asarray(slopes @ direction).ravel()[new]
    np.testing.assert_allclose(ours, expected, atol=1e-6 * np.abs(expected).max())


def test_the_new_contact_is_written_and_mirrored() -> None:
    assert CONTACTS.encode(TORSIONAL, "file") == {"name": "torsional", "parameters": {"radius": 0.02}}
    assert CONTACTS.build("torsional", {"radius": 0.02}) == TORSIONAL
    mirror = amble(robot("astro"), contact=TORSIONAL).all_contacts.mirror
    forces = np.arange(1.0, 17.0)
    image = mirror(forces)
    np.testing.assert_array_equal(mirror(image), forces)
    fl, fr = robot("astro").foot_names.index("fl"), robot("astro").foot_names.index("fr")
    np.testing.assert_array_equal(image[4 * fr : 4 * fr + 4], forces[4 * fl : 4 * fl + 4] * [1.0, -1.0, 1.0, -1.0])


def test_the_pyramid_lies_inside_the_cone() -> None:
    generator = np.random.default_rng(4)
    local = generator.normal(0.0, 1.0, (4, 4000)) * np.array([[20.0], [20.0], [60.0], [0.4]])
    rows = np.asarray(ca.DM(TORSIONAL.pyramid(ca.SX(ca.DM(local)), 0.6)).full())
    assert rows.shape[0] == len(TORSIONAL.sides)
    inside = np.all(rows >= 0.0, axis=0)
    assert inside.sum() > 100
    assert np.all(TORSIONAL.friction_used(local.T)[inside] <= 0.6 * (1.0 + 1e-12))
