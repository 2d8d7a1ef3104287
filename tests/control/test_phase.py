"""The phase variable: its rates against differences, its registry, and a phase of the configuration as an example."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np
import pytest
from examples.extending.phase_configuration import ConfigurationPhase

from amble.control.phase import (
    LATEST_PHASE,
    PHASES,
    DomainPhase,
    Phase,
    PhaseNumber,
    TimePhase,
)
from amble.errors import InputError, UnknownNameError
from amble.hybrid import Stance
from amble.robot import Robot
from tests.robots import robot

STANCE = Stance("D1", ("fl", "rr"))


@dataclass(frozen=True)
class Mixed(Phase):
    """A phase of time and configuration together."""

    name: ClassVar[str] = "mixed"

    @property
    def numbers(self) -> tuple[PhaseNumber, ...]:
        return (PhaseNumber("slope", "1/rad"),)

    def value(self, robot: Robot, stance: Stance, share: ca.SX, q: ca.SX, numbers: ca.SX) -> ca.SX:
        del robot, stance
        return share**2 * ca.sin(q[3]) + numbers[0] * q[4] * q[7] + share


def test_rates_are_those_of_differences_along_a_motion() -> None:
    model, random, T = robot("astro"), np.random.default_rng(0), 0.4
    q0, v0, a0 = random.normal(size=(3, model.size))
    domain = DomainPhase(phase=Mixed(), robot=model, stance=STANCE)
    symbols = [ca.SX.sym("share"), ca.SX.sym("q", model.size), ca.SX.sym("v", model.size)]
    rates = domain.rates(symbols[0], ca.SX(T), symbols[1], symbols[2], ca.SX(0.7))
    function = ca.Function("rates", symbols, [rates.value, rates.rate, rates.second(ca.SX(ca.DM(a0)))])

    def at(t: float) -> list[float]:
        moved = q0 + v0 * t + 0.5 * a0 * t**2
        return [float(part) for part in function((0.1 + t) / T, moved, v0 + a0 * t)]

    step = 1e-4
    before, here, after = at(-step), at(0.0), at(step)
    # truncation step^2 times derivatives of 1 to 100, rounding 1e-16 / step
    assert here[1] == pytest.approx((after[0] - before[0]) / (2.0 * step), abs=1e-5)
    assert here[2] == pytest.approx((after[1] - before[1]) / (2.0 * step), abs=1e-5)


def test_time_is_the_share_of_the_duration() -> None:
    model = robot("astro")
    share, T = ca.SX.sym("share"), ca.SX.sym("T")
    q, v = ca.SX.sym("q", model.size), ca.SX.sym("v", model.size)
    rates = DomainPhase(phase=TimePhase(), robot=model, stance=STANCE).rates(share, T, q, v, ca.SX(0, 1))
    assert not rates.by_state
    assert rates.bias.nnz() == 0
    value, rate = ca.Function("rates", [share, T], [rates.value, rates.rate])(0.3, 0.4)
    assert (float(value), float(rate)) == (0.3, 2.5)
    assert TimePhase().breakpoints(STANCE, 0.4) == (LATEST_PHASE * 0.4,)
    assert TimePhase().measured(model, STANCE, q, q).numel() == 0


def test_a_phase_is_rebuilt_from_its_name_and_parameters() -> None:
    phase = ConfigurationPhase({"D1": {"y": -1.0, "roll": 0.5}})
    again = PHASES.build(phase.name, phase.parameters)
    assert again == phase
    assert hash(again) == hash(phase)
    assert PHASES.build("time", {}) == TimePhase()


def test_what_is_not_registered_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown phase 'sundial'; known: time"):
        PHASES.build("sundial", {})
    with pytest.raises(UnknownNameError, match="unknown parameter of phase 'time' 'speed'; known: none"):
        PHASES.build("time", {"speed": 1.0})


def test_two_phases_cannot_share_a_name() -> None:
    @dataclass(frozen=True)
    class Other(Mixed):
        name: ClassVar[str] = "time"

    with pytest.raises(InputError, match="there is another phase of the name 'time'"):
        PHASES.register("time", Other)
    assert PHASES.build("time", {}) == TimePhase()


def test_the_example_begins_at_zero_and_ends_at_one_wherever_the_robot_walks() -> None:
    model, random = robot("astro"), np.random.default_rng(1)
    first, last = random.normal(0.0, 0.3, (2, model.size))
    domain = DomainPhase(phase=ConfigurationPhase({"D1": {"y": -1.0, "roll": 0.5}}), robot=model, stance=STANCE)
    numbers = domain.measured(first, last)
    shifted = np.zeros(model.size)
    shifted[:2] = 3.0, -2.0
    for q, expected in ((first, 0.0), (last, 1.0), (first + shifted, 0.0)):
        value = domain.phase.value(model, STANCE, ca.SX(0.4), ca.SX(ca.DM(q)), ca.SX(ca.DM(numbers)))
        assert float(ca.evalf(value)) == pytest.approx(expected, abs=1e-12)  # coordinates of 3 over a range of 0.1


def test_a_phase_that_does_not_grow_is_refused() -> None:
    model = robot("astro")
    domain = DomainPhase(phase=ConfigurationPhase({"D1": {"roll": 1.0}}), robot=model, stance=STANCE)
    q, v = np.zeros((2, 3, model.size))
    q[:, 3], v[:, 3] = (0.0, 0.1, 0.2), (1.0, -0.5, 1.0)
    with pytest.raises(InputError, match="'configuration' does not grow all along domain 'D1'"):
        domain.along(np.array([0.0, 0.1, 0.2]), 0.2, q, v, domain.measured(q[0], q[-1]))


def test_a_form_without_coordinates_is_refused() -> None:
    with pytest.raises(InputError, match="the phase of domain 'D2' has no coordinate"):
        ConfigurationPhase({"D1": {"y": 1.0}, "D2": {}})
    with pytest.raises(UnknownNameError, match="unknown coordinate 'tail'"):
        ConfigurationPhase({"D1": {"tail": 1.0}}).value(
            robot("astro"), STANCE, ca.SX(0.0), ca.SX(robot("astro").size, 1), ca.SX(2, 1)
        )
