"""Periodic orbits of hybrid systems whose multipliers are known from elsewhere, built from first principles."""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.hybrid import Domain, HybridSystem, Invariant, Transition


def van_der_pol(damping: float, dead_time: float = 0.1) -> HybridSystem:
    """x'' = damping (1 - x^2) x' - x, cut where x rises through zero."""
    x = ca.SX.sym("x", 2)
    swing = Domain.from_expressions("swing", x, ca.vertcat(x[1], damping * (1 - x[0] ** 2) * x[1] - x[0]))
    section = Transition.from_expressions("swing", "swing", x, x[0], x, +1, dead_time=dead_time)
    return HybridSystem([swing], [section])


def relay_loop(hysteresis: float) -> HybridSystem:
    """A relay of +-1 with hysteresis in negative feedback around 1 / (s + 1)^3: two domains, one for each output."""
    x = ca.SX.sym("x", 3)
    domains = [
        Domain.from_expressions(name, x, ca.vertcat(level - x[0], x[0] - x[1], x[1] - x[2]))
        for name, level in (("plus", 1), ("minus", -1))
    ]
    switches = [
        Transition.from_expressions("plus", "minus", x, x[2] - hysteresis, x, +1),
        Transition.from_expressions("minus", "plus", x, x[2] + hysteresis, x, -1),
    ]
    return HybridSystem(domains, switches)


def ball_on_table(restitution: float, amplitude: float, gravity: float = 1.0, rate: float = 1.0) -> HybridSystem:
    """A ball that bounces once in a period of a table at amplitude * sin(phase); states height, velocity, phase."""
    x = ca.SX.sym("x", 3)
    height, velocity, phase = ca.vertsplit(x)
    table, table_velocity = amplitude * ca.sin(phase), amplitude * rate * ca.cos(phase)
    flight = Domain.from_expressions("flight", x, ca.vertcat(velocity, -gravity, rate))
    after = ca.vertcat(height, -restitution * velocity + (1 + restitution) * table_velocity, phase - 2 * np.pi)
    bounce = Transition.from_expressions("flight", "flight", x, height - table, after, -1)
    return HybridSystem([flight], [bounce], state_names=("height", "velocity", "phase"))


def compass_gait(slope: float, gravity: float = 9.81) -> HybridSystem:
    """Two stiff legs of length 1 with 5 kg half-way and 10 kg at the hip (Goswami, Thuilot, Espiau 1998).

    States: angles of the stance leg and of the swing leg from the vertical, positive where the hip is behind the foot,
    and their rates. The equations come from the energies, the impact from the angular momenta about the new foot (all)
    and about the hip (the leg that lifts).
    """
    leg_mass, hip_mass, half, length = 5.0, 10.0, 0.5, 1.0
    q, v = ca.SX.sym("q", 2), ca.SX.sym("v", 2)
    stance, swing = q[0], q[1]

    def along(angle: ca.SX, distance: float) -> ca.SX:
        return distance * ca.vertcat(-ca.sin(angle), ca.cos(angle))

    hip = along(stance, length)
    points = [(leg_mass, along(stance, half)), (hip_mass, hip), (leg_mass, hip - along(swing, half))]
    mass = sum((m * ca.jacobian(p, q).T @ ca.jacobian(p, q) for m, p in points), start=ca.SX(2, 2))
    potential = sum(m * gravity * p[1] for m, p in points)
    momentum = mass @ v
    bias = ca.jacobian(momentum, q) @ v - ca.gradient(0.5 * ca.dot(v, momentum) - potential, q)
    rate = ca.vertcat(v, -ca.solve(mass, bias))
    x = ca.vertcat(q, v)

    # the impact: positions stay; momentum of all about the swing foot, and of the old stance leg about the hip, stay
    velocities = [ca.jacobian(p, q) @ v for _, p in points]
    foot = hip - along(swing, length)

    def cross(a: ca.SX, b: ca.SX) -> ca.SX:
        return a[0] * b[1] - a[1] * b[0]

    before = ca.vertcat(
        sum(m * cross(p - foot, u) for (m, p), u in zip(points, velocities, strict=True)),
        leg_mass * cross(points[0][1] - hip, velocities[0]),
    )
    w = ca.SX.sym("w", 2)  # rates after the impact: of the new stance leg (old swing), of the new swing leg

    def spin(arm: ca.SX, turn: ca.SX) -> ca.SX:
        return turn * ca.vertcat(-arm[1], arm[0])

    hip_after = spin(hip - foot, w[0])
    after_velocities = [hip_after + spin(points[0][1] - hip, w[1]), hip_after, spin(points[2][1] - foot, w[0])]
    after = ca.vertcat(
        sum(m * cross(p - foot, u) for (m, p), u in zip(points, after_velocities, strict=True)),
        leg_mass * cross(points[0][1] - hip, after_velocities[0]),
    )
    rates = ca.solve(ca.jacobian(after, w), before)
    s = ca.SX.sym("s", 4)
    field = ca.substitute(rate, x, s)
    reset = ca.substitute(ca.vertcat(swing, stance, rates), x, s)
    step = Domain.from_expressions("step", s, field)
    strike = Transition.from_expressions("step", "step", s, s[0] + s[1] + 2 * slope, reset, -1, dead_time=0.2)
    return HybridSystem([step], [strike], state_names=("stance", "swing", "stance rate", "swing rate"))


def spring_mass_runner(angle: float = np.deg2rad(68.0), declared: bool = True) -> HybridSystem:
    """A point mass on a massless spring that is set down at an angle (Geyer, Seyfarth, Blickhan 2005): energy is kept.

    From apex to apex; states: position (from the apex or from the foot), velocity. 80 kg, 1 m, 20 kN/m, g = 9.81.
    """
    x = ca.SX.sym("x", 4)
    place, height, forward, upward = ca.vertsplit(x)
    gravity, stiffness, mass, length = 9.81, 20e3, 80.0, 1.0
    flight = ca.vertcat(forward, upward, 0, -gravity)
    leg = ca.sqrt(place**2 + height**2)
    push = stiffness / mass * (length - leg) / leg
    domains = [
        Domain.from_expressions("fall", x, flight),
        Domain.from_expressions("stance", x, ca.vertcat(forward, upward, push * place, push * height - gravity)),
        Domain.from_expressions("rise", x, flight),
    ]
    landed = ca.vertcat(-length * np.cos(angle), height, forward, upward)
    transitions = [
        Transition.from_expressions("fall", "stance", x, height - length * np.sin(angle), landed, -1),
        Transition.from_expressions("stance", "rise", x, leg - length, x, +1),
        Transition.from_expressions("rise", "fall", x, upward, ca.vertcat(0, height, forward, upward), -1),
    ]
    z = ca.SX.sym("z", 4)
    energy = Invariant("energy", ca.Function("energy", [z], [(z[2] ** 2 + z[3] ** 2) / 2 + gravity * z[1]]))
    names = ("place", "height", "forward", "upward")
    return HybridSystem(domains, transitions, (), names, [energy] if declared else [])
