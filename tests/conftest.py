"""Gaits and a gait problem shared by the whole session: each is built once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from amble.control import PseudoInverse, joint_outputs
from amble.gait import Gait, Limits
from amble.gait.files import load_gait
from amble.hybrid.gaits import amble
from amble.robot import catalogue
from amble.synthesis import GaitProblem
from amble.synthesis.program import GaitProgram, build_program

DATA = Path(__file__).parent / "data"


@pytest.fixture(scope="session")
def stabilised_gait() -> Gait:
    """The gait.json that ``amble reproduce`` of release 0.2.0 wrote; the same command writes it anew."""
    return load_gait(DATA / "stabilised-amble.json")


@pytest.fixture(scope="session")
def walking_gait(stabilised_gait: Gait) -> Gait:
    """The same amble with the outputs of its gait problem."""
    return replace(stabilised_gait, feedback=None)


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are composed, and their files appear without a picture, which takes most of a report's time.

    Pictures are drawn in tests/report/test_figures.py and test_html.py.
    """
    leave_unrendered(monkeypatch)


def leave_unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Do what ``unrendered`` says, for fixtures of a wider scope."""
    from matplotlib.figure import Figure

    def appear(_: Figure, place: Any, **__: Any) -> None:
        if isinstance(place, str | Path):  # else a picture within a page
            Path(place).write_bytes(b"left out")

    monkeypatch.setattr(Figure, "savefig", appear)
    monkeypatch.setattr(Figure, "draw_without_rendering", lambda _: None)


@pytest.fixture(scope="session")
def small_problem() -> GaitProblem:
    """ASTRo's amble on a coarse mesh: the structure of the real problem, solved in seconds."""
    pattern, bounds = amble(catalogue.astro()), catalogue.bounds("astro")
    joints = pattern.robot.joint_names
    limits = Limits(
        durations={stance.name: (0.1, 0.3) for stance in pattern.solved},
        positions=bounds.positions,
        speeds=dict.fromkeys(joints, bounds.speed),
        torques=dict.fromkeys(joints, bounds.torque),
        acceleration=60.0,
        touchdown_velocity=bounds.touchdown_velocity,
        normal_force=5.0,
        clearance=0.02,
    )
    posture = catalogue.posture("astro")
    return GaitProblem(
        pattern=pattern,
        outputs=joint_outputs(pattern),
        law=PseudoInverse(),
        speed=0.2,
        limits=limits,
        posture=posture,
        intervals=5,
    )


@pytest.fixture(scope="session")
def small_program(small_problem: GaitProblem) -> GaitProgram:
    """The coarse problem, transcribed and compiled."""
    return build_program(small_problem)
