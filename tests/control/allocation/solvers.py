"""The allocation problems as conic programs for Clarabel: the oracle of the law tests."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt
from typing import Any

import clarabel
import numpy as np
from scipy import sparse

from amble.control.actuator import ACTUATORS
from amble.types import Matrix, Vector
from tests import robots
from tests.control.allocation.stances import FRICTION, NORMAL, Sample

PAPER_HEAT = ACTUATORS["paper"].heat_coefficient


@dataclass(frozen=True)
class Program:
    """Minimise x^T P x / 2 + c^T x with b - A x in a product of cones; the last k entries of x are s."""

    P: Matrix
    c: Vector
    A: Matrix
    b: Vector
    cones: list[Any]

    def solve(self) -> tuple[Vector, str]:
        """The minimiser and Clarabel's status."""
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
        size = np.abs(self.c).max()  # a problem of size one
        quadratic, rows = sparse.csc_matrix(np.triu(self.P) / size), sparse.csc_matrix(self.A)
        found = clarabel.DefaultSolver(quadratic, self.c / size, rows, self.b, self.cones, settings).solve()
        return np.array(found.x), str(found.status)


@lru_cache(maxsize=8)
def efforts(name: str) -> Vector:
    """Torque limits of a robot, N m."""
    return np.array([joint.effort for joint in robots.robot(name).joints])


def weight_share(name: str, count: int) -> float:
    """Weight that each of some feet carries, N."""
    return robots.robot(name).mass * robots.robot(name).gravity / count


def power_program(sample: Sample, heat: Vector | float = PAPER_HEAT) -> Program:
    """Variables (p, s): the positive power p of every joint bounds u w and 0 from above; heat a squared torque."""
    r = np.broadcast_to(heat, 12)
    u, N, w = sample.torques, sample.torque_basis, sample.speeds
    k = N.shape[1]
    P = np.zeros((12 + k, 12 + k))
    P[12:, 12:] = 2.0 * N.T @ (r[:, None] * N)
    A = np.block([[-np.eye(12), np.zeros((12, k))], [-np.eye(12), w[:, None] * N]])
    c = np.concatenate([np.ones(12), 2.0 * N.T @ (r * u)])
    return Program(P, c, A, np.concatenate([np.zeros(12), -u * w]), [clarabel.NonnegativeConeT(24)])


def peak_program(name: str, sample: Sample) -> Program:
    """Variables (t, s): t bounds every relative torque of the stance legs."""
    steered = np.any(sample.torque_basis != 0.0, axis=1)
    a, B = (
        values[steered] / efforts(name)[steered][:, None] for values in (sample.torques[:, None], sample.torque_basis)
    )
    k = B.shape[1]
    ones = np.ones((len(a), 1))
    A = np.block([[-ones, B], [-ones, -B]])
    c = np.concatenate([[1.0], np.zeros(k)])
    b = np.concatenate([-a[:, 0], a[:, 0]])
    return Program(np.zeros((k + 1, k + 1)), c, A, b, [clarabel.NonnegativeConeT(len(b))])


def bounded_program(name: str, sample: Sample) -> Program:
    """Variables s: exact cones for two feet, the inner pyramid for more; forces relative to the weight's share."""
    N, k = sample.torque_basis, sample.torque_basis.shape[1]
    share = weight_share(name, len(sample.forces) // 3)
    W, forces, least = sample.force_basis / share, sample.forces / share, NORMAL / share
    steered = np.any(N != 0.0, axis=1)
    a, B = sample.torques[steered] / efforts(name)[steered], N[steered] / efforts(name)[steered][:, None]
    rows, right = [B, -B, -W[2::3]], [1.0 - a, 1.0 + a, forces[2::3] - least]
    cones: list[Any] = [clarabel.NonnegativeConeT(2 * len(a) + len(forces) // 3)]
    slope = FRICTION / sqrt(2.0)
    pyramid = np.array([[1.0, 0.0, -slope], [-1.0, 0.0, -slope], [0.0, 1.0, -slope], [0.0, -1.0, -slope]])
    cone = np.array([[0.0, 0.0, -FRICTION], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    for foot in range(len(forces) // 3):
        here = slice(3 * foot, 3 * foot + 3)
        matrix = cone if k == 1 else pyramid
        rows.append(matrix @ W[here])
        right.append(-matrix @ forces[here])
        cones.append(clarabel.SecondOrderConeT(3) if k == 1 else clarabel.NonnegativeConeT(4))
    return Program(N.T @ N, N.T @ sample.torques, np.vstack(rows), np.concatenate(right), cones)
