"""The cases of the battery: eighteen ways in which a plant and its measurements differ from the model.

Sizes are those of ASTRo's amble in its robot's natural units, m g l of a torque, sqrt(l / g) of a time, ...; so a case
is as hard for a robot of another size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.robot import Robot
from amble.validation.loop import Schedule
from amble.validation.mujoco_model import HARD, POINT, Plant

ASTRO_MASS, ASTRO_LENGTH, ASTRO_GRAVITY = 21.5, 0.87628, 9.81
"""The robot whose figures the cases are written in, kg, m, m/s^2."""


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
        softness: time constant of the contacts, s.
        radius: of the feet, m.
        noise_angle: standard deviation of joint angles, rad.
        noise_rate: of joint rates, rad/s.
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
    softness: float = HARD
    radius: float = POINT
    noise_angle: float = 0.0
    noise_rate: float = 0.0


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

STEP, CONFIRM, THRESHOLD = 5e-4, 1e-3, 5.0
"""Step of the plant, s, time that confirms a contact, s, and the force that sets a flag, N, at ASTRo's size."""


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

    def applied(self, case: Case) -> tuple[Plant, Schedule]:
        """Scale a case from ASTRo's size."""
        mass, length, time = self.mass, self.length, self.time
        step, torque = STEP * time, mass * length * self.gravity / ASTRO_GRAVITY
        plant = Plant(
            step=step,
            friction=case.friction,
            radius=case.radius * length,
            softness=case.softness * time,
            damping=case.damping * torque * time,
            dry_friction=case.dry_friction * torque,
            armature=case.armature * mass * length**2,
            trunk=case.trunk,
            balanced=case.balanced,
        )
        schedule = Schedule(
            cycles=1,
            period=case.period * time or step,
            delay=case.delay * time,
            threshold=THRESHOLD * mass * self.gravity / ASTRO_GRAVITY,
            noise_angle=case.noise_angle,
            noise_rate=case.noise_rate / time,
        )
        return plant, schedule
