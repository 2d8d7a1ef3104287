"""A certificate cannot be fooled by its file: one thing changed in a certified gait, and it is refused by name.

A change of the robot comes with the hash of the changed robot: the hash has no key, so anybody can write it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amble.errors import AmbleError, CertificateError, InputError
from amble.gait import DomainTrajectory, Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.files import load_gait
from amble.residual import Residual
from amble.robot import Robot
from amble.stability import Certificate, certification, certify
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.gait_certificate import certified_orbit, held_against
from amble.stability.orbit_conditions import orbit_conditions
from amble.types import frozen
from tests.grounds import on_friction

TROT = Path(__file__).parents[1] / "data" / "trot-front-feet-in-the-air.json"


def refusal(gait: Gait, **options: bool) -> list[str]:
    """Names of the rows that fail."""
    with pytest.raises(CertificateError) as caught:
        certify(gait, **options)
    return [row.name for row in caught.value.rows if row.violation > 0.0]


def with_robot(gait: Gait, robot: Robot) -> Gait:
    return replace(gait, pattern=replace(gait.pattern, robot=robot))


def with_domains(gait: Gait, change: Callable[[DomainTrajectory], dict[str, Any]]) -> Gait:
    return replace(gait, domains=tuple(replace(domain, **change(domain)) for domain in gait.domains))


def with_limits(gait: Gait, friction: float | None = None, **fields: Any) -> Gait:
    changed = replace(gait, limits=replace(gait.limits, **fields))
    return changed if friction is None else on_friction(changed, friction)


def scaled_inertia(robot: Robot, index: int, factor: float) -> Robot:
    links = list(robot.links)
    links[index] = replace(links[index], inertia=frozen(factor * links[index].inertia))
    return replace(robot, links=tuple(links), symmetry_tolerance=100.0)


def heavier_on_the_left(robot: Robot, factor: float) -> Robot:
    """Left legs' masses by a factor; the tolerance in the file lets the mirror pass."""
    left = {robot.joints[j].child for foot in robot.feet if foot.name.endswith("l") for j in robot.chain(foot.link)}
    links = tuple(replace(link, mass=factor * link.mass) if i in left else link for i, link in enumerate(robot.links))
    return replace(robot, links=links, symmetry_tolerance=100.0)


@pytest.mark.parametrize("seed", range(4))
def test_a_negative_inertia_is_refused(stabilised_gait: Gait, seed: int) -> None:
    draw = np.random.default_rng(seed)
    index = int(draw.integers(len(stabilised_gait.robot.links)))
    named = f"inertia of link '{stabilised_gait.robot.links[index].name}' is not positive definite"
    with pytest.raises(InputError, match=named):
        scaled_inertia(stabilised_gait.robot, index, -float(draw.uniform(1e-6, 1e-3)))


@pytest.mark.parametrize("factor", [1.5, 1.01, 1.0001])
def test_an_asymmetric_robot_is_refused_whatever_tolerance_its_file_states(
    stabilised_gait: Gait, factor: float
) -> None:
    gait = with_robot(stabilised_gait, heavier_on_the_left(stabilised_gait.robot, factor))
    assert refusal(gait) == ["left-right asymmetry of the robot"]


def test_a_robot_that_no_frame_fits_is_refused(stabilised_gait: Gait) -> None:
    joints = list(stabilised_gait.robot.joints)
    joints[0] = replace(joints[0], axis=frozen(1.1 * joints[0].axis))
    with pytest.raises(InputError, match=f"axis of joint '{joints[0].name}' is 1.1 long"):
        replace(stabilised_gait.robot, joints=tuple(joints), symmetry_tolerance=100.0)


RECORDED = ("positions", "velocities", "accelerations", "torques", "forces", "impulse", "coefficients")


@pytest.mark.parametrize("field", RECORDED)
@pytest.mark.parametrize("factor", [0.0, -1.0, 1.1])
def test_a_recorded_quantity_that_is_not_the_motion_s_is_refused(
    stabilised_gait: Gait, field: str, factor: float
) -> None:
    """Zeroed velocities and forces do not even make a record; zeroed positions leave the outputs without rank."""
    with pytest.raises(AmbleError) as caught:
        certify(with_domains(stabilised_gait, lambda domain: {field: frozen(factor * getattr(domain, field))}))
    named = [domain.name for domain in stabilised_gait.domains] + ["the outputs of stance"]
    assert any(name in str(caught.value) for name in named)


@pytest.mark.parametrize("seed", range(6))
def test_a_single_recorded_number_is_held_to_the_motion(stabilised_gait: Gait, seed: int) -> None:
    draw = np.random.default_rng(seed)
    number, field = int(draw.integers(2)), str(draw.choice(RECORDED))
    domains = list(stabilised_gait.domains)
    values = np.array(getattr(domains[number], field))
    place = tuple(int(draw.integers(size)) for size in values.shape)
    values[place] += draw.choice([-1.0, 1.0]) * 0.1 * (1.0 + np.max(np.abs(values)))
    domains[number] = replace(domains[number], **{field: frozen(values)})
    names = refusal(replace(stabilised_gait, domains=tuple(domains)))
    assert names


