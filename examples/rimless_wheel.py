"""The rimless wheel: spokes without a rim, rolling down a slope; each spoke that lands takes some speed away.

McGeer, International Journal of Robotics Research 9, 1990. Its return map is known in closed form, which makes it the
first test of any stability tool: with n spokes at angle 2 pi / n the rate after impact obeys

    omega+^2 = cos^2(2 pi / n) (omega^2 + 4 (g / l) sin(pi / n) sin(slope)),

so that the multiplier is cos^2(2 pi / n).

Run it: python rimless_wheel.py
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.hybrid import Domain, HybridSystem, Transition
from amble.stability import FixedPoint, Spectrum, certify, fixed_point, multipliers

SPOKES, SLOPE, GRAVITY_OVER_LENGTH = 6, 0.2, 1.0  # -, rad, 1/s^2


def rimless_wheel(spokes: int = SPOKES, slope: float = SLOPE) -> HybridSystem:
    """Build the system: angle of the standing spoke from the vertical (rad, forward positive) and its rate (rad/s)."""
    state = ca.SX.sym("x", 2)
    angle, rate = ca.vertsplit(state)
    half = np.pi / spokes
    fall = ca.vertcat(rate, GRAVITY_OVER_LENGTH * ca.sin(angle))
    forward = rate  # a wheel that rolls back never lands its next spoke: the motion has ended
    stance = Domain.from_expressions("stance", state, fall, admissibility=forward)
    after = ca.vertcat(slope - half, ca.cos(2 * half) * rate)
    landing = Transition.from_expressions("stance", "stance", state, angle - (slope + half), after, direction=+1)
    return HybridSystem([stance], [landing], state_names=("angle", "rate"))


def known_rate(spokes: int = SPOKES, slope: float = SLOPE) -> float:
    """Return the rate just after impact on the periodic orbit, in closed form, rad/s."""
    share = np.cos(2 * np.pi / spokes) ** 2
    gained = 4 * GRAVITY_OVER_LENGTH * np.sin(np.pi / spokes) * np.sin(slope)
    return float(np.sqrt(share * gained / (1 - share)))


def find_orbit(system: HybridSystem, spokes: int = SPOKES, slope: float = SLOPE) -> tuple[FixedPoint, Spectrum]:
    """Return the fixed point just after impact, sought from a rate 10 % off the known one, and its multipliers."""
    found = fixed_point(system, np.array([slope - np.pi / spokes, 1.1 * known_rate(spokes, slope)]))
    return found, multipliers(system, found.state)


def rolling() -> tuple[HybridSystem, np.ndarray]:
    """Return the wheel and a start near its orbit, for ``amble prove examples/rimless_wheel.py:rolling``."""
    return rimless_wheel(), np.array([SLOPE - np.pi / SPOKES, known_rate()])


if __name__ == "__main__":
    wheel = rimless_wheel()
    orbit, spectrum = find_orbit(wheel)
    print(f"period        {orbit.period:.9f} s")
    print(f"fixed point   rate {orbit.state[1]:.9f} rad/s (closed form {known_rate():.9f})")
    print(f"multiplier    {spectrum.radius:.9f} (closed form {np.cos(2 * np.pi / SPOKES) ** 2:.9f})")
    certificate = certify(wheel, orbit.state)
    print(f"certificate   radius {certificate.radius:.6f} +- {certificate.error:.1e}")
