"""Style as a cost: each term is what it says, measured by the robot, and a weight makes its own term smaller."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.gait.cost import COSTS, TORQUE_SQUARED, Instant
from amble.gait.style import WEIGHTS, Style
from amble.hybrid import Contacts
from amble.robot import Robot, kinematics
from amble.robot.proposal import nominal_posture
from amble.synthesis import gait_problem, synthesize
from amble.types import Vector
from amble.verification.check import _landing, _running, _torque_rates, check
from amble.verification.domain_rows import sampled
from tests.robots import PLANAR, robot
from tests.similar import similar_robot

FIRST = {"astro": ("fl", "rr"), PLANAR: ("l",)}
OTHER = {"astro": ("fr", "rl"), PLANAR: ("r",)}


def value(style: Style, of: Robot, feet: tuple[str, ...], state: tuple[Vector, ...]) -> float:
    contacts = Contacts(of, feet)
    sizes = (of.size, of.size, of.size, len(of.joints), contacts.size, 1)
    q, v, a, u, lam, T = symbols = [ca.SX.sym(letter, size) for letter, size in zip("qvaulT", sizes, strict=True)]
    instant = Instant(contacts=contacts, positions=q, velocities=v, accelerations=a, torques=u, forces=lam, duration=T)
    rest = (np.zeros(of.size), state[2], np.zeros(contacts.size), 1.0)
    return float(ca.Function("style", symbols, [style.running(instant)])(*state[:2], *rest))


def drawn(of: Robot) -> tuple[Vector, Vector, Vector]:
    generator = np.random.default_rng(5)
    return tuple(generator.uniform(-0.4, 0.4, size) for size in (of.size, of.size, len(of.joints)))  # type: ignore


@pytest.mark.parametrize("name", FIRST)
def test_every_term_is_what_it_says(name: str) -> None:
    of, feet = robot(name), FIRST[name]
    q, v, u = state = drawn(of)
    g, length, joints = of.gravity, of.leg_length, len(of.joints)
    tau = of.mass * g * length
    swing = [foot for foot in of.foot_names if foot not in feet]
    heights = [float(kinematics.foot_position(of, foot, q)[2]) for foot in swing]
    angles = [q[of.coordinate_index(angle)] for angle in ("roll", "pitch") if angle in of.coordinate_names]
    nominal = np.array([nominal_posture(of).angles[joint] for joint in of.joint_names])
    expected = {
        "torques": u @ u,
        "power": np.sum((u * v[-joints:]) ** 2) * length / g,
        "attitude": tau**2 * np.sum(np.square(angles)),
        "posture": tau**2 * np.sum((q[-joints:] - nominal) ** 2),
        "swing_height": tau**2 * np.sum(np.square(heights)) / length**2,
    }
    for term, wanted in expected.items():
        found = value(Style(**{"torques": 0.0, term: 3.0}), of, feet, state)
        assert found == pytest.approx(3.0 * wanted, rel=1e-12), term
    q_, v_ = ca.SX.sym("q", of.size), ca.SX.sym("v", of.size)
    landing = Style(touchdown_speed=2.0).landing(Contacts(of, feet), tuple(swing), q_, v_)
    speeds = [np.asarray(kinematics.foot_jacobian(of, foot, q)) @ v for foot in swing]
    wanted = 2.0 * tau**2 * np.sqrt(length / g) * np.sum(np.square(speeds)) / (g * length)
    assert float(ca.Function("landing", [q_, v_], [landing])(q, v)) == pytest.approx(wanted, rel=1e-12)
    assert Style(effort_rate=2.0).torque_rate(of) == pytest.approx(2.0 * length / g)
    assert value(Style(), of, feet, state) == pytest.approx(u @ u)


@pytest.mark.parametrize("name", FIRST)
def test_a_motion_and_its_mirror_image_cost_the_same(name: str) -> None:
    of = robot(name)
    q, v, u = drawn(of)
    image = (of.mirror.position(q), of.mirror.position(v), of.mirror.torque(u))
    style = Style(**dict.fromkeys(set(WEIGHTS) - {"touchdown_speed", "effort_rate"}, 1.0))
    here, there = value(style, of, FIRST[name], (q, v, u)), value(style, of, OTHER[name], image)
    assert there == pytest.approx(here, rel=1e-12)


def test_a_weight_means_the_same_at_every_size() -> None:
    """The image of a motion costs as much in units of its robot's m g l."""
    of = robot("astro")
    image = similar_robot(of, 4.0, 8.0)
    q, v, u = drawn(of)
    tau, larger = (one.mass * one.gravity * one.leg_length for one in (of, image))
    lengths, rate = np.where(np.arange(of.size) < 3, 8.0, 1.0), 8.0**-0.5
    named = dict.fromkeys(of.joint_names, 0.1)
    style = Style(**dict.fromkeys(set(WEIGHTS) - {"touchdown_speed", "effort_rate"}, 1.0), angles=named)
    there = value(style, image, FIRST["astro"], (q * lengths, v * lengths * rate, u * larger / tau))
    assert there / larger**2 == pytest.approx(value(style, of, FIRST["astro"], (q, v, u)) / tau**2, rel=1e-12)


