"""What is drawn of a robot of which only the tree is known."""

import numpy as np

from amble.robot import catalogue
from amble.view.shapes import link_shapes
from tests.similar import similar_robot


def test_every_link_is_drawn_and_every_bone_ends_at_a_joint_or_a_foot() -> None:
    robot = catalogue.astro()
    shapes = link_shapes(robot)
    assert {shape.link for shape in shapes} == set(range(len(robot.links)))
    assert [shape.link for shape in shapes if shape.kind == "box"] == [0]
    ends = {(joint.parent, *joint.translation) for joint in robot.joints} | {
        (foot.link, *foot.offset) for foot in robot.feet
    }
    assert {(shape.link, *shape.second) for shape in shapes if shape.kind == "capsule"} == {
        end for end in ends if end[0] != 0
    }


def test_the_box_of_the_base_holds_what_hangs_on_it() -> None:
    robot = catalogue.astro()
    box = link_shapes(robot)[0]
    hips = np.array([joint.translation for joint in robot.joints if joint.parent == 0])
    assert np.all(hips > box.first)
    assert np.all(hips < box.second)


def test_sizes_follow_the_robot() -> None:
    """No length but the robot's own: bones of a robot ten times as large are ten times as thick."""
    robot = catalogue.astro()
    large = similar_robot(robot, mass=1.0, length=10.0)
    for small, big in zip(link_shapes(robot), link_shapes(large), strict=True):
        np.testing.assert_allclose(10.0 * small.second, big.second, atol=1e-12)
        np.testing.assert_allclose(10.0 * small.radius, big.radius, rtol=1e-12)
