"""Actuator models against numbers worked out by hand."""

import numpy as np
import pytest

from amble.control.actuator import ACTUATORS, DATASHEET, PAPER, Actuator
from amble.errors import InputError, UnknownNameError


def test_paper_model_by_hand() -> None:
    # 1.74 = 6 * 0.29, so one ampere gives 1.74 N m at the joint and costs 0.55 W.
    assert PAPER.heat(1.74) == pytest.approx(0.55, rel=1e-14)
    assert PAPER.power(-1.74, 2.0) == pytest.approx(0.55, rel=1e-14)
    assert PAPER.power(-1.74, -2.0) == pytest.approx(0.55 + 3.48, rel=1e-14)


@pytest.mark.parametrize(("rms", "heat"), [(7.932, 137.2), (9.659, 203.4)])
def test_heat_identity_of_the_paper(rms: float, heat: float) -> None:
    """Twelve actuators at the paper's RMS torque lose the power of docs/theory/energy.md, eq. 7."""
    # the published numbers have four digits
    assert float(np.sum(PAPER.heat(np.full(12, rms)))) == pytest.approx(heat, rel=5e-4)


def test_whole_gear_chain_divides_heat_by_the_square_of_the_built_in_gear() -> None:
    assert PAPER.heat(3.0) / DATASHEET.heat(3.0) == pytest.approx(6.2**2, rel=1e-12)


@pytest.mark.parametrize("model", ACTUATORS.entries, ids=lambda model: model.name)
def test_power_is_never_below_heat_and_keeps_the_shape(model: Actuator) -> None:
    random = np.random.default_rng(1)
    torque, speed = random.normal(size=(2, 7, 12))
    power = model.power(torque, speed)
    assert power.shape == (7, 12)
    absorbing = torque * speed <= 0.0
    assert np.array_equal(power[absorbing], model.heat(torque)[absorbing])
    assert np.all(power[~absorbing] > model.heat(torque)[~absorbing])
    assert np.allclose(model.power(2.0 * torque, 2.0 * speed), 4.0 * power, rtol=1e-14, atol=0.0)


def test_lookup() -> None:
    assert ACTUATORS["paper"] is PAPER
    with pytest.raises(UnknownNameError, match="known: paper, datasheet"):
        ACTUATORS["servo"]


def test_joints_may_have_motors_of_their_own() -> None:
    """Two motors by hand: 1 N m costs 0.5 / (2 * 0.1)^2 = 12.5 W at the knee, 0.2 / (10 * 0.1)^2 = 0.2 W elsewhere."""
    knee = Actuator("knee", 0.1, 0.5, 2.0, "a test")
    model = Actuator("leg", 0.1, 0.2, 10.0, "a test", joints={"knee": knee})
    joints = ("hip", "knee")
    assert model.heat_coefficients(joints) == pytest.approx([0.2, 12.5], rel=1e-14)
    assert model.heat([[1.0, 1.0], [2.0, 0.0]], joints) == pytest.approx(np.array([[0.2, 12.5], [0.8, 0.0]]))
    assert model.power([1.0, -1.0], [3.0, 3.0], joints) == pytest.approx([3.2, 12.5])
    assert (model.fits(joints), model.fits(("hip",))) == (True, False)
    assert Actuator(**model.fields) == model
    assert hash(Actuator(**model.fields)) == hash(model)
    assert "joints" not in knee.fields
    for joints in ((), ("hip", "ankle")):
        with pytest.raises(UnknownNameError, match="joint 'knee'"):
            model.heat([1.0, 1.0], joints)
    for wrong, words in (
        (3.0, "are 3.0, not a motor"),
        ({"knee": model}, "'knee' has joints of its own"),
        ({"knee": {"name": "bare"}}, "joint 'knee' is no actuator model"),
        ({"knee": 3.0}, "joint 'knee' is no actuator model"),
    ):
        with pytest.raises(InputError, match=words):
            Actuator("leg", 0.1, 0.2, 10.0, "a test", joints=wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf")])
def test_numbers_no_motor_has_are_refused(bad: float) -> None:
    with pytest.raises(InputError, match="gear_ratio"):
        Actuator("broken", 0.29, 0.55, bad, "nowhere")
