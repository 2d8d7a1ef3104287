"""Walkers with known answers, through the public API and the example scripts alone."""

from __future__ import annotations

import json
import runpy
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from examples import rimless_wheel, simplest_walker, three_link_walker

from amble.errors import CertificateError
from amble.simulation import simulate
from amble.stability import FixedPoint, Spectrum, certify, contraction, section_distances

MULTIPLIERS = 1e-6
PERIOD = 1e-7


@pytest.mark.parametrize(
    ("guess", "state", "period", "known"),
    [
        (
            simplest_walker.LONG_STEP,
            (0.2003109005442, -0.1998324730050),
            3.88246375,
            (-0.19009984 + 0.55759878j, -0.19009984 - 0.55759878j),
        ),
        (simplest_walker.SHORT_STEP, (0.1939373698102, -0.2038669274420), 3.09610587, (4.00386436, 0.45958959)),
    ],
)
def test_simplest_walker(
    guess: tuple[float, float], state: tuple[float, float], period: float, known: tuple[complex, complex]
) -> None:
    orbit, spectrum = simplest_walker.find_orbit(simplest_walker.simplest_walker(), guess)
    assert orbit.state[[0, 2]] == pytest.approx(state, abs=1e-10)
    assert orbit.period == pytest.approx(period, abs=PERIOD)
    for value in known:
        assert np.abs(spectrum.multipliers - value).min() < MULTIPLIERS
    # reset and guard leave a section of two dimensions: the other two multipliers are 0
    assert np.abs(spectrum.multipliers[2:]).max() < MULTIPLIERS


@pytest.mark.parametrize(("spokes", "slope"), [(6, 0.2), (8, 0.15), (8, 0.2), (12, 0.05)])
def test_rimless_wheel(spokes: int, slope: float) -> None:
    orbit, spectrum = rimless_wheel.find_orbit(rimless_wheel.rimless_wheel(spokes, slope), spokes, slope)
    assert orbit.state[1] == pytest.approx(rimless_wheel.known_rate(spokes, slope), abs=1e-10)
    assert spectrum.radius == pytest.approx(np.cos(2 * np.pi / spokes) ** 2, abs=MULTIPLIERS)


def test_rimless_wheel_of_six_spokes() -> None:
    orbit, _ = rimless_wheel.find_orbit(rimless_wheel.rimless_wheel())
    assert orbit.state[1] == pytest.approx(0.363931615, abs=1e-9)


def test_three_link_walker() -> None:
    walker = three_link_walker.three_link_walker()
    orbit, spectrum = three_link_walker.find_orbit(walker)
    assert orbit.period == pytest.approx(1.1084974, abs=PERIOD)
    assert spectrum.radius == pytest.approx(0.57273, abs=5e-6)  # the source has five digits
    before = simulate(walker, orbit.state, 1, 1e-12).events[0].before
    assert before[3] == pytest.approx(1.5525214, abs=1e-7)


def test_the_hidden_modes_of_the_three_link_walker_vanish_with_epsilon() -> None:
    """Hybrid zero dynamics: with faster outputs only the multiplier of the zero dynamics remains."""
    second = []
    for epsilon in (0.1, 0.08, 0.06):
        _, spectrum = three_link_walker.find_orbit(three_link_walker.three_link_walker(epsilon))
        second.append(abs(spectrum.multipliers[1]))
    assert second[0] > 3 * second[1] > 9 * second[2]


def test_certificates_of_walkers() -> None:
    walker = simplest_walker.simplest_walker()
    orbit, spectrum = simplest_walker.find_orbit(walker, simplest_walker.LONG_STEP)
    certificate = certify(walker, orbit.state)
    assert certificate.radius == pytest.approx(spectrum.radius, abs=1e-9)
    assert certificate.error < 1e-5
    unstable, _ = simplest_walker.find_orbit(walker, simplest_walker.SHORT_STEP)
    with pytest.raises(CertificateError, match="spectral radius plus its error bar"):
        certify(walker, unstable.state)


def test_measured_contraction_agrees_with_the_radius() -> None:
    walker = three_link_walker.three_link_walker()
    orbit, spectrum = three_link_walker.find_orbit(walker)
    start = orbit.state + 1e-3 * np.array([0, 0, 1, 1, -1, 1])  # angles stay on the section
    trace = simulate(walker, start, 40, 1e-11)
    assert trace.completed
    measured = contraction(section_distances(walker, trace.section, orbit.state))
    assert measured.rate == pytest.approx(spectrum.radius, rel=0.01)


@pytest.mark.parametrize("script", ["simplest_walker", "rimless_wheel", "three_link_walker"])
def test_the_examples_run(script: str, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(Path(__file__).parents[2] / "examples" / f"{script}.py"), run_name="__main__")
    assert "multiplier" in capsys.readouterr().out


KNOWN: dict[str, Callable[[], tuple[FixedPoint, Spectrum]]] = {
    "simplest long": lambda: simplest_walker.find_orbit(simplest_walker.simplest_walker(), simplest_walker.LONG_STEP),
    "simplest short": lambda: simplest_walker.find_orbit(simplest_walker.simplest_walker(), simplest_walker.SHORT_STEP),
    "wheel 6": lambda: rimless_wheel.find_orbit(rimless_wheel.rimless_wheel(6, 0.2), 6, 0.2),
    "wheel 8": lambda: rimless_wheel.find_orbit(rimless_wheel.rimless_wheel(8, 0.15), 8, 0.15),
    "wheel 12": lambda: rimless_wheel.find_orbit(rimless_wheel.rimless_wheel(12, 0.05), 12, 0.05),
    "three-link": lambda: three_link_walker.find_orbit(three_link_walker.three_link_walker()),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_walkers_are_what_they_were(name: str) -> None:
    """States, periods and multipliers as they were when the hybrid core knew neither excursions nor sliding."""
    known = json.loads((Path(__file__).parents[1] / "data" / "known-walkers.json").read_text())[name]
    orbit, spectrum = KNOWN[name]()
    np.testing.assert_allclose(orbit.state, known["state"], rtol=0.0, atol=1e-9)
    assert orbit.period == pytest.approx(known["period"], rel=0.0, abs=1e-9)
    for pair in known["multipliers"]:
        assert np.abs(spectrum.multipliers - complex(*pair)).min() < 1e-9
