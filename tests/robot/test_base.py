"""A base in the plane: the robot in space whose base keeps y, roll and yaw at zero, and nothing moves it from there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.hybrid import Contacts, Plane, constrained_dynamics, gait_pattern, impact
from amble.robot import Adaptation, Robot, dynamics, kinematics, load_robot
from amble.robot.base import PLANE, SPACE
from amble.robot.files import ROBOT
from amble.synthesis import gait_problem
from tests.robots import PLANAR, path, random_states, robot


def in_space(of: Robot) -> Robot:
    """The same with moments about all axes, free in space."""
    links = tuple(replace(link, inertia=link.inertia + 0.01 * np.diag([1.0, 0.0, 1.0])) for link in of.links)
    return replace(of, links=links, base=SPACE)


def test_spatial_coordinates_have_zeros_where_the_base_stays() -> None:
    own = np.arange(1.0, 6.0)
    expected = [1.0, 0.0, 2.0, 0.0, 3.0, 0.0, 4.0, 5.0]
    np.testing.assert_array_equal(PLANE.spatial(own), expected)
    np.testing.assert_array_equal(np.asarray(PLANE.spatial(ca.DM(own))).ravel(), expected)
    np.testing.assert_array_equal(PLANE.spatial(np.array([own, own])), [expected, expected])
    assert SPACE.spatial(own) is own


def test_nothing_leaves_the_plane() -> None:
    """The rows of y, roll and yaw of the free robot are zero along every motion in the plane; the others are its."""
    planar = robot(PLANAR)
    free, own = in_space(planar), planar.base.columns(len(planar.joints))
    others = [place for place in range(free.size) if place not in own]
    a = np.random.default_rng(2).normal(size=planar.size)
    for q, v in zip(*random_states(planar, 10), strict=True):
        loads = np.asarray(dynamics.inverse_dynamics(free, *map(PLANE.spatial, (q, v, a)))).ravel()
        expected = np.asarray(dynamics.inverse_dynamics(planar, q, v, a)).ravel()
        np.testing.assert_allclose(loads[own], expected, atol=1e-12 * np.abs(expected).max())
        np.testing.assert_allclose(loads[others], 0.0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("feet", [(), ("l",), ("l", "r")])
def test_a_stance_and_an_impact_are_those_of_numpy(feet: tuple[str, ...]) -> None:
    """Of the dense system D a + h = B u + J^T lambda, J a + dJ v = 0, with J the rows of x and z of the feet."""
    planar = robot(PLANAR)
    contacts, u = Contacts(planar, feet), np.array([3.0, -1.0, 2.0, 5.0])
    q_, v_ = ca.SX.sym("q", planar.size), ca.SX.sym("v", planar.size)
    motion = constrained_dynamics(contacts, q_, v_)
    parts = [motion.free_acceleration + motion.input_map @ u, motion.free_force + motion.force_map @ u]
    parts += impact(contacts, q_, v_) if feet else [v_, ca.SX(0, 1)]
    function = ca.Function("stance", [q_, v_], [ca.densify(part) for part in parts])
    assert contacts.labels == tuple(f"{foot} {axis}" for foot in feet for axis in "xz")
    for q, v in zip(*random_states(planar, 5, seed=3), strict=True):
        D, h = np.asarray(dynamics.mass_matrix(planar, q)), np.asarray(dynamics.bias(planar, q, v)).ravel()
        rows = [np.asarray(kinematics.foot_jacobian(planar, foot, q))[[0, 2]] for foot in feet]
        biases = [np.asarray(kinematics.foot_bias(planar, foot, q, v)).ravel()[[0, 2]] for foot in feet]
        J, turn = np.vstack([np.zeros((0, planar.size)), *rows]), np.concatenate([np.zeros(0), *biases])
        system = np.block([[D, -J.T], [J, np.zeros((len(J), len(J)))]])
        expected = np.linalg.solve(system, np.concatenate([np.concatenate([np.zeros(3), u]) - h, -turn]))
        stopped = np.linalg.solve(system, np.concatenate([D @ v, np.zeros(len(J))]))
        ours = np.concatenate([np.asarray(part).ravel() for part in function(q, v)])
        wanted = np.concatenate([expected, stopped])
        np.testing.assert_allclose(ours, wanted, atol=1e-9 * np.abs(wanted).max())


def test_internal_forces_and_their_torques_move_nothing() -> None:
    planar = robot(PLANAR)
    contacts = Contacts(planar, ("l", "r"))
    assert (contacts.internal_force_count, Contacts(planar, ("l",)).internal_force_count) == (1, 0)
    for q in random_states(planar, 5)[0]:
        N, W = (np.asarray(ca.DM(part)) for part in contacts.torque_null_space(ca.SX(q)))
        J = np.asarray(ca.DM(contacts.jacobian(ca.SX(q))))
        carried = J.T @ W + np.vstack([np.zeros((3, 1)), N])
        np.testing.assert_allclose(carried, 0.0, atol=1e-12 * np.abs(W).max())


def test_flat_bodies_and_virtual_joints_are_planar_robots(tmp_path: Path) -> None:
    """Two ways to say it, and one robot; a planar robot has a hash of its own and comes back from a file."""
    text = path(PLANAR).read_text()
    bare = text[: text.index('<link name="world"/>')] + text[text.index('<link name="torso">') :]
    file = tmp_path / "bare.urdf"
    file.write_text(bare)
    feet = {"l": "l_foot", "r": "r_foot"}
    with pytest.raises(InputError, match="planar = true"):
        load_robot(file, feet)
    planar = load_robot(file, feet, twins=[("l", "r")], adaptation=Adaptation(planar=True))
    assert planar.hash == robot(PLANAR).hash
    assert planar.coordinate_names == ("x", "z", "pitch", "l_hip", "l_knee", "r_hip", "r_knee")
    assert in_space(planar).hash != replace(in_space(planar), base=PLANE).hash
    assert ROBOT.decode(ROBOT.encode(planar, "robot"), "robot") == planar


def test_what_cannot_be_in_the_plane_is_said() -> None:
    planar, astro = robot(PLANAR), robot("astro")
    with pytest.raises(InputError, match=r"'fl_hip_yaw' turns about .*, not about y: let it move in space, or lock"):
        replace(astro, base=PLANE)
    with pytest.raises(InputError, match="its ground cannot rise sideways"):
        gait_pattern(planar, [("l",), ("r",)], ground=Plane(slope=0.1, heading=1.0))
    with pytest.raises(InputError, match="moves in a plane: it has no lateral speed and no yaw rate"):
        gait_problem(planar, "walk", speed=0.5, yaw_rate=0.1)


@pytest.mark.parametrize("name", ["roll", "x", "rate of x", "acceleration of l_hip"])
def test_no_joint_has_the_name_of_another_coordinate(name: str) -> None:
    """Outputs, limits and states are named by coordinates: a joint called roll was the base's."""
    planar = robot(PLANAR)
    with pytest.raises(InputError, match="which is the name of another coordinate or derivative"):
        replace(planar.joints[0], name=name)
