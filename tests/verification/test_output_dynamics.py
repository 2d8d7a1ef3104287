"""The reference integration ends, whatever it starts from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from amble.errors import WorkError
from amble.gait import Gait
from amble.types import Vector
from amble.verification.domain_rows import sampled
from amble.verification.output_dynamics import Effort, Record, integrate
from amble.verification.stance_model import terms


def test_an_integration_that_takes_too_long_is_named(stabilised_gait: Gait) -> None:
    domain = sampled(stabilised_gait, 0, 1)
    arguments = (domain.contacts, domain.loop, domain.positions[0], domain.velocities[0], domain.times)
    q, _ = integrate(*arguments)
    assert q.shape == domain.positions.shape
    with pytest.raises(WorkError, match="stance rl, fr cannot be integrated: the evaluations that a check"):
        integrate(*arguments, Effort(50))
    shared, spent = Effort(2000), []
    for _ in range(2):
        before = shared.left
        integrate(*arguments, shared)
        spent.append(before - shared.left)
    assert spent[0] == spent[1] > 100


def test_the_integration_is_that_of_scipy(stabilised_gait: Gait) -> None:
    domain = sampled(stabilised_gait, 1, 3)
    start = np.concatenate([domain.positions[0], domain.velocities[0]])
    size = len(domain.positions[0])

    def rate(t: float, x: Vector) -> Vector:
        q, v = x[None, :size], x[None, size:]
        motion = domain.loop.solve(terms(domain.contacts, q, v), np.array([t]), q, v)
        return np.concatenate([v[0], motion.accelerations[0]])

    span = (domain.times[0], domain.times[-1])
    expected = solve_ivp(rate, span, start, method="DOP853", t_eval=domain.times, rtol=1e-11, atol=1e-11).y.T
    found = np.hstack(integrate(domain.contacts, domain.loop, start[:size], start[size:], domain.times))
    np.testing.assert_array_equal(found, expected)


def test_an_integration_ends_where_it_leaves_the_record(stabilised_gait: Gait) -> None:
    """The record runs away from the motion: what is returned ends with the first point that is not near."""
    domain = sampled(stabilised_gait, 0, 2)
    arguments = (domain.contacts, domain.loop, domain.positions[0], domain.velocities[0], domain.times)
    whole = np.hstack(integrate(*arguments))
    away = whole + np.linspace(0.0, 1.0, len(whole))[:, None]
    near = np.full(whole.shape[1], 0.4999)
    part = np.hstack(integrate(*arguments, None, Record(states=away, near=near)))
    assert len(part) == len(whole) // 2 + 1
    np.testing.assert_array_equal(part, whole[: len(part)])


def test_numbers_that_are_no_motion_are_given_up(stabilised_gait: Gait) -> None:
    """Rates a hundred times too large: the motion is stiff at once."""
    domain = sampled(stabilised_gait, 0, 1)
    with pytest.raises(WorkError, match="cannot be integrated"):
        integrate(domain.contacts, domain.loop, domain.positions[0], 100.0 * domain.velocities[0], domain.times)


@pytest.mark.parametrize("seed", range(6))
def test_a_motion_that_leaves_the_numbers_there_are_is_given_up(seed: int, stabilised_gait: Gait) -> None:
    """Gains of up to 1e308: a trial step is not finite any more, and no decomposition of its Jacobian converges."""
    random = np.random.default_rng(seed)
    domain = sampled(stabilised_gait, int(random.integers(2)), 1)
    gains = (10.0 ** float(random.uniform(150.0, 308.0)), 10.0 ** float(random.uniform(0.0, 308.0)))
    q = domain.positions[0] + 10.0 ** float(random.uniform(-16.0, 0.0))
    with pytest.raises(WorkError, match=r"cannot be integrated|lose their rank"):
        integrate(domain.contacts, replace(domain.loop, gains=gains), q, domain.velocities[0], domain.times)
