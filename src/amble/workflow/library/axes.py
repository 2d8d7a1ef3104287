"""The axes of a library: which number of a specification each one is, over which range, in which steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Generic, TypeVar

from pydantic import AfterValidator, Field

from amble.errors import InputError, shown
from amble.hybrid import Plane
from amble.io.quantities import parse_quantity
from amble.io.reader import read_toml
from amble.synthesis.problem import GaitProblem
from amble.synthesis.quantity_types import Angle, AngularSpeed, Length, Mass, Ratio, Speed, Time, ordered
from amble.synthesis.specification import Section, Specification, specification_of, validated
from amble.synthesis.specified import problem_of
from amble.types import Json
from amble.workflow.library.grid import Grid

Quantity = TypeVar("Quantity")

MOST = 100_000
"""Gaits of a library, at most: a step that is a thousand times too small is a slip."""

WHOLE = 1e-6
"""By how much of a step a range may miss a whole number of steps."""


class Axis(Section, Generic[Quantity]):
    """Values from the lower to the upper end of a range, both included, by steps."""

    range: Annotated[list[Quantity], Field(min_length=2, max_length=2), AfterValidator(ordered)]
    step: Quantity


class AxesSection(Section):
    """What changes from gait to gait.

    ``height`` is the middle of the range of the base's height, which keeps its width; ``payload`` the mass that is
    carried. Neighbours are walked in the order of the axes in the file.
    """

    speed: Axis[Speed] | None = None
    lateral_speed: Axis[Speed] | None = None
    yaw_rate: Axis[AngularSpeed] | None = None
    height: Axis[Length] | None = None
    slope: Axis[Angle] | None = None
    friction: Axis[Ratio] | None = None
    payload: Axis[Mass] | None = None


class LibrarySection(Section):
    """The axes, and the wall time after which a gait is given up."""

    axes: AxesSection
    time_limit: Annotated[Time, Field(gt=0.0, le=1e6)] = 600.0


class LibraryFile(Specification):
    """A specification with a library."""

    library: LibrarySection


PLACES = {
    "speed": ("gait", "speed"),
    "lateral_speed": ("gait", "lateral_speed"),
    "yaw_rate": ("gait", "yaw_rate"),
    "slope": ("ground", "slope"),
    "friction": ("ground", "friction"),
    "payload": ("robot", "payload", "mass"),
}
"""Axis -> its key in a specification; that of ``height`` is a range."""

HEIGHT = ("limits", "base", "z")

UNITS = {
    "speed": "m/s",
    "lateral_speed": "m/s",
    "yaw_rate": "rad/s",
    "height": "m",
    "slope": "rad",
    "friction": "1",
    "payload": "kg",
}
"""Axis -> its unit."""


@dataclass(frozen=True, kw_only=True)
class LibrarySpecification:
    """A specification with axes.

    Attributes:
        tree: the specification without ``[library]``, as a tree.
        folder: where a relative path of a robot file starts.
        grid: the axes' values.
        width: of the range of the base's height, m; of no account where that is no axis.
        time_limit: wall time after which a gait is given up, s.
    """

    tree: Json
    folder: Path
    grid: Grid
    width: float
    time_limit: float

    def specification(self, values: Mapping[str, float]) -> Specification:
        """Return the specification of one gait.

        Args:
            values: axis -> its value.
        """
        tree = self.tree
        for axis, value in values.items():
            if axis == "height":
                tree = _placed(tree, HEIGHT, [value - 0.5 * self.width, value + 0.5 * self.width])
            elif axis == "payload" and value == 0.0:
                tree = {**tree, "robot": {key: entry for key, entry in tree["robot"].items() if key != "payload"}}
            else:
                tree = _placed(tree, PLACES[axis], value)
        return specification_of(tree, "library")

    def problem(self, values: Mapping[str, float]) -> GaitProblem:
        """Build the problem of one gait; errors as in ``problem_of``."""
        return problem_of(self.specification(values), self.folder)


def read_library(path: str | Path) -> LibrarySpecification:
    """Read a specification with a table ``[library]``.

    Raises:
        InputError: in one sentence, where the file is no specification, has no axes, or an axis cannot be used.
    """
    path = Path(path)
    tree = read_toml(path, "specification")
    if "library" not in tree:
        raise InputError(
            f"{shown(path.name)} has no [library.axes]; `amble synthesize` finds the one gait it describes"
        )
    read = validated(tree, path.name, LibraryFile)
    names = tuple(name for name in tree["library"].get("axes", ()) if getattr(read.library.axes, name) is not None)
    if not names:
        raise InputError(f"{shown(path.name)}: [library.axes] names no axis; known: {', '.join(UNITS)}")
    del tree["library"]
    problem = problem_of(read, path.parent)
    low, high = problem.limits.positions.get("z", (-float("inf"), float("inf")))
    if "height" in names and not isfinite(high - low):
        raise InputError(
            f"{shown(path.name)}: axis height moves the range of the base's height, which needs [limits.base] z"
        )
    values = tuple(_values(name, getattr(read.library.axes, name)) for name in names)
    own = _own(tree, problem)
    first = tuple(
        min(range(len(row)), key=lambda i: abs(row[i] - own[name])) for name, row in zip(names, values, strict=True)
    )
    grid = Grid(names=names, values=values, first=first)
    if grid.size > MOST:
        raise InputError(f"{shown(path.name)}: the axes make {grid.size} gaits; at most {MOST} are taken")
    return LibrarySpecification(
        tree=tree, folder=path.parent, grid=grid, width=high - low, time_limit=read.library.time_limit
    )


def check_ends(library: LibrarySpecification) -> None:
    """Build the problem where the way begins, and from there at both ends of every axis.

    What is wrong with all gaits, or with an end of an axis such as a negative friction, is said before any is made.

    Raises:
        InputError: with the axis and its value.
    """
    begin = library.grid.at(library.grid.first)
    library.problem(begin)
    for name, values in zip(library.grid.names, library.grid.values, strict=True):
        for value in (values[0], values[-1]):
            if value == begin[name]:
                continue
            try:
                library.problem({**begin, name: value})
            except InputError as error:
                unit = "" if UNITS[name] == "1" else f" {UNITS[name]}"
                raise InputError(f"axis {name} at {value:g}{unit}: {error}") from None


def label(values: Mapping[str, float]) -> str:
    """Return the name of a gait's files: its values, in the same order in every library that has them."""
    return "-".join(f"{name}_{values[name]:.12g}" for name in UNITS if name in values)


