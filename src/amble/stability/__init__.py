"""Orbital stability of hybrid systems: Poincare map, fixed point, multipliers, certificate."""

from amble.stability.certificate import Certificate, assess
from amble.stability.certification import certify
from amble.stability.contraction import Contraction, contraction, section_distances
from amble.stability.fixed_point import FixedPoint, fixed_point
from amble.stability.monodromy import Monodromy, monodromy
from amble.stability.poincare import Differences, difference_check, poincare_map
from amble.stability.spectrum import Neutral, Spectrum, multipliers

__all__ = [
    "Certificate",
    "Contraction",
    "Differences",
    "FixedPoint",
    "Monodromy",
    "Neutral",
    "Spectrum",
    "assess",
    "certify",
    "contraction",
    "difference_check",
    "fixed_point",
    "monodromy",
    "multipliers",
    "poincare_map",
    "section_distances",
]
