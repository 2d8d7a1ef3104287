"""What of a library is to be done next: gaits whose neighbour on the way is settled, each with its start."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from amble.errors import InputError
from amble.types import Json
from amble.workflow.library.axes import label
from amble.workflow.library.files import LibraryEntry, read_entry
from amble.workflow.library.grid import Grid, Point


@dataclass(frozen=True)
class Task:
    """One gait to be made; files are named from the library's folder.

    Attributes:
        values: axis -> its value.
        start: file of the gait that the solver starts from; None for a kinematic walk.
        weights: file of the stabilised gait whose weights are tried first; None for none.
    """

    values: dict[str, float]
    start: str | None
    weights: str | None

    def to_dict(self) -> Json:
        """Return it as a tree for a line of JSON."""
        return {"values": self.values, "start": self.start, "weights": self.weights}


class Way:
    """The way through a grid, with what of it is settled.

    A gait starts from the nearest one before it on the way that was solved, stabilised or not, and with the weights of
    the nearest that is certified.
    """

    def __init__(self, folder: Path, grid: Grid, again: bool = False, within: Point | None = None) -> None:
        """Read what is settled.

        Args:
            folder: of the library.
            grid: its grid.
            again: whether what failed is to be tried again.
            within: the first point of the only chain whose gaits are to be made; all by default.
        """
        self._grid, self._settled = grid, dict[Point, LibraryEntry]()
        points = grid.points()
        for point in points:
            entry = read_entry(folder, grid.at(point))
            if entry is not None and (entry.certified or not again):
                self._settled[point] = entry
        self._wanted = [point for point in points if within is None or grid.chain(point) == within]
        self._waiting = [point for point in self._wanted if point not in self._settled]
        self._within, self._folder = within, folder

    @property
    def size(self) -> int:
        """Number of gaits to be there in the end."""
        return len(self._wanted)

    @property
    def settled(self) -> int:
        """How many of them are settled, certified or failed."""
        return sum(point in self._settled for point in self._wanted)

    @property
    def failed(self) -> int:
        """How many of them failed."""
        return sum(not self._settled[point].certified for point in self._wanted if point in self._settled)

    def next(self) -> Point | None:
        """Take the next gait that can be begun; None where all that wait are waiting for one that is being made."""
        for place, point in enumerate(self._waiting):
            parent = self._grid.parent(point)
            if parent is None or parent in self._settled or self._outside(parent):
                return self._waiting.pop(place)
        return None

    def task(self, point: Point) -> Task:
        """Return what a worker has to know of a gait."""
        before = [self._settled[each] for each in self._ancestors(point) if each in self._settled]
        return Task(
            values=self._grid.at(point),
            start=next((entry.file for entry in before if entry.file is not None), None),
            weights=next((entry.file for entry in before if entry.certified), None),
        )

    def read(self, point: Point) -> None:
        """Read what a worker wrote of a gait.

        Raises:
            InputError: there is nothing.
        """
        entry = read_entry(self._folder, self._grid.at(point))
        if entry is None:
            raise InputError(f"the record of {label(self._grid.at(point))} is gone")
        self.settle(point, entry)

    def settle(self, point: Point, entry: LibraryEntry) -> None:
        """Say what became of a gait."""
        self._settled[point] = entry

    def _outside(self, point: Point) -> bool:
        """Whether a point belongs to no chain that is being made here: what it is now is what it is."""
        return self._within is not None and self._grid.chain(point) != self._within

    def _ancestors(self, point: Point) -> Iterator[Point]:
        parent = self._grid.parent(point)
        while parent is not None:
            yield parent
            parent = self._grid.parent(parent)
