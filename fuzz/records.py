"""Records of libraries, of transitions and of proofs, tables of commands and logs, and the SRDF beside a robot."""

from __future__ import annotations

import json
import logging
import random
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzz import gait_bases, robots, toml
from fuzz.bytes import damaged
from fuzz.kinds import biped_urdf, damaged_xml
from fuzz.trees import as_json, damage, with_literals
from fuzz.words import LITERALS, NAMES

if TYPE_CHECKING:
    from amble.gait import Gait

SPEEDS = (0.2, 0.3)

SPECIFICATION: dict[str, Any] = {
    "robot": {"file": "biped.urdf", "feet": {"l": "l_foot", "r": "r_foot"}, "twins": [["l", "r"]]},
    "gait": {"speed": "0.2 m/s", "stances": [["l"], ["r"]], "mirrored": False},
    "limits": {
        **{"clearance": "2 cm", "normal_force": 5.0, "duration": [0.1, "0.3 s"], "torque": "60 N m"},
        **{"speed": "8 rad/s", "acceleration": 60.0, "base": {"z": [0.3, 0.6], "roll": [-0.1, 0.1]}},
        "touchdown_velocity": {"x": [-0.2, 0.3], "y": [-0.1, 0.1], "z": [-2.0, -0.1]},
    },
    "ground": {"friction": 0.6},
    "outputs": {"order": 4},
    "posture": {"height": "0.5 m", "angles": dict.fromkeys(robots.biped().joint_names, "5 deg")},
    "solver": {"intervals": 5, "refinement": 1, "tolerance": 1e-8, "iterations": 100},
}
"""Of a biped from a file."""

AXES: dict[str, Any] = {
    "speed": {"range": [0.2, "0.4 m/s"], "step": 0.1},
    "height": {"range": [0.4, 0.5], "step": 0.05},
    "slope": {"range": ["-2 deg", "2 deg"], "step": "1 deg"},
    "friction": {"range": [0.6, 0.8], "step": 0.1},
    "payload": {"range": [0.0, 1.0], "step": 0.5},
    "yaw_rate": {"range": [-0.1, 0.1], "step": 0.1},
    "lateral_speed": {"range": [0.0, 0.05], "step": 0.05},
}


def _with_bytes(content: bytes, done: list[str], draw: random.Random) -> tuple[bytes, list[str]]:
    if draw.random() < 0.12:
        content, what = damaged(content, draw)
        done.append(what)
    return content, done


def _damaged(tree: dict[str, Any], draw: random.Random) -> tuple[bytes, list[str]]:
    done = [damage(tree, draw) for _ in range(draw.choice((1, 1, 1, 2, 3))) if tree]
    return _with_bytes(as_json(tree, draw), done, draw)


# libraries -----------------------------------------------------------------------------------------------------------


def draw_library(draw: random.Random) -> tuple[bytes, list[str]]:
    """A specification with axes; the damage is to the axes more often than elsewhere."""
    tree = json.loads(json.dumps(SPECIFICATION))
    names = draw.sample(list(AXES), draw.choice((1, 1, 2)))
    library: dict[str, Any] = {"library": {"time_limit": "600 s", "axes": {name: AXES[name] for name in names}}}
    library = json.loads(json.dumps(library))
    done = [damage(library if draw.random() < 0.8 else tree, draw) for _ in range(draw.choice((1, 1, 2))) if library]
    text = with_literals(toml.as_toml({**tree, **library}), draw)
    return _with_bytes(text.encode("utf-8", "surrogatepass"), done, draw)


def read_library(path: Path) -> Any:
    """Read the axes, pose the first gait and those at the ends, and claim a folder for them."""
    from amble.workflow.library.axes import check_ends, read_library
    from amble.workflow.library.files import claim_folder

    path.with_name("biped.urdf").write_text(biped_urdf(), encoding="utf-8")
    library, folder = read_library(path), path.with_suffix(".library")
    check_ends(library)
    shutil.rmtree(folder, ignore_errors=True)
    claim_folder(folder, library)
    claim_folder(folder, library)  # again it is its own
    return library


@cache
def _folder() -> dict[str, bytes]:
    """Files of a library with its transitions."""
    from amble.gait.files import load_gait

    with tempfile.TemporaryDirectory() as folder:
        write_library(Path(folder), load_gait(gait_bases.SOUND["biped-of-small-basin"]))
        return {str(file.relative_to(folder)): file.read_bytes() for file in Path(folder).rglob("*.json")}


