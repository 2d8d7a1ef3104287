"""ASTRo with the inertias and centres of mass of its CAD model; geometry, masses and limits as in `astro`."""

from __future__ import annotations

from amble.robot.catalogue.astro import AUTHORS_BOUNDS, POSTURE, load_leg_model
from amble.robot.catalogue.record import Entry
from amble.robot.model import Robot


def astro_cad() -> Robot:
    """Return ASTRo as its CAD model says."""
    return load_leg_model("astro_cad")


ENTRY = Entry(astro_cad, POSTURE, AUTHORS_BOUNDS)