def _own(tree: Json, problem: GaitProblem) -> dict[str, float]:
    """What the specification itself says along every axis."""
    low, high = problem.limits.positions.get("z", (0.0, 0.0))
    ground, payload = problem.pattern.ground, tree["robot"].get("payload")
    return {
        "speed": problem.speed,
        "lateral_speed": problem.lateral_speed,
        "yaw_rate": problem.yaw_rate,
        "height": 0.5 * (low + high),
        "slope": ground.slope if isinstance(ground, Plane) else 0.0,
        "friction": ground.friction,
        "payload": 0.0 if payload is None else parse_quantity(payload.get("mass", 0.0), "mass"),
    }


def _values(name: str, axis: Axis[float]) -> tuple[float, ...]:
    low, high = axis.range
    if not axis.step > 0.0:
        raise InputError(f"axis {name}: its step is {axis.step:g}; it must be above 0")
    steps = (high - low) / axis.step
    if not steps <= MOST:
        raise InputError(
            f"axis {name}: {steps:.3g} steps of {axis.step:g} are too many; at most {MOST} gaits are taken"
        )
    count = round(steps)
    if abs(steps - count) > WHOLE:
        raise InputError(f"axis {name}: its range of {high - low:g} is no whole number of steps of {axis.step:g}")
    values = [low + (high - low) * i / max(count, 1) for i in range(count + 1)]
    # a place a rounding error beside 0 is 0: straight ahead is no turn of 1e-17 rad/s
    return tuple(0.0 if abs(value) < WHOLE * axis.step else float(f"{value:.12g}") for value in values)


def _placed(tree: Json, place: tuple[str, ...], value: Any) -> Json:
    """Return a tree with one entry in the place of another; missing tables are made."""
    key, *rest = place
    return {**tree, key: _placed(tree.get(key) or {}, tuple(rest), value) if rest else value}
