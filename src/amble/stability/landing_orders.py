"""Where feet land one by one: the return map has one derivative for every order of landing, and all must contract.

The map is continuous and piecewise differentiable at a motion whose feet land at once. The spectral radius of each
derivative is not sufficient; one quadratic W with A^T W A < r^2 W, r < 1, for all of them is
(docs/theory/hybrid-model.md, section 10). Of a mirrored gait the maps are those of half a cycle: the orders of its two
halves are then free of each other, and the same W bounds all their products.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from amble.control import AllocationLaw
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.landing_stances import landing_steps
from amble.hybrid import HybridSystem
from amble.progress import Progress, silent
from amble.residual import Residual
from amble.stability.common_bound import CommonBound, common_bound
from amble.stability.group import closest_shift
from amble.stability.two_ways import TwoWays, differentiate
from amble.types import Json, Vector

MOST_ORDERS = 64
"""Orders that are followed at most."""

Order = Mapping[str, tuple[str, ...]]
"""Switch -> its feet in the order in which they land."""


@dataclass(frozen=True)
class LandingOrder:
    """One order of landing over the solved stances.

    Attributes:
        feet: the order.
        derivative: of the return map whose feet land in that order, whatever the motion (``closed_loop`` with orders).
        missed: largest |P(x) - g x| of that map: 0 within rounding of the order that the orbit takes.
    """

    feet: Order
    derivative: TwoWays
    missed: float

    @property
    def name(self) -> str:
        """In words."""
        return "; ".join(f"{switch}: {', '.join(feet)}" for switch, feet in self.feet.items())


@dataclass(frozen=True)
class LandingOrders:
    """All orders of a gait, and one quadratic function for their derivatives.

    Attributes:
        orders: every order.
        bound: W and r for all of them.
    """

    orders: tuple[LandingOrder, ...]
    bound: CommonBound

    @property
    def taken(self) -> LandingOrder:
        """The order in which the feet land on the orbit; where they land at once, any."""
        return min(self.orders, key=lambda order: order.missed)

    def rows(self, largest_disagreement: float) -> tuple[Residual, ...]:
        """Return what must hold as rows."""
        below, least = float(np.nextafter(1.0, 0.0)), float(np.nextafter(0.0, 1.0))
        found = []
        for order in self.orders:
            where, known = f"landing {order.name}", order.derivative
            bar = known.spectrum.radius + known.error
            found.append(Residual(f"spectral radius plus its error bar, {where}", 0.0, bar, below))
            found.append(
                Residual(f"disagreement of the two Jacobians, {where}", 0.0, known.disagreement, largest_disagreement)
            )
        verified = min(min(bound.definite, bound.decrease) for bound in self.bound.bounds)
        return (
            *found,
            Residual("contraction of one quadratic function in all orders of landing", 0.0, self.bound.rate, below),
            Residual("least eigenvalue of W and r^2 W - A^T W A in all orders", least, verified, float("inf")),
        )

    def to_dict(self) -> Json:
        """Return them as a tree for a JSON file."""
        return {
            "orders": [
                {
                    "feet": {switch: list(feet) for switch, feet in order.feet.items()},
                    "taken_by_the_orbit": order is self.taken,
                    "spectral_radius": order.derivative.spectrum.radius,
                    "spectral_radius_error": order.derivative.error,
                    "jacobians_disagreement_relative": order.derivative.disagreement,
                    "return_map": order.derivative.spectrum.matrix.tolist(),
                }
                for order in self.orders
            ],
            "basis": self.orders[0].derivative.spectrum.basis.tolist(),
            "contraction_bound": {"rate": self.bound.rate, "W": self.bound.metric.tolist()},
        }


def orders_of(gait: Gait) -> tuple[Order, ...]:
    """Return all orders in which the feet of the solved switches may land; none where no feet land one by one.

    Raises:
        InputError: there are more than are followed.
    """
    several = [switch for switch in gait.pattern.switches if len(landing_steps(gait, switch)) > 1]
    if not several:
        return ()
    choices = [tuple(permutations(switch.landing)) for switch in several]
    count = int(np.prod([len(choice) for choice in choices]))
    if count > MOST_ORDERS:
        raise InputError(f"the feet of gait '{gait.pattern.name}' land in {count} orders; {MOST_ORDERS} are followed")
    return tuple(
        {switch.name: order for switch, order in zip(several, orders, strict=True)} for orders in product(*choices)
    )


def in_order(gait: Gait, order: Order, law: AllocationLaw | None = None) -> HybridSystem:
    """Close the loop of the whole cycle with the feet landing in one order, in a mirrored half in its mirror image."""
    pattern = gait.pattern
    known = dict(order)
    for switch, twin in zip(pattern.switches, pattern.all_switches[len(pattern.solved) :], strict=False):
        if switch.name in order:
            known[twin.name] = tuple(gait.robot.mirror.feet[foot] for foot in order[switch.name])
    return closed_loop(gait, law, orders=known)


def landing_orders(
    gait: Gait,
    state: Vector,
    tolerances: Sequence[float],
    progress: Progress | None = None,
    law: AllocationLaw | None = None,
) -> LandingOrders | None:
    """Differentiate the return map for every order of landing, twice; of a mirrored gait that of half a cycle.

    Args:
        gait: the gait.
        state: the fixed point at the entry of the first domain, (n_x,).
        tolerances: of the integrator; the last, tightest one counts.
        progress: called with what is being computed.
        law: another allocation law than the gait's.

    Returns:
        Nothing where no feet land one by one.

    Raises:
        FallError: the motion does not come back in one of the orders.
        InputError: there are more orders than are followed.
    """
    found = []
    for order in orders_of(gait):
        system = closed_loop(gait, law, half=True, orders=order)
        derivative = differentiate(system, state, tolerances, progress or silent)
        image = derivative.monodromy.image
        found.append(
            LandingOrder(order, derivative, float(np.abs(image - closest_shift(system, state, image).image).max()))
        )
    if not found:
        return None
    return LandingOrders(tuple(found), common_bound([order.derivative.spectrum.matrix for order in found]))
