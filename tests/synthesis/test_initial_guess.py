"""The start of the solver: footholds, inverse kinematics, sway of the base."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.gait.command import Command
from amble.robot import dynamics, kinematics
from amble.robot.catalogue import load
from amble.synthesis import GaitProblem, gait_problem
from amble.synthesis.initial_guess import (
    Walk,
    foot_path,
    grounded_posture,
    initial_guess,
    inverse_kinematics,
    stance_span,
    starting_durations,
)
from amble.synthesis.layout import DomainLayout, Layout, build_layout
from amble.types import Vector

DURATIONS = {"D1": 0.2, "D2": 0.1}
CYCLE = 2.0 * (0.2 + 0.1)

WALK = Walk(Command(forward=0.5), 0.03)


@pytest.mark.parametrize("foot", ["fl", "fr", "rl", "rr"])
def test_a_foot_rests_in_stance_and_clears_the_ground_in_swing(small_problem: GaitProblem, foot: str) -> None:
    pattern, home = small_problem.pattern, np.array([0.3, 0.2, 0.0])
    span = stance_span(pattern, DURATIONS, foot)
    assert span is not None
    landing, stance, cycle = span
    assert cycle == pytest.approx(CYCLE)
    times = landing + np.linspace(0.0, cycle, 601)[:-1]
    path = foot_path(pattern, DURATIONS, foot, home, WALK, times)
    resting = times < landing + stance - 1e-6
    np.testing.assert_allclose(path[resting], path[0] * np.ones((resting.sum(), 1)), atol=1e-12)
    assert np.all(path[~resting][1:, 2] > 0.0)
    assert path[:, 2].max() == pytest.approx(0.03, rel=1e-3)  # a sample near the top of the parabola
    # under its hip in the middle of the stance, and one stride further a cycle later
    assert path[0, 0] == pytest.approx(home[0] + 0.5 * (landing + 0.5 * stance))
    later = foot_path(pattern, DURATIONS, foot, home, WALK, times + cycle)
    np.testing.assert_allclose(later[:, 0] - path[:, 0], 0.5 * cycle, atol=1e-9)


def test_inverse_kinematics_meets_the_feet(small_problem: GaitProblem) -> None:
    robot = small_problem.pattern.robot
    pose, homes = grounded_posture(small_problem)
    base = np.tile(pose[:6], (3, 1))
    base[:, 3] = [-0.05, 0.0, 0.05]
    motion = inverse_kinematics(robot, base, pose[6:], np.tile(homes.ravel(), (3, 1)))
    np.testing.assert_array_equal(motion[:, :6], base)
    for q in motion:
        feet = np.array([np.asarray(kinematics.foot_position(robot, foot, q)).ravel() for foot in robot.foot_names])
        np.testing.assert_allclose(feet, homes, atol=1e-6)  # the damping leaves a part of every step


@pytest.mark.parametrize("share", [0.1, 0.2])
def test_a_crawl_of_astro_starts_with_legs_that_are_not_turned_around(share: float) -> None:
    """Feet pass under the vertical hip axes: with little damping one joint went to 7.6 rad, its torque to 30 kN m."""
    robot = load("astro")
    problem = gait_problem(robot, "crawl", speed=share * np.sqrt(robot.gravity * robot.leg_length))
    layout = build_layout(problem)
    guess = initial_guess(problem, layout)
    angles = np.concatenate([guess[domain.q][:, 6:] for domain in layout.domains])
    assert np.abs(angles).max() < 0.6 * np.pi
    durations = starting_durations(problem)
    standing, swinging = durations["D1"], durations["D2"]
    assert 2.0 * standing < swinging < problem.limits.durations["D2"][1]


def _balance(problem: GaitProblem, domain: DomainLayout, guess: np.ndarray) -> float:
    """Largest residual of the base rows of the dynamics, in weights of the robot."""
    robot = problem.pattern.robot
    q, v, a = (ca.SX.sym(letter, robot.size) for letter in "qva")
    lam = ca.SX.sym("lambda", domain.force.shape[1])
    rows = dynamics.inverse_dynamics(robot, q, v, a) - problem.pattern.contacts(domain.stance).jacobian(q).T @ lam
    function = ca.Function("balance", [q, v, a, lam], [rows[:6]]).map(domain.nodes)
    parts = (guess[place].T for place in (domain.q, domain.v, domain.a, domain.force))
    return float(np.abs(np.asarray(function(*parts))).max() / (robot.mass * robot.gravity))


def _standing(problem: GaitProblem, layout: Layout) -> Vector:
    """A robot that stands in its posture, its weight shared evenly by the stance feet."""
    robot, guess = problem.pattern.robot, np.zeros(layout.size)
    for domain in layout.domains:
        feet = len(domain.stance.feet)
        guess[domain.q] = problem.posture.coordinates(robot)
        guess[domain.force] = np.tile([0.0, 0.0, robot.mass * robot.gravity / feet], feet)
    return guess


def test_the_sway_carries_what_a_level_base_cannot(small_problem: GaitProblem) -> None:
    """With both right feet down a level base lacks a moment of weight times their distance."""
    layout = build_layout(small_problem)
    swaying, still = (
        max(_balance(small_problem, domain, start(small_problem, layout)) for domain in layout.domains)
        for start in (initial_guess, _standing)
    )
    assert still > 0.2  # m, of the moment over the weight
    assert swaying < 0.75 * still  # what linear dynamics and curves of order four leave
    period = float(initial_guess(small_problem, layout)[layout.period][0])
    assert period == pytest.approx(sum(starting_durations(small_problem).values()))


def test_the_walk_goes_on_mirrored(small_problem: GaitProblem) -> None:
    layout, robot = build_layout(small_problem), small_problem.pattern.robot
    guess = initial_guess(small_problem, layout)
    first, last = layout.domains[0], layout.domains[-1]
    advance = np.zeros(robot.size)
    advance[0] = small_problem.speed * float(guess[layout.period][0])
    end, start = guess[last.q[-1]], robot.mirror.position(guess[first.q[0]])
    # the fit of curves meets the ends; the feet are mirror images because the footholds are
    np.testing.assert_allclose(end - advance, start, atol=1e-5)
