from __future__ import annotations

import json
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from amble.errors import CertificateError, InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.residual import Residual
from amble.stability import assess, certify, difference_check, fixed_point, poincare
from amble.stability.certificate import row_to_dict
from tests.hybrids import travelling

GUESS = np.array([0.0, 0.3, 1.0, -2.0, 0.4])


@pytest.fixture(scope="module")
def state() -> np.ndarray:
    return fixed_point(travelling(0.7, -1), GUESS).state


def test_a_certificate_holds_its_evidence(state: np.ndarray) -> None:
    system = travelling(0.7, -1)
    certificate = certify(system, state, [Residual("friction", 0.0, 0.3, 0.6)])
    assert certificate.radius < 0.5
    assert 0 < certificate.error < 1e-4
    assert certificate.disagreement < 1e-7
    assert [tolerance for tolerance, _ in certificate.sweep] == [1e-8, 1e-10, 1e-12]
    assert all(radius == pytest.approx(certificate.radius, abs=1e-6) for _, radius in certificate.sweep)
    matrix, bound = certificate.spectrum.matrix, certificate.bound
    assert bound is not None
    assert certificate.radius < bound.rate < 1.0
    assert np.linalg.eigvalsh(bound.metric).min() > 0.0
    assert np.linalg.eigvalsh(bound.rate**2 * bound.metric - matrix.T @ bound.metric @ matrix).min() > 0.0
    names = [row.name for row in certificate.rows()]
    assert {"contraction bound r", "least eigenvalue of W", "least eigenvalue of r^2 W - A^T W A"} <= set(names)


def test_a_certificate_is_json(state: np.ndarray) -> None:
    certificate = assess(travelling(0.7, -1), state)
    tree = json.loads(json.dumps(certificate.to_dict(), allow_nan=False))
    assert tree["spectral_radius"] == certificate.radius
    assert tree["symmetries"][2]["name"] == "heading"
    assert tree["fixed_point"]["y"] == state[3]
    names = [entry["name"] for entry in tree["conditions"]]
    assert names == [row.name for row in certificate.rows()]
    assert all(entry["holds"] for entry in tree["conditions"])


def test_every_condition_is_in_the_certificate(state: np.ndarray) -> None:
    above = Residual("smallest normal force", 0.0, 2.0, np.inf)
    certificate = certify(travelling(0.7, -1), state, [above])
    assert certificate.rows()[-1] is above
    expected = {"name": "smallest normal force", "lower": 0.0, "value": 2.0, "upper": None, "holds": True}
    assert certificate.to_dict()["conditions"][-1] == expected


def test_a_value_that_is_no_number_does_not_hold() -> None:
    tree = row_to_dict(Residual("friction", 0.0, float("nan"), 0.6))
    assert tree == {"name": "friction", "lower": 0.0, "value": None, "upper": 0.6, "holds": False}


@pytest.mark.parametrize(("share", "holds"), [(0.91, True), (1.09, True), (0.89, False), (1.11, False)])
def test_the_measured_contraction_is_checked_within_a_tenth(share: float, holds: bool, state: np.ndarray) -> None:
    certificate = assess(travelling(0.7, -1), state)
    assert certificate.mode is not None
    assert certificate.mode.difference < 1e-3  # the start is 1e-5 away, and the map is smooth
    changed = replace(certificate, mode=replace(certificate.mode, rate=share * certificate.radius))
    (row,) = [row for row in changed.rows() if row.name == "contraction of the leading mode in simulation"]
    assert (row.violation == 0.0) == holds


def test_a_violated_condition_is_refused(state: np.ndarray) -> None:
    with pytest.raises(CertificateError, match=r"1 of \d+ conditions fail\n.*smallest normal force"):
        certify(
            travelling(0.7, -1), state, [Residual("smallest normal force", 0.0, -2.0, np.inf), Residual("ok", 0, 1, 2)]
        )


