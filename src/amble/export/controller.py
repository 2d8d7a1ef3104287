"""Write the controller of a gait as a folder of self-contained C99."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from amble.codegen.cache import content_key
from amble.control import AllocationLaw
from amble.errors import InputError, listed
from amble.export.code import Code, build_rules, c_code, filled, template
from amble.export.impedance import LONGEST, impedance_files, impedance_texts
from amble.export.law import LATEST, StanceLaw, stance_laws, tables
from amble.export.schedule import schedule_texts
from amble.export.turning import turning_code
from amble.export.vectors import DAMPING, smallest_pivot, test_vectors
from amble.gait import Gait
from amble.gait.impedance import Impedance
from amble.gait.linearising_law import control_of
from amble.gait.schedule import Schedule
from amble.hybrid import ONE_BY_ONE
from amble.io.storage import check_replaceable, replacing_folder
from amble.version import __version__

logger = logging.getLogger("amble")

PIVOT_SHARE = 1e-3
"""Rank counts as lost where the smallest pivot falls below this share of the smallest one along the gait."""

FILES = ("amble_controller.h", "amble_controller.c", "replay.c", "CMakeLists.txt", "test_vectors.txt")
"""Every file of the folder but the laws."""


@dataclass(frozen=True)
class Exported:
    """A written controller.

    Attributes:
        folder: where it is.
        sources: C files of the controller, without the program that replays the vectors.
        files: every file that was written.
        laws: what each solved stance evaluates, then each between the landings into one.
    """

    folder: Path
    sources: tuple[Path, ...]
    files: tuple[Path, ...]
    laws: tuple[StanceLaw, ...]


def export_controller(gait: Gait, law: AllocationLaw | None, folder: str | Path) -> Exported:
    """Write the controller of a gait as C99 without heap.

    The folder gets amble_controller.h and .c (state, phase clock, switching, rank monitor, saturation, fallback), one C
    file of generated code for every solved stance and every one between the landings into it, test_vectors.txt,
    replay.c and CMakeLists.txt. It is replaced as a whole, and files of two controllers do not compile together: each
    holds an id of the content of all.

    Under ``Impedance`` the controller reads joints and contacts alone and has no generated code: the commands of motor
    drivers, a clock of its own, touchdown confirmed (docs/export.md).

    Args:
        gait: the gait; with feedback its stabilised outputs are used.
        law: another allocation law than the gait's.
        folder: where to write; it is made where it does not exist, and may hold nothing but an earlier controller.

    Raises:
        InputError: where a stance has no feet, or the folder cannot be written or holds other files.
        WorkError: where writing fails for another reason, or the generated code has an unknown form.
    """
    control = control_of(gait)
    if not isinstance(control, Impedance):
        return export_state_controller(gait, law, folder)
    _require(gait, folder)
    return _impedance(folder, impedance_texts(gait, control, law), _comments(gait, law or gait.law))


def export_schedule(schedule: Schedule, changes: Sequence[float], folder: str | Path) -> Exported:
    """Write a gain-scheduled impedance law as C99: the interface of one gait under impedance, and a command.

    ``amble_steer`` asks for a command, which is approached from step to step as in ``amble.steer``.

    Args:
        schedule: the law, such as ``Transitions.schedule``.
        changes: how far the command of every axis may move from step to step (``Transitions.changes``).
        folder: as in ``export_controller``.

    Raises:
        InputError: a stance has no feet, a change is not positive, or the folder cannot be written.
    """
    gait = schedule.gait
    _require(gait, folder)
    ranges = (
        f"{axis} {row[0]:g} to {row[-1]:g} ({len(row)} gaits)"
        for axis, row in zip(schedule.axes, schedule.values, strict=True)
    )
    own = _comments(gait, gait.law)
    title = f"Walking controller: {gait.pattern.name}, {', '.join(ranges)}."
    comments = {**own, "TITLE": title, "AXES_NAMES": ", ".join(schedule.axes)}
    return _impedance(folder, schedule_texts(schedule, changes), comments)


def _impedance(
    folder: str | Path, texts: tuple[dict[str, str], dict[str, str]], comments: Mapping[str, str]
) -> Exported:
    """Write a controller under impedance from what its templates leave open."""
    code, vectors = texts
    draft = {**impedance_files(code, comments, "0"), **vectors}
    files = impedance_files(code, comments, f"0x{content_key(draft.values())[:16]}ULL")
    return _written(folder, {**files, **vectors}, ["amble_controller.c"], [])


def export_state_controller(gait: Gait, law: AllocationLaw | None, folder: str | Path) -> Exported:
    """Write a controller that reads the whole state and evaluates the law with a model; see ``export_controller``."""
    _require(gait, folder)
    chosen = law or gait.law
    laws = stance_laws(gait, law)
    codes = [
        c_code(law.function, f"Law of stance {law.stance.name}, feet {', '.join(law.stance.feet)}.") for law in laws
    ]
    vectors = "".join(f"{vector.line()}\n" for vector in test_vectors(gait, laws))
    code, comments = _code(gait, laws, codes), _comments(gait, chosen)
    draft = _contents(codes, code, comments, vectors, "0")
    contents = _contents(codes, code, comments, vectors, f"0x{content_key(draft.values())[:16]}ULL")
    sources = [f"{code.name}.c" for code in codes] + ["amble_controller.c"]
    return _written(folder, contents, sources, laws)


def _require(gait: Gait, folder: str | Path) -> None:
    """Refuse what cannot be exported or written, before the work; say where C is not what the simulation is."""
    check_replaceable(folder, _is_exported)
    if together := [step.name for step in gait.pattern.steps if len(step.landing) > 1]:
        logger.warning(
            "by the landing rule '%s' the feet of %s stop at one instant in simulation and certificate; the exported "
            "code awaits the last of them: '%s' is followed by all",
            *(gait.pattern.landing_rule, listed(together), ONE_BY_ONE),
        )
    for stance in gait.pattern.stances:
        if not stance.feet:
            raise InputError(f"stance '{stance.name}' has no foot on the ground; such gaits cannot be exported yet")


def _written(
    folder: str | Path, contents: Mapping[str, str], sources: Sequence[str], laws: Sequence[StanceLaw]
) -> Exported:
    with replacing_folder(folder, _is_exported) as fresh:
        for name, text in contents.items():
            (fresh / name).write_bytes(text.encode())
    place = Path(folder)
    return Exported(
        place, tuple(place / name for name in sources), tuple(place / name for name in contents), tuple(laws)
    )


def _is_exported(name: str) -> bool:
    """Whether an earlier export may have written a file of this name."""
    return name in FILES or (name.startswith("amble_law_") and name.endswith(".c"))


def _contents(
    codes: list[Code], code: Mapping[str, str], comments: Mapping[str, str], vectors: str, content: str
) -> dict[str, str]:
    """File name -> text; every file that is compiled into the controller holds the content id and tests it."""
    test = filled(template("same_export.c"), {"CONTENT": content})
    inside = {**code, "CONTENT": content}
    return {
        **{f"{code.name}.c": code.text + test for code in codes},
        "amble_controller.h": filled(template("controller.h"), inside, comments),
        "amble_controller.c": filled(template("controller.c"), inside, comments) + test,
        "replay.c": template("replay.c"),
        "CMakeLists.txt": build_rules([f"{code.name}.c" for code in codes]),
        "test_vectors.txt": vectors,
    }


def _comments(gait: Gait, law: AllocationLaw) -> Mapping[str, str]:
    """What the templates leave open in comments: text that may come from anywhere."""
    return {
        "TITLE": f"Walking controller: {gait.pattern.name}, {gait.speed:g} m/s.",
        "VERSION": __version__,
        "GAIT": gait.pattern.name,
        "ROBOT": gait.robot.name,
        "LAW": law.name,
        "CONTROL": control_of(gait).name,
        "JOINTS": ", ".join(gait.robot.joint_names),
        "FEET": ", ".join(gait.robot.foot_names),
        "AXES_NAMES": "nothing",
    }


def _code(gait: Gait, laws: list[StanceLaw], codes: list[Code]) -> Mapping[str, str]:
    """What the templates leave open in code."""
    robot = gait.robot
    return {
        "COORDINATES": str(robot.size),
        "JOINT_COUNT": str(len(robot.joints)),
        "FOOT_COUNT": str(len(robot.feet)),
        "FORCE_COUNT": str(gait.pattern.all_contacts.size),
        "COMPONENTS": ", ".join(gait.pattern.contact.labels),
        "GAIT_STANCES": str(len(gait.pattern.stances)),
        "STANCE_COUNT": str(len(gait.pattern.visited)),
        "WORK": str(max(1, *(code.work for code in codes))),
        "INTEGERS": str(max(1, *(code.integers for code in codes))),
        "LATEST": f"{LATEST:g}",
        "LONGEST": repr(LONGEST * min(law.duration for law in laws)),
        "DAMPING": repr(DAMPING),
        "TABLES": tables(
            gait,
            laws,
            PIVOT_SHARE * smallest_pivot(gait, laws),
            max(code.arguments for code in codes),
            max(code.results for code in codes),
        ),
        **turning_code(gait),
        "PROTOTYPES": "\n".join(
            f"int {code.name}(const double **arg, double **res, long long *iw, double *w);" for code in codes
        ),
        "EVALUATIONS": ", ".join(code.name for code in codes),
    }
