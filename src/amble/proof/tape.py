"""A casadi function as a list of operations, evaluated on balls or on power series of balls.

The expressions themselves are evaluated, in casadi's order; nothing is compiled, so what the compiler or libm does has
no part in a proof. A switch (a comparison, a minimum, a maximum) must be decided for every number in the balls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca
from flint import arb, arb_series

from amble.errors import InputError, WorkError

Value: TypeAlias = arb | arb_series


class UndecidedError(WorkError):
    """A switch of an expression, or whether a divisor is 0, could not be decided for all numbers of a ball."""


NOT_ENCLOSED = (UndecidedError, ZeroDivisionError, ValueError)
"""What an operation on balls raises where its result has no bounds: python-flint's own errors are of the last two."""


LARGEST_PRODUCT = 64
"""A larger power is computed by logarithm and exponential."""


def _leading(value: Value) -> arb:
    return value[0] if isinstance(value, arb_series) else value


def _decided(truth: bool, contrary: bool, what: str) -> bool:
    if truth == contrary:
        raise UndecidedError(f"a switch in the model ({what}) cannot be decided on the enclosure")
    return truth


def _less(a: Value, b: Value) -> Value:
    return arb(int(_decided(_leading(a) < _leading(b), _leading(a) >= _leading(b), "<")))


def _less_or_equal(a: Value, b: Value) -> Value:
    return arb(int(_decided(_leading(a) <= _leading(b), _leading(a) > _leading(b), "<=")))


def _smaller(a: Value, b: Value) -> Value:
    return a if _decided(_leading(a) <= _leading(b), _leading(a) >= _leading(b), "min") else b


def _larger(a: Value, b: Value) -> Value:
    return a if _decided(_leading(a) >= _leading(b), _leading(a) <= _leading(b), "max") else b


def _size(a: Value) -> Value:
    return a if _decided(_leading(a) >= 0, _leading(a) <= 0, "absolute value") else -a


def _sign(a: Value) -> Value:
    return arb(1 if _decided(_leading(a) > 0, _leading(a) < 0, "sign") else -1)


def _opposite(a: Value) -> Value:
    return arb(int(_decided(_leading(a) == 0, _leading(a) != 0, "not")))


def _where(condition: Value, value: Value) -> Value:
    return arb(0) if _decided(_leading(condition) == 0, _leading(condition) != 0, "if") else value


def _quotient(a: Value, b: Value) -> Value:
    """Divide by what is not 0: where both series begin with 0 their quotient would lack the last coefficient."""
    if not _leading(b) != 0:
        raise UndecidedError("a divisor in the model may be 0 on the enclosure")
    return a / b


def _fixed(value: Value) -> bool:
    """Whether a value is a number: a series whose coefficients behind the first are 0."""
    return isinstance(value, arb) or all(value[number] == 0 for number in range(1, len(value)))


def _power(base: Value, exponent: Value) -> Value:
    power = _leading(exponent).unique_fmpz() if _fixed(exponent) else None
    if power is None or abs(int(power)) > LARGEST_PRODUCT or not _leading(exponent).is_integer():
        return (base.log() * exponent).exp()
    count = int(power)
    product: Value = arb(1)
    for _ in range(abs(count)):
        product = product * base
    return _quotient(arb(1), product) if count < 0 else product


OPERATIONS: dict[int, Callable[..., Value]] = {
    ca.OP_ASSIGN: lambda a: a,
    ca.OP_ADD: lambda a, b: a + b,
    ca.OP_SUB: lambda a, b: a - b,
    ca.OP_MUL: lambda a, b: a * b,
    ca.OP_DIV: _quotient,
    ca.OP_NEG: lambda a: -a,
    ca.OP_INV: lambda a: _quotient(arb(1), a),
    ca.OP_SQ: lambda a: a * a,
    ca.OP_TWICE: lambda a: a + a,
    ca.OP_SQRT: lambda a: a.sqrt(),
    ca.OP_SIN: lambda a: a.sin(),
    ca.OP_COS: lambda a: a.cos(),
    ca.OP_TAN: lambda a: a.tan(),
    ca.OP_ASIN: lambda a: a.asin(),
    ca.OP_ACOS: lambda a: a.acos(),
    ca.OP_ATAN: lambda a: a.atan(),
    ca.OP_EXP: lambda a: a.exp(),
    ca.OP_LOG: lambda a: a.log(),
    ca.OP_POW: _power,
    ca.OP_CONSTPOW: _power,
    ca.OP_TANH: lambda a: 1 - 2 / ((a + a).exp() + 1),
    ca.OP_FABS: _size,
    ca.OP_SIGN: _sign,
    ca.OP_LT: _less,
    ca.OP_LE: _less_or_equal,
    ca.OP_NOT: _opposite,
    ca.OP_IF_ELSE_ZERO: _where,
    ca.OP_FMIN: _smaller,
    ca.OP_FMAX: _larger,
}


