"""Derivatives of the functions of a hybrid system with respect to state and clock."""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.errors import InputError
from amble.hybrid import Domain
from amble.types import Matrix, Vector


def field_jacobian(domain: Domain) -> ca.Function:
    """Return d field / d x as a function (t, x, p) -> (n_x, n_x): the domain's own, or by automatic differentiation.

    Raises:
        InputError: where the field cannot be differentiated (an external without derivatives) and the domain does not
            bring a Jacobian.
    """
    if domain.jacobian is not None:
        return domain.jacobian
    return _differentiated(domain.field, f"the field of domain '{domain.name}'", (1,), "give Domain.jacobian")


def slopes(function: ca.Function, what: str, clock: float, state: Vector, parameters: Vector) -> tuple[Matrix, Vector]:
    """Return (d function / d x, d function / d t) of a function (t, x, p), shapes (m, n_x) and (m,).

    Raises:
        InputError: where the function cannot be differentiated.
    """
    derivative = _differentiated(function, what, (1, 0), "compile it with its derivatives")
    by_state, by_clock = derivative(clock, state, parameters)
    return np.asarray(by_state.full()), np.asarray(by_clock.full()).reshape(-1)


def _differentiated(function: ca.Function, what: str, inputs: tuple[int, ...], remedy: str) -> ca.Function:
    names, result = function.name_in(), function.name_out()[0]
    try:
        return function.factory(f"{function.name()}_slopes", names, [f"jac:{result}:{names[i]}" for i in inputs])
    except RuntimeError as error:
        raise InputError(f"{what} has no derivatives: {remedy}") from error
