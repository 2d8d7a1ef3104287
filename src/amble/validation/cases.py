"""The cases of the battery: eighteen ways in which a plant and its measurements differ from the model.

Sizes are those of ASTRo's amble in its robot's natural units, m g l of a torque, sqrt(l / g) of a time, ...; so a case
is as hard for a robot of another size.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from types import MappingProxyType

import numpy as np

from amble.amounts import check_number
from amble.errors import InputError, shown
from amble.gait import Gait
from amble.gait.closed_loop import start_state
from amble.robot import Robot
from amble.validation.loop import NO_CAP, Schedule
from amble.validation.mujoco_model import HARD, POINT, Plant

ASTRO_MASS, ASTRO_LENGTH, ASTRO_GRAVITY = 21.5, 0.87628, 9.81
"""The robot whose figures the cases are written in, kg, m, m/s^2."""

RANGES = MappingProxyType(
    {
        "friction": (1e-3, 10.0),
        "period": (0.0, 0.1),
        "delay": (0.0, 0.1),
        "damping": (0.0, 1e3),
        "dry_friction": (0.0, 1e3),
        "armature": (0.0, 10.0),
        "trunk": (0.1, 10.0),
        "links": (0.1, 10.0),
        "softness": (1e-4, 1.0),
        "radius": (1e-4, 0.3),
        "noise_angle": (0.0, 1.0),
        "noise_rate": (0.0, 1e3),
        "quantum_angle": (0.0, 1.0),
        "quantum_rate": (0.0, 1e3),
        "cap": (0.0, 1e6),
        "lag": (0.0, 1.0),
        "push_at": (0.0, 1e4),
        "rise": (-0.3, 0.3),
    }
)
"""What the figures of a case can be, at ASTRo's size."""

LARGEST_PUSH = 1e4
"""Largest part of a push, N s, at ASTRo's size."""

FASTEST = 1e-5
"""Shortest period of a controller, s, at ASTRo's size: the plant takes no longer steps."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One way in which a plant and its measurements differ from the model; figures at ASTRo's size, SI units.

    Attributes:
        name: what differs.
        friction: coefficient between feet and ground.
        period: of the controller, s; 0 at every step of the plant.
        delay: until a command arrives, s.
        damping: of the joints, N m s/rad.
        dry_friction: of the joints, N m.
        armature: rotor inertia of the joints, kg m^2.
        balanced: link inertias made physical, as MuJoCo does by itself.
        trunk: factor of the base link's mass and inertia.
        links: factor of the mass and inertia of every other link.
        softness: time constant of the contacts, s.
        radius: of the feet, m.
        noise_angle: standard deviation of joint angles, rad.
        noise_rate: of joint rates, rad/s.
        quantum_angle: steps in which joint angles are measured, rad; 0 where they are not rounded.
        quantum_rate: of joint rates, rad/s.
        cap: largest torque that the motors give, N m; 0 where they give what is asked for.
        lag: time constant of the motors, s.
        push: impulse on the base's centre of mass, forward, to the left and upward, N s, within 20 ms.
        push_at: gait cycles after which it begins.
        rise: height of a step of the ground, m, negative where it goes down; its edge lies across the way, one leg
            length ahead of where the base starts.

    Raises:
        InputError: a figure is no number or out of its range, ``RANGES``.
    """

    name: str
    friction: float = 0.8
    period: float = 0.0
    delay: float = 0.0
    damping: float = 0.0
    dry_friction: float = 0.0
    armature: float = 0.0
    balanced: bool = False
    trunk: float = 1.0
    links: float = 1.0
    softness: float = HARD
    radius: float = POINT
    noise_angle: float = 0.0
    noise_rate: float = 0.0
    quantum_angle: float = 0.0
    quantum_rate: float = 0.0
    cap: float = 0.0
    lag: float = 0.0
    push: tuple[float, float, float] = (0.0, 0.0, 0.0)
    push_at: float = 2.25
    rise: float = 0.0

    def __post_init__(self) -> None:
        """Refuse figures that no plant has."""
        where = f"of case '{shown(self.name)}'"
        for what, (least, most) in RANGES.items():
            check_number(f"{what} {where}", getattr(self, what), least, most)
        if self.period:
            check_number(f"period {where}", self.period, FASTEST, RANGES["period"][1])
        if len(self.push) != 3:
            raise InputError(f"the push {where} has {len(self.push)} numbers: forward, to the left and upward, N s")
        for part in self.push:
            check_number(f"a part of the push {where}", part, -LARGEST_PUSH, LARGEST_PUSH)


