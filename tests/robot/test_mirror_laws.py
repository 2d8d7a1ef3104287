"""The mirror's group law on arbitrary symmetric robots: its own inverse, and a symmetry of what it mirrors."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from amble.robot import Robot, kinematics
from amble.robot.mirror import REFLECTION
from amble.robot.parts import Foot, Joint, Link
from amble.types import Matrix, Vector, frozen

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def body(random: np.random.Generator, name: str) -> Link:
    """Draw a rigid body: principal moments that three masses on the axes have, in a random orientation."""
    masses = random.uniform(0.01, 0.1, 3)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    inertia = turn @ np.diag(masses.sum() - masses) @ turn.T
    return Link(name, float(random.uniform(0.2, 3.0)), frozen(random.normal(0.0, 0.1, 3)), frozen(inertia))


def image(link: Link, name: str) -> Link:
    """Mirror a body in the plane y = 0 of its frame."""
    return Link(name, link.mass, frozen(REFLECTION @ link.center), frozen(REFLECTION @ link.inertia @ REFLECTION))


def symmetric_robot(seed: int, pairs: int, depth: int) -> Robot:
    """Draw a robot with pairs of mirrored legs, all frames parallel at the zero pose.

    The twin of a joint turns about the mirrored axis, a pseudo-vector, or about its reverse: each is drawn.
    """
    random = np.random.default_rng(seed)
    base = body(random, "base")
    links, joints, feet, twins = [Link("base", base.mass, *halves(base))], [], [], []
    for pair in range(pairs):
        names, parents = (f"left{pair}", f"right{pair}"), [0, 0]
        for level in range(depth):
            place, axis = random.normal(0.0, 0.2, 3), np.array(AXES[random.integers(3)])
            own = body(random, f"{names[0]}_{level}")
            reverse = random.choice([-1.0, 1.0])
            sides = (
                (place, axis, own),
                (REFLECTION @ place, reverse * (-REFLECTION @ axis), image(own, f"{names[1]}_{level}")),
            )
            for side, (translation, direction, link) in enumerate(sides):
                links.append(link)
                joints.append(revolute(link.name, parents[side], len(links) - 1, translation, direction))
                parents[side] = len(links) - 1
        offset = random.normal(0.0, 0.2, 3)
        for name, parent, place in zip(names, parents, (offset, REFLECTION @ offset), strict=True):
            feet.append(Foot(name, name, parent, frozen(place)))
        twins.append(names)
    return Robot(
        name="drawn",
        source="drawn",
        links=tuple(links),
        joints=tuple(joints),
        feet=tuple(feet),
        gravity=9.81,
        twins=tuple(twins),
    )


def halves(link: Link) -> tuple[Vector, Matrix]:
    """Centre and inertia of the mean of a body and its image, which is symmetric in itself."""
    twin = image(link, link.name)
    return frozen((link.center + twin.center) / 2.0), frozen((link.inertia + twin.inertia) / 2.0)


def revolute(name: str, parent: int, child: int, translation: Vector, axis: Vector) -> Joint:
    """Return a joint without limits."""
    endless = np.inf
    return Joint(
        name=name,
        parent=parent,
        child=child,
        rotation=frozen(np.eye(3)),
        translation=frozen(translation),
        axis=frozen(axis),
        lower=-endless,
        upper=endless,
        effort=endless,
        velocity=endless,
    )


few = settings(derandomize=True, max_examples=12, deadline=None, database=None)
robots = st.builds(symmetric_robot, st.integers(0, 2**32 - 1), st.integers(1, 3), st.integers(1, 3))


@few
@given(robots, st.integers(0, 2**32 - 1))
def test_the_mirror_of_the_mirror_is_the_motion(model: Robot, seed: int) -> None:
    """A signed permutation only moves numbers and turns signs, so nothing may be lost to rounding."""
    mirror, random = model.mirror, np.random.default_rng(seed)
    joints, feet = len(model.joints), len(model.feet)
    maps = {
        "coordinates": (mirror.position, model.size),
        "states": (mirror.state, 2 * model.size),
        "torques": (mirror.torque, joints),
        "forces": (mirror.force, 3 * feet),
    }
    for name, (apply, size) in maps.items():
        values = random.normal(size=size)
        np.testing.assert_array_equal(apply(apply(values)), values, err_msg=name)
        assert not np.array_equal(apply(values), values), name


@few
@given(robots, st.integers(0, 2**32 - 1))
def test_mirrored_quantities_belong_to_the_mirrored_motion(model: Robot, seed: int) -> None:
    """Twin feet move as mirror images; torques and contact forces keep their power.

    Positions and powers are of size one, sums of a few tens of terms: 1e-10 leaves four digits over rounding.
    """
    mirror, random = model.mirror, np.random.default_rng(seed)
    q, v = random.uniform(-1.0, 1.0, (2, model.size))
    torque, force = random.normal(size=len(model.joints)), random.normal(size=3 * len(model.feet))
    image_q, image_v = mirror.position(q), mirror.position(v)

    def velocity(foot: str, at: Vector, rate: Vector) -> Vector:
        return np.asarray(kinematics.foot_jacobian(model, foot, at)) @ rate

    for foot, twin in mirror.feet.items():
        place = np.asarray(kinematics.foot_position(model, foot, q)).ravel()
        twin_place = np.asarray(kinematics.foot_position(model, twin, image_q)).ravel()
        np.testing.assert_allclose(twin_place, REFLECTION @ place, atol=1e-10)
        np.testing.assert_allclose(velocity(twin, image_q, image_v), REFLECTION @ velocity(foot, q, v), atol=1e-10)
    before = np.concatenate([velocity(foot, q, v) for foot in model.foot_names])
    after = np.concatenate([velocity(foot, image_q, image_v) for foot in model.foot_names])
    np.testing.assert_allclose(mirror.force(force) @ after, force @ before, atol=1e-10)
    np.testing.assert_allclose(mirror.torque(torque) @ image_v[6:], torque @ v[6:], atol=1e-10)
