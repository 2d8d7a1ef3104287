"""Array aliases whose names state their axes; the shapes are those of docs/notation.md."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""One axis: (n,)."""

IntegerVector = NDArray[np.int64]
"""One axis, whole numbers: (n,)."""

Matrix = NDArray[np.float64]
"""Two axes: (rows, columns)."""

NodeValues = NDArray[np.float64]
"""(node, coordinate): a quantity sampled along a domain."""

Json = dict[str, Any]
"""A tree of dictionaries, lists, strings, numbers, booleans and None."""


def frozen(values: Any) -> NDArray[np.float64]:
    """Return a read-only float64 copy, so that a frozen record stays frozen."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array
