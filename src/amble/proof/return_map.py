"""The return map over a box: its image, its derivative for every start, and a quick way to points of high precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from flint import arb, arb_mat

from amble.hybrid import HybridSystem
from amble.progress import Progress, silent
from amble.proof.arc import Arc, follow
from amble.proof.arithmetic import roomy
from amble.proof.glide import passed
from amble.proof.leg import Leg
from amble.proof.moving_set import MovingSet
from amble.proof.tape import Tape


@dataclass(frozen=True, kw_only=True)
class ReturnMap:
    """A system whose cycle is prepared for enclosures.

    Attributes:
        system: itself.
        legs: its domains in order.
        order: Q of the Taylor steps.
        tolerance: size of a step's remainder that the step length aims at.
        progress: called after every step.
        turns: generators, tapes over x, of symmetries that are no translations and that the cycle reverses, as the
            mirror does with a turn about the vertical; of a gait's law they are proved (``turns``).
        record: hash of the robot record whose decimal numbers a gait's expressions are held against.
    """

    system: HybridSystem
    legs: tuple[Leg, ...]
    order: int
    tolerance: float
    progress: Progress = silent
    turns: tuple[Tape, ...] = ()
    record: str = ""

    @classmethod
    def of(cls, system: HybridSystem, order: int, tolerance: float) -> ReturnMap:
        """Prepare a system; errors as in ``Leg.of`` and ``HybridSystem.cycle``."""
        legs = tuple(Leg.of(domain, leaving) for domain, leaving in system.cycle())
        return cls(system=system, legs=legs, order=order, tolerance=tolerance)

    def __call__(
        self, centre: Sequence[arb], radii: Sequence[arb], lengths: Sequence[Sequence[arb]] | None = None
    ) -> Enclosure:
        """Enclose the map over a box.

        Args:
            centre: of the box, exact.
            radii: of the box.
            lengths: of the steps of every domain, where they are known.

        Raises:
            ProofError: what could not be proved.
        """
        return self.of_set(MovingSet.about(centre, radii), lengths)

    def of_set(self, here: MovingSet, lengths: Sequence[Sequence[arb]] | None = None) -> Enclosure:
        """Enclose the map over a set at the entry of the first domain; as for a box."""
        arcs = list[Arc]()
        for number, leg in enumerate(self.legs):
            known = None if lengths is None else lengths[number]
            arc = follow(leg, here, self.order, self.tolerance, known, progress=self.progress)
            arcs.append(arc)
            here = arc.after
        return Enclosure(tuple(arcs), here.middle(), here.hull(), here.derivative())

    def point(self, start: Sequence[arb], durations: Sequence[float]) -> list[arb]:
        """Return the image of a point close to what it is, not enclosed.

        Args:
            start: the point, exact.
            durations: about the time that it spends in every domain, s.

        Raises:
            ProofError: the motion does not get through.
        """
        state = list(start)
        for leg, duration in zip(self.legs, durations, strict=True):
            state = passed(leg, state, self.order, self.tolerance, duration)
        return state


@dataclass(frozen=True)
class Enclosure:
    """The map over a box.

    Attributes:
        arcs: through the domains.
        centre: box that holds the image of the centre.
        image: box that holds the image of every start.
        derivative: balls that hold the derivative at every start, along the coordinates of the set.
    """

    arcs: tuple[Arc, ...]
    centre: list[arb]
    image: list[arb]
    derivative: arb_mat

    def roomy(self) -> Enclosure:
        """Return it with room for what another precision makes of it; margins have theirs (``arc.follow``)."""
        rows, columns = self.derivative.nrows(), self.derivative.ncols()
        return Enclosure(
            arcs=tuple(replace(arc, duration=roomy(arc.duration)) for arc in self.arcs),
            centre=list(map(roomy, self.centre)),
            image=list(map(roomy, self.image)),
            derivative=arb_mat(rows, columns, list(map(roomy, self.derivative.entries()))),
        )
