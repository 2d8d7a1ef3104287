from __future__ import annotations

import json

import numpy as np
import pytest

from amble.errors import CertificateError, InputError, Row
from amble.stability import assess, certify, difference_check, fixed_point
from amble.stability.certificate import lyapunov_matrix
from tests.hybrids import travelling

GUESS = np.array([0.0, 0.3, 1.0, -2.0, 0.4])


@pytest.fixture(scope="module")
def state() -> np.ndarray:
    return fixed_point(travelling(0.7, -1), GUESS).state


def test_a_certificate_holds_its_evidence(state: np.ndarray) -> None:
    system = travelling(0.7, -1)
    certificate = certify(system, state, [Row("friction", 0.0, 0.3, 0.6)])
    assert certificate.radius < 0.5
    assert 0 < certificate.error < 1e-4
    assert certificate.disagreement < 1e-7
    assert [tolerance for tolerance, _ in certificate.sweep] == [1e-8, 1e-10, 1e-12]
    assert all(radius == pytest.approx(certificate.radius, abs=1e-6) for _, radius in certificate.sweep)
    matrix, lyapunov = certificate.spectrum.matrix, certificate.lyapunov
    assert lyapunov is not None
    assert np.linalg.eigvalsh(lyapunov).min() >= 1.0  # W = 1 + A^T A + ...
    assert matrix.T @ lyapunov @ matrix - lyapunov == pytest.approx(-np.eye(2), abs=1e-9)


def test_a_certificate_is_json(state: np.ndarray) -> None:
    certificate = assess(travelling(0.7, -1), state)
    tree = json.loads(json.dumps(certificate.to_json(), allow_nan=False))
    assert tree["spectral_radius"] == certificate.radius
    assert tree["symmetries"][2]["name"] == "heading"
    assert tree["fixed_point"]["y"] == state[3]


def test_a_violated_condition_is_refused(state: np.ndarray) -> None:
    with pytest.raises(CertificateError, match=r"1 conditions fail\n.*smallest normal force"):
        certify(travelling(0.7, -1), state, [Row("smallest normal force", 0.0, -2.0, np.inf), Row("ok", 0, 1, 2)])


def test_a_state_that_is_not_a_fixed_point_is_refused(state: np.ndarray) -> None:
    with pytest.raises(CertificateError, match="residual of the fixed point"):
        certify(travelling(0.7, -1), state + np.array([0, 1e-3, 0, 0, 0]))


def test_lyapunov_matrix_of_an_unstable_map_is_not_positive() -> None:
    assert np.linalg.eigvalsh(lyapunov_matrix(np.array([[1.2, 1.0], [0.0, 0.5]]))).min() < 0


@pytest.mark.parametrize("steps", [(1e-4,), (1e-4, 1e-4), (1e-4, 0.0)])
def test_a_sweep_takes_two_steps(state: np.ndarray, steps: tuple[float, ...]) -> None:
    with pytest.raises(InputError, match="at least two different positive steps"):
        difference_check(travelling(0.7, -1), state, steps)


def test_steps_that_do_not_come_back_are_skipped(state: np.ndarray) -> None:
    found = difference_check(travelling(0.7, -1), state, (2.0, 1e-4, 1e-5), longest=2.0)
    assert found.sweep[0][1] == np.inf
    assert found.step == 1e-5
