"""Fields given by expressions: what else a system says of them is not believed."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from flint import arb

from amble.hybrid import Domain, HybridSystem, Transition
from amble.proof import ProofError, Settings, prove
from amble.proof.arithmetic import working_precision
from amble.proof.explicit_field import ExplicitField
from amble.proof.return_map import ReturnMap

SETTINGS = Settings(order=10, basin=0.0)
T, X, P = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 0)
PHASE, SIZE = ca.vertsplit(X)


def growing(**changes: object) -> HybridSystem:
    """A clock and a size that grows by e in every cycle."""
    domain = Domain.from_expressions("stride", X, ca.vertcat(1, SIZE))
    step = Transition.from_expressions("stride", "stride", X, PHASE - 1, ca.vertcat(0, SIZE), +1)
    return HybridSystem([replace(domain, **changes)], [step], (), ("phase", "size"))  # type: ignore[arg-type]


def test_a_jacobian_of_the_system_is_not_believed() -> None:
    """Before, this orbit was proved to be stable, with the derivative that the domain says it has."""
    false = ca.Function("jacobian", [T, X, P], [ca.diag(ca.vertcat(0, -1))], ["t", "x", "p"], ["slope"])
    proof = prove(growing(jacobian=false), np.zeros(2), SETTINGS)
    assert not proof.stable
    assert proof.proved.unstable is not None
    assert float(proof.proved.unstable) == pytest.approx(np.e, abs=1e-9)


def test_margins_beside_the_fall_are_asked_for_too() -> None:
    """Before, margins of a domain beside its admissibility were not looked at."""
    kept, left = (
        ca.Function("margin", [T, X, P], [value], ["t", "x", "p"], ["margin"]) for value in (2 - PHASE, 0.5 - PHASE)
    )
    proof = prove(growing(margins={"too far": kept}), np.zeros(2), SETTINGS)
    (margins,) = proof.proved.margins
    assert 0.9 < float(margins["'too far'"]) <= 1.0
    with working_precision(128), pytest.raises(ProofError, match="margin of 'too far' is only known to be above"):
        ReturnMap.of(growing(margins={"too far": left}), 10, 1e-25)([arb(0)] * 2, [arb(1e-19)] * 2)


def test_sparse_arguments_and_results_are_those_of_their_places() -> None:
    """A function whose state has no place for its first entry reads the second one."""
    x = ca.SX.sym("x", ca.Sparsity.triplet(3, 1, [2], [0]))
    rate = ca.SX(3, 1)
    rate[1] = 5 * x[2]
    field = ca.Function("field", [T, x, P], [rate], ["t", "x", "p"], ["rate"])
    with working_precision(128):
        found = ExplicitField.of(Domain(name="d", field=field))
        part = found.part(arb(0), [arb(1), arb(2), arb(3)])
        assert [float(value) for value in part.rate] == [0.0, 15.0, 0.0]
        assert float(found.slope(part)[1, 2]) == 5.0
        assert [float(row[1]) for row in found.polynomial(arb(0), part.box, 2)] == [0.0, 15.0, 0.0]
