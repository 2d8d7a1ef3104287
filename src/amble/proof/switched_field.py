"""A vector field in stretches of the clock, smooth along each, as that of a law whose references come in pieces."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from amble.errors import InputError
from amble.proof.step import Field, Part, Step, StepError
from amble.proof.tape import Tape


@dataclass(frozen=True)
class SwitchedField:
    """Fields that follow each other in time. A motion is continuous where they change, its rate need not be.

    Attributes:
        fields: one for every stretch.
        ends: clocks at which stretches end, ascending, exact; infinite for one without end, s.
    """

    fields: tuple[Field, ...]
    ends: tuple[arb, ...]

    def __post_init__(self) -> None:
        """Refuse stretches that do not follow each other: at one clock two would hold.

        Raises:
            InputError: their ends do not ascend from a clock above 0.
        """
        if not all(earlier < later for earlier, later in itertools.pairwise((arb(0), *self.ends))):
            ends = ", ".join(f"{float(end):g}" for end in self.ends)
            raise InputError(f"the stretches of a control law end at clocks that do not ascend: {ends} s")

    @property
    def size(self) -> int:
        """Number of states."""
        return self.fields[0].size

    @property
    def governing(self) -> tuple[Tape, ...]:
        """The expressions that determine the motion, over (t, x, p), each once."""
        return tuple(dict.fromkeys(tape for field in self.fields for tape in field.governing))

    def part(self, during: arb, box: Sequence[arb]) -> Part:
        """Return what holds in a small box of states at some clocks."""
        return self._along(during).part(during, box)

    def slope(self, part: Part) -> arb_mat:
        """Return balls that hold f_x there."""
        return self._along(part.during).slope(part)

    def drift(self, part: Part) -> list[arb]:
        """Return balls that hold f_t there."""
        return self._along(part.during).drift(part)

    def polynomial(self, clock: arb, centre: Sequence[arb], order: int) -> list[list[arb]]:
        """Return every state's coefficients of the motion from a point, as it goes on from there."""
        return self._along(clock).polynomial(clock, centre, order)

    def step(self, clock: arb, centre: Sequence[arb], box: Sequence[arb], length: arb, order: int) -> Step:
        """Advance a box by a step that lies in one stretch; see ``Field.step``."""
        return self._along(clock, clock + length).step(clock, centre, box, length, order)

    def _along(self, first: arb, last: arb | None = None) -> Field:
        """Return the field of the stretch that holds clocks from a first to a last one, or about a first one alone.

        Raises:
            StepError: they are not proved to lie in one stretch.
        """
        begins = arb("-inf"), *self.ends[:-1]
        # at a breakpoint the later stretch, at the end of the last one that
        for field, begin, end in reversed(list(zip(self.fields, begins, self.ends, strict=True))):
            if first >= begin and (first if last is None else last) <= end:
                return field
        raise StepError("clocks are not known to lie between two breakpoints of the law")
