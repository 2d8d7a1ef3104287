"""Replays of gaits and of traces, one or two side by side."""

from __future__ import annotations

from pathlib import Path

from amble.analysis import Samples, samples_of_gait, samples_of_trace
from amble.defaults import SHOWN_CYCLES
from amble.gait import Gait
from amble.simulation import Trace
from amble.view.meshes import link_meshes
from amble.view.page import ReplayPage
from amble.view.replay import check_cycles, replay_of_samples


def replay(
    motion: Gait | Samples,
    beside: Gait | Samples | Trace | None = None,
    cycles: int = SHOWN_CYCLES,
    robot_file: str | Path | None = None,
) -> ReplayPage:
    """Lay out a motion, or two side by side, as a page that replays them; a notebook shows it.

    Args:
        motion: a gait, whose optimised motion is shown, or samples of any motion of a legged robot.
        beside: another one; a trace is a simulation of the first.
        cycles: the most gait cycles of each to show, from 1 to 1000.
        robot_file: URDF file of the robot, whose shapes and meshes are drawn; without it, bones from joint to joint.

    Raises:
        UnknownNameError: a domain of the trace is no stance of the first motion's gait.
        InputError: ``cycles`` is out of range, a motion cannot be shown, or the file is not that of its robot.
    """
    check_cycles(cycles)
    motions = [_samples(motion, cycles)]
    if isinstance(beside, Trace):
        motions.append(samples_of_trace(beside, motions[0].pattern))
    elif beside is not None:
        motions.append(_samples(beside, cycles))
    looks = [() if robot_file is None else link_meshes(samples.robot, robot_file) for samples in motions]
    replays = tuple(
        replay_of_samples(samples, _label(samples), cycles, meshes)
        for samples, meshes in zip(motions, looks, strict=True)
    )
    title = " beside ".join(dict.fromkeys(f"{each.pattern.name} of {each.robot.name}" for each in motions))
    return ReplayPage(title=title, replays=replays)


def _samples(motion: Gait | Samples, cycles: int) -> Samples:
    return samples_of_gait(motion, cycles) if isinstance(motion, Gait) else motion


def _label(samples: Samples) -> str:
    how = "optimised" if samples.label == "nominal" else samples.label
    return f"{samples.robot.name}, {samples.pattern.name}, {how}"
