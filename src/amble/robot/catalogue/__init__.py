"""Robots that ship with the package; one file a machine, with its models."""

from amble.errors import UnknownNameError
from amble.robot.adaptation import AS_WRITTEN, Adaptation
from amble.robot.catalogue.astro import ENTRIES as _ENTRIES
from amble.robot.catalogue.astro import astro, astro_cad
from amble.robot.catalogue.record import Entry, GaitBounds, Posture
from amble.robot.model import Robot


def names() -> tuple[str, ...]:
    """Names of the robots of the catalogue."""
    return tuple(_ENTRIES)


def entry(name: str) -> Entry:
    """Return the record of a robot.

    Raises:
        UnknownNameError: the catalogue has no such robot.
    """
    if name not in _ENTRIES:
        raise UnknownNameError("robot", name, _ENTRIES)
    return _ENTRIES[name]


def load(name: str, adaptation: Adaptation = AS_WRITTEN) -> Robot:
    """Return a robot of the catalogue by name, with what is different from its file."""
    return entry(name).load(adaptation)


def holds(robot: Robot) -> bool:
    """Whether a robot is that of the catalogue, unchanged."""
    return robot.name in _ENTRIES and robot == load(robot.name)


def posture(name: str) -> Posture:
    """Return the nominal walking posture of a robot of the catalogue."""
    return entry(name).posture


def bounds(name: str) -> GaitBounds:
    """Return the bounds of the builders' own gait problem for a robot of the catalogue."""
    return entry(name).bounds


__all__ = [
    "Entry",
    "GaitBounds",
    "Posture",
    "astro",
    "astro_cad",
    "bounds",
    "entry",
    "holds",
    "load",
    "names",
    "posture",
]
