"""Translations that a system declares: those of the system are proved to be its symmetries, others are refused."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from flint import arb

from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Symmetry, Transition
from amble.hybrid.ground import Plane
from amble.proof import ProofError, Settings, prove
from amble.proof.arithmetic import working_precision
from amble.proof.invariance import rates, require_invariance, spanned
from amble.proof.orbit import prove_orbit, refined
from amble.proof.quotient import translations
from amble.proof.return_map import ReturnMap
from amble.proof.tape import record
from amble.stability import fixed_point
from tests.hybrids import travelling
from tests.proof import gaits

X = ca.SX.sym("x", 3)
PHASE, SIZE, LAG = ca.vertsplit(X)


def declared(
    rate: ca.SX | None = None, guard: ca.SX | None = None, after: ca.SX | None = None, margin: ca.SX | None = None
) -> HybridSystem:
    """A clock, a size and a lag; the size is declared as a translation. As it is given nothing sees it."""
    chosen = ca.vertcat(1, LAG, -LAG) if rate is None else rate
    stride = Domain.from_expressions("stride", X, chosen, admissibility=2 - PHASE if margin is None else margin)
    reset = ca.vertcat(0, SIZE, LAG + 0.1) if after is None else after
    step = Transition.from_expressions("stride", "stride", X, PHASE - 1 if guard is None else guard, reset, +1)
    z = ca.SX.sym("z", 3)
    along = Symmetry("size", ca.Function("along_size", [z], [ca.DM([0, 1, 0])]))
    return HybridSystem([stride], [step], [along], ("phase", "size", "lag"))


def test_an_unstable_system_is_not_stable_by_declaration() -> None:
    """The size grows by e in every cycle; without it what remains would be stable."""
    with pytest.raises(InputError, match=r"'size' is declared as a symmetry, but the vector field \(domain 'stride'\)"):
        prove(declared(rate=ca.vertcat(1, 1 + SIZE, -LAG)), np.zeros(3), Settings(order=10, basin=0.0))


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ({"rate": ca.vertcat(1, LAG, -LAG + 1e-9 * ca.sin(SIZE))}, "vector field"),
        ({"guard": PHASE - 1 - 0.01 * SIZE}, "guard of"),
        ({"after": ca.vertcat(0, SIZE, LAG + 0.1 * SIZE**2)}, "reset"),
        ({"after": ca.vertcat(0, ca.sin(SIZE), LAG)}, "reset"),
        ({"after": ca.vertcat(0, SIZE, LAG + 2 * SIZE)}, "reset"),
        ({"margin": 2 - PHASE + 1e-3 * SIZE}, "margin of admissibility"),
    ],
)
def test_what_sees_a_declared_translation_is_named(changed: dict[str, ca.SX], what: str) -> None:
    require(declared())
    require(declared(after=ca.vertcat(0, -0.5 * SIZE + LAG, LAG)))  # it need not be kept, only led to itself
    with pytest.raises(InputError, match=f"but the {what}"):
        require(declared(**changed))


def require(system: HybridSystem) -> None:
    prepared = ReturnMap.of(system, 10, 1e-20)
    require_invariance(system, prepared.legs, translations(system, np.zeros(system.state_size)))


def test_translations_of_a_gait_are_proved_along_its_whole_loop() -> None:
    prepared, state = gaits.loop()
    system, legs = prepared.system, prepared.legs
    along = translations(system, np.array([float(value) for value in state]))
    assert [symmetry.name for symmetry in system.symmetries] == ["x", "y"]
    require_invariance(system, legs, along)
    height = np.roll(along, 1, axis=0)
    with pytest.raises(InputError, match=r"'y' is declared .* guard of"):
        require_invariance(system, legs, height)


def test_rates_are_those_of_doubles() -> None:
    """A plane's gap along the plane is the same to the last bit that doubles do not have, and not along another."""
    plane = Plane(slope=0.1, heading=0.7)
    q, t, p = ca.SX.sym("q", 3), ca.SX.sym("t"), ca.SX.sym("p", 0)
    tape = record(
        ca.Function("gap", [t, q, p], [plane.gap(q), ca.sin(q[0] - q[1]), -(q[0] / 3.0) + 2 * q[2], q[0] * q[1]])
    )
    for translation in plane.translations.values():
        along = [Fraction(float(value)) for value in translation]
        (gap,), (sine,), (mixed,), (product,) = rates(tape, along)
        assert gap == 0
        assert sine is None
        assert mixed == -along[0] / 3 + 2 * along[2]
        assert product is None
        assert rates(tape, [along[0], along[1], Fraction(float(np.nextafter(translation[2], 1)))])[0][0] != 0
    assert rates(tape, [Fraction(1), Fraction(1), Fraction(0)])[1] == [0]


def test_what_is_found_to_change_at_a_rate_does() -> None:
    """Random expressions of sums, products and functions: where a rate is found, differences are that rate."""
    draws, found = np.random.default_rng(0), 0
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 4), ca.SX.sym("p", 0)
    for _ in range(100):
        terms = [*ca.vertsplit(x), ca.SX(float(draws.normal()))]
        for _ in range(6):
            one, other = (terms[int(k)] for k in draws.integers(0, len(terms), 2))
            kinds = [one + other, one - other, one * other, -one, ca.sin(one - other), 2 * one, one / (other**2 + 1)]
            terms.append(kinds[int(draws.integers(0, len(kinds)))])
        function = ca.Function("f", [t, x, p], [terms[-1]])
        along = draws.integers(-1, 2, 4)
        (rate,) = rates(record(function), [Fraction(int(value)) for value in along])[0]
        if rate is None:
            continue
        found += rate != 0
        start = draws.normal(size=4)
        moved = float(function(0, start + 0.5 * along, [])) - float(function(0, start, []))
        assert moved == pytest.approx(0.5 * float(rate), rel=1e-9, abs=1e-9 * (1 + abs(float(function(0, start, [])))))
    assert found > 10


def test_spans_are_those_of_rational_numbers() -> None:
    one, other = [Fraction(1), Fraction(0), Fraction(1, 3)], [Fraction(0), Fraction(1), Fraction(2)]
    assert spanned([Fraction(3), Fraction(-1), Fraction(-1)], [one, other])
    assert not spanned([Fraction(3), Fraction(-1), Fraction(-1) + Fraction(1, 10**40)], [one, other])
    assert spanned([Fraction(0)] * 3, [])


def test_a_turn_that_is_none_is_refused() -> None:
    """Its generator is taken out of the span of the symmetries, which the enclosed derivative shows."""
    system = travelling(0.0, -1)
    kept = HybridSystem(system.domains, system.transitions, system.symmetries[:2], system.state_names)
    z = ca.SX.sym("z", 5)
    turn = record(ca.Function("turn", [z], [ca.vertcat(0, 1e-6, -z[3], z[2], 1)]))
    with working_precision(128):
        prepared = replace(ReturnMap.of(kept, 14, 1e-22), turns=(turn,))
        centre = refined(prepared, fixed_point(kept, np.array([0.0, 0.2, 0.0, 0.0, 0.0])).state, 1e-18)
        with pytest.raises(ProofError, match="declared as a symmetry is none"):
            prove_orbit(prepared, centre, [arb(1e-15)] * 5)
