"""The hash of what a proof is of: systems that differ in anything that is proved have others, equal ones the same."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from examples import rimless_wheel
from flint import arb

from amble.hybrid import Domain, HybridSystem, Symmetry, Transition
from amble.proof.arithmetic import working_precision
from amble.proof.identity import generator, system_hash
from amble.proof.leg import Leg
from amble.proof.loop_field import LoopField
from amble.proof.return_map import ReturnMap
from amble.proof.switched_field import SwitchedField
from amble.proof.tape import Tape, record
from tests.hybrids import travelling
from tests.proof.test_switched_field import MARKS, PUSHES, pushed, sliding

SAYS_ITSELF = {"order", "tolerance", "progress", "system", "domain"}
"""Attributes that a proof's file holds itself, or that are looked at apart."""


def other_tape() -> Tape:
    x = ca.SX.sym("x", 1)
    return record(ca.Function("other", [x], [ca.sin(x)]))


def variants(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Return a value with one number, text or tape in it changed, every one in turn."""
    if isinstance(value, tuple):
        for number, entry in enumerate(value):
            for where, other in variants(entry, f"{path}[{number}]"):
                yield where, (*value[:number], other, *value[number + 1 :])
        if value and not isinstance(value[0], int):
            yield f"{path} shorter", value[:-1]
    elif is_dataclass(value):
        for part in fields(value):
            if part.name not in SAYS_ITSELF:
                for where, other in variants(getattr(value, part.name), f"{path}.{part.name}"):
                    yield where, replace(value, **{part.name: other})  # type: ignore[type-var]
    else:
        yield path, changed_leaf(value)


def changed_leaf(value: Any) -> Any:
    if isinstance(value, arb):
        return value + arb(2) ** -200 if value.is_finite() else arb(7)
    if isinstance(value, bool) or value is None:
        return not value
    if isinstance(value, float):
        return float(np.nextafter(value, np.inf))
    return value + 1 if isinstance(value, int) else f"{value} "


def watched() -> ReturnMap:
    """A wheel with margins of two kinds, a robot and a turn, whatever they mean."""
    rolling, _ = rimless_wheel.rolling()
    prepared = ReturnMap.of(rolling, 4, 0.0)
    (leg,) = prepared.legs
    x = ca.SX.sym("x", 1)
    height = record(ca.Function("height", [x], [0.25 - ca.cos(x)]))
    margins = replace(leg.margins, names=("height",), rising=(True,), values=height)
    return replace(
        prepared, legs=(replace(leg, margins=margins, landing=margins, load=2.5),), turns=(height,), record="robot"
    )


@pytest.mark.parametrize("made", [sliding, watched])
def test_whatever_is_changed_changes_the_hash(made: Any) -> None:
    """Stretches, their ends and numbers, margins and their names, guards, resets, scales, turns, the robot record."""
    with working_precision(300):
        seen = {system_hash(made()): "nothing"}
        assert system_hash(made()) in seen
        for where, changed in variants(made()):
            found = system_hash(changed)
            assert found not in seen, f"{where} as {seen[found]}"
            seen[found] = where
    assert len(seen) > 30


def test_every_attribute_is_met() -> None:
    with working_precision(128):
        places = {where for made in (sliding, watched) for where, _ in variants(made())}
    wanted = [f".legs[0].{part.name}" for part in fields(Leg) if part.name not in ("domain", "parameters")]
    wanted += [".legs[0].field.ends[0]", ".legs[0].field.fields[1].loop.parameters[0]", ".turns[0]", ".record"]
    assert all(any(place.startswith(want) for place in places) for want in wanted)


def test_stretches_of_a_law_are_in_the_hash() -> None:
    """Before, neither their numbers nor where they end were."""
    with working_precision(128):
        base = sliding()
        fields = [
            pushed(),
            pushed((*PUSHES[:3], float(np.nextafter(PUSHES[3], 4)))),
            pushed(ends=(float(np.nextafter(MARKS[0], 1)), *MARKS[1:], float("inf"))),
            pushed(ends=(*MARKS, 2.0)),
        ]
        hashes = {system_hash(replace(base, legs=(replace(base.legs[0], field=field),))) for field in fields}
        assert len(hashes) == len(fields)


def test_the_same_entries_at_other_places_are_another_system() -> None:
    """Of M and H the tapes hold the nonzeros alone."""
    with working_precision(128):
        base, (first, *rest) = sliding(), pushed().fields
        assert isinstance(first, LoopField)
        moved = replace(first, loop=replace(first.loop, slope_places=((0, 0),)))
        field = SwitchedField((moved, *rest), pushed().ends)
        assert system_hash(base) != system_hash(replace(base, legs=(replace(base.legs[0], field=field),)))


def test_symmetries_and_names_are_in_the_hash() -> None:
    system = travelling(0.0, -1)
    both = HybridSystem(system.domains, system.transitions, system.symmetries[:2], system.state_names)
    x = ca.SX.sym("x", 5)
    aslant = Symmetry("y", ca.Function("aslant", [x], [ca.DM([1, 1, 0, 0, 0])]))
    renamed = Symmetry("z", both.symmetries[1].generator)
    others = [
        both,
        replace(both, symmetries=both.symmetries[:1]),
        replace(both, symmetries=both.symmetries[::-1]),
        replace(both, symmetries=(both.symmetries[0], aslant)),
        replace(both, symmetries=(both.symmetries[0], renamed)),
        replace(both, state_names=[*both.state_names[:-1], "other"]),
    ]
    with working_precision(128):
        hashes = [system_hash(ReturnMap.of(other, 4, 0.0)) for other in others]
        assert len(set(hashes)) == len(others)
        assert system_hash(ReturnMap.of(both, 8, 1e-3)) == hashes[0]
        prepared = ReturnMap.of(both, 4, 0.0)
        assert system_hash(replace(prepared, turns=(generator(system.symmetries[2]),))) not in hashes


def test_what_a_system_itself_says_is_in_the_hash() -> None:
    """Direction, dead time, breakpoints, parameters, margins: by the system, not by what is prepared of it."""
    x, p = ca.SX.sym("x", 1), ca.SX.sym("p", 1)
    domain = Domain.from_expressions("d", x, p, admissibility=2 - x, parameters=p, values=[1.0])
    leave = Transition.from_expressions("d", "d", x, x - 1, 0 * x, +1, parameters=p)
    margin = ca.Function("m", [ca.SX.sym("t"), x, p], [3 - x], ["t", "x", "p"], ["m"])
    systems = [
        HybridSystem([replace(domain, **changed)], [replace(leave, **moved)])  # type: ignore[arg-type]
        for changed, moved in (
            ({}, {}),
            ({"parameters": np.array([np.nextafter(1.0, 2.0)])}, {}),
            ({"breakpoints": (0.5,)}, {}),
            ({"admissibility": None}, {}),
            ({"margins": {"far": margin}}, {}),
            ({"margins": {"farther": margin}}, {}),
            ({}, {"direction": -1}),
            ({}, {"dead_time": 0.25}),
            ({}, {"reset": leave.guard}),
        )
    ]
    with working_precision(128):
        hashes = [system_hash(ReturnMap.of(system, 4, 0.0)) for system in systems]
        assert len(set(hashes)) == len(systems)
        assert hashes[0] == system_hash(
            ReturnMap.of(replace(systems[0], domains=[replace(domain, jacobian=None)]), 4, 0.0)
        )


def test_a_kind_of_attribute_that_is_not_known_ends_the_work() -> None:
    with working_precision(128), pytest.raises(TypeError, match="holds a dict"):
        system_hash(replace(sliding(), legs=(replace(sliding().legs[0], load={}),)))  # type: ignore[arg-type]
