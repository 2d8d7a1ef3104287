"""Where feet land one by one: the return map has one derivative for every order of landing, and all must contract.

The map is continuous and piecewise differentiable at a motion whose feet land at once. The spectral radius of each
derivative is not sufficient; one quadratic W with A^T W A < r^2 W, r < 1, for all of them is
(docs/theory/hybrid-model.md, section 10).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from amble.control import AllocationLaw
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.landing_domains import landing_steps
from amble.residual import Residual
from amble.stability.lyapunov import quadratic_bound, verified_bound
from amble.stability.monodromy import prepare_variational
from amble.stability.spectrum import Spectrum, spectrum
from amble.types import Matrix, Vector

MOST_ORDERS = 64
"""Orders that are followed at most."""


@dataclass(frozen=True)
class LandingOrder:
    """One order of landing over the solved stances: switch -> its feet in order, and the map's derivative there."""

    feet: Mapping[str, tuple[str, ...]]
    spectrum: Spectrum

    @property
    def name(self) -> str:
        """In words."""
        return "; ".join(f"{switch}: {', '.join(feet)}" for switch, feet in self.feet.items())


def landing_orders(gait: Gait, state: Vector, law: AllocationLaw | None = None) -> tuple[LandingOrder, ...]:
    """Differentiate the return map for every order of landing; of a mirrored gait that of half a cycle.

    Args:
        gait: the gait.
        state: the fixed point at the entry of the first domain, (n_x,).
        law: another allocation law than the gait's.

    Returns:
        Nothing where no feet land one by one.

    Raises:
        FallError: the motion does not come back in one of the orders.
        InputError: there are more orders than are followed.
    """
    several = [switch for switch in gait.pattern.switches if len(landing_steps(gait, switch)) > 1]
    choices = [tuple(permutations(switch.landing)) for switch in several]
    count = int(np.prod([len(choice) for choice in choices]))
    if count > MOST_ORDERS:
        raise InputError(f"the feet of gait '{gait.pattern.name}' land in {count} orders; {MOST_ORDERS} are followed")
    found = []
    for orders in product(*choices) if several else ():
        feet = {switch.name: order for switch, order in zip(several, orders, strict=True)}
        system = closed_loop(gait, law, half=True, orders=feet)
        there = prepare_variational(system)(state)
        found.append(LandingOrder(feet, spectrum(system, state, there.image, there.matrix)))
    return tuple(found)


def landing_order_rows(gait: Gait, state: Vector, law: AllocationLaw | None = None) -> tuple[Residual, ...]:
    """Return the radius of every order, and the rate at which one quadratic function falls in all of them."""
    orders = landing_orders(gait, state, law)
    if not orders:
        return ()
    below = float(np.nextafter(1.0, 0.0))
    radii = tuple(
        Residual(f"spectral radius, landing {order.name}", 0.0, order.spectrum.radius, below) for order in orders
    )
    common = common_rate([order.spectrum.matrix for order in orders])
    return (*radii, Residual("contraction of one quadratic function in all orders of landing", 0.0, common, below))


def common_rate(matrices: Iterable[Matrix]) -> float:
    """Return the smallest r found with r^2 W - A^T W A > 0 for all matrices A and one W > 0; infinite where none is.

    Tried are the W of every matrix and of their mean (``quadratic_bound``), verified for all by Cholesky factors.
    """
    given = list(matrices)
    best = float("inf")
    for candidate in (np.mean(given, axis=0), *given):
        if not np.abs(np.linalg.eigvals(candidate)).max() < 1.0:
            continue
        metric = quadratic_bound(candidate).metric
        root = np.linalg.cholesky(metric).T
        rate = max(float(np.linalg.norm(root @ matrix @ np.linalg.inv(root), 2)) for matrix in given) * (1.0 + 1e-9)
        bounds = [verified_bound(matrix, rate, metric) for matrix in given]
        if min(min(bound.definite, bound.decrease) for bound in bounds) > 0.0:
            best = min(best, rate)
    return best
