"""A block of a nonlinear program: a small vector function, repeated over index sets, with its rows' names and units."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Index = NDArray[np.int64]


@dataclass(frozen=True)
class Label:
    """What a row of a block is: its kind, by which code selects it, its name, which people read, and its unit."""

    kind: str
    name: str
    unit: str = "1"


@dataclass(frozen=True, kw_only=True)
class Block:
    """A vector function of some variables, repeated over instances.

    Attributes:
        name: the block's name, unique in a program.
        variables: symbol w of the local variables, (n_w,).
        constants: symbol c that differs between instances (a node's phase, say), (n_c,).
        parameters: symbol of the program's parameters, the same everywhere, (n_p,).
        rows: expressions of the constraint rows, (n_r,).
        cost: scalar expression added to the objective.
        labels: kind and name of every row.
        columns: indices of the program's variables, (instances, n_w); distinct within an instance.
        values: value of the constants, (instances, n_c).
        places: name of every instance, such as "D1 node 3".
        lower: lower bounds of the rows, (instances, n_r).
        upper: upper bounds of the rows, (instances, n_r).
    """

    name: str
    variables: ca.SX
    constants: ca.SX
    parameters: ca.SX
    rows: ca.SX
    cost: ca.SX
    labels: tuple[Label, ...]
    columns: Index
    values: NDArray[np.float64]
    places: tuple[str, ...]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    @property
    def instances(self) -> int:
        """How often the block is repeated."""
        return int(self.columns.shape[0])
