"""The exported controller and MuJoCo in one C loop: compiled once for a gait, called once for a walk."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from amble.amounts import check_amount
from amble.codegen import compiler
from amble.codegen.cache import content_key, kept, writable_folder
from amble.control import AllocationLaw
from amble.errors import InputError, WorkError, listed
from amble.export import export_controller
from amble.export.code import template
from amble.gait import Gait
from amble.gait.closed_loop import start_state
from amble.io.storage import workplace
from amble.types import Matrix
from amble.validation.mujoco_model import require_mujoco, to_mujoco

FLAGS = ("-std=c99", "-Wall", "-Wextra", "-O2", "-fPIC", "-shared")

MOST_CYCLES = 10_000
"""Of one walk."""

NO_CAP = 1e9
"""Torque of motors that give what is asked for, N m."""

AS_THEY_ARE = (
    *("threshold", "noise_angle", "noise_rate", "quantum_angle", "quantum_rate", "cap", "lag"),
    *("rise", "edge", "ahead"),
)
"""Numbers of a schedule that the loop takes, in the order of its structure."""

LOWEST, STEEPEST = 0.5, 0.7
"""A base below this share of its height at the start, or whose axis has a smaller vertical component, has fallen."""


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """What is done to a walk; SI units.

    Attributes:
        cycles: the most gait cycles.
        period: of the controller, s; a whole number of the plant's steps.
        delay: until a command arrives, s; the next whole step of the plant.
        threshold: normal force at which a foot's flag is set, N.
        noise_angle: standard deviation of measured joint angles, rad; where a controller reads the base, of its angles
            too, and times the leg length of its place.
        noise_rate: of measured rates, rad/s, in the same way.
        quantum_angle: steps in which joint angles are measured, rad; 0 where they are not rounded.
        quantum_rate: of joint rates, rad/s.
        cap: largest torque of the motors, N m.
        lag: their time constant, s.
        push: force on the base, N, from and until, s: (x, y, z, from, until).
        rise: height of a step of the ground, m; what is past its edge stands on that height.
        edge: where it is, x in m.
        ahead: 1 where the step lies towards +x, -1 towards -x.
        seed: of the noise.
    """

    cycles: int
    period: float
    delay: float = 0.0
    threshold: float
    noise_angle: float = 0.0
    noise_rate: float = 0.0
    quantum_angle: float = 0.0
    quantum_rate: float = 0.0
    cap: float = NO_CAP
    lag: float = 0.0
    push: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 1e9, 1e9)
    rise: float = 0.0
    edge: float = 0.0
    ahead: float = 1.0
    seed: int = 1

    def __post_init__(self) -> None:
        """Refuse a walk without end and a seed that would be cut."""
        check_amount("cycles", self.cycles, 1, MOST_CYCLES)
        if not 0 <= self.seed < 2**64:
            raise InputError(f"the seed of the noise is a whole number from 0 on of at most 64 bits, not {self.seed}")


@dataclass(frozen=True, kw_only=True)
class Walk:
    """What a walk came to.

    Attributes:
        cycles: completed.
        fell: whether the base fell.
        time: walked, s.
        distance: along x, m.
        sideways: along y, m.
        rms: torque over all joints, N m.
        peak: largest torque, N m.
        slip: way of feet that stand and are pressed, all together, m.
        deepest: how far an origin or centre of mass of a link came below the ground, m; negative above it.
        status: all bits that the controller told.
        trace: time, stance, qpos, qvel, torques, contact forces (world), (rows, width); empty where none was asked for.
    """

    cycles: int
    fell: bool
    time: float
    distance: float
    sideways: float
    rms: float
    peak: float
    slip: float
    deepest: float
    status: int
    trace: Matrix


class Loop:
    """The controller of a gait, ready to walk in MuJoCo.

    Args:
        gait: the gait.
        law: another allocation law than the gait's.
        confirm: time for which a foot must touch until it counts, s.

    Raises:
        InputError: the robot moves in the plane, its gait cannot be exported, or MuJoCo is not installed.
        WorkError: where there is no C compiler, or it fails.
    """

    def __init__(self, gait: Gait, law: AllocationLaw | None, confirm: float) -> None:
        if not gait.robot.base.in_space:
            raise InputError(f"MuJoCo walks robots in space; '{gait.robot.name}' moves in the plane of x and z")
        sliding = [joint.name for joint in gait.robot.joints if joint.prismatic]
        if sliding:
            raise InputError(f"MuJoCo walks robots whose joints turn; these slide: {listed(sliding)}")
        self.gait = gait
        joints, feet = len(gait.robot.joints), len(gait.robot.feet)
        self._settings, self._outcome = _structures(joints, feet)
        self._library = ctypes.CDLL(str(_built(gait, law, confirm)))

    def __call__(self, model: Any, schedule: Schedule, interval: int = 0) -> Walk:
        """Walk once.

        Args:
            model: of the robot, as ``mujoco_model`` builds it.
            schedule: what is done to the walk.
            interval: steps of the plant between two rows of the trace; 0 keeps none.

        Raises:
            InputError: the controller's period is no whole number of the plant's steps, or the delay is too long.
        """
        require_mujoco()
        import mujoco

        data, robot = mujoco.MjData(model), self.gait.robot
        start = start_state(self.gait)
        data.qpos[:], data.qvel[:] = to_mujoco(robot, model, start[: robot.size], start[robot.size :])
        settings = self._filled(model, schedule, float(start[2]))
        result, width = self._outcome(), 2 + model.nq + model.nv + len(robot.joints) + 3 * len(robot.feet)
        rows = int(settings.longest / model.opt.timestep / interval) + 1 if interval else 0
        trace = np.zeros((rows, width))
        self._library.walk(
            ctypes.c_void_p(model._address), ctypes.c_void_p(data._address), ctypes.byref(settings),
            ctypes.byref(result), trace.ctypes.data_as(ctypes.c_void_p), rows, width, interval,
        )  # fmt: skip
        steps = round(result.time / model.opt.timestep)
        return Walk(
            cycles=result.cycles,
            fell=bool(result.fell),
            time=result.time,
            distance=result.x,
            sideways=result.y,
            rms=float(np.sqrt(result.square / max(result.time, 1e-9) / len(robot.joints))),
            peak=result.peak,
            slip=result.slip,
            deepest=result.deepest,
            status=int(result.status),
            trace=trace[: -(-steps // interval)] if interval else trace,
        )

    def _filled(self, model: Any, schedule: Schedule, height: float) -> Any:
        gait, step = self.gait, model.opt.timestep
        every, delay = round(schedule.period / step), ceil(schedule.delay / step - 1e-6)
        if every < 1 or abs(every * step - schedule.period) > 1e-6 * schedule.period or not 0 <= delay < 512:
            raise InputError(
                f"a controller with the period {schedule.period:g} s and the delay {schedule.delay:g} s does not fit "
                f"a plant with the step {step:g} s: whole steps, and a delay below 512 of them"
            )
        settings = self._settings()
        settings.cycles, settings.every, settings.delay = schedule.cycles, every, delay
        settings.trunk, settings.reach = model.body(gait.robot.links[0].name).id, gait.robot.leg_length
        for name in ("seed", *AS_THEY_ARE):
            setattr(settings, name, getattr(schedule, name))
        settings.push[:], (settings.push_from, settings.push_until) = schedule.push[:3], schedule.push[3:]
        settings.lowest, settings.steepest = LOWEST * height, STEEPEST
        settings.longest = 1.5 * gait.period * (schedule.cycles + 1)
        for number, joint in enumerate(gait.robot.joint_names):
            entry = model.joint(joint)
            settings.qpos[number], settings.dof[number] = int(entry.qposadr[0]), int(entry.dofadr[0])
            settings.motor[number] = model.actuator(joint).id
        for number, foot in enumerate(gait.robot.foot_names):
            settings.geom[number] = model.geom(foot).id
        return settings


def _structures(joints: int, feet: int) -> tuple[Any, Any]:
    """The structures of ``loop.c``."""
    whole, real = ctypes.c_int, ctypes.c_double
    settings = [
        *((name, whole) for name in ("cycles", "every", "delay", "trunk")),
        *((name, real) for name in (*AS_THEY_ARE, "reach")),
        ("push", real * 3),
        *((name, real) for name in ("push_from", "push_until", "lowest", "steepest", "longest")),
        ("seed", ctypes.c_uint64),
        *((name, whole * joints) for name in ("qpos", "dof", "motor")),
        ("geom", whole * feet),
    ]
    outcome = [
        *((name, whole) for name in ("cycles", "fell")),
        *((name, real) for name in ("time", "x", "y", "square", "peak", "slip", "deepest")),
        ("status", ctypes.c_uint),
    ]
    return type("Settings", (ctypes.Structure,), {"_fields_": settings}), type(
        "Outcome", (ctypes.Structure,), {"_fields_": outcome}
    )


def _built(gait: Gait, law: AllocationLaw | None, confirm: float) -> Path:
    """Export, compile with the loop, and keep by content."""
    require_mujoco()
    import mujoco

    tool = compiler()
    if tool is None:
        raise WorkError("the exported controller needs a C compiler; none was found")
    engine = Path(mujoco.__file__).parent
    library = next(iter(sorted(engine.glob("libmujoco.*"))), None)
    if library is None:
        raise WorkError(f"the library of MuJoCo {mujoco.__version__} was not found beside its Python package")
    folder = writable_folder()
    with workplace(folder) as work:
        exported = export_controller(gait, law, work / "controller")
        source = exported.folder / "loop.c"
        source.write_text(template("loop.c", "amble.validation"), encoding="utf-8")
        flags = (
            *FLAGS, "-DAMBLE_CONFIRM_TICKS=1", f"-DAMBLE_CONFIRM_TIME={confirm!r}", f"-I{engine / 'include'}",
            *(str(path) for path in exported.sources), "-Wl,--no-as-needed", str(library), f"-Wl,-rpath,{engine}",
        )  # fmt: skip
        texts = [path.read_text(encoding="utf-8") for path in (source, *exported.sources)]
        key = content_key([*texts, tool.path, tool.version, mujoco.__version__, repr(confirm), str(engine), *FLAGS])
        return kept(folder / f"validation-{key}.so", lambda output: tool.build(source, output, flags))