def test_a_refusal_carries_every_row_that_was_checked(state: np.ndarray) -> None:
    with pytest.raises(CertificateError) as caught:
        certify(travelling(0.7, -1), state, [Residual("friction", 0.0, 0.7, 0.6)])
    violated = [row.name for row in caught.value.rows if row.violation > 0]
    assert violated == ["friction"]
    assert "spectral radius plus its error bar" in [row.name for row in caught.value.rows]


def test_a_certificate_tells_what_it_computes(state: np.ndarray) -> None:
    told: list[str] = []
    certify(travelling(0.7, -1), state, progress=lambda report: told.append(str(report)))
    assert told[:3] == [f"variational equations, tolerance {tolerance:g}" for tolerance in (1e-8, 1e-10, 1e-12)]
    assert told[3] == "differences, step 0.0001, state 1 of 5"  # whether a larger one is worth it is seen from this one


def test_a_state_that_is_not_a_fixed_point_is_refused(state: np.ndarray) -> None:
    with pytest.raises(CertificateError, match="residual of the fixed point"):
        certify(travelling(0.7, -1), state + np.array([0, 1e-3, 0, 0, 0]))


def test_an_unstable_orbit_has_no_contraction_bound() -> None:
    """A deviation that grows by 1.5 in every cycle."""
    state = ca.SX.sym("x", 2)
    stride = Domain.from_expressions("stride", state, ca.vertcat(1, 0))
    step = Transition.from_expressions("stride", "stride", state, state[0] - 1, ca.vertcat(0, 1.5 * state[1]), +1)
    certificate = assess(HybridSystem([stride], [step], (), ("phase", "deviation")), np.zeros(2))
    assert certificate.radius == pytest.approx(1.5)
    assert certificate.bound is None
    assert certificate.to_dict()["contraction_bound"] is None


@pytest.mark.parametrize("steps", [(1e-4,), (1e-4, 1e-4), (1e-4, 0.0)])
def test_a_sweep_takes_two_steps(state: np.ndarray, steps: tuple[float, ...]) -> None:
    with pytest.raises(InputError, match="at least two different positive steps"):
        difference_check(travelling(0.7, -1), state, steps)


def test_steps_that_do_not_come_back_are_skipped(state: np.ndarray) -> None:
    found = difference_check(travelling(0.7, -1), state, (2.0, 1e-4, 1e-5), time_limit=2.0)
    assert (found.step, len(found.sweep)) == (1e-5, 1)
    found = difference_check(travelling(0.7, -1), state, (2.5, 2.0, 1e-4, 1e-5), time_limit=2.0)
    assert [distance for _, distance in found.sweep[:2]] == [np.inf, np.inf]
    assert found.step == 1e-5


def test_a_first_step_that_is_too_large_is_left_out(state: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    """One of its columns shows that the sweep comes to the same without it; one that agrees is taken."""
    steps, system = (0.1, 1e-4, 1e-5), travelling(0.7, -1)
    found = difference_check(system, state, steps)
    agreeing = difference_check(system, state, (1e-3, 1e-4, 1e-5))
    monkeypatch.setattr(poincare, "_useless", lambda *_: False)
    whole = difference_check(system, state, steps)
    assert found.sweep == whole.sweep[1:]
    assert found.step == whole.step
    assert np.array_equal(found.matrix, whole.matrix)
    assert agreeing.sweep == difference_check(system, state, (1e-3, 1e-4, 1e-5)).sweep


def test_a_step_that_did_not_come_back_is_written_as_none(state: np.ndarray) -> None:
    """JSON has no infinity, and a granted certificate must be written."""
    certificate = assess(travelling(0.7, -1), state)
    sweep = ((1e-1, np.inf), *certificate.differences.sweep)
    tree = replace(certificate, differences=replace(certificate.differences, sweep=sweep)).to_dict()
    assert tree["jacobians"]["difference_sweep"][0] == [1e-1, None]
    json.dumps(tree, allow_nan=False)
