"""The closed loop of a gait as a field through which sets are followed; its equations are ``loop_tapes``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from amble.proof.arithmetic import column
from amble.proof.loop_expansion import expand
from amble.proof.loop_step import loop_step
from amble.proof.loop_tapes import LoopTapes, stacked_rates
from amble.proof.step import Part, Step, StepError
from amble.proof.tape import NOT_ENCLOSED, Tape
from amble.proof.taylor import coefficient, series


@dataclass(frozen=True)
class LoopField:
    """The field q' = v, v' = S z with M z = b.

    Attributes:
        loop: the equations.
    """

    loop: LoopTapes

    @property
    def size(self) -> int:
        """Number of states."""
        return self.loop.size

    @property
    def governing(self) -> tuple[Tape, ...]:
        """The expressions that determine the motion, over (t, x, p)."""
        return (self.loop.equations,)

    def part(self, during: arb, box: Sequence[arb]) -> Part:
        """Return what holds in a small box of states at some clocks, by Arb's verified solver.

        Raises:
            ZeroDivisionError: M is not proved to be invertible.
        """
        matrix, right = self.loop.equations([during], box, self.loop.parameters)
        values = column([coefficient(value, 0) for value in right])
        solution = self.loop.of_matrix(matrix).solve(values).entries()
        rate = [*box[self.size // 2 :], *solution[: self.size // 2]]
        return Part(during=during, box=list(box), rate=rate, solution=solution)

    def slope(self, part: Part) -> arb_mat:
        """Return balls that hold f_x there, by the equations' own slopes."""
        half = self.size // 2
        matrix, slope = self.loop.slopes([part.during], part.box, self.loop.parameters, part.solution)
        answer = self.loop.of_matrix(matrix).solve(self.loop.of_slope(slope))
        below = arb_mat(half, self.size, [int(j == half + i) for i in range(half) for j in range(self.size)])
        return stacked_rates(below, -answer, half)

    def drift(self, part: Part) -> list[arb]:
        """Return balls that hold f_t there: M z_t = b_t - M_t z."""
        half, state = self.size // 2, [series([value, arb(0)], 2) for value in part.box]
        matrix, right = self.loop.equations([series([part.during, arb(1)], 2)], state, self.loop.parameters)
        changed = column([coefficient(value, 1) for value in right])
        changed = changed - self.loop.of_matrix(matrix, 1) * column(part.solution)
        answer = self.loop.of_matrix(matrix).solve(changed).entries()
        return [*([arb(0)] * half), *answer[:half]]

    def polynomial(self, clock: arb, centre: Sequence[arb], order: int) -> list[list[arb]]:
        """Return every state's coefficients of the motion from a point."""
        return expand(self.loop, clock, centre, order).state

    def step(self, clock: arb, centre: Sequence[arb], box: Sequence[arb], length: arb, order: int) -> Step:
        """Advance a box; see ``loop_step``.

        Raises:
            StepError: no enclosure was found.
        """
        try:
            return loop_step(self.loop, clock, centre, box, length, order)
        except NOT_ENCLOSED as error:
            raise StepError(str(error)) from None
