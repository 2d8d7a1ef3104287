"""The tables of a gain-scheduled impedance law: every gait's law written over the same pieces.

A gait that turns to the left has a mirror image that turns to the right, under the mirrored law. So of an axis that
the mirror changes the sign of, gaits from 0 on are enough.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from amble.control import AllocationLaw
from amble.errors import InputError
from amble.gait.impedance import GROUP, HOLD, Impedance, unpacked
from amble.gait.landing_stances import entering, landings, twin
from amble.gait.orbit import OrbitArc, orbit_arcs
from amble.gait.record import Gait
from amble.gait.schedule import Schedule
from amble.hybrid import SIMULTANEOUS
from amble.numerics.pieces import FAR, ORDER, SAMPLES, Pieces, padded, piece
from amble.robot.mirror import Mirror, SignedPermutation
from amble.types import Matrix, Vector, frozen

SAME = 1e-9
"""Ends of pieces this near to each other, as a share of the planned duration, are one."""

SIDEWAYS = "lateral_speed", "yaw_rate"
"""Axes of which the mirror changes the sign."""

Place = tuple[float, ...]
Gains = tuple[Vector, Vector]


@dataclass(frozen=True, kw_only=True)
class _Node:
    """The law of one gait, in parts.

    Attributes:
        arcs: the orbit in every solved stance.
        gains: P and D there.
        between: packed numbers of every stance between landings, in the order of ``landings``.
        start: fixed point, (2 n_q,).
    """

    arcs: tuple[OrbitArc, ...]
    gains: tuple[Gains, ...]
    between: tuple[Vector, ...]
    start: Vector


def impedance_schedule(
    gaits: Mapping[Place, Gait], axes: Sequence[str], law: AllocationLaw | None = None, images: bool = False
) -> Schedule:
    """Write the impedance law of a grid of gaits over the same pieces.

    Args:
        gaits: values along the axes -> stabilised gait under ``Impedance``; every combination of the values.
        axes: their names.
        law: another allocation law of the feed-forward than the gaits'.
        images: add the mirror images of all gaits (``mirrored_axis``).

    Raises:
        InputError: a combination is missing, an axis has one value only, or the gaits are of different robots, stances,
            grounds or windows of lift-offs.
        WorkError: an orbit cannot be integrated.
    """
    first = next(iter(gaits.values()))
    grid_values(gaits, axes)
    if len({impedance_of(gait).lift_offs for gait in gaits.values()}) > 1:
        raise InputError("the laws of the gaits have different windows of lift-offs; between such is no interpolation")
    nodes = {tuple(place): _node(gait, law or gait.law) for place, gait in gaits.items()}
    if images:
        axis, shift = mirrored_axis(gaits, axes), _ahead(first)
        nodes |= {
            tuple(-value if k == axis else value for k, value in enumerate(place)): _image(first, node, shift)
            for place, node in nodes.items()
            if axis is not None and place[axis] > 0.0
        }
    values = tuple(tuple(sorted({place[k] for place in nodes})) for k in range(len(axes)))
    every = [nodes[place] for place in itertools.product(*values)]
    solved, joints = len(first.pattern.solved), len(first.robot.joints)
    cuts = [_shares([node.arcs[number] for node in every]) for number in range(solved)]
    count = -(-(max(map(len, cuts)) - 1) // GROUP) * GROUP  # of pieces, the same in every stance
    rows = [
        np.array([_packed(node.arcs[number], cuts[number], node.gains[number], count) for node in every])
        for number in range(solved)
    ]
    rows += [
        np.array([_lengthened(node.between[number], joints, count) for node in every])
        for number in range(len(every[0].between))
    ]
    shape = tuple(len(row) for row in values)
    return Schedule(
        gait=replace(first, yaw_rate=0.0) if first.turn else first,
        axes=tuple(axes),
        values=values,
        tables=frozen(np.stack(rows, axis=1).reshape(*shape, len(rows), -1)),
        starts=frozen(np.array([node.start for node in every]).reshape(*shape, -1)),
    )


def impedance_of(gait: Gait) -> Impedance:
    """Return the impedance law of a gait.

    Raises:
        InputError: it walks under another.
    """
    if not isinstance(gait.control, Impedance):
        raise InputError("the gaits of a schedule walk under control law 'impedance'")
    return gait.control


def grid_values(gaits: Mapping[Place, Gait], axes: Sequence[str]) -> tuple[tuple[float, ...], ...]:
    """Return the values of every axis, ascending, of gaits that one law can be interpolated over.

    Raises:
        InputError: no law can be; see ``impedance_schedule``.
    """
    values = tuple(tuple(sorted({place[k] for place in gaits})) for k in range(len(axes)))
    grid = list(itertools.product(*values))
    for axis, row in zip(axes, values, strict=True):
        if len(row) < 2:
            raise InputError(f"axis {axis} has one value, {row[0]:g}: between gaits there have to be two at least")
    missing = [place for place in grid if place not in gaits]
    if missing:
        where = ", ".join(f"{axis} {value:g}" for axis, value in zip(axes, missing[0], strict=True))
        raise InputError(f"{len(missing)} of {len(grid)} gaits of the grid are not there, the first at {where}")
    first = gaits[grid[0]]
    if any(_kind(gait) != _kind(first) for gait in gaits.values()):
        raise InputError("the gaits differ in robot, stances, landing rule or ground; between such is no interpolation")
    return values


def mirrored_axis(gaits: Mapping[Place, Gait], axes: Sequence[str]) -> int | None:
    """Return the axis along which mirror images are gaits too, beyond a lowest value of 0; None where there is none.

    Of two axes that change their sign, images would leave corners of the grid open.
    """
    sideways = [number for number, axis in enumerate(axes) if axis in SIDEWAYS]
    if len(sideways) != 1 or min(place[sideways[0]] for place in gaits) != 0.0:
        return None
    first = next(iter(gaits.values()))
    return sideways[0] if first.pattern.ground.mirrored and _ahead(first) is not None else None


def _kind(gait: Gait) -> object:
    """What has to be the same; a rule of landing is no matter where single feet land."""
    pattern = gait.pattern
    single = pattern.steps == pattern.all_switches
    return replace(pattern, landing_rule=SIMULTANEOUS if single else pattern.landing_rule)


def _node(gait: Gait, law: AllocationLaw) -> _Node:
    arcs, control = orbit_arcs(gait, law), impedance_of(gait)
    between = control.landing_numbers(gait, law)
    return _Node(
        arcs=arcs,
        gains=tuple(control.joint_gains(gait.robot, stance) for stance in gait.pattern.solved),
        between=tuple(between[stance.name].parameters for stance, _ in landings(gait)),
        start=gait.feedback.start,  # type: ignore[union-attr]  # orbit_arcs saw it
    )


def _ahead(gait: Gait) -> int | None:
    """By how many stances a gait without a mirror is ahead of its mirror image; None where it has none."""
    stances = gait.pattern.stances
    try:
        feet = gait.robot.mirror.feet
    except InputError:  # a robot that is not left-right symmetric
        return None
    images = [{feet[foot] for foot in stance.feet} for stance in stances]
    if gait.pattern.mirrored:
        return None
    shifts = range(len(stances))
    return next((k for k in shifts if images == [set(s.feet) for s in (*stances[k:], *stances[:k])]), None)


def _image(gait: Gait, node: _Node, shift: int | None) -> _Node:
    """Mirror the law of a gait: every stance has the image of the one that is its own image's."""
    if shift is None:
        raise InputError("the gaits have no mirror images")
    mirror, stances, between = gait.robot.mirror, gait.pattern.stances, landings(gait)
    places = [(number + shift) % len(stances) for number in range(len(stances))]
    switches = [entering(gait, places[stances.index(following)]) for _, following in between]
    sources = [
        between.index((twin(gait, switch, stance), switch.target))
        for (stance, _), switch in zip(between, switches, strict=True)
    ]
    return _Node(
        arcs=tuple(_mirrored_arc(mirror, node.arcs[place]) for place in places),
        gains=tuple((P[mirror.joints.index], D[mirror.joints.index]) for P, D in (node.gains[k] for k in places)),
        between=tuple(_mirrored(node.between[source], mirror.joints) for source in sources),
        start=frozen(mirror.state(node.arcs[places[0]].states(np.zeros(1))[0][0])),
    )


