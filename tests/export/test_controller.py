"""The exported C: compiles strictly, answers what Python answers, needs no heap, and fails as documented."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from amble.codegen import compiler
from amble.control import AllocationLaw, BoundedMinimumNorm, PseudoInverse
from amble.errors import InputError
from amble.export import Exported, export_controller
from amble.export.law import speed_limits, torque_limits
from amble.export.vectors import (
    BAD_CLOCK,
    CONTACT_FLAGS,
    CONTACT_FORCE,
    DAMPING,
    LATE,
    NOT_FINITE,
    OK,
    RANK_LOST,
    SATURATED,
    SILENT,
)
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.robot import kinematics

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-O2")
GAIT = Path(__file__).parents[1] / "data" / "stabilised-amble.json"
LAWS: tuple[AllocationLaw, ...] = (PseudoInverse(), BoundedMinimumNorm(0.6, 5.0))

pytestmark = pytest.mark.skipif(compiler() is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def gait() -> Gait:
    return load_gait(GAIT)


@pytest.fixture(scope="module", params=LAWS, ids=lambda law: law.name)
def exported(request: pytest.FixtureRequest, gait: Gait, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """A folder with strictly compiled objects beside the sources."""
    written = export_controller(gait, request.param, tmp_path_factory.mktemp(request.param.name))
    tool = compiler()
    assert tool is not None
    names = [path.name for path in (*written.sources, written.folder / "replay.c")]
    subprocess.run([tool.path, *STRICT, "-fPIC", "-c", *names], cwd=written.folder, check=True)
    return written


def objects(exported: Exported) -> list[str]:
    return [path.with_suffix(".o").name for path in exported.sources]


def link(exported: Exported, *arguments: str) -> None:
    tool = compiler()
    assert tool is not None
    subprocess.run([tool.path, *arguments, *objects(exported), "-lm"], cwd=exported.folder, check=True)


def test_the_test_vectors_are_reproduced(exported: Exported) -> None:
    """The program itself holds every difference against 1e-12 of the largest value, and every status."""
    link(exported, "-o", "replay", "replay.o")
    done = subprocess.run(
        ["./replay", "test_vectors.txt"], cwd=exported.folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"{20 * 4 + 5} vectors, 0 wrong")


def test_a_wrong_vector_is_noticed(exported: Exported) -> None:
    link(exported, "-o", "replay", "replay.o")
    lines = (exported.folder / "test_vectors.txt").read_text().splitlines()
    words = lines[0].split()
    words[-2 - 12] = repr(float(words[-2 - 12]) + 1e-9)  # the last torque
    (exported.folder / "wrong.txt").write_text("\n".join([" ".join(words), *lines[1:]]))
    done = subprocess.run(["./replay", "wrong.txt"], cwd=exported.folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.startswith("vector 0")) == (1, True)
    (exported.folder / "short.txt").write_text(lines[0][:200])
    done = subprocess.run(["./replay", "short.txt"], cwd=exported.folder, capture_output=True, text=True, check=False)
    assert done.returncode == 2


@pytest.mark.skipif(shutil.which("nm") is None, reason="nm is not installed")
def test_nothing_is_allocated_and_only_libm_is_called(exported: Exported) -> None:
    done = subprocess.run(
        ["nm", "--undefined-only", *objects(exported)], cwd=exported.folder, capture_output=True, text=True, check=True
    )
    called = {line.split()[-1] for line in done.stdout.splitlines() if " U " in line}
    own = {f"amble_law_{law.stance.name}" for law in exported.laws}
    # __isfinite: how glibc spells a macro of math.h; the table of offsets belongs to position-independent code
    known = {"sqrt", "sin", "cos", "sincos", "fmin", "fmax", "fabs", "pow", "__isfinite", "_GLOBAL_OFFSET_TABLE_"}
    assert called <= own | known | {"__stack_chk_fail"}


def test_the_code_of_a_domain_is_below_a_megabyte(exported: Exported) -> None:
    for name in objects(exported):
        assert (exported.folder / name).stat().st_size < 2**20


@pytest.mark.skipif(shutil.which("cmake") is None, reason="cmake is not installed")
def test_cmake_builds_and_replays(exported: Exported) -> None:
    if exported.folder.name.startswith("bounded"):
        pytest.skip("once is enough")
    for command in (["cmake", "-B", "build", "-S", "."], ["cmake", "--build", "build"]):
        subprocess.run(command, cwd=exported.folder, check=True, capture_output=True)
    subprocess.run(["ctest"], cwd=exported.folder / "build", check=True, capture_output=True)


class Controller:
    """The exported functions, called as C would."""

    def __init__(self, library: Path) -> None:
        self.library = ctypes.CDLL(str(library))
        self.library.amble_enter.argtypes = (ctypes.c_void_p, ctypes.c_int, ctypes.c_double)
        self.library.amble_step.argtypes = (ctypes.c_void_p, ctypes.c_double, *[ctypes.c_void_p] * 5)
        self.library.amble_watchdog.argtypes = (ctypes.c_void_p, ctypes.c_double, *[ctypes.c_void_p] * 3)
        self.library.amble_step.restype = self.library.amble_enter.restype = ctypes.c_uint
        self.memory = ctypes.create_string_buffer(1 << 16)  # room for the struct
        self.torques, self.forces = np.zeros(12), np.zeros(12)

    @property
    def stance(self) -> int:
        return ctypes.c_int.from_buffer(self.memory).value

    @property
    def margin(self) -> float:
        """Of the last evaluation, N; behind two int and two double."""
        return ctypes.c_double.from_buffer(self.memory, 24).value

    def enter(self, stance: int, time: float) -> int:
        return int(self.library.amble_enter(self.memory, stance, time))

    def step(self, time: float, q: np.ndarray, v: np.ndarray, feet: tuple[int, ...]) -> int:
        contact = np.array(feet, dtype=np.uint8)
        arrays = (np.ascontiguousarray(q), np.ascontiguousarray(v), contact, self.torques, self.forces)
        return int(self.library.amble_step(self.memory, time, *(array.ctypes.data for array in arrays)))

    def silence(self, time: float, v: np.ndarray) -> int:
        arrays = (np.ascontiguousarray(v), self.torques, self.forces)
        return int(self.library.amble_watchdog(self.memory, time, *(array.ctypes.data for array in arrays)))


@pytest.fixture(scope="module")
def library(exported: Exported) -> Path:
    link(exported, "-shared", "-o", "controller.so")
    return exported.folder / "controller.so"


@pytest.fixture
def controller(library: Path) -> Controller:
    return Controller(library)


def down(gait: Gait, *stances: int) -> tuple[int, ...]:
    feet = {foot for stance in stances for foot in gait.pattern.stances[stance].feet}
    return tuple(int(foot in feet) for foot in gait.robot.foot_names)


def node(gait: Gait, domain: int, index: int) -> tuple[float, np.ndarray, np.ndarray]:
    part = gait.domains[domain]
    return float(part.times[index]), part.positions[index].copy(), part.velocities[index].copy()


def test_the_stance_follows_contact_and_clock(gait: Gait, controller: Controller) -> None:
    """A foot that has just lifted may touch; one that lands ends the stance; the clock of the references restarts."""
    assert controller.enter(0, 10.0) == OK
    time, q, v = node(gait, 0, 3)
    assert controller.step(10.0 + time, q, v, down(gait, 0, 3)) == OK
    assert controller.step(10.0 + time, q, v, down(gait, 0)) == OK
    assert controller.stance == 0
    time, q, v = node(gait, 0, -1)
    landed = down(gait, 0, 1)
    controller.step(10.0 + time, q, v, landed)
    assert controller.stance == 1
    before = controller.torques.copy()
    controller.enter(1, 10.0 + time)
    controller.step(10.0 + time, q, v, landed)
    assert np.array_equal(before, controller.torques)


def test_four_switches_come_back_to_the_first_stance(gait: Gait, controller: Controller) -> None:
    controller.enter(0, 0.0)
    clock, seen = 0.0, []
    for stance in range(4):
        time, q, v = node(gait, stance % 2, -1)
        if stance >= 2:
            q, v = gait.robot.mirror.position(q), gait.robot.mirror.position(v)
        controller.step(clock + 0.5 * time, q, v, down(gait, stance))
        clock += time
        controller.step(clock, q, v, down(gait, stance, (stance + 1) % 4))
        seen.append(controller.stance)
    assert seen == [1, 2, 3, 0]


def test_wrong_flags_are_told_and_the_torques_go_on(gait: Gait, controller: Controller) -> None:
    time, q, v = node(gait, 0, 5)
    controller.enter(0, 0.0)
    controller.step(time, q, v, down(gait, 0))
    sound = controller.torques.copy()
    never = tuple(int(foot not in gait.pattern.stances[1].feet) for foot in gait.robot.foot_names)
    for flags in ((0, 0, 0, 0), never, tuple(1 - flag for flag in down(gait, 1))):
        assert controller.step(time, q, v, flags) & CONTACT_FLAGS
        assert np.array_equal(controller.torques, sound)


def test_a_late_stance_is_told(gait: Gait, controller: Controller) -> None:
    _, q, v = node(gait, 0, -1)
    controller.enter(0, 0.0)
    assert controller.step(2.1 * gait.domains[0].duration, q, v, down(gait, 0)) & LATE


def fallback(gait: Gait, v: np.ndarray) -> np.ndarray:
    return np.clip(-DAMPING * np.where(np.isfinite(v[6:]), v[6:], 0.0), -torque_limits(gait), torque_limits(gait))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", [0, 2, 5, 17, 20, 35])
def test_what_is_not_finite_ends_in_the_fallback(gait: Gait, controller: Controller, value: float, place: int) -> None:
    time, q, v = node(gait, 1, 5)
    state = np.concatenate([q, v])
    state[place] = value
    controller.enter(1, 0.0)
    assert controller.step(time, state[:18], state[18:], down(gait, 1)) == NOT_FINITE
    assert np.array_equal(controller.torques, fallback(gait, state[18:]))
    assert not controller.forces.any()
    # the next sound call goes on as if nothing had been
    assert controller.step(time, q, v, down(gait, 1)) & (NOT_FINITE | RANK_LOST | BAD_CLOCK) == 0


def test_no_extreme_state_has_results_that_are_no_numbers(gait: Gait, controller: Controller) -> None:
    """The margin alone was not a number in 302 of 60,000 such steps, and the status said nothing."""
    random = np.random.default_rng(0)
    statuses = []
    for _ in range(3000):
        domain = int(random.integers(2))
        time, q, v = node(gait, domain, 5)
        largest = 10.0 ** random.uniform(0.0, 200.0, 2)
        q[random.integers(18)] += largest[0] * random.normal()
        v[random.integers(18)] += largest[1] * random.normal()
        controller.enter(domain, 0.0)
        statuses.append(controller.step(time, q, v, down(gait, domain)))
        assert np.all(np.isfinite([*controller.torques, *controller.forces]))
        assert statuses[-1] & (NOT_FINITE | RANK_LOST) or np.isfinite(controller.margin)
    assert any(status & NOT_FINITE for status in statuses)
    assert any(status & CONTACT_FORCE for status in statuses)


def test_lost_rank_ends_in_the_fallback(gait: Gait, controller: Controller) -> None:
    """Both stance feet at one point: there is no line between them, so nothing tells their torques apart."""
    time, q, v = node(gait, 0, 5)
    robot, feet = gait.robot, gait.pattern.stances[0].feet
    legs = [6 + robot.joint_index(joint) for foot in feet for joint in robot.legs[foot]]

    def gap(angles: np.ndarray) -> np.ndarray:
        posed = q.copy()
        posed[legs] = angles
        first, second = (np.asarray(kinematics.foot_position(robot, foot, posed)).ravel() for foot in feet)
        return first - second

    found = q.copy()
    found[legs] = least_squares(gap, q[legs], xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    assert np.linalg.norm(gap(found[legs])) < 1e-9
    controller.enter(0, 0.0)
    status = controller.step(time, found, v, down(gait, 0))
    assert status & RANK_LOST
    assert np.array_equal(controller.torques, fallback(gait, v))


def test_time_before_the_entry_and_a_controller_that_was_not_entered(gait: Gait, controller: Controller) -> None:
    time, q, v = node(gait, 0, 5)
    assert controller.step(time, q, v, down(gait, 0)) == BAD_CLOCK
    controller.enter(0, 1.0)
    assert controller.step(0.5, q, v, down(gait, 0)) == BAD_CLOCK
    assert controller.step(np.nan, q, v, down(gait, 0)) == NOT_FINITE
    for stance, time in ((-1, 0.0), (4, 0.0), (0, np.inf)):
        assert controller.enter(stance, time) == BAD_CLOCK
        assert controller.step(2.0, q, v, down(gait, 0)) == BAD_CLOCK


def test_torques_are_cut_to_their_limits(gait: Gait, controller: Controller) -> None:
    time, q, v = node(gait, 0, 5)
    v[6:] += 60.0  # the damping of the outputs answers with large torques
    controller.enter(0, 0.0)
    assert controller.step(time, q, v, down(gait, 0)) & SATURATED
    limit = torque_limits(gait)
    assert np.all(np.abs(controller.torques) <= limit)
    assert np.any(np.abs(controller.torques) == limit)


def test_a_fast_motor_pushes_less(gait: Gait, exported: Exported, controller: Controller) -> None:
    """The line of torque over speed, and the whole limit for braking; against the same rule in numpy."""
    tool = compiler()
    assert tool is not None
    slow = [tool.path, *STRICT, "-fPIC", "-DAMBLE_CORNER=0.1", "-c", "amble_controller.c", "-o", "slow.o"]
    subprocess.run(slow, cwd=exported.folder, check=True)
    laws = [name for name in objects(exported) if name != "amble_controller.o"]
    subprocess.run([tool.path, "-shared", "-o", "slow.so", "slow.o", *laws, "-lm"], cwd=exported.folder, check=True)
    other, generator = Controller(exported.folder / "slow.so"), np.random.default_rng(2)
    torque, speed, cut = torque_limits(gait), speed_limits(gait), 0
    time, q, v = node(gait, 0, 5)
    for _ in range(100):
        rate = v.copy()
        rate[6:] += generator.uniform(-1.0, 1.0, 12) * speed
        for one in (controller, other):
            one.enter(0, 0.0)
        whole = controller.step(time, q, rate, down(gait, 0)) & SATURATED
        status = other.step(time, q, rate, down(gait, 0)) & SATURATED
        falling = torque * np.clip((1.0 - np.abs(rate[6:]) / speed) / 0.9, 0.0, 1.0)
        limit = np.where(controller.torques * rate[6:] > 0.0, falling, torque)
        np.testing.assert_allclose(other.torques, np.clip(controller.torques, -limit, limit), rtol=1e-12, atol=1e-12)
        beyond = int(np.sum(np.abs(controller.torques) > limit))
        assert bool(status) == bool(whole or beyond)
        cut += beyond
    assert cut > 20


def test_the_watchdog_lets_go_of_a_silent_robot(gait: Gait, controller: Controller) -> None:
    assert gait.feedback is not None
    longest = 0.25 * min(gait.feedback.durations.values())
    time, q, v = node(gait, 0, 5)
    controller.enter(0, 0.0)
    controller.step(time, q, v, down(gait, 0))
    torques = controller.torques.copy()
    assert controller.silence(time + 0.9 * longest, v) == OK
    assert np.array_equal(controller.torques, torques)
    assert controller.step(time + 0.9 * longest, q, v, down(gait, 0)) & BAD_CLOCK == 0
    assert controller.silence(time + 1.8 * longest, v) == OK  # a step starts the time again
    assert controller.silence(time + 2.0 * longest, v) == SILENT
    assert np.array_equal(controller.torques, fallback(gait, v))
    assert controller.step(time + 2.0 * longest, q, v, down(gait, 0)) == BAD_CLOCK
    for late in (-1.0, np.nan):
        controller.enter(0, 0.0)
        assert controller.silence(late, v) == SILENT
    assert controller.silence(0.0, v) == BAD_CLOCK


def test_contact_forces_outside_the_cone_are_told(gait: Gait, controller: Controller) -> None:
    time, q, v = node(gait, 0, 5)
    controller.enter(0, 0.0)
    statuses = []
    for push in np.linspace(0.0, 60.0, 30):
        rate = v.copy()
        rate[6:] += push
        statuses.append(controller.step(time, q, rate, down(gait, 0)) & CONTACT_FORCE)
    assert statuses[0] == OK
    assert CONTACT_FORCE in statuses


@pytest.fixture(scope="module")
def two_exports(gait: Gait, tmp_path_factory: pytest.TempPathFactory) -> tuple[Exported, Exported]:
    one, other = (export_controller(gait, law, tmp_path_factory.mktemp("two") / "folder") for law in LAWS)
    return one, other


@pytest.mark.parametrize("mixed", ["amble_controller.h", "amble_controller.c", "amble_law_D1.c"])
def test_files_of_two_exports_do_not_compile_together(
    mixed: str, two_exports: tuple[Exported, Exported], tmp_path: Path
) -> None:
    one, other = two_exports
    tool = compiler()
    assert tool is not None
    folder = tmp_path / "folder"
    shutil.copytree(one.folder, folder)
    command = [tool.path, *STRICT, "-fsyntax-only", *(path.name for path in one.sources)]
    subprocess.run(command, cwd=folder, check=True)
    shutil.copy(other.folder / mixed, folder / mixed)
    done = subprocess.run(command, cwd=folder, check=False, capture_output=True, text=True)
    assert done.returncode != 0
    assert "belong to two exports" in done.stderr


def test_an_export_is_the_same_at_every_writing(gait: Gait, tmp_path: Path) -> None:
    first, second = (export_controller(gait, None, tmp_path / name) for name in ("first", "second"))
    assert [path.read_bytes() for path in first.files] == [path.read_bytes() for path in second.files]


def test_a_folder_with_other_files_is_refused_before_the_work(
    gait: Gait, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("amble.export.controller.stance_laws", lambda *_: pytest.fail("the work has begun"))
    (tmp_path / "main.c").touch()
    with pytest.raises(InputError, match=r"'main\.c' in it was not written by this command"):
        export_controller(gait, None, tmp_path)


def test_a_stance_without_feet_is_refused(gait: Gait, tmp_path: Path) -> None:
    from dataclasses import replace

    from amble.control import joint_outputs
    from amble.hybrid import gait_pattern

    flying = gait_pattern(gait.robot, [("fl",), ()])
    outputs = joint_outputs(flying, gait.outputs.order)
    curves = np.zeros((len(gait.robot.joints), gait.outputs.order + 1))
    standing, flight = (
        replace(domain, coefficients=curves, forces=domain.forces[:, :columns], impulse=np.zeros(3 - columns))
        for domain, columns in zip(gait.domains, (3, 0), strict=True)  # the foot lands at the end of the flight
    )
    hopping = replace(gait, pattern=flying, outputs=outputs, domains=(standing, flight), feedback=None)
    with pytest.raises(InputError, match="no foot on the ground"):
        export_controller(hopping, None, tmp_path)