def test_what_is_no_style_is_refused() -> None:
    for given, words in (
        ({"power": -1.0}, "weight 'power' of the style is -1.0; it must be finite and not negative"),
        ({"torques": float("inf")}, "weight 'torques'"),
        ({"torques": True}, "weight 'torques'"),
        ({"torques": 0.0}, "all weights of the style are zero"),
        ({"angles": {"fl_knee": float("nan")}}, "angle of 'fl_knee'"),
    ):
        with pytest.raises(InputError, match=words):
            Style(**given)  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match="no_joint"):
        value(Style(posture=1.0, angles={"no_joint": 0.0}), robot(PLANAR), ("l",), drawn(robot(PLANAR)))


def test_a_file_keeps_every_weight() -> None:
    style = Style(power=0.5, posture=0.1, angles={"l_knee": 0.4})
    assert COSTS.decode(COSTS.encode(style, "cost"), "cost") == style
    assert hash(style) == hash(Style(power=0.5, posture=0.1, angles={"l_knee": 0.4}))
    assert COSTS.build("style", {"effort_rate": 0.01}) == Style(effort_rate=0.01)


@lru_cache(maxsize=8)
def walk(weight: str, size: float) -> Gait:
    cost = Style(**{weight: size}) if weight else TORQUE_SQUARED
    return synthesize(replace(gait_problem(robot(PLANAR), "walk", speed=0.5, intervals=20), cost=cost))


def term(gait: Gait, weight: str) -> float:
    """The mean of one term over a gait."""
    from scipy.integrate import simpson

    own = replace(gait, cost=Style(**{"torques": 0.0, weight: 1.0}))
    domains = [sampled(own, number, 4) for number in range(len(own.domains))]
    total = sum(
        simpson(_running(own, one), x=one.times) + _landing(own, one) + _torque_rates(own, one) for one in domains
    )
    return float(total) / sum(one.trajectory.duration for one in domains)


SIZES = {
    "power": 1.0,
    "touchdown_speed": 0.1,
    "attitude": 10.0,
    "posture": 0.1,
    "swing_height": 1.0,
    "effort_rate": 0.001,
}


@pytest.mark.parametrize(
    "weight", [pytest.param(name, marks=[] if name == "effort_rate" else pytest.mark.slow) for name in SIZES]
)
def test_a_weight_makes_its_own_term_smaller(weight: str) -> None:
    """Of two optima that of the larger weight has the smaller term, and the larger squared torques."""
    plain, styled = walk("", 0.0), walk(weight, SIZES[weight])
    assert term(styled, weight) < 0.99 * term(plain, weight)
    assert term(styled, "torques") > term(plain, "torques")
    expected = term(styled, "torques") + SIZES[weight] * term(styled, weight)
    assert styled.solver.objective == pytest.approx(expected, rel=1e-4)  # the grid of the check against the mesh
    failed = check(styled).failed
    assert [row for row in failed if row.kind != "cost"] == []
    assert styled.solver.linear_solver == "structured"