def _mirrored_arc(mirror: Mirror, arc: OrbitArc) -> OrbitArc:
    def image(pieces: Pieces, matrix: Matrix) -> Pieces:
        return Pieces(breaks=pieces.breaks, coefficients=frozen(np.einsum("sr,krc->ksc", matrix, pieces.coefficients)))

    states = np.asarray(np.kron(np.eye(2), mirror.coordinates.matrix), dtype=np.float64)
    return replace(arc, states=image(arc.states, states), torques=image(arc.torques, mirror.joints.matrix))


def _mirrored(packed: Vector, mirror: SignedPermutation) -> Vector:
    """Mirror packed numbers: gains change places, angles and torques the sign too."""
    ends, P, D, places, curves = unpacked(packed, mirror.index.size)
    images = np.einsum("sr,akrc->aksc", mirror.matrix, curves)
    return frozen(np.concatenate([ends, P[mirror.index], D[mirror.index], places.ravel(), images.ravel()]))


def _lengthened(packed: Vector, joints: int, count: int) -> Vector:
    """Pack the same with more pieces, which are never reached."""
    ends, P, D, places, curves = unpacked(packed, joints)
    used = int(np.sum(places[0] < FAR))
    more = count - used
    if more < 0:
        raise InputError("the law between two landings has more pieces than any stance")
    places = np.concatenate([places[:, :used], [np.full(more, FAR), np.ones(more)]], axis=1)
    curves = np.concatenate([curves[:, :used], np.zeros((2, more, joints, ORDER + 1))], axis=1)
    return frozen(np.concatenate([ends, P, D, places.ravel(), curves.ravel()]))


def _shares(arcs: Sequence[OrbitArc]) -> Vector:
    """Ends of pieces, as shares of the planned duration, at which every gait's pieces end too."""
    every = np.unique(np.concatenate([arc.torques.breaks / arc.duration for arc in arcs]))
    kept = np.concatenate([[True], np.diff(every) > SAME])
    return np.asarray(every[kept])


def _packed(arc: OrbitArc, shares: Vector, gains: Gains, count: int) -> Vector:
    """Pack the law as ``Impedance.numbers`` does, with given pieces."""
    T = arc.duration
    joints, torques = (_cut(curve, shares * T) for curve in (arc.joints, arc.torques))
    (places, angles), (_, efforts) = (padded(pieces, count) for pieces in (joints, torques))
    ends = np.array([shares[-1] * T, HOLD * T])
    return frozen(np.concatenate([ends, *gains, places.ravel(), angles.ravel(), efforts.ravel()]))


def _cut(curve: Pieces, breaks: Vector) -> Pieces:
    """Write a curve in pieces with other ends, its own among them: polynomials, so that nothing is lost."""
    found = [piece(curve(0.5 * (a + b) + 0.5 * (b - a) * SAMPLES)[0])[0] for a, b in itertools.pairwise(breaks)]
    return Pieces(breaks=frozen(breaks), coefficients=frozen(np.array(found)))
