"""A motion from elsewhere as a gait: to be checked, stabilised, compared, or started from.

Coordinates over time are enough. What the file lacks follows from them: rates and accelerations by splines, contact
forces and torques by the equations of motion with the shortest torques, curves by a fit, impulses by the impact. Where
the motion is none of the robot, the rows of the problem that it violates say so, and `amble check` in detail.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from amble.amounts import LARGEST_NUMBER
from amble.errors import InputError, UnknownNameError, listed, printable, shown
from amble.gait import Gait
from amble.gait.recorded import RecordedDomain, RecordedMotion
from amble.hybrid import Contacts, impact
from amble.robot import dynamics
from amble.synthesis.initial_guess import phase_curves
from amble.synthesis.landing_rows import fill_landings
from amble.synthesis.layout import DomainLayout
from amble.synthesis.problem import GaitProblem
from amble.synthesis.program import build_program
from amble.synthesis.result import to_gait
from amble.synthesis.solve import finished
from amble.types import Matrix, NodeValues, Vector

IMPORTED = "imported"
"""Solver of a gait that no solver has found."""


def imported_gait(problem: GaitProblem, motion: RecordedMotion, coordinates: Sequence[str] | None = None) -> Gait:
    """Return a recorded motion as a gait of a problem: of its robot, pattern, outputs, law and limits.

    Nothing is optimised. The solver's report has the largest violation of a row of the problem.

    Args:
        problem: what the motion is one of; its mesh is that of the gait.
        motion: the solved domains in order, by the names of the pattern where the file names them.
        coordinates: names of the file's columns in their order, "-" before one whose sign is the opposite; by default
            those in the file, else the robot's order.

    Raises:
        InputError: domains or columns do not fit the problem.
        UnknownNameError: a column is no coordinate of the robot.
    """
    motion.check()
    program = build_program(problem)
    layout, x = program.layout, np.zeros(program.layout.size)
    recorded = _in_order(problem, motion)
    order, signs = _columns(problem, motion, coordinates)
    for domain, samples in zip(layout.domains, recorded, strict=True):
        _fill(problem, domain, x, _arranged(samples, order, signs, motion.source))
    x[layout.period] = sum(x[domain.duration] for domain in layout.domains)
    fill_landings(problem, layout, x)
    solution = finished(
        program,
        x / layout.scale,
        solver=IMPORTED,
        status=f"read from {printable(motion.source)}",
        solved=False,
        iterations=0,
        seconds=0.0,
    )
    return to_gait(problem, layout, solution)


def _in_order(problem: GaitProblem, motion: RecordedMotion) -> list[RecordedDomain]:
    names = [stance.name for stance in problem.pattern.solved]
    found = {domain.name: domain for domain in motion.domains if domain.name}
    if len(motion.domains) != len(names) or (found and set(found) != set(names)):
        raise InputError(
            f"motion '{printable(motion.source)}' has {len(motion.domains)} domains "
            f"({listed(found) or 'without names'}); the gait needs {listed(names)}"
        )
    return [found[name] for name in names] if found else list(motion.domains)


def _columns(
    problem: GaitProblem, motion: RecordedMotion, coordinates: Sequence[str] | None
) -> tuple[list[int], Vector]:
    """Where every coordinate of the robot stands in the file, and its sign."""
    names = problem.pattern.robot.coordinate_names
    given = tuple(coordinates or motion.columns or names)
    plain = [name.removeprefix("-") for name in given]
    for name in plain:
        if name not in names:
            raise UnknownNameError("coordinate", name, names)
    missing = [name for name in names if name not in plain]
    if missing or len(plain) != len(names):
        raise InputError(
            f"motion '{printable(motion.source)}' lacks {listed(missing) or 'nothing, but names a coordinate twice'}"
        )
    order = [plain.index(name) for name in names]
    return order, np.array([-1.0 if given[place].startswith("-") else 1.0 for place in order])


def _arranged(samples: RecordedDomain, order: list[int], signs: Vector, source: str) -> RecordedDomain:
    """Columns in the robot's order and signs, time from 0."""

    def columns(values: Matrix | None) -> Matrix | None:
        if values is not None and (values.ndim != 2 or values.shape[1] != len(order)):
            raise InputError(f"motion '{printable(source)}' has {np.shape(values)[-1]} columns, not {len(order)}")
        return None if values is None else values[:, order] * signs

    columns(samples.positions)  # refuses another width
    return replace(
        samples,
        times=samples.times - samples.times[0],
        positions=samples.positions[:, order] * signs,
        velocities=columns(samples.velocities),
        accelerations=columns(samples.accelerations),
    )


