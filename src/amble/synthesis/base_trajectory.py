"""How the base must move so that the contact forces can carry it: a small linear-quadratic problem around a level walk.

A robot on two feet cannot stand still: gravity turns it about the line between them. Which trajectory of the base
brings it back in time follows from the rows of the dynamics that no actuator enters. Linear in small motions s of
the base, every foot held on its path by the legs, they make a quadratic program with equalities only, solved by one
sparse factorisation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.hybrid import Contacts, GaitPattern
from amble.numerics.collocation import CollocationScheme
from amble.robot import Robot, dynamics, kinematics
from amble.robot.coordinate_units import units
from amble.robot.natural_units import RobotUnits
from amble.types import Matrix, NodeValues, Vector, frozen

Index = NDArray[np.int64]

SWAY = frozen([0.05, 0.05, 0.02, 0.1, 0.05, 0.1])
"""A motion of the base that is not small any more, in units of the robot and rad; the inverse squares weigh the
quadratic program."""

SWAY_ACCELERATION = frozen([3.0, 10.0, 1.0, 30.0, 30.0, 30.0])
"""The same for its acceleration; nearly even height, or the robot would hop to be light."""

FORCE = frozen([0.07, 0.07, 0.3])
"""The same for a contact force, in weights of the robot; little horizontal force, for the sake of friction."""

MOMENT = 0.06
"""The same for a moment that a contact holds, in weights times the robot's unit of length."""

FREE = 1e-3
"""Weight of what is hardly weighed."""

DAMPING = 1e-3
"""Of the legs' answer to the base, in units of the robot a unit of a joint."""


@dataclass(frozen=True, kw_only=True)
class LevelWalk:
    """A domain of a walk with a level base: contacts, duration, s, scheme, and q, v, a at its nodes, (n, n_q)."""

    contacts: Contacts
    duration: float
    scheme: CollocationScheme
    q: NodeValues
    v: NodeValues
    a: NodeValues


@dataclass(frozen=True)
class _Places:
    """Where a domain's unknowns stand: s, its two rates, (n, n_b) each, and the forces in robot weights, (n, n_f)."""

    s: Index
    ds: Index
    dds: Index
    force: Index


def base_trajectory(
    pattern: GaitPattern, walks: Sequence[LevelWalk], turn: float = 0.0
) -> tuple[list[NodeValues], list[NodeValues]]:
    """Return for every domain the motion of the base to add, (n, n_b), and the contact forces, (n, n_f), N.

    Args:
        pattern: the gait pattern.
        walks: its solved domains.
        turn: of the heading from the first entry to the last end, rad.
    """
    from scipy.sparse import bmat, diags, identity
    from scipy.sparse.linalg import spsolve

    base = _BaseUnits.of(pattern.robot)
    places, sizes, weights, wanted = _unknowns(walks, base)
    rows = [_dynamics(walk, at, base) for walk, at in zip(walks, places, strict=True)]
    rows += [_collocation(walk, at, base) for walk, at in zip(walks, places, strict=True)]
    rows.append(_continuity(pattern, places, turn, base))
    matrix, right = _stacked(rows, sizes)
    hessian = diags(weights)
    system = bmat([[hessian, matrix.T], [matrix, -1e-9 * identity(right.size)]]).tocsc()
    solution = sizes * spsolve(system, np.concatenate([weights * wanted, right]))[: sizes.size]
    weight = pattern.robot.mass * pattern.robot.gravity
    return [solution[at.s] for at in places], [weight * solution[at.force] for at in places]


@dataclass(frozen=True, kw_only=True)
class _BaseUnits:
    """Sizes of the base's coordinates, of two rates of them, (n_b,) each, of the joints, and of a length, m."""

    s: Vector
    ds: Vector
    dds: Vector
    joints: Vector
    length: float

    @classmethod
    def of(cls, robot: Robot) -> _BaseUnits:
        sizes, names = RobotUnits.of(robot), robot.base.coordinates
        s, ds, dds = (np.array([sizes.size(unit) for unit in units(robot, names, per)]) for per in ("", "/s", "/s^2"))
        joints = np.array([sizes.size(joint.unit) for joint in robot.joints])
        return cls(s=s, ds=ds, dds=dds, joints=joints, length=sizes.length)


