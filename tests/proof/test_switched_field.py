"""Fields in stretches of the clock: motions are followed to every breakpoint exactly, and none is stepped over."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import casadi as ca
import numpy as np
import pytest
from flint import arb

from amble.control.loop_equations import LoopEquations
from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.proof.arithmetic import working_precision
from amble.proof.leg import Leg
from amble.proof.loop_field import LoopField
from amble.proof.loop_tapes import LoopTapes
from amble.proof.return_map import ReturnMap
from amble.proof.step import StepError
from amble.proof.switched_field import SwitchedField

MARKS = 0.1, 0.375, 0.7
PUSHES = 1.0, -2.0, 0.5, 3.0
RATE, FAR = 2.0, 1.75


def pushed(pushes: tuple[float, ...] = PUSHES, ends: tuple[float, ...] = (*MARKS, inf)) -> SwitchedField:
    """A unit mass, q'' = p - v with another push p in every stretch."""
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 1)
    loop = LoopEquations(matrix=ca.SX.eye(1), right=p - x[1], load=1.0, accelerations=1, torques=0, forces=0)
    tapes = LoopTapes.of(loop, [t, x, p], np.array(pushes[:1]))
    fields = [LoopField(tapes.at(np.array([push]))) for push in pushes]
    return SwitchedField(tuple(fields), tuple(map(arb, ends)))


def marked() -> Domain:
    x = ca.SX.sym("x", 2)
    domain = Domain.from_expressions("slide", x, ca.vertcat(x[1], -x[1]))
    return replace(domain, breakpoints=MARKS)


def sliding() -> ReturnMap:
    """From q = 0 to q = FAR, through all stretches; put back to q = 0 with the rate that it has."""
    x = ca.SX.sym("x", 2)
    back = Transition.from_expressions("slide", "slide", x, x[0] - FAR, ca.vertcat(0, x[1]), +1)
    prepared = ReturnMap.of(HybridSystem([marked()], [back], state_names=("q", "v")), 16, 1e-22)
    return replace(prepared, legs=(replace(prepared.legs[0], field=pushed()),))


def exact(rate: arb) -> tuple[arb, arb]:
    """When q = FAR is reached, and the rate there: stretch by stretch in closed form, the last by Newton."""
    clock, q, v = arb(0), arb(0), rate
    for push, mark in zip(PUSHES, MARKS, strict=False):
        fading = (-(arb(mark) - clock)).exp()
        q, v, clock = q + push * (arb(mark) - clock) + (v - push) * (1 - fading), push + (v - push) * fading, arb(mark)
    push, after = PUSHES[-1], arb(0.1)
    for _ in range(8):
        fading = (-after).exp()
        late = q + push * after + (v - push) * (1 - fading) - arb(FAR)
        after = (after - late / (push + (v - push) * fading)).mid()
    return clock + after, push + (v - push) * (-after).exp()


def test_a_motion_through_all_stretches_is_that_in_closed_form() -> None:
    with working_precision(128):
        found = sliding()([arb(0), arb(RATE)], [arb(0), arb(1e-12)])
        clock, rate = exact(arb(RATE))
        assert clock > arb(MARKS[-1])
        assert found.arcs[0].duration.contains(clock)
        assert found.centre[1].overlaps(rate)
        assert float(found.centre[1].rad()) < 1e-19
        step = arb(2) ** -40  # central difference: its own error is about 1e-24, and 1e-26 of rounding
        slope = (exact(arb(RATE) + step)[1] - exact(arb(RATE) - step)[1]) / (2 * step)
        assert found.derivative[1, 1].overlaps(slope + arb(0, 1e-22))
        assert float(found.derivative[1, 1].rad()) < 1e-9
        glided = sliding().point([arb(0), arb(RATE)], [float(clock)])
        assert abs(float(glided[1] - rate)) < 1e-18


def test_other_stretches_are_another_motion() -> None:
    """So the test above sees which push is taken where."""
    with working_precision(128):
        prepared = sliding()
        field = pushed((1.0, -2.0, 0.5, 3.0 + 1e-12))
        found = replace(prepared, legs=(replace(prepared.legs[0], field=field),))([arb(0), arb(RATE)], [arb(0)] * 2)
        assert not found.centre[1].overlaps(exact(arb(RATE))[1])


def test_no_step_passes_a_breakpoint() -> None:
    field, state = pushed(), [arb(0), arb(1)]
    with working_precision(128):
        field.step(arb(0), state, state, arb(MARKS[0]), 8)
        for clock, length in ((0.0, 0.125), (0.05, 0.0625)):
            with pytest.raises(StepError, match="between two breakpoints"):
                field.step(arb(clock), state, state, arb(length), 8)
        with pytest.raises(StepError, match="between two breakpoints"):
            field.part(arb(MARKS[0], 1e-9), state)
        ending = pushed(PUSHES[:3], MARKS)
        assert float(ending.part(arb(MARKS[-1]), state).rate[1]) == PUSHES[2] - 1.0  # closed: a step may end there
        with pytest.raises(StepError, match="between two breakpoints"):
            ending.part(arb(0.75), state)


@pytest.mark.parametrize("ends", [(0.1, 0.7, 0.375, inf), (0.1, 0.1, 0.375, inf), (0.0, 0.1, 0.375, inf)])
def test_stretches_that_overlap_are_refused(ends: tuple[float, ...]) -> None:
    """The later of two that held at one clock was taken."""
    with pytest.raises(InputError, match="end at clocks that do not ascend"):
        pushed(ends=ends)


def test_at_a_breakpoint_the_motion_goes_on_with_the_next_stretch() -> None:
    with working_precision(128):
        for clock, push in zip((0.0, *MARKS), PUSHES, strict=True):
            assert float(pushed().polynomial(arb(clock), [arb(0), arb(0)], 3)[1][1]) == push


@pytest.mark.parametrize("bits", [64, 128, 181])
def test_clocks_are_exact_and_meet_every_breakpoint(bits: int) -> None:
    draws = np.random.default_rng(0)
    x = ca.SX.sym("x", 2)
    leave = Transition.from_expressions("slide", "slide", x, x[0] - FAR, x, +1)
    leg, met = Leg.of(marked(), leave), set[float]()
    with working_precision(bits):
        clock = arb(0)
        while clock < 0.9:
            length = leg.cut(clock, arb(draws.uniform(1e-3, 0.1)) / 3)
            assert length > 0
            clock = clock + length
            assert clock.is_exact()
            met |= {mark for mark in MARKS if clock == arb(mark)}
    assert met == set(MARKS)
