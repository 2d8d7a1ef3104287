"""Gains as free parameters: exact slopes of the Poincare Jacobian, and an orbit that gains do not move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.impedance import Impedance
from amble.stability.closed_loop_orbit import without_yaw
from amble.stability.gain_search import GainSearch
from amble.stability.monodromy import monodromy


def test_collocated_jacobian_equals_adaptive_variational_equations(gain_search: GainSearch) -> None:
    """Two code paths. The integrator's 1e-10 grows by the size of the Jacobian, about 100."""
    theta = np.random.default_rng(0).normal(0.0, 0.3, gain_search.size)
    values = dict(zip(gain_search.labels, gain_search.values(theta), strict=True))
    gait = replace(gain_search.gait, control=gain_search.law.with_gains(values))
    matrix = monodromy(without_yaw(closed_loop(gait, half=True), True), gain_search.orbit.start).matrix
    found = gain_search.evaluate(theta).matrices[0]
    assert np.abs(found - gain_search.orbit.dual @ matrix @ gain_search.orbit.basis).max() < 1e-6 * np.abs(found).max()


def test_gradient_is_that_of_central_differences(gain_search: GainSearch) -> None:
    """Of a random linear function of the Jacobian; the quadrature along the orbit leaves 1e-7 of the largest slope."""
    generator = np.random.default_rng(5)
    theta = generator.normal(0.0, 0.2, gain_search.size)
    here = gain_search.evaluate(theta)
    outer = generator.normal(size=here.matrices[0].shape)
    gradient = here.gradient([outer])
    for _ in range(3):
        direction = generator.normal(size=gain_search.size)
        ahead, behind = (
            float((gain_search.evaluate(theta + sign * 1e-4 * direction).matrices[0] * outer).sum())
            for sign in (1.0, -1.0)
        )
        assert (ahead - behind) / 2e-4 == pytest.approx(float(gradient @ direction), abs=1e-4 * np.abs(gradient).max())


def test_a_law_without_gains_is_refused(stabilised_gait: Gait) -> None:
    rigid = Impedance(stance_stiffness=0.0, stance_damping=0.0, swing_stiffness=0.0, swing_damping=0.0)
    with pytest.raises(InputError, match="control law 'impedance' has no positive gains"):
        GainSearch.of(replace(stabilised_gait, control=rigid))
