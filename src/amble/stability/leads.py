"""Torques in proportion to the change of the command in a step, so that a walk does not lag behind its orbits.

Shorthand of this file: x(c) the orbit of a command on the section, x' its slope along an axis, P(x; c, d) the state
after a step in which the command goes from c to c + d. A walk on x(c) ends the step at P(x(c); c, d), which misses
x(c + d) by E d to first order,

    E = dP/dd - x',    x' = (1 - A)^-1 dP(x(c); c + e, 0)/de.                                                      (1)

The step map contracts slowly, so under changes that go on the misses add up to |E d| / (1 - r). Constant torques z of
every joint and stance move the end of the step by S z; z = d y with the least |E + S y| in the metric in which all
steps contract, and little |y|, leaves almost nothing of it (docs/howto/transitions.md, eq. 4). All derivatives here
are differences: what is left of their errors is a miss of second order.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from amble.errors import WorkError
from amble.gait.closed_loop import closed_loop
from amble.gait.landing_stances import laws
from amble.gait.ramp import RampedImpedance, ramped
from amble.gait.schedule import Schedule
from amble.gait.impedance import unpacked
from amble.hybrid import HybridSystem
from amble.simulation.trace import COMPLETED
from amble.simulation.walk import walk
from amble.stability.poincare import TIME_LIMIT
from amble.stability.scheduled import SampledStep, on_section, section_coordinates
from amble.types import Matrix, NodeValues, Vector, frozen
