"""Gaits that load, through everything that is done with one: check, certificate, export, compilation of the export.

What is drawn here is damaged gently, so that most of it loads. A certificate of a gait whose motion was not touched
must state what that of the sound gait states.
"""

from __future__ import annotations

import json
import random
import shutil
import subprocess
import tempfile
from functools import cache, partial
from pathlib import Path
from typing import Any

from fuzz import gait_bases
from fuzz.kinds import rehash
from fuzz.oracle import Verdict, judged
from fuzz.trees import drawn_place, get, put
from fuzz.words import NAMES

SECONDS = 60
"""Processor time of one gait; certifying the sound one of ASTRo takes 8 s."""

SHARES = {"biped-of-small-basin": 0.2, "stabilised-amble": 0.02}
"""Shares of damaged copies of the sound gaits, which come as far as their closed loop; the rest are no motions."""

COMPILE = ("cc", "-fsyntax-only", "-std=c99", "-Wall", "-Wextra", "-Werror")
RADIUS = 1e-6
"""Two certificates of one motion; what differs is the rounding of another order of sums."""

UNTOUCHED = ("names", "versions", "solver", "limits", "multipliers")
GENTLY = ("weights", "start", "record")
TOUCHED = ("number", "number", "numbers", "law", "gains", "ground", "robot", "feedback", "parent", "speed", "order")


def draw_walker(draw: random.Random) -> tuple[bytes, list[str]]:
    """A gait file with damage that leaves it a gait, most often."""
    base = draw.choices((*SHARES, ""), (*SHARES.values(), 1.0 - sum(SHARES.values())))[0]
    text = gait_bases.SOUND[base].read_text(encoding="utf-8") if base else gait_bases.small(draw.randrange(12))
    tree = json.loads(text)
    kinds: tuple[str, ...] = (*UNTOUCHED, *TOUCHED)
    if base:
        kinds = draw.choice((UNTOUCHED, (*UNTOUCHED, *GENTLY), kinds))
    done = []
    for _ in range(draw.choice((1, 1, 2, 3))):
        kind = draw.choice(kinds)
        globals()[f"_{kind}"](tree, draw)
        done.append(kind)
    rehash(tree)
    if base and set(done) <= set(UNTOUCHED):
        tree["versions"][MOTION] = base
    return json.dumps(tree).encode("utf-8", "surrogatepass"), done


MOTION = "motion of"
"""In the versions of a file whose motion is that of a sound gait: its name."""


def _allowed_name(draw: random.Random) -> str:
    while True:
        name = draw.choice(NAMES) + draw.choice(("", "", draw.choice(NAMES)))
        if 0 < len(name) <= 100 and name.isprintable() and name == name.strip():
            return name


def _renamed(entry: Any, old: str, new: str) -> Any:
    if isinstance(entry, dict):
        return {new if key == old else key: _renamed(one, old, new) for key, one in entry.items()}
    if isinstance(entry, list):
        return [_renamed(one, old, new) for one in entry]
    return new if entry == old else entry


def _names(tree: Any, draw: random.Random) -> None:
    robot, new = tree["robot"], _allowed_name(draw)
    kind = draw.choice(("joints", "feet", "links", "robot", "pattern", "frame"))
    if kind == "robot":
        robot["name"] = new
    elif kind == "pattern":
        tree["pattern"]["name"] = new
    elif kind == "frame":
        draw.choice(robot["feet"])["frame"] = new
    elif kind == "links":
        draw.choice(robot["links"])["name"] = new
    else:
        old = draw.choice(robot[kind])["name"]
        for part in list(tree):
            tree[part] = _renamed(tree[part], old, new)


def _versions(tree: Any, draw: random.Random) -> None:
    tree["versions"][_allowed_name(draw)] = _allowed_name(draw)


def _solver(tree: Any, draw: random.Random) -> None:
    tree["solver"][draw.choice(("solver", "status"))] = _allowed_name(draw)
    tree["solver"][draw.choice(("seconds", "violation"))]["value"] = draw.choice((0.0, 1e308, -1.0))


