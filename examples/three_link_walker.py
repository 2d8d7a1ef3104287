"""Three-link walker with hybrid zero dynamics: a torso on two legs, walking on the flat under two hip torques.

Westervelt, Grizzle, Chevallereau, Choi, Morris, Feedback Control of Dynamic Bipedal Robot Locomotion, chapter 3;
Grizzle, Abba, Plestan, IEEE Transactions on Automatic Control 46, 2001. The torso angle and the angle of the swing leg
follow polynomials of the angle of the stance leg, so that what remains is a motion of the stance leg alone.

Run it: python three_link_walker.py
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.hybrid import Domain, HybridSystem, Transition
from amble.stability import FixedPoint, Spectrum, fixed_point, multipliers

LEG, TORSO = 1.0, 0.5  # lengths, m; the mass of a leg is at its middle
LEG_MASS, HIP_MASS, TORSO_MASS = 5.0, 15.0, 10.0  # kg
GRAVITY = 9.8  # m/s^2, the value of the source
STEP_ANGLE = np.pi / 8  # of the stance leg at impact, rad
LEAN = (0.512, 0.073, 0.035, -0.819)  # torso angle as a polynomial of the stance leg's angle
SWING = (-2.27, 3.26, 3.11, 1.89)  # the same for the swing leg, times (theta_1^2 - STEP_ANGLE^2)


def three_link_walker(epsilon: float = 0.1) -> HybridSystem:
    """Build the closed loop: state (stance, swing, torso angle from the vertical and their rates), rad and rad/s."""
    state = ca.SX.sym("x", 6)
    angles, rates = state[:3], state[3:]
    hip = LEG * ca.vertcat(ca.sin(angles[0]), ca.cos(angles[0]))
    kinetic, potential = _energies(angles, rates, hip, ca.jacobian(hip, angles) @ rates)
    mass = ca.hessian(kinetic, rates)[0]
    bias = ca.jacobian(mass @ rates, angles) @ rates - ca.gradient(kinetic, angles) + ca.gradient(potential, angles)
    torque_map = ca.DM([[-1, 0], [0, -1], [1, 1]])

    # input-output linearisation: y'' = -y / epsilon^2 - 2 y' / epsilon
    stance, swing, torso = ca.vertsplit(angles)
    lean = sum(c * stance**k for k, c in enumerate(LEAN))
    spread = sum(c * stance**k for k, c in enumerate(SWING)) * (stance**2 - STEP_ANGLE**2)
    output = ca.vertcat(torso - lean, swing + stance - spread)
    slope = ca.jacobian(output, angles)
    output_rate = slope @ rates
    drift = ca.jacobian(output_rate, angles) @ rates - slope @ ca.solve(mass, bias)
    wanted = -output / epsilon**2 - 2 * output_rate / epsilon
    torques = ca.solve(slope @ ca.solve(mass, torque_map), wanted - drift)
    acceleration = ca.solve(mass, torque_map @ torques - bias)

    walk = Domain.from_expressions("walk", state, ca.vertcat(rates, acceleration), signals={"torque": torques})
    impact = Transition.from_expressions("walk", "walk", state, stance - STEP_ANGLE, _impact(angles, rates), +1)
    names = ("stance", "swing", "torso", "stance_rate", "swing_rate", "torso_rate")
    return HybridSystem([walk], [impact], state_names=names)


def _energies(angles: ca.SX, rates: ca.SX, hip: ca.SX, hip_rate: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Kinetic and potential energy of the links for a hip that moves as given."""
    offsets = [(-LEG / 2, 0, LEG_MASS), (-LEG / 2, 1, LEG_MASS), (TORSO, 2, TORSO_MASS)]
    kinetic = HIP_MASS * ca.sumsqr(hip_rate) / 2
    potential = HIP_MASS * GRAVITY * hip[1]
    for offset, link, mass in offsets:
        place = hip + offset * ca.vertcat(ca.sin(angles[link]), ca.cos(angles[link]))
        velocity = hip_rate + offset * rates[link] * ca.vertcat(ca.cos(angles[link]), -ca.sin(angles[link]))
        kinetic += mass * ca.sumsqr(velocity) / 2
        potential += mass * GRAVITY * place[1]
    return kinetic, potential


def _impact(angles: ca.SX, rates: ca.SX) -> ca.SX:
    """Plastic impact of the swing foot: free flight, an impulse at that foot that stops it; then the legs swap."""
    free = ca.SX.sym("v", 5)  # rates of the angles, velocity of the hip
    kinetic, _ = _energies(angles, free[:3], ca.SX.zeros(2), free[3:])
    mass = ca.hessian(kinetic, free)[0]
    foot_velocity = free[3:] - LEG * free[1] * ca.vertcat(ca.cos(angles[1]), -ca.sin(angles[1]))
    contact = ca.jacobian(foot_velocity, free)
    hip_velocity = LEG * rates[0] * ca.vertcat(ca.cos(angles[0]), -ca.sin(angles[0]))
    before = ca.vertcat(rates, hip_velocity)
    system = ca.vertcat(ca.horzcat(mass, -contact.T), ca.horzcat(contact, ca.SX.zeros(2, 2)))
    after = ca.solve(system, ca.vertcat(mass @ before, ca.SX.zeros(2)))
    return ca.vertcat(angles[1], angles[0], angles[2], after[1], after[0], after[2])


def find_orbit(system: HybridSystem, rate: float = 1.55) -> tuple[FixedPoint, Spectrum]:
    """Return the fixed point just after impact, sought from a stance leg's rate just before it, and the multipliers."""
    lean = np.polynomial.Polynomial(LEAN)
    swing = np.polynomial.Polynomial(SWING) * np.polynomial.Polynomial([-(STEP_ANGLE**2), 0, 1])
    angles = [STEP_ANGLE, -STEP_ANGLE, lean(STEP_ANGLE)]
    rates = rate * np.array(
        [1.0, swing.deriv()(STEP_ANGLE) - 1.0, lean.deriv()(STEP_ANGLE)]
    )  # where the outputs vanish
    after = system.transitions[0].reset(0.0, np.concatenate([angles, rates]), [])
    found = fixed_point(system, np.array(after).ravel())
    return found, multipliers(system, found.state)


if __name__ == "__main__":
    walker = three_link_walker()
    orbit, spectrum = find_orbit(walker)
    print(f"period        {orbit.period:.7f} s")
    print("fixed point   " + ", ".join(f"{n} {v:.7f}" for n, v in zip(walker.state_names, orbit.state, strict=True)))
    print("multipliers   " + ", ".join(f"{value:.6g}" for value in spectrum.multipliers))
    print(f"radius        {spectrum.radius:.6f}: {'stable' if spectrum.radius < 1 else 'unstable'}")
