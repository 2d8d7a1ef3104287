"""Joint impedance about a gait's own orbit (docs/theory/impedance.md).

u = u_d(t) - P (q_j - q_d(t)) - D (q_j' - q_d'(t)): the torques that an allocation law applies on the orbit, and joint
springs and dampers of constant gains about the orbit's joint angles. It reads joints and contacts only. Gains of
prismatic joints are those of a joint that moves them by an arm of the leg length l: P / l^2 in N/m, D / l^2 in N s/m.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from amble.control import AllocationLaw
from amble.control.allocation.law import finite
from amble.control.landing import landing_plant, stopping
from amble.errors import InputError, UnknownNameError, shown
from amble.gait.control_law import CONTROL_LAWS, Numbers, TorqueLaw
from amble.gait.landing_stances import landings
from amble.gait.orbit import OrbitArc, orbit_arcs
from amble.gait.record import Gait
from amble.hybrid import Contacts, Stance, Symmetry
from amble.hybrid.system import numeric
from amble.numerics.pieces import FAR, ORDER, Pieces, evaluated, padded
from amble.robot import Robot
from amble.robot.coordinate_units import from_torques
from amble.types import Matrix, NodeValues, Vector, frozen

STANCE = 0.812, 0.1267
SWING = 0.65, 0.0452
SWING_END = 0.433, 0.0181
"""Default stiffness over m g l and damping over m g l sqrt(l / g): of the joints of legs on the ground, of the others,
and of the last joint of those, which moves so little inertia that more damping rings where commands come late. 150,
120 and 80 N m/rad, 7, 2.5 and 1 N m s/rad on ASTRo; by trial in MuJoCo (docs/validation.md)."""

SINGLE = "stiffness", "damping"

LIFT_OFFS = 0.5, 1.2
"""Where no foot lands, a stance ends between these shares of its plan (``ControlLaw.lift_offs``): the impact of the
landing before may take the load off a foot for a moment, and a foot that goes on carrying is lifted by the next stance
alone (docs/validation.md, section on walks)."""

HOLD = 1.5
"""Share of the planned duration until which the references go on; then they stand still."""

GROUP = 4
"""Pieces are counted up to a multiple of this, so that gaits of one robot mostly share compiled code."""


class PackedImpedance(TorqueLaw):
    """The law of equation (1), whatever its numbers come from: its torques, and the plan, are read from packed ones."""

    def planned(self, gait: Gait, stance: Stance, p: ca.MX) -> ca.MX:
        """Read the plan from the packed parameters: of an interpolated law that at its command."""
        del gait, stance
        return p[1] / HOLD

    def keeps(self, gait: Gait, symmetry: Symmetry) -> bool:
        """All of them: it reads clock and joints."""
        del gait, symmetry
        return True

    @staticmethod
    def torques(contacts: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        """Write equations (1) and (2); the gains are among the parameters, so that all share one expression."""
        joints = len(contacts.robot.joints)
        return _about(contacts.robot, references(p, joints, t), p[2 : 2 + 2 * joints], q, v)


@dataclass(frozen=True, kw_only=True)
class Impedance(PackedImpedance):
    """Feed-forward from the orbit and constant joint gains; what is not given follows from the robot's size.

    Attributes:
        stance_stiffness: P of joints of legs on the ground, N m/rad.
        stance_damping: D of those, N m s/rad.
        swing_stiffness: P of the other joints, N m/rad; where none is given, the last joint of a leg has less.
        swing_damping: D of those, N m s/rad.
        stiffness: P of single joints in single domains, "DOMAIN JOINT" -> N m/rad; where feet land one by one, also in
            the stances between two landings.
        damping: D of those, N m s/rad.

    Raises:
        InputError: a gain is not a finite number, or negative.
    """

    units: ClassVar[Mapping[str, str]] = {
        "stance_stiffness": "N m/rad",
        "stance_damping": "N m s/rad",
        "swing_stiffness": "N m/rad",
        "swing_damping": "N m s/rad",
        "stiffness": "N m/rad",
        "damping": "N m s/rad",
    }
    lift_offs = LIFT_OFFS

    stance_stiffness: float | None = None
    stance_damping: float | None = None
    swing_stiffness: float | None = None
    swing_damping: float | None = None
    stiffness: Mapping[str, float] = field(default_factory=dict)
    damping: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse feedback that drives away."""
        given = {what: value for what, value in vars(self).items() if what not in SINGLE}
        for what in SINGLE:
            single = vars(self)[what]
            if not isinstance(single, Mapping):
                raise InputError(f"the {what} is {shown(single)}, not a number for every joint of a domain")
            given |= {f"{what} of '{shown(key)}'": value for key, value in single.items()}
        for what, value in given.items():
            if value is not None and finite(what.replace("_", " "), value) < 0.0:
                raise InputError(f"the {what.replace('_', ' ')} is {value:g}; it must not be negative")

    def __hash__(self) -> int:
        """Mappings have no hash of their own."""
        single = (frozenset(self.stiffness.items()), frozenset(self.damping.items()))
        return hash((self.stance_stiffness, self.stance_damping, self.swing_stiffness, self.swing_damping, *single))

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "impedance"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The gains that are given."""
        return {key: dict(v) if isinstance(v, Mapping) else v for key, v in vars(self).items() if v not in (None, {})}

    def joint_gains(self, robot: Robot, stance: Stance) -> tuple[Vector, Vector]:
        """Return P, N m/rad, and D, N m s/rad, of all joints in a stance, (n_joints,) each."""
        length = robot.leg_length
        scale = robot.mass * robot.gravity * length
        units = scale, scale * float(np.sqrt(length / robot.gravity))
        standing = {joint for foot in stance.feet for joint in robot.legs[foot]}
        ends = {robot.legs[foot][-1] for foot in robot.foot_names if robot.legs[foot]}
        found = []
        for what, unit, on, off, end in zip(SINGLE, units, STANCE, SWING, SWING_END, strict=True):
            single, stand, swing = (vars(self)[name] for name in (what, f"stance_{what}", f"swing_{what}"))
            high = on * unit if stand is None else stand
            low, last = (off * unit, end * unit) if swing is None else (swing, swing)
            usual = [high if joint in standing else last if joint in ends else low for joint in robot.joint_names]
            values = [single.get(f"{stance.name} {j}", own) for j, own in zip(robot.joint_names, usual, strict=True)]
            found.append(frozen(values))
        return found[0], found[1]

    def packed(self, gait: Gait, domain: str) -> Vector:
        """Pack a domain with the feed-forward of the gait's own allocation law; see ``numbers``."""
        place = [stance.name for stance in gait.pattern.solved].index(domain)
        return self.numbers(gait, None)[place].parameters

    def numbers(self, gait: Gait, allocation: AllocationLaw | None) -> tuple[Numbers, ...]:
        """Follow the orbit and take the torques of an allocation law along it.

        Raises:
            InputError: the gait does not hold its closed loop's own orbit.
        """
        self._check_names(gait)
        arcs = orbit_arcs(gait, allocation or gait.law)
        return tuple(
            self._of_arc(gait.robot, stance, arc) for stance, arc in zip(gait.pattern.solved, arcs, strict=True)
        )

    def _of_arc(self, robot: Robot, stance: Stance, arc: OrbitArc) -> Numbers:
        hold, end = HOLD * arc.duration, float(arc.torques.breaks[-1])
        packed = self._packed(robot, stance, (end, hold), [arc.joints, arc.torques])
        return Numbers(parameters=packed, breakpoints=(*map(float, arc.torques.breaks[1:]), hold))

    def _packed(self, robot: Robot, stance: Stance, ends: tuple[float, float], curves: Sequence[Pieces]) -> Vector:
        """Pack end and hold, gains, and the pieces of angles and torques, which are cut at the same places."""
        P, D = self.joint_gains(robot, stance)
        count = -(-curves[0].count // GROUP) * GROUP
        (places, angles), (_, torques) = (padded(pieces, count) for pieces in curves)
        return frozen(np.concatenate([np.array(ends), P, D, places.ravel(), angles.ravel(), torques.ravel()]))

    def _check_names(self, gait: Gait) -> None:
        """Refuse a gain of a domain or a joint that there is not."""
        joints, stances = gait.robot.joint_names, [*gait.pattern.solved, *(stance for stance, _ in landings(gait))]
        names = [stance.name for stance in stances]
        for what in SINGLE:
            for key in vars(self)[what]:
                if any(key == f"{name} {joint}" for name in names for joint in joints):
                    continue
                domain = next((key[: -len(joint) - 1] for joint in joints if key.endswith(f" {joint}")), None)
                if domain is not None:
                    raise UnknownNameError("domain with a gain of its own", domain, names)
                raise UnknownNameError(f"joint with a {what} of its own", key.partition(" ")[2], joints)

    def landing_numbers(self, gait: Gait, allocation: AllocationLaw | None) -> Mapping[str, Numbers]:
        """Reach on for the ground between two landings (docs/theory/impedance.md, eq. 9).

        The references begin where the orbit is when all feet land at once and go on at the rates that the impact of the
        feet that have landed leaves there; the feed-forward is that of the orbit's next stance, and of legs that have
        still to land what keeps their joints' rates. So nothing but the references is needed: no base, no model.
        """
        between = landings(gait)
        if not between:
            return {}
        arcs, found = orbit_arcs(gait, allocation or gait.law), dict[str, Numbers]()
        for stance, following in between:
            place = gait.pattern.solved.index(following)
            last, entered = arcs[place - 1], arcs[place]
            before = last.states(np.array([last.duration]))[0][0]
            if place == 0 and gait.pattern.mirrored:
                before = gait.robot.mirror.state(before)
            torques = entered.torques(np.zeros(1))[0][0]
            found[stance.name] = self._reaching(gait, stance, following, (before, torques), entered.duration)
        return found

    def _reaching(
        self, gait: Gait, stance: Stance, following: Stance, orbit: tuple[Vector, Vector], duration: float
    ) -> Numbers:
        """Pack one piece: a line of angles, and constant torques; ``orbit`` is the state before the landing, and u."""
        robot, contacts = gait.robot, gait.pattern.contacts(stance)
        late = tuple(foot for foot in following.feet if foot not in stance.feet)
        landed = stopping(contacts)(orbit[0])
        u = numeric(landing_plant(contacts, late)(landed, orbit[1])[2])
        joints, hold = len(robot.joints), (HOLD - 1.0) * duration
        angle, rate = (numeric(part)[-joints:] for part in ca.vertsplit(landed, robot.size))
        angles, torques = np.zeros((2, 1, joints, ORDER + 1))
        angles[0, :, 0], angles[0, :, 1], torques[0, :, 0] = angle + 0.5 * hold * rate, 0.5 * hold * rate, u
        breaks = frozen([0.0, hold])
        lines = [Pieces(breaks=breaks, coefficients=frozen(part)) for part in (angles, torques)]
        return Numbers(parameters=self._packed(robot, stance, (hold, hold), lines), breakpoints=(hold,))

    def gains(self, gait: Gait, domain: str) -> Mapping[str, int]:
        """All of them: one P and one D a joint and domain."""
        joints = gait.robot.joint_names
        places = {f"{domain} {joint} stiffness": 2 + number for number, joint in enumerate(joints)}
        return places | {f"{domain} {joint} damping": 2 + len(joints) + n for n, joint in enumerate(joints)}

    def with_gains(self, values: Mapping[str, float]) -> Impedance:
        """Return the law with other gains, by the labels of ``gains``."""
        chosen = {what: dict(vars(self)[what]) for what in SINGLE}
        for label, value in values.items():
            key, _, what = label.rpartition(" ")
            chosen[what][key] = float(value)
        return replace(self, stiffness=chosen["stiffness"], damping=chosen["damping"])

    def smooth(self, gait: Gait, numbers: Numbers) -> tuple[Numbers, ...]:
        """Cut a domain at its pieces, up to the end of the last: the gains, one place and one piece each."""
        # shorthand
        ends, P, D, places, curves = unpacked(numbers.parameters, len(gait.robot.joints))

        used = np.flatnonzero(places[0] < FAR)
        cuts = (*places[0, used[1:]], ends[0])
        return tuple(
            Numbers(
                parameters=frozen(np.concatenate([P, D, places[:, k], curves[:, k].ravel()])),
                breakpoints=(float(end),),
            )
            for k, end in zip(used, cuts, strict=True)
        )

    def smooth_torques(self, contacts: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        """Write equation (1) along one piece of the references."""
        joints = len(contacts.robot.joints)
        gains, place, angles, torques = ca.vertsplit(
            p, [0, 2 * joints, 2 * joints + 2, 2 * joints + 2 + joints * (ORDER + 1), p.shape[0]]
        )
        angle, rate = evaluated(place, angles, joints, t)
        return _about(contacts.robot, (angle, rate, evaluated(place, torques, joints, t)[0]), gains, q, v)


def unpacked(packed: Vector, joints: int) -> tuple[Vector, Vector, Vector, Matrix, NodeValues]:
    """Take packed numbers apart: [end, hold], P, D, places, curves.

    Places are starts and half lengths of the pieces, (2, n), curves the coefficients of angles and torques,
    (2, n, n_joints, ORDER + 1).
    """
    ends, P, D, rest = np.split(packed, [2, 2 + joints, 2 + 2 * joints])
    count = rest.size // (2 + 2 * joints * (ORDER + 1))
    return ends, P, D, rest[: 2 * count].reshape(2, count), rest[2 * count :].reshape(2, count, joints, ORDER + 1)


def _about(robot: Robot, reference: tuple[ca.SX, ca.SX, ca.SX], gains: ca.SX, q: ca.SX, v: ca.SX) -> ca.SX:
    """Write equation (1): springs and dampers about angles and rates, and the torques there."""
    angle, rate, torque = reference
    joints = angle.shape[0]
    away, apart = (from_torques(robot, part) for part in (q[-joints:] - angle, v[-joints:] - rate))
    return torque - from_torques(robot, gains[:joints] * away) - from_torques(robot, gains[joints:] * apart)


def references(p: ca.SX, joints: int, t: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Write q_d, q_d' and u_d at a clock from packed parameters, (n_joints,) each.

    After the end of the pieces angles go on at their last rate and torques stay, until ``HOLD``; then all stand still.
    """
    size = joints * (ORDER + 1)
    end, hold, rest = p[0], p[1], p[2 + 2 * joints :]
    count = rest.numel() // (2 + 2 * size)
    places = ca.reshape(rest[: 2 * count], count, 2).T
    inside = ca.fmin(t, end)
    angles, torques = ca.vertsplit(rest[2 * count :], count * size)
    angle, rate = evaluated(places, angles, joints, inside)
    torque, _ = evaluated(places, torques, joints, inside)
    return angle + rate * (ca.fmin(t, hold) - inside), ca.if_else(t < hold, rate, 0.0), torque


CONTROL_LAWS.register("impedance", Impedance)
