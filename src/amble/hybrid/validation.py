"""Whether the parts of a hybrid system are what they must be: functions (t, x, p), its graph, its numbers."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import casadi as ca

from amble.errors import InputError

if TYPE_CHECKING:
    from amble.hybrid.system import Domain, HybridSystem, Invariant, Symmetry, Transition

FIELD_ARGUMENTS = ("t", "x", "p")

_OUTPUT = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", re.ASCII)
_RESERVED = ("null", "jac", "hess")
"""Words that casadi keeps for itself."""


def arguments(state: ca.SX, clock: ca.SX | None, parameters: ca.SX | None) -> list[ca.SX]:
    """Return the symbols t, x, p, with new ones for a clock or parameters that are not given.

    Raises:
        InputError: one of them is no symbol of casadi's kind SX.
    """
    given = {"clock": clock, "state": state, "parameters": parameters}
    for what, symbol in given.items():
        if symbol is not None and not (isinstance(symbol, ca.SX) and symbol.is_valid_input() and symbol.is_dense()):
            raise InputError(f"the {what} is no symbol of kind SX (ca.SX.sym) but {_kind(symbol)}")
    clock = ca.SX.sym("t") if clock is None else clock
    if not clock.is_scalar():
        raise InputError(f"the clock is a scalar symbol, not one of {clock.numel()}")
    return [clock, state, ca.SX.sym("p", 0) if parameters is None else parameters]


def function(name: str, what: str, symbols: list[ca.SX], results: Mapping[str, Any]) -> ca.Function:
    """Build a function (t, x, p) -> results, dense.

    Args:
        name: casadi's name of the function.
        what: the same in words, for the sentence.
        symbols: t, x, p.
        results: name -> expression.

    Raises:
        InputError: a name is no word, an expression is not of casadi's kind SX, or it holds a symbol that is not among
            the symbols.
    """
    for label in results:
        if not isinstance(label, str) or not _OUTPUT.fullmatch(label) or label.lower() in _RESERVED:
            raise InputError(f"the {what} cannot be called {label!r}: a word of letters, digits and single underscores")
    expressions = [_expression(what, value) for value in results.values()]
    allowed = {element.element_hash() for symbol in symbols for element in ca.vertsplit(ca.vec(symbol))}
    foreign = [s.name() for s in ca.symvar(ca.veccat(*expressions)) if s.element_hash() not in allowed]
    if foreign:
        raise InputError(f"the {what} holds the symbol '{foreign[0]}', which is neither clock, state nor parameter")
    if len(allowed) < sum(symbol.numel() for symbol in symbols):
        raise InputError(f"the symbols of the {what} occur twice among clock, state and parameters")
    return ca.Function(name, symbols, expressions, list(FIELD_ARGUMENTS), list(results))


def _expression(what: str, value: Any) -> ca.SX:
    if isinstance(value, ca.MX):
        raise InputError(f"the {what} is no expression of kind SX but {_kind(value)}")
    try:
        return ca.densify(ca.vertcat(*value) if isinstance(value, (list, tuple)) else ca.SX(value))
    except (NotImplementedError, TypeError, RuntimeError):
        raise InputError(f"the {what} is no expression of kind SX but {_kind(value)}") from None


def _kind(value: Any) -> str:
    if isinstance(value, ca.MX):
        return "of kind MX"
    if isinstance(value, ca.SX):
        return "an expression or sparse"
    return f"a {type(value).__name__}"


def validate(system: HybridSystem) -> None:
    """Raise InputError where the graph or the shapes do not fit together."""
    names = [domain.name for domain in system.domains]
    if not names:
        raise InputError("a hybrid system needs at least one domain")
    if len(set(names)) != len(names):
        raise InputError(f"domain names occur twice: {names}")
    size = system.state_size
    for domain in system.domains:
        _validate_domain(system, domain)
    for transition in system.transitions:
        _validate_transition(system, transition)
    for symmetry in system.symmetries:
        _validate_symmetry(symmetry, size)
    reached = _reachable(system, names[0])
    for name in names:
        if name not in reached:
            raise InputError(f"domain '{name}' cannot be reached from '{names[0]}'")
    for invariant in system.invariants:
        _validate_invariant(invariant, size)
    _validate_names(system)


def _validate_names(system: HybridSystem) -> None:
    if len(system.state_names) != system.state_size:
        raise InputError(f"{len(system.state_names)} state names for {system.state_size} states")
    for what, given in (("state", system.state_names), ("symmetry", [known.name for known in system.symmetries])):
        twice = [name for number, name in enumerate(given) if name in given[:number]]
        if twice:
            raise InputError(f"the {what} name '{twice[0]}' occurs twice")


def _validate_invariant(invariant: Invariant, size: int) -> None:
    called = invariant.function
    if called.n_in() != 1 or (called.numel_in(0), called.numel_out(0)) != (size, 1):
        raise InputError(f"invariant '{invariant.name}' is no function of {size} states with one value")


def _validate_symmetry(symmetry: Symmetry, size: int) -> None:
    generator = symmetry.generator
    if (generator.numel_in(0), generator.numel_out(0)) != (size, size):
        raise InputError(
            f"the generator of symmetry '{symmetry.name}' maps {generator.numel_in(0)} states to "
            f"{generator.numel_out(0)} rates, not {size} of each"
        )


def _validate_transition(system: HybridSystem, transition: Transition) -> None:
    size = system.state_size
    source = system.domain(transition.source)
    system.domain(transition.target)
    if transition.direction not in (-1, 1):
        raise InputError(f"direction of '{transition.name}' is {transition.direction}; known: -1, +1")
    if not transition.dead_time >= 0:
        raise InputError(f"the dead time of '{transition.name}' is {transition.dead_time:g} s, below 0")
    if not transition.slope_bound > 0:
        raise InputError(f"the slope bound of '{transition.name}' is {transition.slope_bound:g}, not above 0")
    _expect_shape(f"guard of '{transition.name}'", transition.guard, size, 1)
    _expect_shape(f"reset of '{transition.name}'", transition.reset, size, size)
    for what, called in (("guard", transition.guard), ("reset", transition.reset)):
        if called.numel_in(2) != source.parameters.size:
            raise InputError(
                f"the {what} of '{transition.name}' takes {called.numel_in(2)} parameters, and domain "
                f"'{source.name}' has {source.parameters.size}"
            )


def _validate_domain(system: HybridSystem, domain: Domain) -> None:
    size = system.state_size
    _expect_shape(f"field of domain '{domain.name}'", domain.field, size, size)
    if domain.admissibility is not None:
        _expect_shape(f"margin of domain '{domain.name}'", domain.admissibility, size, 1)
    for what, margin in domain.margins.items():
        _expect_shape(f"margin '{what}' of domain '{domain.name}'", margin, size, 1)
    for what, called in (("signals", domain.signals), ("jacobian", domain.jacobian)):
        if called is not None:
            _expect_state(f"{what} of domain '{domain.name}'", called, size)
    if domain.field.numel_in(2) != domain.parameters.size:
        raise InputError(
            f"domain '{domain.name}' has {domain.parameters.size} parameters, not {domain.field.numel_in(2)}"
        )
    if not all(earlier < later for earlier, later in itertools.pairwise((0.0, *domain.breakpoints))):
        raise InputError(
            f"the breakpoints of domain '{domain.name}' are not positive and ascending: {domain.breakpoints}"
        )
    if not system.leaving(domain.name):
        raise InputError(f"domain '{domain.name}' has no transition that leaves it")


def _expect_shape(what: str, function: ca.Function, size_in: int, size_out: int) -> None:
    expect_arguments(what, function)
    if function.numel_in(1) != size_in or function.numel_out(0) != size_out:
        raise InputError(
            f"the {what} maps {function.numel_in(1)} states to {function.numel_out(0)} values, "
            f"not {size_in} to {size_out}"
        )


def _expect_state(what: str, function: ca.Function, size: int) -> None:
    expect_arguments(what, function)
    if function.numel_in(1) != size:
        raise InputError(f"the {what} takes {function.numel_in(1)} states, not {size}")


def expect_arguments(what: str, function: ca.Function) -> None:
    """Raise InputError where a function does not take (t, x, p)."""
    if function.n_in() != len(FIELD_ARGUMENTS):
        raise InputError(f"the {what} takes {function.n_in()} arguments, not (t, x, p)")


def _reachable(system: HybridSystem, start: str) -> set[str]:
    reached, frontier = {start}, [start]
    while frontier:
        for transition in system.leaving(frontier.pop()):
            if transition.target not in reached:
                reached.add(transition.target)
                frontier.append(transition.target)
    return reached
