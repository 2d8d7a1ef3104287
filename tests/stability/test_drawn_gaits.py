"""Either a changed gait is refused, or its certificate is true: seeded draws of what a file may hold.

A change that leaves the closed loop as it is leaves fixed point and radius as they were. Under other weights they are
computed again: by differences of the half cycle, where the certificate has variational equations of the whole one.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amble.errors import AmbleError, CertificateError
from amble.gait import Feedback, Gait
from amble.gait.files import load_gait
from amble.stability import Certificate, certify, difference_check, poincare_map
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.spectrum import spectrum
from amble.types import frozen
from tests.seeds import seeds
from tests.similar import similar

BIPED = Path(__file__).parents[1] / "data" / "biped-of-small-basin.json"


@pytest.fixture(scope="module")
def biped() -> Gait:
    return load_gait(BIPED)


@pytest.fixture(scope="module")
def certificate(biped: Gait) -> Certificate:
    return certify(biped)


def feedback_of(gait: Gait) -> Feedback:
    assert gait.feedback is not None
    return gait.feedback


def with_start(gait: Gait, size: float, draw: np.random.Generator) -> Gait:
    feedback = feedback_of(gait)
    change = size * draw.choice([-1.0, 1.0], feedback.start.shape)
    change[:2] = 0.0  # where on the plane is not the motion's
    return replace(gait, feedback=replace(feedback, start=frozen(feedback.start + change)))


def with_record(gait: Gait, size: float, draw: np.random.Generator) -> Gait:
    def noisy(values: np.ndarray) -> np.ndarray:
        return frozen(values + size * (1.0 + np.max(np.abs(values))) * draw.uniform(-1.0, 1.0, values.shape))

    fields = ("accelerations", "torques", "forces")
    return replace(
        gait,
        domains=tuple(
            replace(domain, **{name: noisy(getattr(domain, name)) for name in fields}) for domain in gait.domains
        ),
    )


def with_durations(gait: Gait, size: float, draw: np.random.Generator) -> Gait:
    """Those of the record alone: nothing of the closed loop."""
    domains = []
    for domain in gait.domains:
        factor = 1.0 + size * float(draw.choice([-1.0, 1.0]))
        domains.append(replace(domain, duration=factor * domain.duration, times=frozen(factor * domain.times)))
    return replace(gait, domains=tuple(domains))


def drawn() -> list[Any]:
    """Every change of every size; a certificate of each change for `make test`, the others for `make slow`."""
    quick = {(with_start, 1e-7), (with_record, 1e-2), (with_durations, 1e-4)}
    return [
        pytest.param(change, size, marks=() if (change, size) in quick else pytest.mark.slow)
        for change in (with_start, with_record, with_durations)
        for size in (1e-7, 1e-4, 1e-2)
    ]


@pytest.mark.parametrize(("change", "size"), drawn())
def test_what_leaves_the_closed_loop_leaves_the_certificate(
    biped: Gait, certificate: Certificate, change: object, size: float
) -> None:
    draw = np.random.default_rng(int(-np.log10(size)))
    try:
        found = certify(change(biped, size, draw))  # type: ignore[operator]
    except AmbleError:
        assert size > 1e-6  # roundoff of a file is no reason to refuse
        return
    assert size < 1e-2  # a percent is
    np.testing.assert_allclose(found.state[2:], certificate.state[2:], atol=1e-8)  # both to the residual of Newton
    assert found.radius == pytest.approx(certificate.radius, abs=1e-6)
    assert found.period == pytest.approx(certificate.period, rel=1e-8)


@pytest.mark.parametrize("seed", seeds(1, 6))
def test_under_other_weights_the_radius_is_that_of_the_changed_loop(biped: Gait, seed: int) -> None:
    draw = np.random.default_rng(seed)
    feedback, size = feedback_of(biped), 10.0 ** draw.uniform(-4.0, -1.0)
    weights = {
        name: frozen(values * (1.0 + size * draw.uniform(-1.0, 1.0, values.shape)))
        for name, values in feedback.weights.items()
    }
    gait = replace(biped, feedback=replace(feedback, weights=weights))
    try:
        found = certify(gait)
    except AmbleError:
        return
    system, there = closed_loop_fixed_point(gait)
    derivative = difference_check(system, there.state, (1e-4, 1e-5)).matrix
    half = spectrum(system, there.state, poincare_map(system, there.state), derivative)
    assert half.radius**2 == pytest.approx(found.radius, abs=1e-5)
    assert found.radius + found.error < 1.0


@pytest.mark.parametrize(("mass", "length"), [(0.1, 0.05), pytest.param(1000.0, 3.0, marks=pytest.mark.slow)])
def test_the_same_gait_of_another_size_has_the_same_certificate(
    biped: Gait, certificate: Certificate, mass: float, length: float
) -> None:
    """A robot of 0.1 kg on legs of 45 mm, and one of a tonne: everything that is held is a share of l, g and weight."""
    found = certify(similar(biped, mass / biped.robot.mass, length))
    assert found.disturbance is not None
    assert certificate.disturbance is not None
    assert found.radius == pytest.approx(certificate.radius, abs=1e-6)
    assert found.period == pytest.approx(np.sqrt(length) * certificate.period)
    assert found.disturbance.growth.factor == pytest.approx(certificate.disturbance.growth.factor, rel=1e-4)
    assert found.disturbance.returns == certificate.disturbance.returns


@pytest.mark.parametrize("factor", [0.9, 1.1])
@pytest.mark.parametrize("field", ["positions", "velocities", "accelerations", "torques", "forces", "impulse"])
def test_a_small_robot_is_held_to_its_record_too(biped: Gait, field: str, factor: float) -> None:
    gait = similar(biped, 0.1 / biped.robot.mass, 0.05)
    domains = tuple(replace(part, **{field: frozen(factor * getattr(part, field))}) for part in gait.domains)
    with pytest.raises(CertificateError):
        certify(replace(gait, domains=domains))