BATTERY = (
    Case(name="nominal"),
    Case(name="friction 0.6", friction=0.6),
    Case(name="friction 0.45", friction=0.45),
    Case(name="1 kHz, 1 ms delay", period=1e-3, delay=1e-3),
    Case(name="500 Hz, 2 ms delay", period=2e-3, delay=2e-3),
    Case(name="damping 0.1", damping=0.1),
    Case(name="damping 0.5", damping=0.5),
    Case(name="dry friction 0.3", dry_friction=0.3),
    Case(name="dry friction 1", dry_friction=1.0),
    Case(name="armature 0.01", armature=0.01),
    Case(name="armature 0.05", armature=0.05),
    Case(name="balanced inertias", balanced=True),
    Case(name="trunk +10 %", trunk=1.1),
    Case(name="trunk -10 %", trunk=0.9),
    Case(name="soft contact 20 ms", softness=0.02),
    Case(name="feet of 20 mm", radius=0.02),
    Case(name="noise", noise_angle=1e-3, noise_rate=0.05),
    Case(
        name="all, mildly", friction=0.6, period=1e-3, delay=1e-3, damping=0.1, dry_friction=0.3, armature=0.01,
        trunk=1.05, radius=0.01, noise_angle=1e-3, noise_rate=0.05,
    ),
)  # fmt: skip
"""Realism cases, at ASTRo's size."""

MORE = (
    Case(name="300 Hz, 2 ms delay", period=1 / 300, delay=2e-3),
    Case(name="encoders 1 mrad, 50 mrad/s", quantum_angle=1e-3, quantum_rate=0.05),
    Case(name="links +10 %", links=1.1),
    Case(name="torque cap 14 N m", cap=14.0),
    Case(name="torque lag 2 ms", lag=2e-3),
    Case(name="push forward 30 N s", push=(30.0, 0.0, 0.0)),
    Case(name="push to the left 10 N s", push=(0.0, 10.0, 0.0)),
    Case(name="step up 10 mm", rise=0.01),
    Case(name="step down 10 mm", rise=-0.01),
)
"""Cases beside the battery, which are walked where they are named."""

STEP, CONFIRM, THRESHOLD = 5e-4, 1e-3, 5.0
"""Longest step of the plant, s, time that confirms a contact, s, and the force that sets a flag, N, at ASTRo's size."""

PUSHED = 0.02
"""How long a push lasts, s, at ASTRo's size."""

EDGE, BEHIND = 1.0, 2.5
"""How far ahead of the base the edge of a step of the ground lies, and after what way of the base all feet have it
behind them, in leg lengths: the hind feet stand up to one behind the base, and are up to half a step late."""


@dataclass(frozen=True, kw_only=True)
class Scales:
    """Sizes of a robot over ASTRo's.

    Attributes:
        mass: of the robot.
        length: of its longest leg.
        time: sqrt(l / g).
        gravity: m/s^2, not a ratio.
    """

    mass: float = 1.0
    length: float = 1.0
    time: float = 1.0
    gravity: float = ASTRO_GRAVITY

    @classmethod
    def of(cls, robot: Robot) -> Scales:
        """Return those of a robot."""
        length = robot.leg_length / ASTRO_LENGTH
        time = float(np.sqrt(length * ASTRO_GRAVITY / robot.gravity))
        return cls(mass=robot.mass / ASTRO_MASS, length=length, time=time, gravity=robot.gravity)

    @property
    def confirm(self) -> float:
        """Time that confirms a contact, s."""
        return CONFIRM * self.time

    def applied(self, case: Case, gait: Gait) -> tuple[Plant, Schedule]:
        """Scale a case from ASTRo's size; a period of the controller is a whole number of the plant's steps."""
        mass, length, time = self.mass, self.length, self.time
        step = time * (case.period / ceil(case.period / STEP - 1e-9) if case.period else STEP)
        force = mass * self.gravity / ASTRO_GRAVITY
        torque, pushed = force * length, PUSHED * time
        x, y, z = (part * force / PUSHED for part in case.push)
        began, ahead = case.push_at * gait.period, -1.0 if gait.speed < 0.0 else 1.0
        edge = float(start_state(gait)[0]) + ahead * EDGE * gait.robot.leg_length
        plant = Plant(
            step=step,
            friction=case.friction,
            radius=case.radius * length,
            softness=case.softness * time,
            damping=case.damping * torque * time,
            dry_friction=case.dry_friction * torque,
            armature=case.armature * mass * length**2,
            trunk=case.trunk,
            links=case.links,
            balanced=case.balanced,
            rise=case.rise * length,
            edge=edge,
            ahead=ahead,
        )
        schedule = Schedule(
            cycles=1,
            period=case.period * time or step,
            delay=case.delay * time,
            threshold=THRESHOLD * force,
            noise_angle=case.noise_angle,
            noise_rate=case.noise_rate / time,
            quantum_angle=case.quantum_angle,
            quantum_rate=case.quantum_rate / time,
            cap=case.cap * torque or NO_CAP,
            lag=case.lag * time,
            push=(x, y, z, began, began + pushed),
            rise=plant.rise,
            edge=edge,
            ahead=ahead,
        )
        return plant, schedule