def _unknowns(walks: Sequence[LevelWalk], base: _BaseUnits) -> tuple[list[_Places], Vector, Vector, Vector]:
    """Number the unknowns node by node: places, sizes of one unit, and scaled by these weights and wanted values."""
    places, sizes, weights, wanted, offset = [], [], [], [], 0
    for walk in walks:
        nodes, contacts = walk.q.shape[0], walk.contacts
        axes, own = list(contacts.contact.axes), list(contacts.robot.base.places)
        count = len(own)
        width = 3 * count + contacts.size
        index = offset + np.arange(nodes * width).reshape(nodes, width)
        places.append(_Places(*np.split(index, [count, 2 * count, 3 * count], axis=1)))
        moments, feet = len(contacts.contact.moments), len(contacts.feet)
        held = np.tile([*FORCE[axes], *[MOMENT] * moments], feet)
        spread = [SWAY[own], np.full(count, FREE**-0.5), SWAY_ACCELERATION[own], held]
        weights.append(np.tile(np.concatenate(spread) ** -2.0, nodes))
        wanted.append(np.tile(np.concatenate([np.zeros(3 * count), _share(contacts)]), nodes))
        units_of_force = np.tile([*np.ones(len(axes)), *[base.length] * moments], feet)
        sizes.append(np.tile(np.concatenate([base.s, base.ds, base.dds, units_of_force]), nodes))
        offset += index.size
    return places, np.concatenate(sizes), np.concatenate(weights), np.concatenate(wanted)


def _share(contacts: Contacts) -> Vector:
    """Vertical forces of equal size that carry the robot, in its weight."""
    count, share = len(contacts.feet), np.zeros(contacts.contact.size)
    share[len(contacts.contact.axes) - 1] = 1.0 / max(count, 1)
    return np.tile(share, count)


Rows = tuple[Matrix, Index, Vector, Vector]
"""Coefficients and the places of their unknowns, (rows, terms) each, right-hand sides and sizes, (rows,) each."""


def _dynamics(walk: LevelWalk, at: _Places, base: _BaseUnits) -> Rows:
    """The base rows of D a + h = J^T lambda, in robot weights, linear around the level walk."""
    robot, nodes, share = walk.contacts.robot, walk.q.shape[0], _share(walk.contacts)
    n = robot.base.size
    # shorthand
    q, v, a = (ca.SX.sym(letter, robot.size) for letter in "qva")
    lam, weight = ca.SX.sym("lambda", share.size), robot.mass * robot.gravity
    r = dynamics.inverse_dynamics(robot, q, v, a)[:n] / weight - walk.contacts.jacobian(q)[:, :n].T @ lam

    J = ca.vertcat(*[kinematics.foot_jacobian(robot, foot, q) for foot in robot.foot_names])
    parts = [r, ca.jacobian(r, q), ca.jacobian(r, a), ca.jacobian(r, lam), J]
    function = ca.Function("balance", [q, v, a, lam], [ca.densify(part) for part in parts]).map(nodes)
    values = function(walk.q.T, walk.v.T, walk.a.T, np.tile(share[:, None], nodes))
    rest, by_q, by_a, by_force, feet_by_q = (_by_node(value, nodes) for value in values)
    units = base.joints
    legs, moved = feet_by_q[:, :, n:] * units, feet_by_q[:, :, :n]
    normal = legs.transpose(0, 2, 1) @ legs + (DAMPING * base.length) ** 2 * np.eye(legs.shape[2])
    follow = -units[:, None] * np.linalg.solve(normal, legs.transpose(0, 2, 1) @ moved)
    S = np.concatenate([np.tile(np.eye(n), (nodes, 1, 1)), follow], axis=1)
    coefficients = np.concatenate([by_q @ S, by_a @ S, by_force], axis=2)
    terms = np.hstack([at.s, at.dds, at.force])
    return (
        coefficients.reshape(nodes * n, -1),
        np.repeat(terms, n, axis=0),
        (by_force @ share - rest[:, :, 0]).ravel(),
        np.tile(base.length / base.s, nodes),  # forces in weights, moments in weights times a length
    )


