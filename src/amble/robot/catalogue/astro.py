"""ASTRo as its builders simulated it: 21.5 kg, four legs of hip yaw, hip pitch and knee, point feet.

Numbers are facts read from the public research code of the builders (Norwegian-Legged-Lab/Tetrapod-Robot, branch
hzd-control-feature). At knee angle 0 the lower leg is folded back; straight is pi. The legs fl and rr turn outwards
with positive hip yaw, fr and rl with negative.
"""

from __future__ import annotations

from importlib import resources
from math import radians

from amble.robot.adaptation import AS_WRITTEN, Adaptation
from amble.robot.catalogue.record import Entry, GaitBounds, Interval, Posture
from amble.robot.loading import load_robot
from amble.robot.model import Robot

LEGS = ("fl", "rl", "fr", "rr")
"""In file order."""

OUTWARD = {"fl": 1.0, "rl": -1.0, "fr": -1.0, "rr": 1.0}
"""Sign of the hip yaw that turns a leg outwards."""

POSTURE = Posture(
    0.300,
    {
        name: angle
        for leg in LEGS
        for name, angle in (
            (f"{leg}_hip_yaw", 0.5 * OUTWARD[leg]),
            (f"{leg}_hip_pitch", 0.38),
            (f"{leg}_knee", 1.16),
        )
    },
)
"""About the middle of the builders' amble at 0.2 m/s, whose hip yaw angles range over 0.35 to 0.72 rad."""


def _outward(leg: str, lower: float, upper: float) -> Interval:
    return (lower, upper) if OUTWARD[leg] > 0.0 else (-upper, -lower)


AUTHORS_BOUNDS = GaitBounds(
    duration=(0.01, 0.15),
    torque=50.0,
    speed=4.0,
    acceleration=100.0,
    positions={
        "z": (0.3, 0.9),
        "roll": (-0.2, 0.2),
        "pitch": (-0.1, 0.1),
        "yaw": (-0.3, 0.3),
        **{f"{leg}_hip_yaw": _outward(leg, 0.0, radians(60.0)) for leg in LEGS},
        **{f"{leg}_hip_pitch": (radians(-45.0), radians(22.5)) for leg in LEGS},
        **{f"{leg}_knee": (radians(60.0), radians(180.0)) for leg in LEGS},
    },
    touchdown_velocity=((-0.2, 0.3), (-0.1, 0.1), (-2.0, -0.06)),
)
"""The bounds of the builders' own gait optimisation; touchdown velocity along x, y, z of the world. Theirs
along z ends at 0, where a foot grazes the ground; here it ends at 0.02 sqrt(g l)."""


def load_leg_model(name: str, adaptation: Adaptation) -> Robot:
    """Load one of the two models of ASTRo that ship with the package."""
    with resources.as_file(resources.files("amble.robot.catalogue") / f"{name}.urdf") as path:
        return load_robot(path, {leg: f"{leg}_foot" for leg in LEGS}, name=name, adaptation=adaptation)


def astro(adaptation: Adaptation = AS_WRITTEN) -> Robot:
    """Return ASTRo as its builders simulated it: every centre of mass at its link's joint frame."""
    return load_leg_model("astro", adaptation)


def astro_cad(adaptation: Adaptation = AS_WRITTEN) -> Robot:
    """Return ASTRo with the inertias and centres of mass of its CAD model; geometry, masses and limits are the same."""
    return load_leg_model("astro_cad", adaptation)


ENTRIES = {"astro": Entry(astro, POSTURE, AUTHORS_BOUNDS), "astro_cad": Entry(astro_cad, POSTURE, AUTHORS_BOUNDS)}
