"""Synthetic motions with known metrics."""

from collections.abc import Callable

import numpy as np
import pytest

from amble.analysis.motion import Motion

JOINTS = tuple(f"{leg}_{joint}" for leg in ("fl", "rl", "fr", "rr") for joint in ("yaw", "pitch", "knee"))


def build_constant(torque: float, speed: float, duration: float = 2.0, distance: float = 0.4) -> Motion:
    """All joints at one torque and one speed, over two segments of unequal length."""
    times = np.concatenate([np.linspace(0.0, 0.3 * duration, 4), np.linspace(0.3 * duration, duration, 9)])
    segments = np.repeat([0, 1], [4, 9])
    return Motion(
        label="nominal",
        joints=JOINTS,
        times=times,
        segments=segments,
        speeds=np.full((13, 12), speed),
        torques={"pinv": np.full((13, 12), torque)},
        distance=distance,
        mass=21.5,
        gravity=9.81,
    )


def build_oscillating(count: int, period: float = 0.4) -> Motion:
    """Torque a sin(w t) + b at speed c cos(w t), with a jump in the middle of the period."""
    half = np.linspace(0.0, period / 2.0, count)
    times = np.concatenate([half, half + period / 2.0])
    segments = np.repeat([0, 1], count)
    phase = 2.0 * np.pi * times / period
    scale = np.linspace(0.5, 1.5, 12)
    torque = 10.0 * np.sin(phase)[:, None] * scale + 3.0 * (segments == 1)[:, None]
    speeds = 2.0 * np.cos(phase)[:, None] * scale
    return Motion(
        label="nominal",
        joints=JOINTS,
        times=times,
        segments=segments,
        speeds=speeds,
        torques={"drop": 1.3 * torque, "pinv": torque},
        distance=0.2 * period,
        mass=21.5,
        gravity=9.81,
    )


@pytest.fixture
def constant_motion() -> Callable[..., Motion]:
    """Builder of motions at one torque and one speed."""
    return build_constant


@pytest.fixture
def oscillating_motion() -> Callable[..., Motion]:
    """Builder of oscillating motions by the number of samples a segment."""
    return build_oscillating
