"""The records that the C code of the structured KKT solver shares with Python."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, field
from typing import Any

INTEGERS = ctypes.POINTER(ctypes.c_int)


def _structure(*groups: tuple[Any, str]) -> list[tuple[str, Any]]:
    return [(name, kind) for kind, names in groups for name in names.split()]


class DomainPlan(ctypes.Structure):
    """``Domain`` of structured_kkt.c."""

    _fields_ = _structure(
        (ctypes.c_int, "nodes intervals stages ns ne nh ny nt na nd"),
        (INTEGERS, "end read c_start c_column defect rate variable explicit_row implicit_row defect_row"),
    )


class Plan(ctypes.Structure):
    """``Plan`` of structured_kkt.c."""

    _fields_ = _structure(
        (ctypes.c_int, "domains variables equalities inequalities end_variables end_rows"),
        (ctypes.c_int, "tips cross_tips crosses links end_inequalities"),
        (ctypes.POINTER(DomainPlan), "domain"),
        (INTEGERS, "end_index end_row jacobian_start jacobian_row jacobian_block jacobian_place"),
        (INTEGERS, "hessian_start hessian_row hessian_block hessian_place diagonal_block diagonal_place"),
        (INTEGERS, "node_inequality inequality_row inequality_start inequality_place"),
        (INTEGERS, "variable_node variable_place tip_variable cross_tip cross_other link_row link_tip"),
        (INTEGERS, "end_inequality_row end_inequality_start end_inequality_column"),
    )


@dataclass(frozen=True)
class KeptPlan:
    """A plan with the arrays that it points to."""

    plan: Plan
    arrays: list[Any] = field(repr=False)
