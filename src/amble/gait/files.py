"""Gaits as files: one JSON, versioned, complete, every number with its unit; no pickle, no solver needed to read it."""

from __future__ import annotations

from pathlib import Path

from amble.control import DomainOutputs, Outputs
from amble.control.allocation import law_from
from amble.control.outputs import controllable
from amble.errors import InputError
from amble.gait.motion_tree import (
    domain_from,
    domain_tree,
    feedback_from,
    feedback_tree,
    limits_from,
    limits_tree,
    multipliers_from,
    multipliers_tree,
    solver_from,
    solver_tree,
)
from amble.gait.record import Gait
from amble.gait.robot_tree import robot_from, robot_tree
from amble.hybrid import CONTACTS, GROUNDS, GaitPattern, gait_pattern
from amble.io.codec import Reader, dumps, loads, quantity
from amble.io.storage import atomic_write
from amble.robot import Robot
from amble.types import Json

FORMAT = "amble gait"
FORMAT_VERSION = 2

PARTS = (
    "robot",
    "pattern",
    "outputs",
    "law",
    "speed",
    "gains",
    "limits",
    "domains",
    "solver",
    "feedback",
    "multipliers",
)


def save_gait(gait: Gait, path: str | Path) -> Path:
    """Write a gait to a JSON file, in one step; floats read back exactly. Returns the path."""
    tree = {"format": FORMAT, "format_version": FORMAT_VERSION, "versions": dict(gait.versions), **gait_tree(gait)}
    return atomic_write(path, dumps(tree) + "\n")


def load_gait(path: str | Path, robot: Robot | None = None) -> Gait:
    """Read a gait.

    The file holds the whole robot, so its URDF is not needed.

    Args:
        path: file that ``save_gait`` wrote.
        robot: the robot that the caller believes it is; where not given, no more is checked than that the robot in
            the file has the hash it was written with.

    Raises:
        InputError: in one sentence, where the file is missing, truncated, of another version, or was written for
            another robot; where a key is missing or unknown, a unit or a shape differs, or a number is not finite.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"gait file '{path}' cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise InputError(f"gait file '{path}' is not text") from None
    reader = Reader(loads(text, f"gait file '{path}'"), f"gait file '{path.name}'")
    _check_format(reader, path)
    written_for = robot_from(reader.inside("robot"))
    _same_robot(written_for, robot, path)
    return _gait_from(reader, written_for)


def gait_tree(gait: Gait) -> Json:
    """Write everything that a gait is, without file format and versions."""
    return {
        "robot": robot_tree(gait.robot),
        "pattern": {
            "name": gait.pattern.name,
            "mirrored": gait.pattern.mirrored,
            "stances": [list(stance.feet) for stance in gait.pattern.stances],
            "ground": GROUNDS.to_dict(gait.pattern.ground),
            "contact": CONTACTS.to_dict(gait.pattern.contact),
        },
        "outputs": {
            "order": gait.outputs.order,
            "domains": {entry.domain: list(entry.coordinates) for entry in gait.outputs.domains},
        },
        "law": {"name": gait.law.name, "parameters": dict(gait.law.parameters)},
        "speed": quantity(gait.speed, "m/s"),
        "gains": {"position": quantity(gait.gains[0], "1/s^2"), "velocity": quantity(gait.gains[1], "1/s")},
        "limits": limits_tree(gait.limits),
        "domains": {domain.name: domain_tree(domain, gait.robot) for domain in gait.domains},
        "solver": solver_tree(gait.solver),
        "feedback": None if gait.feedback is None else feedback_tree(gait.feedback, gait.robot),
        "multipliers": None if gait.multipliers is None else multipliers_tree(gait.multipliers),
    }


def _check_format(reader: Reader, path: Path) -> None:
    if "format" not in reader.names() or reader.raw("format") != FORMAT:
        raise InputError(f"'{path}' is not a gait file")
    version = reader.raw("format_version") if "format_version" in reader.names() else None
    if version != FORMAT_VERSION:
        raise InputError(f"gait file '{path}' has format version {version!r}; this package reads {FORMAT_VERSION}")
    reader.expect("format", "format_version", "versions", *PARTS)


def _same_robot(written_for: Robot, given: Robot | None, path: Path) -> None:
    if given is not None and given != written_for:
        raise InputError(
            f"gait of another robot: '{path}' was written for '{written_for.name}' (hash {written_for.hash[:12]}), "
            f"not for '{given.name}' (hash {given.hash[:12]})"
        )


def _gait_from(reader: Reader, robot: Robot) -> Gait:
    versions = reader.inside("versions")
    pattern = _pattern_from(reader.inside("pattern"), robot)
    outputs = _outputs_from(reader.inside("outputs"), pattern)
    gains = reader.inside("gains").expect("position", "velocity")
    solved = [stance.name for stance in pattern.solved]
    domains = reader.inside("domains").expect(*solved)
    feedback, multipliers = reader.raw("feedback"), reader.raw("multipliers")
    report = solver_from(reader.inside("solver"))
    return Gait(
        pattern=pattern,
        outputs=outputs,
        law=law_from(*_kind_from(reader.inside("law"))),
        speed=reader.number("speed", "m/s"),
        gains=(gains.number("position", "1/s^2"), gains.number("velocity", "1/s")),
        limits=limits_from(reader.inside("limits"), pattern),
        domains=tuple(domain_from(domains.inside(name), name, pattern, outputs) for name in solved),
        solver=report,
        feedback=None if feedback is None else feedback_from(reader.inside("feedback"), pattern, outputs),
        versions={name: versions.text(name) for name in versions.names()},
        multipliers=None if multipliers is None else multipliers_from(reader.inside("multipliers"), report),
    )


def _pattern_from(reader: Reader, robot: Robot) -> GaitPattern:
    reader.expect("name", "mirrored", "stances", "ground", "contact")
    rows = reader.raw("stances")
    if not isinstance(rows, list) or not all(
        isinstance(row, list) and all(isinstance(f, str) for f in row) for row in rows
    ):
        raise InputError("the stances of the gait file are not lists of feet")
    ground, contact = (_kind_from(reader.inside(key)) for key in ("ground", "contact"))
    return gait_pattern(
        robot,
        rows,
        reader.flag("mirrored"),
        reader.text("name"),
        GROUNDS.build(*ground),
        CONTACTS.build(*contact),
    )


def _kind_from(reader: Reader) -> tuple[str, Json]:
    """Read a name with its parameters."""
    reader.expect("name", "parameters")
    parameters = reader.raw("parameters")
    if not isinstance(parameters, dict):
        raise InputError(f"the parameters of '{reader.text('name')}' in the gait file are not an object")
    return reader.text("name"), parameters


def _outputs_from(reader: Reader, pattern: GaitPattern) -> Outputs:
    reader.expect("order", "domains")
    solved = [stance.name for stance in pattern.solved]
    entries = reader.inside("domains").expect(*solved)
    known = controllable(pattern.robot)
    domains = []
    for name in solved:
        coordinates = entries.texts(name)
        Reader(dict.fromkeys(coordinates), "the outputs of the gait file").expect_among("coordinate", known)
        if len(set(coordinates)) != len(coordinates):
            raise InputError(f"the outputs of domain '{name}' in the gait file repeat a coordinate")
        domains.append(DomainOutputs(name, coordinates))
    return Outputs(tuple(domains), reader.count("order"))
