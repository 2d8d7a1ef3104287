"""A motion from elsewhere: torques, forces and impulses of a solved gait come back from its coordinates alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError
from amble.gait import DomainTrajectory, Gait
from amble.gait.files import load_gait
from amble.gait.recorded import RecordedDomain, RecordedMotion
from amble.synthesis import GaitProblem
from amble.synthesis.imported import imported_gait

TROT = Path(__file__).parents[1] / "data" / "trot.json"


@pytest.fixture(scope="module")
def trot() -> Gait:
    return load_gait(TROT)


@pytest.fixture(scope="module")
def problem(trot: Gait) -> GaitProblem:
    from amble.robot.catalogue import Posture

    middle = trot.domains[0].positions[0]
    angles = dict(zip(trot.robot.joint_names, map(float, middle[6:]), strict=True))
    return GaitProblem(
        pattern=trot.pattern,
        outputs=trot.outputs,
        law=trot.law,
        speed=trot.speed,
        limits=trot.limits,
        posture=Posture(float(middle[2]), angles),
        intervals=(len(trot.domains[0].times) - 1) // 2,
        gains=trot.gains,
    )


def motion_of(gait: Gait, *fields: str) -> RecordedMotion:
    def samples(part: DomainTrajectory) -> RecordedDomain:
        rest = {field: getattr(part, field) for field in fields}
        return RecordedDomain(name=part.name, times=part.times, positions=part.positions, **rest)

    return RecordedMotion("elsewhere.npz", tuple(samples(part) for part in gait.domains))


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")


def test_what_the_file_lacks_follows_from_the_motion(trot: Gait, problem: GaitProblem) -> None:
    found = imported_gait(problem, motion_of(trot, "velocities", "accelerations"))
    for here, there in zip(found.domains, trot.domains, strict=True):
        for field in ("positions", "velocities", "accelerations"):
            np.testing.assert_allclose(getattr(here, field), getattr(there, field), rtol=0.0, atol=1e-9)
        # the stored gait solves its equations to 1e-8 of the scaled problem
        np.testing.assert_allclose(here.torques, there.torques, rtol=0.0, atol=1e-4)
        np.testing.assert_allclose(here.forces, there.forces, rtol=0.0, atol=1e-4)
        np.testing.assert_allclose(here.impulse, there.impulse, rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(here.coefficients, there.coefficients, rtol=0.0, atol=1e-5)
    assert found.solver.solver == "imported"
    assert (
        found.solver.violation < 0.02
    )  # a foot of the stored trot goes down 0.012 as it is released, older than that row
    assert found.solver.objective == pytest.approx(trot.solver.objective, rel=1e-5)


def test_coordinates_alone_are_enough(trot: Gait, problem: GaitProblem) -> None:
    """Rates and accelerations by a spline through 17 samples a domain."""
    found = imported_gait(problem, motion_of(trot))
    for here, there in zip(found.domains, trot.domains, strict=True):
        np.testing.assert_allclose(here.positions, there.positions, rtol=0.0, atol=1e-9)
        largest = np.abs(there.velocities).max()
        np.testing.assert_allclose(here.velocities, there.velocities, rtol=0.0, atol=0.02 * largest)


def test_columns_have_names_and_signs(trot: Gait, problem: GaitProblem) -> None:
    names = list(trot.robot.coordinate_names)
    order = np.random.default_rng(0).permutation(len(names))
    signs = np.where(np.arange(len(names)) % 3 == 0, -1.0, 1.0)
    given = [("-" if signs[place] < 0 else "") + names[place] for place in order]
    motion = motion_of(trot, "velocities", "accelerations")
    mixed = tuple(
        replace(part, **{f: (getattr(part, f) * signs)[:, order] for f in ("positions", "velocities", "accelerations")})
        for part in motion.domains
    )
    found = imported_gait(problem, replace(motion, domains=mixed), given)
    for here, there in zip(found.domains, trot.domains, strict=True):
        np.testing.assert_allclose(here.positions, there.positions, rtol=0.0, atol=1e-9)
    with pytest.raises(UnknownNameError, match="unknown coordinate 'tail'"):
        imported_gait(problem, motion, [*names[:-1], "tail"])
    with pytest.raises(InputError, match=f"lacks {names[-1]}"):
        imported_gait(problem, motion, names[:-1])


def test_a_motion_that_is_none_of_the_robot_violates_rows(trot: Gait, problem: GaitProblem) -> None:
    motion = motion_of(trot, "velocities", "accelerations")
    lifted = tuple(replace(part, positions=part.positions + np.eye(18)[2] * 0.05) for part in motion.domains)
    assert imported_gait(problem, replace(motion, domains=lifted)).solver.violation > 0.04


def test_domains_must_be_those_of_the_gait(trot: Gait, problem: GaitProblem) -> None:
    motion = motion_of(trot)
    with pytest.raises(InputError, match="has 2 domains"):
        imported_gait(problem, replace(motion, domains=motion.domains * 2))
    unnamed = tuple(replace(part, name="") for part in motion.domains)
    assert imported_gait(problem, replace(motion, domains=unnamed)).domains[0].name == trot.domains[0].name


@pytest.mark.parametrize("count", range(3, 9))
def test_few_samples_are_enough(count: int, trot: Gait, problem: GaitProblem) -> None:
    """Five of them had no spline."""
    motion = motion_of(trot)
    parts = []
    for part in motion.domains:
        times = np.linspace(0.0, part.times[-1], count)
        rows = np.array([np.interp(times, part.times, column) for column in part.positions.T]).T
        parts.append(replace(part, times=times, positions=rows))
    found = imported_gait(problem, replace(motion, domains=tuple(parts)))
    for here, there in zip(found.domains, parts, strict=True):
        np.testing.assert_allclose(here.positions[[0, -1]], there.positions[[0, -1]], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("field", "values", "says"),
    [
        ("positions", np.full((5, 18), np.nan), "not finite"),
        ("positions", np.full((5, 18), 1e300), r"above 1e\+12"),
        ("positions", np.zeros(5), "are no table"),
        ("velocities", np.array(1.0), "are no table"),
        ("times", np.zeros((5, 1)), "are no list"),
        ("times", -np.arange(5.0), "run forward"),
        ("velocities", np.zeros((4, 18)), "5 times, but 4 rows"),
        ("times", np.arange(5.0) * 1e-300, "are its times in seconds"),
    ],
)
def test_samples_made_in_python_are_checked_like_those_of_a_file(
    field: str, values: np.ndarray, says: str, problem: GaitProblem
) -> None:
    samples = np.random.default_rng(0).normal(size=(5, 18))
    parts = [
        RecordedDomain(**{"name": stance.name, "times": np.arange(5.0), "positions": samples, field: values})
        for stance in problem.pattern.solved
    ]
    with pytest.raises(InputError, match=says):
        imported_gait(problem, RecordedMotion("python", tuple(parts)))