def write_library(place: Path, gait: Gait) -> None:
    """Write a library of one gait at two speeds, which it says is certified, with transitions that were not found."""
    from amble.gait.files import content_hash, save_gait
    from amble.gait.impedance import Impedance
    from amble.workflow.library.entry import Made
    from amble.workflow.library.files import write_entry

    place.mkdir(exist_ok=True)
    (place / "library.json").write_text(json.dumps({"format": "amble library", "format_version": 1}))
    steered = replace(gait, control=Impedance())
    for speed in SPEEDS:
        numbers = {"radius": 0.5, "linear_solver": "mumps", "iterations": 12, "from_neighbour": True, "growth": None}
        made = Made(stage="certify", reason="no", gait=gait, numbers=numbers, seconds={"solve": 1.5}, notes=["odd"])
        entry = write_entry(place, {"speed": speed}, None, made)
        _certified(place, entry.label)
        save_gait(steered, place / "transitions" / f"{entry.label}.json")
    told = {
        **{"format": "amble transitions", "format_version": 1, "axes": ["speed"], "units": ["m/s"]},
        "gaits": {f"speed_{speed:g}": content_hash(steered) for speed in SPEEDS},
        **{"changes": [0.01], "friction": 0.7, "walked_changes": [0.02], "contraction_bound_of_a_step": 0.5},
        "orbits": [{"command": [0.2], "speed_m_s": 0.2, "step_s": 0.15, "radius_of_a_step": 0.5}],
    }
    (place / "transitions" / "transitions.json").write_text(json.dumps(told))


def _certified(place: Path, label: str) -> None:
    """Say of a gait that failed that it is certified."""
    record = place / "records" / f"{label}.json"
    tree = json.loads(record.read_text())
    tree.update(certified=True, reason="", file=f"gaits/{label}.json")
    record.write_text(json.dumps(tree))
    for folder in ("gaits", "certificates"):
        (place / folder).mkdir(exist_ok=True)
    (place / "failed" / f"{label}.json").rename(place / "gaits" / f"{label}.json")
    (place / "certificates" / f"{label}.json").write_text(json.dumps({"gait": {"content_hash": tree["hash"]}}))


FIRST = f"speed_{SPEEDS[0]:g}"
RECORD, HEADER = f"records/{FIRST}.json", "transitions/transitions.json"


def drawer(file: str) -> Callable[[random.Random], tuple[bytes, list[str]]]:
    """Return what draws a file of a library."""

    def draw(chance: random.Random) -> tuple[bytes, list[str]]:
        return _damaged(json.loads(_folder()[file]), chance)

    return draw


def _library_with(path: Path, file: str) -> Path:
    """A library in which one file is the input."""
    place = path.with_suffix(".library")
    shutil.rmtree(place, ignore_errors=True)
    for name, content in _folder().items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_bytes(path.read_bytes() if name == file else content)
    return place


def read_record(path: Path) -> Any:
    """Read a library with a record, load its gaits and write its tables and maps."""
    from amble.workflow.library.files import load_library, write_tables

    found = load_library(_library_with(path, RECORD))
    write_tables(found)
    for entry in found.entries:
        if entry.label == FIRST:
            found.gait(entry)
    return found


def read_transitions(path: Path) -> Any:
    """Read transitions, and ask for the law between two gaits and the commands of a walk."""
    from amble.workflow.library.between import load_transitions

    found = load_transitions(_library_with(path, HEADER))
    found.schedule.law([0.5 * (row[0] + row[-1]) for row in found.schedule.values])
    return found


# tables --------------------------------------------------------------------------------------------------------------


def draw_commands(draw: random.Random) -> tuple[bytes, list[str]]:
    """Commands of speed, with cells that are none."""
    rows = [["time", "speed"], *([f"{0.5 * k:g}", f"{0.2 + 0.01 * k:g}"] for k in range(8))]
    return _cells(rows, draw)


def _cells(rows: list[list[str]], draw: random.Random) -> tuple[bytes, list[str]]:
    done = []
    for _ in range(draw.choice((1, 1, 2, 4))):
        row = draw.choice(rows)
        at = draw.randrange(len(row) or 1)
        kind = draw.choice(("cell", "cell", "cell", "gone", "quote", "extra", "twice", "swap"))
        done.append(kind)
        if kind == "cell" and row:
            row[at] = draw.choice((*NAMES, *LITERALS[:20], "1e308", "-1e-320", "nan", "0.2", "9" * 200_000))
        elif kind == "gone":
            del row[at:]
        elif kind == "quote" and row:
            row[at] = f'"{row[at]}'
        elif kind == "extra":
            row.append("1")
        elif kind == "twice":
            rows.insert(draw.randrange(len(rows)), list(row))
        else:
            draw.shuffle(rows)
    text = "\n".join(",".join(row) for row in rows) + "\n"
    return _with_bytes(text.encode("utf-8", "surrogatepass"), done, draw)


def read_commands(path: Path) -> Any:
    """Read commands, and hold them against what a walk takes."""
    from amble.simulation.steering import Steered, checked_commands
    from amble.workflow.library.commands import read_commands, write_steered

    found = tuple(read_commands(path, ("speed",)))
    checked_commands(_schedule(), found, (0.01,), 1.0)
    write_steered(
        Steered(axes=("speed",), state_names=(), steps=(), time=1.0, state=np.zeros(0), ended="completed"),
        path.with_suffix(".steered"),
    )
    return found


