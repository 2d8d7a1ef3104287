"""The simplest walking model: two straight massless legs, a mass at the hip, walking down a slope without motors.

Garcia, Chatterjee, Ruina, Coleman, Journal of Biomechanical Engineering 120, 1998: leg length and gravity are 1, the
mass of the feet tends to 0. On the same slope there are two gaits, one with long and one with short steps; this script
finds both and says which is stable.

Run it: python simplest_walker.py
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.hybrid import Domain, HybridSystem, Transition
from amble.stability import FixedPoint, Spectrum, fixed_point, multipliers

SLOPE = 0.009  # rad
LONG_STEP = (0.2, -0.2)  # guesses: angle and rate of the stance leg just after heel strike
SHORT_STEP = (0.194, -0.204)


def simplest_walker(slope: float = SLOPE) -> HybridSystem:
    """Build the system: angle theta of the stance leg from the slope's normal, angle phi between the legs, rates."""
    state = ca.SX.sym("x", 4)
    theta, phi, theta_rate, phi_rate = ca.vertsplit(state)
    pull = ca.sin(theta - slope)
    swinging = ca.sin(phi) * (theta_rate**2 - ca.cos(theta - slope)) + pull
    swing = Domain.from_expressions("swing", state, ca.vertcat(theta_rate, phi_rate, pull, swinging))

    # Heel strike where phi - 2 theta passes 0 upwards. It is 0 just after the last strike too, where a guard does not
    # fire, and passes 0 downwards at mid-stance, where straight legs scuff: the model lets them through. `dead_time`
    # keeps the first of the three quiet from perturbed starts as well.
    c = ca.cos(2 * theta)
    after = ca.vertcat(-theta, -2 * theta, c * theta_rate, c * (1 - c) * theta_rate)
    strike = Transition.from_expressions("swing", "swing", state, phi - 2 * theta, after, direction=+1, dead_time=0.1)
    return HybridSystem([swing], [strike], state_names=("theta", "phi", "theta_rate", "phi_rate"))


def after_strike(guess: tuple[float, float]) -> np.ndarray:
    """Return the state just after heel strike at a guess of (theta, theta_rate)."""
    theta, theta_rate = guess
    return np.array([theta, 2 * theta, theta_rate, (1 - np.cos(2 * theta)) * theta_rate])


def long_step() -> tuple[HybridSystem, np.ndarray]:
    """Return the walker with a start near its long step, for ``amble prove examples/simplest_walker.py:long_step``."""
    return simplest_walker(), after_strike(LONG_STEP)


def short_step() -> tuple[HybridSystem, np.ndarray]:
    """Return the walker with a start near its short step, which is unstable."""
    return simplest_walker(), after_strike(SHORT_STEP)


def find_orbit(system: HybridSystem, guess: tuple[float, float]) -> tuple[FixedPoint, Spectrum]:
    """Return the fixed point just after heel strike near a guess of (theta, theta_rate), and its multipliers."""
    found = fixed_point(system, after_strike(guess))
    return found, multipliers(system, found.state)


if __name__ == "__main__":
    walker = simplest_walker()
    for name, guess in (("long step", LONG_STEP), ("short step", SHORT_STEP)):
        orbit, spectrum = find_orbit(walker, guess)
        print(f"{name}: period {orbit.period:.8f}, {'stable' if spectrum.radius < 1 else 'unstable'}")
        print(
            "  fixed point  " + ", ".join(f"{n} {v:.12f}" for n, v in zip(walker.state_names, orbit.state, strict=True))
        )
        print("  multipliers  " + ", ".join(f"{value:.8f}" for value in spectrum.multipliers))
