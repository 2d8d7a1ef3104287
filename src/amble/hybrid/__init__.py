"""Hybrid systems, and the legged ones built from stance tables: feet in contact with a ground."""

from amble.hybrid.constrained_dynamics import ConstrainedDynamics, constrained_dynamics, impact, selection
from amble.hybrid.contact import CONTACTS, POINT, QUANTITIES, Contact, PlanarPointContact, PointContact
from amble.hybrid.contacts import Contacts
from amble.hybrid.footfalls import Footfall, stance_table
from amble.hybrid.ground import FLAT, GROUNDS, Ground, HeightField, Plane
from amble.hybrid.landing import ONE_BY_ONE, SIMULTANEOUS, Stance, Switch
from amble.hybrid.pattern import GaitPattern, gait_pattern
from amble.hybrid.system import Domain, HybridSystem, Invariant, Symmetry, Transition

__all__ = [
    "CONTACTS",
    "FLAT",
    "GROUNDS",
    "ONE_BY_ONE",
    "POINT",
    "QUANTITIES",
    "SIMULTANEOUS",
    "ConstrainedDynamics",
    "Contact",
    "Contacts",
    "Domain",
    "Footfall",
    "GaitPattern",
    "Ground",
    "HeightField",
    "HybridSystem",
    "Invariant",
    "PlanarPointContact",
    "Plane",
    "PointContact",
    "Stance",
    "Switch",
    "Symmetry",
    "Transition",
    "constrained_dynamics",
    "gait_pattern",
    "impact",
    "selection",
    "stance_table",
]