def test_a_motion_of_zeros_is_no_record(stabilised_gait: Gait) -> None:
    fields = ("positions", "velocities", "accelerations", "torques", "forces")
    with pytest.raises(InputError, match="nothing moves in the motion of domain 'D1'"):
        with_domains(stabilised_gait, lambda domain: {name: np.zeros_like(getattr(domain, name)) for name in fields})


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99, 1.01, 1e6])
def test_a_cost_that_the_torques_do_not_have_is_refused(stabilised_gait: Gait, share: float) -> None:
    """The objective is the mean square of the torques; what a file states is what another gait is compared with."""
    stated = replace(stabilised_gait.solver, objective=share * stabilised_gait.solver.objective)
    names = refusal(replace(stabilised_gait, solver=stated))
    assert names == ["root mean square of the torques less the solver's"]


@pytest.mark.parametrize("speed", [5.0, -99.0, 0.0, 0.21, -0.2])
def test_a_speed_that_is_not_walked_is_refused(stabilised_gait: Gait, speed: float) -> None:
    assert "mean speed less the speed asked for" in refusal(replace(stabilised_gait, speed=speed))


LIMITS: list[tuple[dict[str, Any], str]] = [
    ({"friction": 100.0}, "sensible friction coefficient"),
    ({"friction": 2.1}, "sensible friction coefficient"),
    ({"torques": {"fl_knee": 1e-9}}, "sensible torque limit of 'fl_knee'"),
    ({"torques": {"rr_knee": 1.8}}, "sensible torque limit of 'rr_knee'"),
]


@pytest.mark.parametrize(("fields", "name"), LIMITS)
def test_an_absurd_limit_is_refused_and_said(stabilised_gait: Gait, fields: dict[str, Any], name: str) -> None:
    gait = with_limits(stabilised_gait, **fields)
    assert refusal(gait) == [name]
    assert held_against(gait)["absurd"] == [name.removeprefix("sensible ")]


@pytest.mark.parametrize("gravity", [0.3, 31.0])
def test_an_absurd_gravity_is_refused_before_anything_moves(stabilised_gait: Gait, gravity: float) -> None:
    gait = with_robot(stabilised_gait, replace(stabilised_gait.robot, gravity=gravity))
    assert "sensible gravity" in refusal(gait)
    assert refusal(gait, allow_absurd_limits=True)  # it is not the gravity of this motion either


def test_absurd_limits_are_allowed_where_told(stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    class EnoughError(Exception):
        """The orbit's conditions are there; the rest takes long."""

    def enough(*_: object) -> Certificate:
        raise EnoughError

    found: list[tuple[Residual, ...]] = []

    def kept(*arguments: Any) -> Any:
        result = certified_orbit(*arguments)
        found.append(result[2])
        return result

    monkeypatch.setattr(certification, "certified_orbit", kept)
    monkeypatch.setattr(certification, "assess", enough)
    with pytest.raises(EnoughError):
        certify(with_limits(stabilised_gait, friction=100.0), allow_absurd_limits=True)
    given = found[0]
    assert given
    assert not any(row.name.startswith("sensible") for row in given)
    assert next(row for row in given if row.name == "D1 fr friction").upper == 100.0


@pytest.mark.parametrize("seed", range(3))
def test_references_of_another_orbit_are_refused(stabilised_gait: Gait, seed: int) -> None:
    """The stabilised outputs lead onto an orbit of their own, which is not the recorded one; or onto none."""
    assert stabilised_gait.feedback is not None
    draw = np.random.default_rng(seed)
    joint = int(draw.integers(3, 15))
    shift = float(draw.uniform(0.02, 0.06))
    references = {}
    for name, values in stabilised_gait.feedback.references.items():
        moved = np.array(values)
        moved[joint] += shift
        references[name] = frozen(moved)
    with pytest.raises(AmbleError):
        certify(replace(stabilised_gait, feedback=replace(stabilised_gait.feedback, references=references)))


def test_a_trot_whose_front_feet_stand_in_the_air_is_refused_by_name() -> None:
    """Both front knee references of a stabilised trot moved by 0.08 rad: a stable orbit, 25 mm too high in front."""
    gait = load_gait(TROT)
    names = refusal(gait)
    assert {"D1 fl height on the ground", "D2 fr height on the ground"} <= set(names)
    assert {"D1->D2 height at touchdown fr", "D2->D1 height at touchdown fl"} <= set(names)
    assert "start of the feedback less the fixed point, fl_knee" in names


def test_a_foot_in_the_air_is_named_above_and_below(stabilised_gait: Gait) -> None:
    """The same orbit, 5 mm too high and too low: nothing in the equations of motion feels it, only the rows do."""
    system, found = closed_loop(stabilised_gait), closed_loop_fixed_point(stabilised_gait)[1]
    sound = orbit_conditions(stabilised_gait, system, found.state)
    assert all(row.violation == 0.0 for row in sound)
    for height in (0.005, -0.005):
        state = np.array(found.state)
        state[2] += height
        failed = {row.name for row in orbit_conditions(stabilised_gait, system, state) if row.violation > 0.0}
        assert {"D1 fr height on the ground", "D1 rl height on the ground"} <= failed
