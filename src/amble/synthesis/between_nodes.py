"""Rows between nodes that are far apart: accelerations of the controlled coordinates, read off their curves.

Limits are imposed at the nodes. Over time a controlled coordinate's acceleration is a polynomial of low degree whose
largest value lies where it likes, and passes its bound between two nodes by the square of their distance.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.names import identifier
from amble.numerics.bezier import bezier
from amble.numerics.collocation import HERMITE_SIMPSON
from amble.robot.coordinate_units import units
from amble.robot.parts import ACCELERATION
from amble.synthesis.block import Block
from amble.synthesis.layout import MARGIN, DomainLayout
from amble.synthesis.node_block import ProgramParameters, domain_phase, output_indices
from amble.synthesis.problem import GaitProblem
from amble.synthesis.rows import RowKind
from amble.types import Vector

WIDEST = 1.0 / 40.0
"""Distance of two instants that hold a bound, as a share of the domain; 15 intervals of Hermite-Simpson have 1/30."""


def between_nodes(problem: GaitProblem, domain: DomainLayout) -> list[Block]:
    """Bound accelerations between the nodes; nothing on Hermite-Simpson, whose mesh is refined where that is needed.

    Nothing either where there is no limit, or where curves run over the configuration, which is known at nodes only.
    """
    instants = instants_between(domain.phases)
    robot = problem.pattern.robot
    limits = problem.limits.accelerations(robot)
    names = [robot.coordinate_names[k] for k in output_indices(problem, domain)]
    most = np.array([limits[name] for name in names])
    if problem.scheme == HERMITE_SIMPSON or not instants.size or not np.isfinite(most).any():
        return []
    T, share, numbers = ca.SX.sym("T"), ca.SX.sym("share"), ca.SX.sym("phase_numbers", domain.phase_numbers.size)
    q, v = (ca.SX.sym(letter, robot.size) for letter in "qv")
    phase = domain_phase(problem, domain).rates(share, T, q, v, numbers)
    if phase.by_state:
        return []
    alpha = ca.SX.sym("alpha", len(names), problem.outputs.order + 1)
    _, slope, curvature = bezier(alpha, phase.value)
    upper = np.tile(most * (1.0 - MARGIN * problem.node_margins), (instants.size, 1))
    common = np.concatenate([domain.duration, domain.coefficients, domain.phase_numbers])
    block = Block(
        name=f"between_{identifier(domain.stance.name)}",
        variables=ca.vertcat(T, ca.vec(alpha), numbers),
        constants=share,
        parameters=ProgramParameters.symbols().packed(),
        rows=curvature * phase.rate**2 + slope * phase.bias,
        cost=ca.SX(1, 1),
        labels=tuple(
            RowKind.BETWEEN_NODES.labels((f"{ACCELERATION}{name}" for name in names), units(robot, names, "/s^2"))
        ),
        columns=np.tile(common, (instants.size, 1)),
        values=instants[:, None],
        places=tuple(f"{domain.stance.name} at {at:.3f} of its duration" for at in instants),
        lower=-upper,
        upper=upper,
    )
    return [block]


def instants_between(phases: Vector) -> Vector:
    """Return the instants that divide spacings of nodes evenly, so that none is wider than ``WIDEST``."""
    parts = np.ceil(np.diff(phases) / WIDEST - 1e-9).astype(int)
    pieces = [np.linspace(a, b, n + 1)[1:-1] for a, b, n in zip(phases[:-1], phases[1:], parts, strict=True)]
    return np.concatenate([np.zeros(0), *pieces])
