"""Casadi functions (t, x, p) from symbols and expressions, with one sentence for what is no such expression."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import casadi as ca

from amble.errors import InputError

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
