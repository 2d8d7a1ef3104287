"""The Poincare map of many starts in one native call (``dormand_prince.c``), for what applies it hundreds of times."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amble.hybrid import HybridSystem
from amble.simulation.bound import Callee
from amble.simulation.flow import Flow
from amble.simulation.library import DOUBLES, doubles, load
from amble.simulation.native import NativeFlow, Problem, Tableau
from amble.simulation.prepared import PreparedDomain
from amble.types import NodeValues

INTEGERS = ctypes.POINTER(ctypes.c_int)


class _Passage(ctypes.Structure):
    _fields_ = (
        ("problem", ctypes.POINTER(Problem)),
        ("resets", ctypes.POINTER(Callee)),
        ("targets", INTEGERS),
        ("n_transitions", ctypes.c_int),
    )


ARGUMENTS = (
    ctypes.POINTER(_Passage), ctypes.POINTER(Tableau), ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.c_int,
    ctypes.c_int, DOUBLES, INTEGERS,
)  # fmt: skip


@dataclass(frozen=True)
class NativeMap:
    """The map of a system whose domains are all prepared in native code; ``kept`` holds what C points to."""

    routine: Any
    passages: Any
    tableau: Tableau
    kept: tuple[Any, ...]

    def __call__(
        self, starts: NodeValues, tolerance: float, time_limit: float, max_step: float, cycles: int
    ) -> tuple[NodeValues, NDArray[np.bool_]]:
        """Map starts to the entry of the first domain some cycles later; arguments are those of ``walk``.

        Args:
            starts: at the entry of the first domain, (k, n_x).
            tolerance: of the integrator.
            time_limit: the longest that one domain may last, s.
            max_step: the longest time between two event samples, s.
            cycles: how many.

        Returns:
            Images, (k, n_x), and which starts came back, (k,). Of others ``walk`` says why they do not: a start that
            nothing but its short stays makes doubtful is among them.
        """
        images = np.array(starts, dtype=np.float64, order="C")
        returned = np.zeros(len(images), dtype=np.int32)
        self.routine(
            self.passages, ctypes.byref(self.tableau), tolerance, time_limit, max_step, cycles, len(images),
            doubles(images), returned.ctypes.data_as(INTEGERS),
        )  # fmt: skip
        return images, returned.astype(np.bool_)


def native_map(system: HybridSystem, prepared: Mapping[str, tuple[PreparedDomain, Flow]]) -> NativeMap | None:
    """Return the map of a system; None where Python has a part in it.

    Args:
        system: the system; transitions that fire at the entry are Python's.
        prepared: all its domains.
    """
    library, names = load("dormand_prince"), [domain.name for domain in system.domains]
    flows = [prepared[name][1] for name in names]
    passages, kept = (_Passage * len(names))(), list[Any](flows)
    if library is None or any(transition.at_entry for transition in system.transitions):
        return None
    for number, (name, flow) in enumerate(zip(names, flows, strict=True)):
        here = prepared[name][0]
        callees = [reset.callee for reset in here.resets if not reset.throws]
        known = [callee for callee in callees if callee is not None]
        if not isinstance(flow, NativeFlow) or len(known) < len(here.resets):
            return None
        resets = (Callee * len(known))(*known)
        targets = (ctypes.c_int * len(known))(*(names.index(transition.target) for transition in here.leaving))
        passages[number] = _Passage(
            ctypes.pointer(flow.problem),
            ctypes.cast(resets, ctypes.POINTER(Callee)),
            ctypes.cast(targets, INTEGERS),
            len(known),
        )
        kept += [here, resets, targets]
    first = flows[0]
    if not isinstance(first, NativeFlow):
        return None
    routine = library.amble_map
    routine.argtypes, routine.restype = ARGUMENTS, None
    return NativeMap(routine, passages, first.tableau, tuple(kept))
