"""What the allocation can and cannot change (docs/theory/allocation.md, sections 1 and 2), at random states."""

from __future__ import annotations

from itertools import combinations

import casadi as ca
import numpy as np
import pytest

from amble.control import (
    AllocationLaw,
    BoundedMinimumNorm,
    DropActuator,
    MinimumPeak,
    MinimumPower,
    PseudoInverse,
    WeightedMinimumNorm,
)
from amble.control.linearisation import linearise
from amble.control.virtual_constraints import VirtualConstraints, pack
from amble.hybrid import Contacts, Stance
from amble.hybrid.contact import POINT
from amble.hybrid.internal_forces import point_forces
from tests import robots
from tests.control.allocation.stances import FOREIGN, NAMES, allocate, dynamics, random_postures, samples, stance_feet

TABLE = {2: (11, 1), 3: (9, 3), 4: (6, 6)}


@pytest.mark.parametrize("name", [*NAMES, *FOREIGN])
@pytest.mark.parametrize("count", [2, 3, 4])
def test_rank_and_null_space_are_those_of_the_table(name: str, count: int) -> None:
    rank, free = TABLE[count]
    for q, v in zip(*random_postures(name, 10, seed=1), strict=True):
        _, G, _, slope, null, force_basis = (np.asarray(part.full()) for part in dynamics(name, count)(q, v))
        values = np.linalg.svd(G, compute_uv=False)
        assert values[rank - 1] > 1e-4 * values[0]
        assert np.all(values[rank:] < 1e-10 * values[0])
        assert null.shape[1] == np.linalg.matrix_rank(null) == free
        # null torques accelerate nothing, and the forces that go with them are the internal ones
        assert np.max(np.abs(G @ null)) < 1e-10 * values[0] * np.abs(null).max()
        assert slope @ null == pytest.approx(force_basis, abs=1e-8 * np.abs(force_basis).max())


@pytest.mark.parametrize("name", NAMES)
def test_internal_forces_of_four_feet_on_a_plane_span_six_directions(name: str) -> None:
    del name
    generator = np.random.default_rng(2)
    symbol = ca.SX.sym("p", 12)
    function = ca.Function("W", [symbol], [POINT.internal_forces(ca.vertsplit(symbol, 3), [ca.DM.eye(3)] * 4, 6)])
    feet = np.array([[0.3, 0.2, 0.0], [0.3, -0.2, 0.0], [-0.3, 0.2, 0.0], [-0.3, -0.2, 0.0]])
    for _ in range(20):
        tilt = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        placed = (feet + generator.normal(0.0, 0.03, (4, 3)) * [1.0, 1.0, 0.0]) @ tilt.T
        W = np.asarray(function(placed.ravel()).full())
        grasp = np.vstack([np.hstack([np.eye(3)] * 4), np.hstack([_cross(foot) for foot in placed])])
        assert np.max(np.abs(grasp @ W)) < 1e-12 * max(1.0, np.abs(W).max())
        assert np.linalg.svd(W, compute_uv=False)[5] > 1e-2
        # squeezes along the six lines between the feet miss one direction there
        lines = [_squeeze(placed, a, b) for a in range(4) for b in range(a)]
        assert np.linalg.matrix_rank(np.array(lines), tol=1e-9) == 5


def _cross(p: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -p[2], p[1]], [p[2], 0.0, -p[0]], [-p[1], p[0], 0.0]])


def _squeeze(feet: np.ndarray, a: int, b: int) -> np.ndarray:
    column = np.zeros((4, 3))
    column[a], column[b] = feet[b] - feet[a], feet[a] - feet[b]
    return column.ravel()


def laws(name: str) -> list[AllocationLaw]:
    joints = robots.robot(name).joint_names
    return [
        PseudoInverse(),
        WeightedMinimumNorm({joints[1]: 3.0, joints[5]: 0.2}),
        MinimumPower("paper"),
        MinimumPower("datasheet"),
        MinimumPeak(),
        BoundedMinimumNorm(0.6, 5.0),
    ]


@pytest.mark.parametrize("name", [*NAMES, *FOREIGN])
def test_all_laws_cause_the_same_acceleration(name: str) -> None:
    """The whole linearisation under every law, at random states and random references."""
    robot = robots.robot(name)
    feet = stance_feet(robot, 2)
    q, v, t = ca.SX.sym("q", robot.size), ca.SX.sym("v", robot.size), ca.SX.sym("t")
    constraints = VirtualConstraints.symbols(11, robot.size - 3, 4)
    symbols = [q, v, t, constraints.packed()]
    phase = constraints.phase_rates(robot, Stance("S", feet), t, q, v)
    standing = [joint for foot in feet for joint in robot.legs[foot]]
    functions = []
    for law in (*laws(name), DropActuator((standing[1],))):
        loop = linearise(Contacts(robot, feet), law, q, v, phase, constraints)
        functions.append(ca.Function("loop", symbols, [loop.acceleration, loop.torques, loop.forces]))
    generator = np.random.default_rng(3)
    weights = np.hstack([np.zeros((11, 3)), np.delete(np.eye(12), robot.joint_index(standing[1]), axis=0)])
    for state, rate in zip(*random_postures(name, 20, seed=3), strict=True):
        curves = state[3:, None] + generator.normal(0.0, 0.1, (robot.size - 3, 5))
        packed = pack(0.2, (100.0, 20.0), curves, weights)
        found = [[np.asarray(part.full()).ravel() for part in f(state, rate, 0.1, packed)] for f in functions]
        least = np.linalg.norm(found[0][1])
        for acceleration, torque, _ in found[1:]:
            # conditioning of the solve: accelerations of several hundred rad/s^2 from torques that differ by as much
            assert np.max(np.abs(acceleration - found[0][0])) <= 1e-9 * np.max(np.abs(found[0][0]))
            assert np.linalg.norm(torque) >= least * (1.0 - 1e-9)