def _fill(problem: GaitProblem, domain: DomainLayout, x: Vector, samples: RecordedDomain) -> None:
    """Write the variables of a domain."""
    T, contacts = float(samples.times[-1]), problem.pattern.contacts(domain.stance)
    q, v, a = _resampled(samples, T * domain.phases)
    x[domain.duration] = T
    x[domain.phase_numbers], curves = phase_curves(problem, domain, T, q, v)
    x[domain.coefficients] = curves.ravel(order="F")
    x[domain.q], x[domain.v], x[domain.a] = q, v, a
    x[domain.u], x[domain.force] = _shortest(contacts, q, v, a)
    if domain.switch.landing:
        landed = problem.pattern.contacts(domain.switch.target)
        at, rate = ca.SX.sym("q", contacts.robot.size), ca.SX.sym("v", contacts.robot.size)
        stopped = ca.Function("impulse", [at, rate], [impact(landed, at, rate)[1]])
        x[domain.impulse] = np.asarray(stopped(q[-1], v[-1])).ravel()


def _resampled(samples: RecordedDomain, times: Vector) -> tuple[NodeValues, NodeValues, NodeValues]:
    """q, v and a at other times, by the smoothest spline through what is recorded."""
    t, q, v, a = samples.times, samples.positions, samples.velocities, samples.accelerations
    with np.errstate(all="ignore"):  # what overflows is refused below
        found = _curves(t, q, v, a, times)
    if not all(np.all(np.abs(values) <= LARGEST_NUMBER) for values in found):
        raise InputError(
            f"domain '{shown(samples.name)}' of the motion moves faster than any robot: its rates or accelerations "
            f"exceed {LARGEST_NUMBER:g}; are its times in seconds?"
        )
    return found


def _curves(
    t: Vector, q: NodeValues, v: NodeValues | None, a: NodeValues | None, times: Vector
) -> tuple[NodeValues, NodeValues, NodeValues]:
    """Return a spline through samples, and its two derivatives, at other times."""
    from scipy.interpolate import BPoly, CubicHermiteSpline, make_interp_spline

    if v is None:
        degree = 2 if len(t) == 3 else min(5, len(t) - 1 - len(t) % 2)  # odd, and below the number of samples
        curve = make_interp_spline(t, q, k=degree)
    elif a is None:
        curve = CubicHermiteSpline(t, q, v)
    else:
        curve = BPoly.from_derivatives(t, np.stack([q, v, a], axis=1))
    return curve(times), curve.derivative(1)(times), curve.derivative(2)(times)


def _shortest(contacts: Contacts, q: NodeValues, v: NodeValues, a: NodeValues) -> tuple[NodeValues, NodeValues]:
    """Torques and contact forces of accelerations: forces that carry the base, the shortest torques."""
    robot, n = contacts.robot, contacts.robot.base.size
    symbols = [ca.SX.sym(letter, robot.size) for letter in "qva"]
    N, W = contacts.torque_null_space(symbols[0])
    parts = [dynamics.inverse_dynamics(robot, *symbols), contacts.jacobian(symbols[0]), N, W]
    function = ca.Function("motion", symbols, [ca.densify(part) for part in parts])
    torques, forces = np.zeros((len(q), len(robot.joints))), np.zeros((len(q), contacts.size))
    arms = robot.torque_arms
    for row, state in enumerate(zip(q, v, a, strict=True)):
        load, J, N_row, W_row = (np.asarray(part) for part in function(*state))
        force = np.linalg.lstsq(J[:, :n].T, load[:n, 0], rcond=None)[0] if contacts.feet else np.zeros(0)
        torque = load[n:, 0] - J[:, n:].T @ force
        if N_row.shape[1]:
            s = -np.linalg.lstsq(arms[:, None] * N_row, arms * torque, rcond=None)[0]
            torque, force = torque + N_row @ s, force + W_row @ s
        torques[row], forces[row] = torque, force
    return torques, forces
