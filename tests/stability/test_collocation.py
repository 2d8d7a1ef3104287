"""Fundamental solutions by collocation: against an adaptive solver, and their slopes against differences."""

from __future__ import annotations

import numpy as np
import pytest

from amble.stability import collocation
from amble.stability.collocation import GaussRule, fundamental
from amble.types import Matrix, NodeValues

RULE = GaussRule.of(5)
HALF, PANELS, DURATION = 3, 4, 0.7
RNG = np.random.default_rng(5)
LOWER = RNG.normal(size=(3, HALF, 2 * HALF))


def _field(t: float) -> Matrix:
    """F = [0 1; L D], of one harmonic."""
    lower = LOWER[0] + LOWER[1] * np.sin(3.0 * t) + LOWER[2] * np.cos(3.0 * t)
    return np.vstack([np.hstack([np.zeros((HALF, HALF)), np.eye(HALF)]), lower])


def _fields() -> NodeValues:
    clock = DURATION * (np.arange(PANELS)[:, None] + RULE.nodes) / PANELS
    return np.array([_field(t) for t in clock.ravel()])


@pytest.fixture(params=["native", "numpy"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Either way of solving."""
    if request.param == "numpy":
        monkeypatch.setattr(collocation, "_native", lambda _: None)
    elif collocation._native(RULE) is None:
        pytest.skip("no C compiler on this machine")
    return str(request.param)


def test_it_is_that_of_an_adaptive_solver(way: str) -> None:
    """Order 10 in four panels of half a radian each leaves 1e-11."""
    from scipy.integrate import solve_ivp

    size = 2 * HALF
    rate = lambda t, y: (_field(t) @ y.reshape(size, size)).ravel()  # noqa: E731
    expected = solve_ivp(rate, (0.0, DURATION), np.eye(size).ravel(), "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    found = fundamental(RULE, DURATION, _fields())
    assert (found.pivots is not None) == (way == "native")
    assert np.abs(found.whole - expected.reshape(size, size)).max() < 1e-10


def test_both_ways_solve_the_same_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    """To rounding: the map, the solution at every node, and the slopes."""
    rows, fields = RNG.normal(size=(4, 2 * HALF)), _fields()
    found = fundamental(RULE, DURATION, fields)
    slopes = found.pulled(rows)
    monkeypatch.setattr(collocation, "_native", lambda _: None)
    other = fundamental(RULE, DURATION, fields)
    for one, two in ((found.whole, other.whole), (found.until, other.until), (slopes, other.pulled(rows))):
        assert np.abs(one - two).max() < 1e-12 * np.abs(two).max()


@pytest.mark.usefixtures("way")
def test_slopes_are_those_of_central_differences() -> None:
    """Of rows times the map, for a random change of the fields at the nodes; a step of 1e-4 leaves 1e-8."""
    fields, rows = _fields(), RNG.normal(size=(2, 2 * HALF))
    change = np.zeros_like(fields)
    change[:, HALF:] = RNG.normal(size=change[:, HALF:].shape)
    ahead, behind = (rows @ fundamental(RULE, DURATION, fields + step * change).whole for step in (1e-4, -1e-4))
    here = fundamental(RULE, DURATION, fields)
    slope = np.sum(here.pulled(rows) @ change[:, HALF:] @ here.until, axis=0)
    assert np.abs((ahead - behind) / 2e-4 - slope).max() < 1e-6 * np.abs(slope).max()


def test_singular_equations_are_refused() -> None:
    """A stiffness at one node of a panel that makes the equations of that panel singular: 1 = h^2 (A A)_ii L."""
    step = DURATION / PANELS
    fields = np.zeros((PANELS * 5, 2, 2))
    fields[:, 0, 1] = 1.0
    fields[2, 1, 0] = 1.0 / (step**2 * RULE.twice[2, 2])
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        fundamental(RULE, DURATION, fields)
