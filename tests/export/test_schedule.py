"""The exported gain-scheduled law: commands as in Python at the gaits and between, and how it follows what is asked."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.export import export_schedule
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.gait.schedule import Schedule
from amble.gait.schedule_tables import impedance_schedule
from amble.gait.unfolding import unfolded
from amble.gait.unilateral_state import within_window
from tests.conftest import DATA
from tests.export.test_impedance import FEET, JOINTS, NOT_FINITE, Command, Numbers, built
from tests.export.test_impedance import Controller as OneGait

OUT_OF_RANGE, CHANGE = 512, 0.03


class Controller(ctypes.Structure):
    _fields_ = (
        *OneGait._fields_,
        ("asked", ctypes.c_double * 1),
        ("left", ctypes.c_double * 1),
        ("followed", ctypes.c_double * 1),
        ("node", ctypes.c_int * 4),
        ("part", ctypes.c_double * 4),
        ("weight", ctypes.c_double * 4),
        ("begin", ctypes.c_double),
        ("end", ctypes.c_double),
        ("planned", ctypes.c_double),
    )


@pytest.fixture(scope="module")
def schedule(stabilised_gait: Gait) -> Schedule:
    """One gait at three speeds, the tables of the others changed at random: any numbers do for arithmetic."""
    gait = replace(stabilised_gait, control=Impedance())
    found = impedance_schedule({(speed,): gait for speed in (0.1, 0.2, 0.4)}, ("speed",))
    share = np.random.default_rng(5).uniform(0.9, 1.1, found.tables.shape)
    share[..., :2], share[0] = share[..., :1], 1.0
    leads = np.random.default_rng(6).normal(size=(3, 1, 2, JOINTS))
    return replace(found, tables=found.tables * share, leads=leads)


@pytest.fixture(scope="module")
def folder(schedule: Schedule, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return export_schedule(schedule, (CHANGE,), tmp_path_factory.mktemp("export") / "controller").folder


@pytest.mark.parametrize(
    ("flags", "largest"), [((), 1e-12), pytest.param(("-DAMBLE_FLOAT",), 1e-4, marks=pytest.mark.slow)]
)
def test_the_vectors_replay(folder: Path, tmp_path: Path, flags: tuple[str, ...], largest: float) -> None:
    """Relative to the largest torque: seven steps, five of them between commands, of 80 calls each."""
    program = built(folder, tmp_path / "replay", *flags, str(folder / "replay.c"))
    ran = subprocess.run([program, folder / "test_vectors.txt"], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    words = ran.stdout.split()
    assert (int(words[0]), int(words[2])) == (560, 0)
    assert float(words[-1]) <= largest


@pytest.mark.slow
def test_turns_whose_feet_land_one_by_one_replay(tmp_path: Path) -> None:
    """Two axes, mirror images, laws between landings; every table changed at random from gait to gait."""
    trot = replace(unfolded(load_gait(DATA / "stabilised-trot-one-by-one.json")), control=Impedance())
    grid = {(speed, rate): trot for speed in (0.2, 0.4) for rate in (0.0, 0.3)}
    found = impedance_schedule(grid, ("speed", "yaw_rate"), images=True)
    assert found.tables.shape[:3] == (2, 3, 6)  # two stances, and four between landings
    share = np.random.default_rng(5).uniform(0.9, 1.1, found.tables.shape)
    share[..., :2] = share[:, :, :1, :1]  # durations alike
    leads = np.random.default_rng(6).normal(size=(2, 3, 2, 2, JOINTS))
    changed = replace(found, tables=found.tables * share, leads=leads)
    folder = export_schedule(changed, (0.1, 0.1), tmp_path / "controller").folder
    program = built(folder, tmp_path / "replay", str(folder / "replay.c"))
    ran = subprocess.run([program, folder / "test_vectors.txt"], capture_output=True, text=True, check=False)
    words = ran.stdout.split()
    assert (ran.returncode, int(words[0]), int(words[2])) == (0, 7 * 6 * 20, 0)
    assert float(words[-1]) <= 1e-12


def test_commands_are_followed_from_step_to_step(folder: Path, schedule: Schedule, tmp_path: Path) -> None:
    library, c, out = ctypes.CDLL(str(built(folder, tmp_path / "c.so", "-shared", "-fPIC"))), Controller(), Command()
    stances = [[foot in s.feet for foot in schedule.gait.robot.foot_names] for s in schedule.gait.pattern.stances]

    def steer(value: float) -> int:
        return int(library.amble_steer(ctypes.byref(c), (ctypes.c_double * 1)(value)))

    def tick(flags: list[bool]) -> None:
        library.amble_step(
            ctypes.byref(c), ctypes.c_double(0.001), Numbers(), Numbers(), (ctypes.c_ubyte * FEET)(*flags),
            ctypes.byref(out),
        )  # fmt: skip

    assert library.amble_enter(ctypes.byref(c), 0) == 0
    assert (c.followed[0], c.asked[0]) == (0.1, 0.1)
    assert steer(9.0) == OUT_OF_RANGE
    assert c.asked[0] == 0.4
    assert steer(float("nan")) == NOT_FINITE
    assert steer(0.17) == 0
    seen = []
    for stance in (0, 1, 2, 3, 0, 1, 2, 3, 0):
        for _ in range(3):
            tick(stances[stance])
        assert c.stance == stance
        seen.append(c.followed[0])
    expected = [0.1, 0.1, 0.13, 0.13, 0.16, 0.16, 0.17, 0.17, 0.17]  # where they lead; a step is half a cycle
    assert seen == pytest.approx(expected, abs=1e-15)
    found = {node: 0.0 for node in c.node}
    for node, weight in zip(c.node, c.weight, strict=True):
        found[node] += weight
    assert found == pytest.approx({node: weight for (node,), weight in schedule.weights((0.17,)).items()})
    law = schedule.law((0.17,)).entries[0].parameters
    np.testing.assert_allclose(list(out.stiffness), law[2 : 2 + JOINTS], rtol=1e-13)


@pytest.mark.slow
def test_feet_lift_in_the_window_of_the_simulation(folder: Path, schedule: Schedule, tmp_path: Path) -> None:
    """At and between gaits of different plans, by ticks; the first switch at the lift-off alone."""
    code, gait = folder / "amble_controller.c", schedule.gait
    tables = code.read_text()
    first = re.search(r"SWITCH\[SWITCHES\] = \{\n  \{0, 1, (\d+)u, (\d+)u\}", tables)
    assert first is not None
    changed = tmp_path / "controller"
    shutil.copytree(folder, changed)
    row = first[0].replace(f"1, {first[1]}u", "1, 0u")
    (changed / code.name).write_text(tables.replace(first[0], row))
    library, tick = ctypes.CDLL(str(built(changed, tmp_path / "c.so", "-shared", "-fPIC"))), 1e-4
    here = [foot in gait.pattern.stances[0].feet for foot in gait.robot.foot_names]
    up = [flag and not int(first[2]) >> place & 1 for place, flag in enumerate(here)]
    for command in (0.1, 0.13, 0.2, 0.31, 0.4):
        law = schedule.law((command,))
        crossing, clock, p = ca.MX.sym("crossing"), ca.MX.sym("clock"), ca.MX.sym("p", law.entries[0].parameters.size)
        guard = within_window(replace(gait, control=law), gait.pattern.stances[0], crossing, clock, p)
        simulated = ca.Function("guard", [crossing, clock, p], [guard])
        for carries, flags in ((-1.0, up), (1.0, here)):
            c, out, ticks = Controller(), Command(), 0
            assert library.amble_enter_at(ctypes.byref(c), 0, (ctypes.c_double * 1)(command)) == 0
            while c.stance == 0:
                library.amble_step(
                    ctypes.byref(c), ctypes.c_double(tick), Numbers(), Numbers(), (ctypes.c_ubyte * FEET)(*flags),
                    ctypes.byref(out),
                )  # fmt: skip
                ticks += 1
            before, after = ((ticks + more) * tick for more in (-2, 1))  # the clock begins at the first tick or before
            assert float(simulated(carries, before, law.entries[0].parameters)) > 0.0
            assert float(simulated(carries, after, law.entries[0].parameters)) <= 0.0


def test_changes_have_to_be_given(schedule: Schedule, tmp_path: Path) -> None:
    for changes in ((), (0.0,), (float("inf"),), (0.1, 0.1)):
        with pytest.raises(InputError, match="largest change"):
            export_schedule(schedule, changes, tmp_path / "controller")
