"""Rows and bounds that a solver's end violates, by the names that people read."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from amble.residual import Residual, worst_first
from amble.robot.parts import ACCELERATION, RATE
from amble.synthesis.layout import DomainLayout
from amble.synthesis.program import GaitProgram
from amble.types import Vector

ROW_TOLERANCE = 1e-6
"""How far a row may lie outside its bounds in scaled units without being named."""


def violated_rows(
    program: GaitProgram, variables: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[Residual, ...]:
    """Return the rows and bounds that scaled miss by more than ``ROW_TOLERANCE``, worst first, in SI units."""
    nlp, scale = program.program, program.layout.scale
    kinds = np.full(scale.size, "bound")
    rows = _rows(partial(_row_names, program), (nlp.lower, values, nlp.upper), nlp.row_scale, nlp.row_kinds)
    rows += _rows(partial(variable_names, program), (program.lower, variables, program.upper), scale, kinds)
    return worst_first(rows)


def _row_names(program: GaitProgram) -> tuple[str, ...]:
    """Name of every row, with its unit."""
    nlp = program.program
    named = zip(nlp.row_names, nlp.row_units, strict=True)
    return tuple(f"{name} ({unit})" if unit != "1" else name for name, unit in named)


def variable_names(program: GaitProgram) -> tuple[str, ...]:
    """Name of every variable: domain, node and coordinate."""
    robot = program.problem.pattern.robot
    names = ["period"] * program.layout.size
    kinds = {"q": robot.coordinate_names, "v": robot.coordinate_names, "a": robot.coordinate_names}
    words = {"q": "", "v": RATE, "a": ACCELERATION}
    for domain in program.layout.domains:
        labels = {kind: [words[kind] + name for name in kinds[kind]] for kind in kinds}
        labels["u"] = [f"torque {name}" for name in robot.joint_names]
        labels["force"] = [f"force {label}" for label in program.problem.pattern.contacts(domain.stance).labels]
        for kind, texts in labels.items():
            for node, places in enumerate(getattr(domain, kind)):
                for place, text in zip(places, texts, strict=True):
                    names[place] = f"{domain.place(node)} {text}"
        names[int(domain.duration[0])] = f"{domain.stance.name} duration"
        for place, known in zip(domain.phase_numbers, program.problem.outputs.phase.numbers, strict=True):
            names[int(place)] = f"{domain.stance.name} phase {known.name}"
        controlled = program.problem.outputs.of(domain.stance.name).coordinates
        order = program.problem.outputs.order
        curves = [f"coefficient {name} {number}" for number in range(order + 1) for name in controlled]
        axes = [f"impulse {label}" for label in program.problem.pattern.contacts(domain.switch.target).labels]
        for places, texts in ((domain.coefficients, curves), (domain.impulse, axes if domain.impulse.size else [])):
            for place, text in zip(places, texts, strict=True):
                names[place] = f"{domain.stance.name} {text}"
        _name_landings(program, domain, names)
    return tuple(names)


def _name_landings(program: GaitProgram, domain: DomainLayout, names: list[str]) -> None:
    """Name the variables of the stances between landings."""
    pattern = program.problem.pattern
    coordinates = pattern.robot.coordinate_names
    for landing in domain.landings:
        labels = pattern.contacts(landing.stance).labels
        texts = [
            *(f"{RATE}{name}" for name in coordinates),
            *(f"impulse {label}" for label in labels),
            *(f"{ACCELERATION}{coordinates[k]}" for k in landing.free),
            *(f"force {label}" for label in labels),
        ]
        for place, text in zip(landing.index, texts, strict=True):
            names[place] = f"{landing.stance.name} {text}"


def _rows(
    names: Callable[[], tuple[str, ...]],
    values: tuple[Vector, Vector, Vector],
    size: Vector,
    kinds: NDArray[np.str_],
) -> list[Residual]:
    """Return what of (lower, value, upper), all scaled, is violated, times the size of one unit."""
    excess = np.maximum(np.maximum(values[0] - values[1], values[1] - values[2]), 0.0)
    bad = np.flatnonzero(~(excess <= ROW_TOLERANCE))
    if not bad.size:
        return []  # writing thousands of names takes longer than an iteration of the solver
    named, (lower, there, upper) = names(), (size * part for part in values)
    return [Residual(named[i], float(lower[i]), float(there[i]), float(upper[i]), kind=str(kinds[i])) for i in bad]