@cache
def _schedule() -> Any:
    from amble.gait.schedule import Schedule

    gait = _log_gait()
    return Schedule(
        gait=gait,
        axes=("speed",),
        values=(SPEEDS,),
        tables=np.zeros((2, 1, 1)),
        starts=np.zeros((2, 2 * gait.robot.size)),
    )


def draw_log(draw: random.Random) -> tuple[bytes, list[str]]:
    """A log of the biped's joints, with torques now and then."""
    joints, torques = _log_gait().robot.joint_names, draw.random() < 0.5
    head = ["time", *joints, *(f"torque {joint}" for joint in joints if torques)]
    rows = [head, *([f"{0.05 * k:g}", *(f"{0.1 * (k % 5):g}" for _ in head[1:])] for k in range(24))]
    return _cells(rows, draw)


@cache
def _log_gait() -> Any:
    from amble.gait.files import load_gait

    return load_gait(gait_bases.SOUND["biped-of-small-basin"])


def read_log(path: Path) -> Any:
    """Read a log, and hold it against its gait."""
    from amble.analysis.log_comparison import compare_log, read_log

    gait = _log_gait()
    log = read_log(path, gait)
    return compare_log(gait, log) if path.stat().st_size % 8 == 0 else log  # which takes 0.2 s


# proofs --------------------------------------------------------------------------------------------------------------


def draw_proof(draw: random.Random) -> tuple[bytes, list[str]]:
    """A proof as a file has it; no reader sees whether its numbers follow."""
    pair = ["1234567e-7", "1234568e-7"]
    tree: dict[str, Any] = {
        **{"format": "amble proof", "version": 3, "system": "0" * 64, "half": False},
        "software": {"amble": "0.1.0", "python-flint": "0.8.0"},
        "found": {
            **{"order": 20, "bits": 128, "centre": ["123p-7", "-5p-3"], "radii": ["1p-60", "1p-60"]},
            **{"steps": [["1p-5", "3p-6"]], "weight": [[1.0, 0.0], [0.0, 1.0]], "rate": 0.25},
            **{"basin_weight": [[1.0, 0.0], [0.0, 1.0]], "basin_size": 1e-4, "basin_steps": [["1p-5"]]},
        },
        "proved": {
            **{"state": {"angle": pair, "rate": pair}, "shift": {"x": pair}, "durations": [pair]},
            **{"margins": [{"angle": "12e-3"}], "multipliers": [[pair, pair]], "unstable": None},
            **{"basin_rate": 0.5, "basin_extent": [1e-4, 1e-4], "distance": {"force_N": "12e-14"}},
        },
        "basin_limit": "the last crossing is not enclosed",
    }
    return _damaged(tree, draw)


def read_proof(path: Path) -> Any:
    """Read a proof, and write it again."""
    from amble.proof.record import load_proof, save_proof

    proof = load_proof(path)
    if load_proof(save_proof(path.with_suffix(".again"), proof)) != proof:
        raise AssertionError("a proof that was read and written reads back as another")
    return proof


# the SRDF beside a robot ---------------------------------------------------------------------------------------------


def draw_srdf(draw: random.Random) -> tuple[bytes, list[str]]:
    """Group states of the biped with damage to attributes and elements."""
    joints = robots.biped().joint_names
    values = [draw.choice(("0.1", "0", "0.1", "1e9", "-2")) for _ in joints]
    inside = "".join(f'<joint name="{joint}" value="{value}"/>' for joint, value in zip(joints, values, strict=True))
    state = (
        '<group_state name="{}" group="all"><joint name="root" value="0 0 0.3 0 0 0 1"/>' + inside + "</group_state>"
    )
    text = f'<robot name="biped"><group name="all"/>{state.format("standing")}{state.format("lying")}</robot>'
    return damaged_xml(text, draw)


def read_srdf(path: Path) -> Any:
    """Find the posture of a robot in the file beside its own."""
    from amble.robot import load_robot
    from amble.robot.srdf import read_srdf, srdf_posture

    beside = path.with_suffix(".urdf")
    beside.write_text(biped_urdf(), encoding="utf-8")
    heard = _Heard()
    logger = logging.getLogger("amble")
    logger.addHandler(heard)
    try:
        found = srdf_posture(load_robot(beside, {"l": "l_foot", "r": "r_foot"}), beside)
    finally:
        logger.removeHandler(heard)
    if any(not line.isprintable() or len(line) > 2000 for line in heard.lines):
        raise AssertionError("a notice is no printable sentence")
    return found if found is not None else read_srdf(path)


class _Heard(logging.Handler):
    """Keeps what is said."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep one line."""
        self.lines.append(record.getMessage())