def _limits(tree: Any, draw: random.Random) -> None:
    part = tree["limits"][draw.choice(("durations", "positions", "speeds", "torques"))]
    entry = part[draw.choice(list(part))] if part else {"value": 1.0}
    wide: tuple[Any, Any] = draw.choice(((-1e3, 1e3), (-1e200, 1e200), ("-inf", "inf"), (1e-3, 1e3)))
    entry["value"] = list(wide) if isinstance(entry["value"], list) else wide[1]


def _multipliers(tree: Any, draw: random.Random) -> None:
    del draw
    tree.pop("multipliers", None)


def _one_number(tree: Any, part: Any, draw: random.Random, whole: bool = False) -> None:
    """Change a number, or all numbers of an array, by a little or by a lot."""
    for _ in range(50):
        path = drawn_place(part, draw)
        value = get(part, path)
        number = isinstance(value, float | int) and not isinstance(value, bool)
        if whole and path and path[-1] == "value" and isinstance(value, list):
            factor = draw.choice((-1.0, 0.0, 1.01, 2.0, 1e3, 1e100))
            put(part, path, _times(value, factor))
            return
        if not whole and number and path:
            put(part, path, draw.choice((value * 1.0001, value + 0.01, -value, value * 1e3, value * 1e-12, 0 * value)))
            return


def _times(entry: Any, factor: float) -> Any:
    if isinstance(entry, list):
        return [_times(one, factor) for one in entry]
    return entry * factor if isinstance(entry, int | float) else entry


def _number(tree: Any, draw: random.Random) -> None:
    _one_number(tree, tree[draw.choice(("domains", "limits", "control_law", "robot", "outputs"))], draw)


def _numbers(tree: Any, draw: random.Random) -> None:
    _one_number(tree, tree["domains"], draw, whole=True)


def _law(tree: Any, draw: random.Random) -> None:
    name, parameters = draw.choice(gait_bases.LAWS)
    joints = [joint["name"] for joint in tree["robot"]["joints"]]
    if name == "weighted":
        parameters = {"weights": {draw.choice(joints): {"value": draw.choice((2.0, 1e-9, 1e12)), "unit": "1"}}}
    if name == "drop":
        parameters = {"joints": draw.sample(joints, draw.choice((0, 1, 1, 2)))}
    if name == "bounded":
        parameters = {"friction": {"value": draw.choice((0.1, 1e-9, 3.0)), "unit": "1"}}
    tree["allocation_law"] = {"name": name, "parameters": parameters}


def _gains(tree: Any, draw: random.Random) -> None:
    gain = tree["control_law"][draw.choice(("position_gain", "velocity_gain"))]
    gain["value"] = draw.choice((0.0, -1.0, 1e-6, 1e4, 1e12, 1e300))


def _ground(tree: Any, draw: random.Random) -> None:
    entry = tree["ground"]["parameters"][draw.choice(list(tree["ground"]["parameters"]))]
    entry["value"] = draw.choice((0.1, 0.5, 1e-12, 1.0, -0.2, 2.0))


def _robot(tree: Any, draw: random.Random) -> None:
    _one_number(tree, tree["robot"], draw, whole=draw.random() < 0.3)


def _feedback(tree: Any, draw: random.Random) -> None:
    if "feedback" in tree:
        _one_number(tree, tree["feedback"], draw, whole=draw.random() < 0.3)


def _parent(tree: Any, draw: random.Random) -> None:
    joints = tree["robot"]["joints"]
    draw.choice(joints)["parent"] = draw.randrange(len(joints) + 1)


def _speed(tree: Any, draw: random.Random) -> None:
    tree["speed"]["value"] = draw.choice((0.0, -0.2, 1e300, 5.0, 1e-300))


def _order(tree: Any, draw: random.Random) -> None:
    """One more coefficient everywhere."""
    tree["outputs"]["order"] += 1
    for domain in tree["domains"].values():
        for row in domain["coefficients"]["value"]:
            row.append(draw.uniform(-1.0, 1.0))