@dataclass(frozen=True)
class Tape:
    """The operations of one function.

    Attributes:
        steps: (casadi's code of the operation, number of the result's place, numbers of the operands' places) in order.
        constants: (place, number).
        inputs: (place, number of the argument, number of its entry).
        outputs: result -> for every entry its place.
        places: how many there are.
    """

    steps: tuple[tuple[int, int, tuple[int, ...]], ...]
    constants: tuple[tuple[int, float], ...]
    inputs: tuple[tuple[int, int, int], ...]
    outputs: tuple[tuple[int, ...], ...]
    places: int

    def __call__(self, *arguments: Sequence[Value]) -> list[list[Value]]:
        """Return the nonzero entries of every result, dense ones by columns.

        Args:
            arguments: the entries of every argument.

        Raises:
            UndecidedError: a switch cannot be decided for all numbers of the balls.
        """
        place: list[Value] = [arb(0)] * self.places
        for where, constant in self.constants:
            place[where] = arb(constant)
        for where, argument, entry in self.inputs:
            place[where] = arguments[argument][entry]
        for code, where, operands in self.steps:
            if len(operands) == 2:
                place[where] = OPERATIONS[code](place[operands[0]], place[operands[1]])
            else:
                place[where] = OPERATIONS[code](place[operands[0]])
        return [[place[where] for where in result] for result in self.outputs]

    def balls(self, *arguments: Sequence[arb]) -> list[list[arb]]:
        """Return the same for arguments that are balls, not series."""
        return [[_leading(value) for value in result] for result in self(*arguments)]

    def listing(self) -> str:
        """Return all of it as text that is the same for the same expressions: constants are written exactly."""
        constants = [(where, value.hex()) for where, value in self.constants]
        return repr((self.steps, constants, self.inputs, self.outputs, self.places))


def record(function: ca.Function) -> Tape:
    """Return the tape of a function; every instruction gets a place of its own.

    Raises:
        InputError: it calls compiled code or holds an operation that has no enclosure here.
    """
    expanded = _expanded(function)
    entries = [expanded.sparsity_in(k).find() for k in range(expanded.n_in())]
    current: dict[int, int] = {}
    steps, constants, inputs = [], [], []
    outputs = [[-1] * expanded.nnz_out(k) for k in range(expanded.n_out())]
    count = 0
    for k in range(expanded.n_instructions()):
        kind, into = expanded.instruction_id(k), expanded.instruction_output(k)
        operands = expanded.instruction_input(k)
        if kind == ca.OP_OUTPUT:
            outputs[into[0]][into[1]] = current[operands[0]]
            continue
        if kind == ca.OP_CONST:
            constants.append((count, float(expanded.instruction_constant(k))))
        elif kind == ca.OP_INPUT:
            inputs.append((count, operands[0], entries[operands[0]][operands[1]]))
        elif kind in OPERATIONS:
            steps.append((kind, count, tuple(current[number] for number in operands)))
        else:
            raise InputError(f"function '{function.name()}' holds {_named(kind)}, an operation that cannot be enclosed")
        current[into[0]] = count
        count += 1
    return Tape(tuple(steps), tuple(constants), tuple(inputs), tuple(map(tuple, outputs)), count)


def expression(function: ca.Function, symbols: Sequence[ca.SX]) -> ca.SX:
    """Return the first result of a function of symbols, dense.

    Raises:
        InputError: it calls compiled code.
    """
    return ca.densify(_expanded(function).call(list(symbols))[0])


def _named(kind: int) -> str:
    """Return the name that casadi has for an operation."""
    return next((name[3:].lower() for name, code in vars(ca).items() if name.startswith("OP_") and code == kind), "?")


def _expanded(function: ca.Function) -> ca.Function:
    try:
        return function.expand()
    except RuntimeError:
        raise InputError(
            f"function '{function.name()}' is no expression but compiled code, which cannot be enclosed"
        ) from None
