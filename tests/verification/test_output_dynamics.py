"""The reference integration ends, whatever it starts from."""

from __future__ import annotations

import pytest

from amble.errors import WorkError
from amble.gait import Gait
from amble.verification import output_dynamics
from amble.verification.domain_rows import sampled
from amble.verification.output_dynamics import integrate


def test_an_integration_that_takes_too_long_is_named(stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    domain = sampled(stabilised_gait, 0, 1)
    arguments = (domain.contacts, domain.loop, domain.positions[0], domain.velocities[0], domain.times)
    q, _ = integrate(*arguments)
    assert q.shape == domain.positions.shape
    monkeypatch.setattr(output_dynamics, "MOST_EVALUATIONS", 50)
    with pytest.raises(WorkError, match="stance rl, fr cannot be integrated: it took more than 50 evaluations"):
        integrate(*arguments)


def test_numbers_that_are_no_motion_are_given_up(stabilised_gait: Gait) -> None:
    """Rates a hundred times too large: the motion is stiff at once."""
    domain = sampled(stabilised_gait, 0, 1)
    with pytest.raises(WorkError, match="cannot be integrated"):
        integrate(domain.contacts, domain.loop, domain.positions[0], 100.0 * domain.velocities[0], domain.times)
