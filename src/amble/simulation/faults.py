"""Which casadi functions may fail by a C++ exception: one that crosses C code ends the whole process."""

from __future__ import annotations

import casadi as ca

SAFE = ("SXFunction", "External")
"""Straight-line arithmetic, and compiled code, which returns a status."""


def may_throw(function: ca.Function) -> bool:
    """Whether a function holds anything but arithmetic and compiled code: a solver, an assertion, a callback in Python.

    Such a function is evaluated through Python, where its failure is caught.
    """
    if function.class_name() in SAFE:
        return False
    if not function.is_a("MXFunction"):
        return True
    for place in range(function.n_instructions()):
        kind = function.instruction_id(place)
        if kind == ca.OP_ASSERTION:
            return True
        if kind == ca.OP_CALL and may_throw(function.instruction_MX(place).which_function()):
            return True
    return False
