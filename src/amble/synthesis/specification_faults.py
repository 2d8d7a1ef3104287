"""What is wrong with a specification, in one sentence and in the words of the file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from amble.errors import InputError, UnknownNameError, shown


def lacking(tree: Mapping[str, Any]) -> list[str]:
    """Say in the words of the file what is not there and has no default, all at once."""
    robot, gait = (tree.get(key, {}) for key in ("robot", "gait"))
    if not (isinstance(robot, Mapping) and isinstance(gait, Mapping)):
        return []  # which is said when they are read
    found = []
    if not robot.keys() & {"name", "file"}:
        found.append("[robot] name (of the catalogue) or file (URDF)")
    if "file" in robot and not robot.get("feet") and "name" not in robot:
        found.append("[robot] feet (labels and the links or joints they stand for)")
    if not gait.keys() & {"name", "stances", "footfalls"}:
        found.append("[gait] name or stances (a table of stance feet) or footfalls (phases and duty factors)")
    if "speed" not in gait:
        found.append("[gait] speed")
    return found


def in_one_sentence(file: str, error: ValidationError, kind: type[BaseModel]) -> InputError:
    """Word the first fault that validation found in a file of a kind."""
    first = error.errors()[0]
    place, name = [str(part) for part in first["loc"]], shown(file)
    if first["type"] == "extra_forbidden":
        table = ".".join(place[:-1])
        return UnknownNameError(f"key in {f'[{table}] of ' if table else ''}{name}", place[-1], _keys(kind, place[:-1]))
    where = f"{name}: '{shown('.'.join(place))}'"
    if first["type"] == "missing":
        return InputError(f"{where} is missing")
    reason = str(first["ctx"]["error"]) if first["type"] == "value_error" else first["msg"]
    return InputError(f"{where}: {shown(reason[0].lower() + reason[1:], 300)}")


def _keys(model: type[BaseModel], place: list[str]) -> list[str]:
    """Return the keys of the table at a place."""
    for part in place:
        annotation = model.model_fields[part].annotation
        candidates = [annotation, *getattr(annotation, "__args__", ())]
        model = next(each for each in candidates if isinstance(each, type) and issubclass(each, BaseModel))
    return list(model.model_fields)
