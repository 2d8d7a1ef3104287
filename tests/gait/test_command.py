"""Commands: the way of a heading that turns, by integration."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from amble.errors import InputError
from amble.gait.command import Command


@pytest.mark.parametrize("seed", range(4))
def test_the_way_is_the_integral_of_the_turning_velocities(seed: int) -> None:
    forward, lateral, rate = np.random.default_rng(seed).normal(0.0, 1.0, 3)
    command, duration = Command(forward=forward, lateral=lateral, yaw_rate=rate), 0.8

    def velocity(t: float, _: np.ndarray) -> list[float]:
        cosine, sine = np.cos(rate * t), np.sin(rate * t)
        return [cosine * forward - sine * lateral, sine * forward + cosine * lateral]

    walked = solve_ivp(velocity, (0.0, duration), [0.0, 0.0], rtol=1e-11, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(command.way(duration), [*walked, rate * duration], atol=1e-9)
    symbols = [ca.SX.sym(name) for name in ("v", "w", "r", "T")]
    way = ca.Function(
        "way", symbols, list(Command(forward=symbols[0], lateral=symbols[1], yaw_rate=symbols[2]).way(symbols[3]))
    )
    np.testing.assert_allclose([float(part) for part in way(forward, lateral, rate, duration)], command.way(duration))


def test_a_straight_way_is_velocity_times_duration() -> None:
    assert Command(forward=0.3, lateral=-0.1).way(2.0) == (0.6, -0.2, 0.0)


@pytest.mark.parametrize("bad", [{"forward": np.nan}, {"forward": 0.0, "yaw_rate": 1e9}])
def test_what_is_no_command(bad: dict[str, float]) -> None:
    with pytest.raises(InputError, match="number of reasonable size"):
        Command(**bad)
