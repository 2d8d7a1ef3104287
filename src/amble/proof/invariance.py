"""Translations under which a system is invariant, proved on its expressions.

Along x + s xi every number that an expression computes on its way is given a rate: the rational number c where it is
known to change by exactly c s, whatever the state, and none where it is not. An argument changes by its entry of xi, a
sum by the sum of the rates, a multiple by a constant by that multiple; any other operation on operands that do not
change does not change. Constants are the rational numbers that doubles are, so nothing is rounded and a rate that is
found is one in real arithmetic.

If fields, guards and margins do not change and R(x + s xi) = R(x) + s Xi c for all resets R, every motion goes with its
translate, and the return map's derivative takes Xi into the span of Xi.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import isfinite
from typing import TypeAlias

import casadi as ca

from amble.errors import InputError
from amble.hybrid import HybridSystem
from amble.proof.leg import Leg
from amble.proof.tape import Tape
from amble.types import Matrix

Rate: TypeAlias = Fraction | None
STATE = 1
"""Place of the state among the arguments (t, x, p) and (t, x, p, z)."""
NONE = Fraction(0)


def require_invariance(system: HybridSystem, legs: Sequence[Leg], along: Matrix) -> None:
    """Ask that the translations a system declares are symmetries of it.

    Args:
        system: the system, for the names.
        legs: its domains.
        along: the translations as columns, (n_x, n_symmetries).

    Raises:
        InputError: one of them is not proved to be one, and by what.
    """
    columns = [[Fraction(float(value)) for value in column] for column in along.T]
    for symmetry, column in zip(system.symmetries, columns, strict=True):
        for leg in legs:
            seen = _seen(leg, column, columns)
            if seen:
                raise InputError(
                    f"'{symmetry.name}' is declared as a symmetry, but the {seen} (domain '{leg.domain.name}') is not "
                    "proved to be the same along it: leave it out"
                )


def _seen(leg: Leg, column: Sequence[Fraction], columns: Sequence[Sequence[Fraction]]) -> str:
    """Return what of a domain may change along a translation; empty where nothing does."""
    if any(rate != 0 for tape in leg.field.governing for result in rates(tape, column) for rate in result):
        return "vector field"
    if any(rate != 0 for rate in rates(leg.exit.values, column)[0]):
        return leg.exit.name
    for margins in (leg.margins, leg.landing):
        if margins.values is None:
            continue
        for name, rate in zip(margins.names, rates(margins.values, column)[0], strict=True):
            if rate != 0:
                return f"margin of {name}"
    moved = rates(leg.reset, column)[0]
    known = [rate for rate in moved if rate is not None]
    return "" if len(known) == len(moved) and spanned(known, columns) else "reset"


def rates(tape: Tape, along: Sequence[Fraction]) -> list[list[Rate]]:
    """Return at which rate every result's entries change where the state moves along a translation."""
    found: list[Rate] = [NONE] * tape.places
    constants = {where: Fraction(value) for where, value in tape.constants if isfinite(value)}
    for where, argument, entry in tape.inputs:
        if argument == STATE:
            found[where] = along[entry]
    for code, where, operands in tape.steps:
        changes = [found[operand] for operand in operands]
        if any(change != 0 for change in changes):  # what no operand changes is not changed
            found[where] = _rate(code, changes, [constants.get(operand) for operand in operands])
    return [[found[where] for where in result] for result in tape.outputs]


def _rate(code: int, changes: Sequence[Rate], constants: Sequence[Fraction | None]) -> Rate:
    """Return the rate of an operation's result, of operands some of which change."""
    first, last = changes[0], changes[-1]
    if first is None or last is None:
        return None
    if code == ca.OP_ASSIGN:
        return first
    if code == ca.OP_NEG:
        return -first
    if code == ca.OP_TWICE:
        return 2 * first
    if code == ca.OP_ADD:
        return first + last
    if code == ca.OP_SUB:
        return first - last
    divisor = constants[-1]
    if code == ca.OP_DIV and divisor:
        return first / divisor
    if code == ca.OP_MUL:
        factor, rate = (constants[0], last) if constants[0] is not None else (constants[-1], first)
        return None if factor is None else factor * rate
    return None


def spanned(vector: Sequence[Fraction], columns: Sequence[Sequence[Fraction]]) -> bool:
    """Whether a vector lies in the span of others, in rational arithmetic."""
    rest, left = list(vector), [list(column) for column in columns]
    for place in range(len(rest)):
        pivot = next((column for column in left if column[place] != 0), None)
        if pivot is None:
            continue
        left.remove(pivot)
        for row in (rest, *left):
            share = row[place] / pivot[place]
            row[:] = [value - share * other for value, other in zip(row, pivot, strict=True)]
    return not any(rest)