def _weights(tree: Any, draw: random.Random) -> None:
    """Another stabilising feedback, most often: the orbit stays, the radius does not."""
    size = draw.choice((1e-12, 1e-6, 1e-3))
    for entry in tree["feedback"]["weights"].values():
        entry["value"] = _noisy(entry["value"], size, draw)


def _start(tree: Any, draw: random.Random) -> None:
    tree["feedback"]["start"]["value"] = _noisy(tree["feedback"]["start"]["value"], 1e-9, draw)


def _record(tree: Any, draw: random.Random) -> None:
    """What is recorded, near the motion."""
    domain = draw.choice(list(tree["domains"].values()))
    entry = domain[draw.choice(("accelerations", "torques", "forces"))]
    entry["value"] = _noisy(entry["value"], draw.choice((1e-12, 1e-6, 1e-3)), draw)


def _noisy(entry: Any, size: float, draw: random.Random) -> Any:
    if isinstance(entry, list):
        return [_noisy(one, size, draw) for one in entry]
    return entry * (1.0 + size * draw.uniform(-1.0, 1.0))


def walk(path: Path, folder: Path | None = None) -> Verdict:
    """Load a gait and do everything with it that is done with one; the first failure counts."""
    from amble.gait.files import load_gait

    loaded: list[Any] = []
    verdict = judged(lambda file: loaded.append(load_gait(file)), path)
    if verdict.outcome != "loaded":
        return verdict
    with tempfile.TemporaryDirectory(dir=folder) as place:
        outcomes = []
        for step in (_check, _certify, _export):
            verdict = judged(partial(step, loaded[0]), Path(place), exit_codes=(1, 2))
            if verdict.outcome == "failed":
                return Verdict("failed", verdict.reason, f"{step.__name__.strip('_')}: {verdict.signature}")
            outcomes.append(
                f"{step.__name__.strip('_')} {verdict.reason if verdict.outcome == 'loaded' else 'refused'}"
            )
    return Verdict("loaded", "; ".join(outcomes))


def _check(gait: Any, place: Path) -> list[str]:
    from amble.verification.check import check

    del place
    report = check(gait, 1)
    str(report)
    return ["passed" if report.passed else "failed"]


def _certify(gait: Any, place: Path) -> list[str]:
    from amble.errors import WorkError
    from amble.workflow.certify import certify_into

    out = place / "certificate.json"
    try:
        certificate = certify_into(gait, out)
    except WorkError:
        if json.loads(out.read_text(encoding="utf-8"))["certified"] is not False:
            raise AssertionError("a refusal is written as a certificate") from None
        raise
    if not certificate.radius < 1.0:
        raise AssertionError(f"a certificate of radius {certificate.radius}")
    base = gait.versions.get(MOTION)
    if base is not None and abs(certificate.radius - sound_radius(base)) > RADIUS:
        raise AssertionError(f"a certificate of radius {certificate.radius} for a motion of {sound_radius(base)}")
    return ["certified"]


@cache
def sound_radius(base: str) -> float:
    """The spectral radius that is certified of a sound gait."""
    from amble.gait.files import load_gait
    from amble.stability import certify

    return float(certify(load_gait(gait_bases.SOUND[base])).radius)


def _export(gait: Any, place: Path) -> list[str]:
    from amble.export import export_controller

    exported = export_controller(gait, None, place / "controller")
    compiler = shutil.which(COMPILE[0])
    if compiler is None:
        raise AssertionError("no C compiler to try the export with")
    command = [compiler, *COMPILE[1:], *map(str, exported.sources), str(exported.folder / "replay.c")]
    bound = ("sh", "-c", f'ulimit -t {SECONDS} && exec "$@"', "sh")  # processor time: the machine may be busy
    done = subprocess.run([*bound, *command], capture_output=True, text=True, check=False, timeout=6 * SECONDS)
    if done.returncode != 0 or done.stderr:
        raise AssertionError(f"what is exported does not compile: {done.stderr[:1000]}")
    return ["compiles"]