@pytest.mark.parametrize("name", [*NAMES, *FOREIGN])
@pytest.mark.parametrize("count", [2, 3, 4])
def test_any_choice_keeps_the_acceleration(name: str, count: int) -> None:
    function = dynamics(name, count)
    postures = zip(*random_postures(name, 5, seed=4), strict=True)
    for sample, (q, v) in zip(samples(name, count, 5, seed=4), postures, strict=True):
        free, G, *_ = (np.asarray(part.full()) for part in function(q, v))
        before = free[:, 0] + G @ sample.torques
        for law in laws(name):
            if law.name == "weighted":
                continue  # its mapping cannot key the cache of functions; the test above has it
            s = allocate(name, count, law, sample)[0]
            after = free[:, 0] + G @ (sample.torques + sample.torque_basis @ s)
            assert np.max(np.abs(after - before)) <= 1e-9 * np.max(np.abs(before))


@pytest.mark.parametrize("name", NAMES)
def test_normal_forces_of_two_feet_change_only_where_one_stands_higher(name: str) -> None:
    """docs/theory/allocation.md, section 1: internal forces of two feet act along the line between them."""
    symbol, generator = ca.SX.sym("p", 6), np.random.default_rng(5)
    function = ca.Function("W", [symbol], [point_forces([symbol[:3], symbol[3:]])])
    for sample in samples(name, 2, 10, seed=5):
        s = allocate(name, 2, MinimumPower("paper"), sample)[0]
        feet = generator.normal(0.0, 0.3, (2, 3))
        for step in (0.0, 0.05):
            feet[1, 2] = feet[0, 2] + step
            change = (np.asarray(function(feet.ravel())) @ s).ravel()
            largest = np.abs(change).max()
            assert largest > 0.0
            assert (np.abs(change[2::3]).max() > 1e-3 * largest) == (step > 0.0)
            assert change[2] + change[5] == pytest.approx(0.0, abs=1e-12 * largest)


@pytest.mark.parametrize("name", NAMES)
def test_dropping_a_swing_joint_makes_the_decoupling_singular(name: str) -> None:
    robot = robots.robot(name)
    feet = stance_feet(robot, 2)
    swing = next(foot for foot in robot.foot_names if foot not in feet)
    for q, v in zip(*random_postures(name, 5, seed=6), strict=True):
        G = np.asarray(dynamics(name, 2)(q, v)[1].full())
        free = robot.joint_index(robot.legs[feet[0]][1])
        wanted = np.delete(np.arange(12), free)
        for joint, regular in ((robot.legs[swing][1], False), (robot.legs[feet[1]][1], True)):
            kept = np.delete(np.arange(12), robot.joint_index(joint))
            condition = np.linalg.cond(G[np.ix_(6 + wanted, kept)])
            assert (condition < 1e8) if regular else (condition > 1e12)


@pytest.mark.parametrize("name", [*NAMES, *FOREIGN])
@pytest.mark.parametrize("count", [2, 3, 4])
def test_null_torques_have_no_net_power_where_the_feet_rest(name: str, count: int) -> None:
    """docs/theory/energy.md, eq. 8: so the mechanical work of all joints together does not depend on the law."""
    robot = robots.robot(name)
    symbol = ca.SX.sym("q", robot.size)
    slopes = ca.Function("J", [symbol], [Contacts(robot, stance_feet(robot, count)).jacobian(symbol)])
    for q, v in zip(*random_postures(name, 10, seed=7), strict=True):
        J, null = np.asarray(slopes(q).full()), np.asarray(dynamics(name, count)(q, v)[4].full())
        rest = v - np.linalg.lstsq(J, J @ v, rcond=None)[0]
        assert null.T @ rest[6:] == pytest.approx(np.zeros(null.shape[1]), abs=1e-12 * np.abs(null).max())
        assert np.max(np.abs(null.T @ v[6:])) > 1e-3 * np.abs(null).max()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("count", [2, 3])
def test_joints_can_be_left_out_where_the_null_torques_allow_it(name: str, count: int) -> None:
    """docs/theory/virtual-constraints.md, eq. 8, for outputs and, by symmetry, for actuators."""
    seen = set()
    for q, v in zip(*random_postures(name, 3, seed=8), strict=True):
        _, G, _, _, null, _ = (np.asarray(part.full()) for part in dynamics(name, count)(q, v))
        joints, basis = G[6:], np.linalg.qr(null)[0]
        assert joints == pytest.approx(joints.T, abs=1e-10 * np.abs(joints).max())
        for left_out in combinations(range(12), null.shape[1]):
            volume = abs(np.linalg.det(basis[list(left_out)]))
            if 1e-10 < volume < 1e-2:
                continue  # neither clearly regular nor clearly singular
            kept = np.linalg.svd(np.delete(joints, left_out, axis=0), compute_uv=False)
            seen.add(regular := volume > 1e-2)
            assert (kept[-1] > 1e-8 * kept[0]) == regular
    assert seen == {True, False}
