from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np
import pytest

from amble.codegen import compiled
from amble.codegen.compiler import compiler
from amble.errors import FallError, InputError, WorkError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import simulate
from amble.stability import difference_check, fixed_point, monodromy, poincare_map
from amble.types import Matrix, Vector
from tests.hybrids import bouncing_ball, two_phases

START = np.array([0.0, 1.0, 0.2])


def test_both_derivatives_agree_on_a_system_that_has_everything() -> None:
    system = two_phases()
    there = monodromy(system, START)
    differences = difference_check(system, START)
    assert differences.disagreement < 1e-7
    assert differences.matrix == pytest.approx(there.matrix, abs=1e-8)
    assert there.image == pytest.approx(poincare_map(system, START), abs=1e-11)
    assert there.factors[1] @ there.factors[0] == pytest.approx(there.matrix, abs=1e-14)
    assert there.period == pytest.approx(simulate(system, START, 1, 1e-12).events[-1].time, abs=1e-11)


def saltation_product(system: HybridSystem, state: Vector) -> Matrix:
    """The textbook: the clock is a state; Phi in each domain, then D_x + (f+ - D_x f-) H_x / (H_x f-)."""
    size = system.state_size
    total, entry = np.eye(size + 1), state
    for (domain, leaving), (following, _) in zip(system.cycle(), [*system.cycle()[1:], system.cycle()[0]], strict=True):
        clock_free = simulate_domain(domain, leaving, entry)
        when, before, transported = clock_free
        t, x = ca.MX.sym("t"), ca.MX.sym("x", size)
        z = ca.vertcat(x, t)
        reset = ca.vertcat(leaving.reset(t, x, domain.parameters), 0)
        functions = [
            ca.Function("f", [t, x], [value])
            for value in (
                ca.jacobian(reset, z),
                ca.jacobian(leaving.guard(t, x, domain.parameters), z),
                ca.vertcat(domain.field(t, x, domain.parameters), 1),
            )
        ]
        reset_z, guard_z, rate = (np.asarray(function(when, before)) for function in functions)
        entry = np.asarray(leaving.reset(when, before, domain.parameters)).ravel()
        rate_after = np.append(np.asarray(following.field(0, entry, following.parameters)).ravel(), 1.0)[:, None]
        jump = reset_z + (rate_after - reset_z @ rate) @ guard_z / (guard_z @ rate)
        total = jump @ transported @ total
    return total


def simulate_domain(domain: Domain, leaving: Transition, entry: Vector) -> tuple[float, Vector, Matrix]:
    """Clock and state at the event, and the transition matrix of (x, clock) by scipy."""
    from scipy.integrate import solve_ivp

    size = entry.size
    t, x = ca.SX.sym("t"), ca.SX.sym("x", size)
    rate = domain.field(t, x, domain.parameters)
    slope = ca.Function("slope", [t, x], [ca.jacobian(ca.vertcat(rate, 1), ca.vertcat(x, t))])

    def right(clock: float, z: Vector) -> Vector:
        change = np.asarray(slope(clock, z[:size])) @ z[size:].reshape(size + 1, size + 1)
        return np.concatenate([np.asarray(domain.field(clock, z[:size], domain.parameters)).ravel(), change.ravel()])

    before = simulate(HybridSystem([domain], [dataclasses.replace(leaving, target=domain.name)]), entry, 1, 1e-13)
    when = before.events[0].time
    start = np.concatenate([entry, np.eye(size + 1).ravel()])
    end = solve_ivp(right, (0, when), start, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return when, end[:size], end[size:].reshape(size + 1, size + 1)


def test_the_multipliers_are_those_of_the_textbooks_saltation_matrices() -> None:
    system = two_phases()
    start = fixed_point(system, START).state
    ours = np.linalg.eigvals(monodromy(system, start).matrix)
    # the textbook's product has the flow direction as one more eigenvector, multiplier 1 (a cycle returns along it)
    theirs = np.linalg.eigvals(saltation_product(system, start))
    assert np.abs(theirs - 1).min() < 1e-9
    for value in ours[np.abs(ours) > 1e-6]:
        assert np.abs(theirs - value).min() < 1e-9


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_compiled_functions_need_their_derivatives() -> None:
    system = two_phases()
    domain = system.domains[0]
    plain = dataclasses.replace(domain, field=compiled(domain.field))
    with pytest.raises(InputError, match=r"'push' has no derivatives: give Domain\.jacobian"):
        monodromy(HybridSystem([plain, system.domains[1]], system.transitions), START)
    arguments = [ca.SX.sym(name, *domain.field.size_in(i)) for i, name in enumerate("txp")]
    slope = ca.Function("slope", arguments, [ca.jacobian(domain.field(*arguments), arguments[1])])
    for field in (
        dataclasses.replace(plain, jacobian=slope),
        dataclasses.replace(plain, field=compiled(domain.field, ["jac"])),
    ):
        other = HybridSystem([field, system.domains[1]], system.transitions)
        assert monodromy(other, START).matrix == pytest.approx(monodromy(system, START).matrix, abs=1e-12)
    blind = dataclasses.replace(system.transitions[0], reset=compiled(system.transitions[0].reset))
    with pytest.raises(InputError, match="reset of 'push->pull' has no derivatives"):
        monodromy(HybridSystem(system.domains, [blind, system.transitions[1]]), START)


def test_a_motion_that_does_not_come_back_is_a_fall() -> None:
    with pytest.raises(FallError, match="reached no guard"):
        monodromy(two_phases(), START, time_limit=0.01)
    with pytest.raises(FallError, match="reached no guard"):
        poincare_map(two_phases(), START, time_limit=0.01)
    with pytest.raises(FallError, match="fell"):
        monodromy(bouncing_ball(0.5, floor=3.0), np.array([0.0, 1.0]))


@pytest.mark.parametrize("below", [0.0, 1e-16])
@pytest.mark.parametrize("power", [2, 3])
def test_a_touched_guard_whose_gradient_vanishes_has_no_derivative(power: int, below: float) -> None:
    x = ca.SX.sym("x", 2)
    domain = Domain.from_expressions("arc", x, ca.vertcat(1, 0))
    touch = below - (1 - x[0]) ** power
    leaving = Transition.from_expressions("arc", "arc", x, touch, ca.vertcat(0, x[1]), +1)
    with pytest.raises(WorkError, match="grazes"):
        monodromy(HybridSystem([domain], [leaving]), np.zeros(2))


def test_a_grazed_guard_has_no_derivative() -> None:
    x = ca.SX.sym("x", 2)
    domain = Domain.from_expressions("arc", x, ca.vertcat(1, 0))
    grazing = Transition.from_expressions("arc", "arc", x, (x[0] - 1) ** 3 + x[1], ca.vertcat(0, x[1]), +1)
    with pytest.raises(WorkError, match="grazes"):
        monodromy(HybridSystem([domain], [grazing]), np.zeros(2))