def _by_node(value: Any, nodes: int) -> NDArray[np.float64]:
    """Split the columns of a mapped function's result by instance, (nodes, rows, columns)."""
    array = np.asarray(value)
    return array.reshape(array.shape[0], nodes, -1).transpose(1, 0, 2)


def _collocation(walk: LevelWalk, at: _Places, base: _BaseUnits) -> Rows:
    """Every inner and end node of an interval follows from its rates."""
    stages = walk.scheme.stages
    starts = np.arange(0, at.s.shape[0] - 1, stages - 1)
    step = walk.duration / starts.size
    coefficients, terms, sizes = [], [], []
    for stage in range(1, stages):
        for value, rate, size in ((at.s, at.ds, base.s), (at.ds, at.dds, base.ds)):
            columns = [value[starts + stage], value[starts], *(rate[starts + k] for k in range(stages))]
            index = np.stack([column.ravel() for column in columns], axis=1)
            row = np.concatenate([[1.0, -1.0], -step * walk.scheme.integration[stage]])
            terms.append(index)
            coefficients.append(np.tile(row, (index.shape[0], 1)))
            sizes.append(np.tile(size, starts.size))
    stacked = np.vstack(coefficients)
    return stacked, np.vstack(terms), np.zeros(stacked.shape[0]), np.concatenate(sizes)


def _continuity(pattern: GaitPattern, places: Sequence[_Places], turn: float, base: _BaseUnits) -> Rows:
    """The base trajectory goes on from domain to domain, and returns, mirrored where the gait is, turned with it."""
    n = pattern.robot.base.size
    signs = pattern.robot.mirror.coordinates.sign[:n] if pattern.mirrored else np.ones(n)
    links = [(before, after, np.ones(n)) for before, after in pairwise(places)] + [(places[-1], places[0], signs)]
    coefficients = [np.column_stack([np.ones(n), -sign]) for _, _, sign in links for _ in range(2)]
    terms = [
        np.column_stack([end, start])
        for before, after, _ in links
        for end, start in ((before.s[-1], after.s[0]), (before.ds[-1], after.ds[0]))
    ]
    if turn:
        # of a base in space: end = c start - s across along the first axis of positions and of angles, along y
        # s start + c across
        last, first = places[-1], places[0]
        across = np.array([1, 0, 2, 4, 3, 5])
        cosine = np.where(np.isin(np.arange(n), (2, 5)), 1.0, np.cos(turn))
        sine = np.array([-1.0, 1.0, 0.0, -1.0, 1.0, 0.0]) * np.sin(turn)
        turned = np.column_stack([np.ones(n), -cosine, -sine])
        ends = ((last.s[-1], first.s[0]), (last.ds[-1], first.ds[0]))
        coefficients = [np.column_stack([block, np.zeros(n)]) for block in coefficients[:-2]] + [turned, turned]
        terms = [np.column_stack([block, block[:, 0]]) for block in terms[:-2]]
        terms += [np.column_stack([end, start, start[across]]) for end, start in ends]
    sizes = np.tile(np.concatenate([base.s, base.ds]), len(links))
    return np.vstack(coefficients), np.vstack(terms), np.zeros(sizes.size), sizes


def _stacked(rows: Sequence[Rows], sizes: Vector) -> tuple[Any, Vector]:
    """Return the matrix and the right-hand side in scaled unknowns, rows scaled too."""
    from scipy.sparse import csc_matrix, vstack

    blocks = []
    for coefficients, terms, right, row_sizes in rows:
        first = np.repeat(np.arange(right.size), terms.shape[1])
        scaled = coefficients * sizes[terms] / row_sizes[:, None]
        blocks.append(csc_matrix((scaled.ravel(), (first, terms.ravel())), shape=(right.size, sizes.size)))
    return vstack(blocks), np.concatenate([right / row_sizes for _, _, right, row_sizes in rows])
