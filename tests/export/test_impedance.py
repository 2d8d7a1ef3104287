"""The impedance controller in C: commands as in Python, and what it makes of feet that come early, late or never."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.codegen import compiler
from amble.export import export_controller
from amble.export.impedance import DomainTable, impedance_code
from amble.export.law import speed_limits, torque_limits
from amble.gait import Gait
from amble.gait.impedance import HOLD, Impedance
from amble.numerics.pieces import ORDER

JOINTS, FEET, TICK = 12, 4, 0.001
SATURATED, LATE, CONTACT_FLAGS, NOT_FINITE, BAD_CLOCK, NOT_ENTERED, SILENT = 1, 4, 8, 32, 64, 128, 256
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-O2", "-ffp-contract=off")

Numbers = ctypes.c_double * JOINTS


class Controller(ctypes.Structure):
    _fields_ = (
        ("stance", ctypes.c_int),
        ("entered", ctypes.c_int),
        ("clock", ctypes.c_double),
        ("down", ctypes.c_uint),
        ("clear", ctypes.c_uint),
        ("ticks", ctypes.c_int * FEET),
        ("since", ctypes.c_double * FEET),
        ("silent", ctypes.c_double),
    )


class Command(ctypes.Structure):
    _fields_ = tuple((name, Numbers) for name in ("angle", "rate", "torque", "stiffness", "damping", "sum"))


@pytest.fixture(scope="module")
def folder(stabilised_gait: Gait, tmp_path_factory: pytest.TempPathFactory) -> Path:
    gait = replace(stabilised_gait, control=Impedance())
    return export_controller(gait, None, tmp_path_factory.mktemp("export") / "controller").folder


def built(folder: Path, output: Path, *flags: str) -> Path:
    tool = compiler()
    if tool is None:
        pytest.skip("no C compiler")
    subprocess.run([tool.path, *STRICT, *flags, "-o", output, folder / "amble_controller.c", "-lm"], check=True)
    return output


@pytest.fixture(scope="module")
def library(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    return ctypes.CDLL(str(built(folder, tmp_path_factory.mktemp("build") / "c.so", "-shared", "-fPIC")))


@pytest.mark.parametrize(("flags", "largest"), [((), 1e-12), (("-DAMBLE_FLOAT",), 1e-4)])
def test_the_vectors_replay(folder: Path, tmp_path: Path, flags: tuple[str, ...], largest: float) -> None:
    """Relative to the largest torque of the orbit. Measured: 0 in double, 2.1e-6 in float."""
    program = built(folder, tmp_path / "replay", *flags, str(folder / "replay.c"))
    ran = subprocess.run([program, folder / "test_vectors.txt"], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    words = ran.stdout.split()
    assert (int(words[0]), int(words[2])) == (80, 0)
    assert float(words[-1]) <= largest


class Walk:
    """Ticks of one controller, with flags by foot."""

    def __init__(self, library: ctypes.CDLL, gait: Gait, stance: int = 0) -> None:
        self.library, self.c, self.out = library, Controller(), Command()
        self.stances = [[foot in stance.feet for foot in gait.robot.foot_names] for stance in gait.pattern.stances]
        self.durations = [gait.feedback.durations[s.name] for s in gait.pattern.solved] if gait.feedback else []
        assert library.amble_enter(ctypes.byref(self.c), stance) == 0

    def tick(self, flags: list[bool], ticks: int = 1, dt: float = TICK, q: float = 0.0) -> int:
        status = 0
        for _ in range(ticks):
            status = self.library.amble_step(
                ctypes.byref(self.c), ctypes.c_double(dt), Numbers(*[q] * JOINTS), Numbers(),
                (ctypes.c_ubyte * FEET)(*flags), ctypes.byref(self.out),
            )  # fmt: skip
        return int(status)


@pytest.fixture
def walk(library: ctypes.CDLL, stabilised_gait: Gait) -> Walk:
    return Walk(library, stabilised_gait)


def test_two_ticks_confirm_a_touchdown_and_the_clock_starts_again(walk: Walk) -> None:
    here, after = walk.stances[:2]
    both = [a or b for a, b in zip(here, after, strict=True)]
    walk.tick(here, 100)
    walk.tick(both)
    assert walk.c.stance == 0
    walk.tick(here)  # it bounced: the count starts again
    walk.tick(both)
    assert walk.c.stance == 0
    walk.tick(both)
    assert (walk.c.stance, walk.c.clock) == (1, 0.0)


def test_an_early_foot_ends_the_stance(walk: Walk) -> None:
    """As in the simulation; a foot that has just lifted and still touches does not."""
    here, after = walk.stances[:2]
    both = [a or b for a, b in zip(here, after, strict=True)]
    just = [a or b for a, b in zip(here, walk.stances[-1], strict=True)]
    assert not walk.tick(just, 4) & CONTACT_FLAGS
    assert walk.c.stance == 0
    walk.tick(here, 2)
    assert not walk.tick(both, 2) & CONTACT_FLAGS
    assert walk.c.stance == 1


def test_a_window_keeps_an_early_foot_waiting(folder: Path, tmp_path: Path, stabilised_gait: Gait) -> None:
    library = ctypes.CDLL(str(built(folder, tmp_path / "c.so", "-shared", "-fPIC", "-DAMBLE_EARLIEST=0.5")))
    walk = Walk(library, stabilised_gait)
    here, after = walk.stances[:2]
    both = [a or b for a, b in zip(here, after, strict=True)]
    walk.tick(here, 2)
    opens = 0.5 * walk.durations[0]
    walk.tick(both, int(opens / TICK) - 3)
    assert walk.c.stance == 0
    walk.tick(both, 3)
    assert walk.c.stance == 1


def test_feet_lift_near_the_plan_where_none_lands(folder: Path, tmp_path: Path, stabilised_gait: Gait) -> None:
    """The amble with its first switch at the lift-off alone: a foot that an impact unloads has not lifted."""
    tables = (folder / "amble_controller.c").read_text()
    first = re.search(r"SWITCH\[SWITCHES\] = \{\n  \{0, 1, (\d+)u, (\d+)u\}", tables)
    assert first is not None
    lifting = int(first[2])
    changed = tmp_path / "controller"
    shutil.copytree(folder, changed)
    row = first[0].replace(f"1, {first[1]}u", "1, 0u")
    (changed / "amble_controller.c").write_text(tables.replace(first[0], row))
    walks = [
        Walk(ctypes.CDLL(str(built(changed, tmp_path / f"{number}.so", "-shared", "-fPIC", *flags))), stabilised_gait)
        for number, flags in enumerate(((), ("-DAMBLE_EARLIEST_LIFT_OFF=0",)))
    ]
    here = walks[0].stances[0]
    up = [flag and not lifting >> place & 1 for place, flag in enumerate(here)]
    plan = walks[0].durations[0] / TICK
    assert plan > 20
    for walk in walks:
        walk.tick(up, 3)
    assert [walk.c.stance for walk in walks] == [0, 1]  # without the window the stance would be skipped
    walks[0].tick(here, 2)
    walks[0].tick(up, int(0.5 * plan) - 5)
    assert walks[0].c.stance == 0
    walks[0].tick(up, 2)  # up by then, it has lifted
    assert walks[0].c.stance == 1
    late = Walk(walks[0].library, stabilised_gait)
    assert not late.tick(here, int(1.2 * plan) - 1) & LATE
    assert late.c.stance == 0
    late.tick(here, 2)  # a foot that still carries is lifted by the next stance
    assert late.c.stance == 1


class OwnWindow(Impedance):
    """Another window than the default one."""

    lift_offs = 0.25, 1.0 + 1.0 / 3.0


class NoWindow(Impedance):
    """A stance ends whenever the feet are up."""

    lift_offs = None


@pytest.mark.parametrize(
    ("control", "window"),
    [(Impedance(), ("0.5", "1.2")), (OwnWindow(), ("0.25", repr(4.0 / 3.0))), (NoWindow(), ("0.0", "HUGE_VAL"))],
)
def test_the_window_is_that_of_the_law(stabilised_gait: Gait, control: Impedance, window: tuple[str, str]) -> None:
    """To the last digit; it does not depend on the tables."""
    table = DomainTable.of(np.ones(2 + 2 * JOINTS + 2 + 2 * JOINTS * (ORDER + 1)), np.ones(JOINTS), 1.0)
    code = impedance_code(replace(stabilised_gait, control=control), [[table]])
    assert (code["EARLIEST_LIFT_OFF"], code["LATEST_LIFT_OFF"]) == window


def test_a_contact_that_does_not_come_is_waited_for(walk: Walk) -> None:
    here, after = walk.stances[:2]
    both = [a or b for a, b in zip(here, after, strict=True)]
    ticks = int(HOLD * walk.durations[0] / TICK)
    assert not walk.tick(here, ticks) & LATE
    assert walk.tick(here, 2) & LATE
    held = list(walk.out.angle)
    assert list(walk.out.rate) == [0.0] * JOINTS
    assert walk.tick(here, 500) & LATE
    assert list(walk.out.angle) == held
    walk.tick(both, 2)
    assert walk.c.stance == 1


def test_a_lost_stance_foot_is_told(walk: Walk) -> None:
    here = walk.stances[0]
    lost = [flag and place != here.index(True) for place, flag in enumerate(here)]
    assert not walk.tick(lost) & CONTACT_FLAGS
    assert walk.tick(lost) & CONTACT_FLAGS
    assert not walk.tick(here, 2) & CONTACT_FLAGS


def test_a_step_of_the_clock_is_clamped(walk: Walk) -> None:
    here = walk.stances[0]
    for dt, moved in ((-1.0, 0.0), (np.nan, 0.0), (10.0, 0.25 * min(walk.durations))):
        before = walk.c.clock
        assert walk.tick(here, dt=dt) & BAD_CLOCK
        assert walk.c.clock - before == pytest.approx(moved, rel=1e-12)


def test_what_is_not_finite_leaves_damping(walk: Walk) -> None:
    assert walk.tick(walk.stances[0], q=np.inf) == NOT_FINITE
    assert list(walk.out.stiffness) == list(walk.out.torque) == list(walk.out.sum) == [0.0] * JOINTS
    assert list(walk.out.damping) == [1.0] * JOINTS
    walk.c.entered = 0
    assert walk.tick(walk.stances[0]) == NOT_ENTERED
    assert walk.library.amble_enter(ctypes.byref(walk.c), 99) == NOT_ENTERED


def test_a_fast_motor_pushes_less(folder: Path, tmp_path: Path, stabilised_gait: Gait) -> None:
    """The line of torque over speed, and the whole limit for braking; against the same rule in numpy."""
    library = ctypes.CDLL(str(built(folder, tmp_path / "c.so", "-shared", "-fPIC", "-DAMBLE_CORNER=0.4")))
    walk, generator = Walk(library, stabilised_gait), np.random.default_rng(5)
    torque, speed = torque_limits(stabilised_gait), speed_limits(stabilised_gait)
    cut = 0
    for _ in range(200):
        q, qd = generator.uniform(-2.0, 2.0, JOINTS), 1.2 * speed * generator.uniform(-1.0, 1.0, JOINTS)
        status = library.amble_step(
            ctypes.byref(walk.c), ctypes.c_double(0.0), Numbers(*q), Numbers(*qd),
            (ctypes.c_ubyte * FEET)(*walk.stances[0]), ctypes.byref(walk.out),
        )  # fmt: skip
        out = {name: np.array(getattr(walk.out, name)) for name, _ in Command._fields_}
        whole = out["torque"] - out["stiffness"] * (q - out["angle"]) - out["damping"] * (qd - out["rate"])
        falling = torque * np.clip((1.0 - np.abs(qd) / speed) / 0.6, 0.0, 1.0)
        limit = np.where(whole * qd > 0.0, falling, torque)
        np.testing.assert_allclose(out["sum"], np.clip(whole, -limit, limit), rtol=1e-12, atol=1e-12)
        assert bool(status & SATURATED) == bool(np.any(np.abs(whole) > limit))
        cut += int(np.sum((np.abs(whole) > limit) & (limit < torque)))
    assert cut > 100


def test_the_watchdog_lets_go_of_a_silent_robot(walk: Walk) -> None:
    longest, here = 0.25 * min(walk.durations), walk.stances[0]

    def silence(dt: float) -> int:
        numbers = Numbers(*[0.1] * JOINTS), Numbers(*[2.0] * JOINTS)
        return int(
            walk.library.amble_watchdog(ctypes.byref(walk.c), ctypes.c_double(dt), *numbers, ctypes.byref(walk.out))
        )

    walk.tick(here)
    command = list(walk.out.sum)
    assert silence(0.9 * longest) == 0
    assert list(walk.out.sum) == command
    walk.tick(here)
    assert silence(0.9 * longest) == 0  # a step starts the time again
    assert silence(0.2 * longest) == SILENT
    assert list(walk.out.sum) == [-2.0] * JOINTS
    assert walk.tick(here) == NOT_ENTERED
    for dt in (-1.0, np.nan):
        assert walk.library.amble_enter(ctypes.byref(walk.c), 0) == 0
        assert silence(dt) == SILENT
    assert silence(0.0) == NOT_ENTERED
