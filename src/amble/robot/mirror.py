"""The left-right mirror of a robot: a signed permutation of coordinates, found from geometry and then verified."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.errors import InputError
from amble.robot.dynamics import mass_matrix, potential_energy
from amble.robot.kinematics import foot_position, zero_poses
from amble.types import Vector, frozen

if TYPE_CHECKING:
    from amble.robot.model import Robot

REFLECTION = np.diag([1.0, -1.0, 1.0])
BASE_SIGNS = (1.0, -1.0, 1.0, -1.0, 1.0, -1.0)
"""The mirror flips y, roll and yaw."""

LARGEST_MENDED = 0.5
"""Relative deviation from which a robot is rather mounted or labelled wrongly than badly symmetric."""

POSES = 5
"""Random poses at which a mirror is verified, besides the zero pose."""


@dataclass(frozen=True)
class SignedPermutation:
    """The map a -> sign * a[index], its own inverse."""

    index: NDArray[np.int64]
    sign: Vector

    def __call__(self, values: Any) -> Any:
        """Apply to a vector (n,) or to every column of a matrix (n, m); numpy in, numpy out, casadi in, casadi out."""
        if isinstance(values, (ca.SX, ca.MX, ca.DM)):
            return ca.mtimes(ca.DM(self.matrix), values) if isinstance(values, ca.MX) else self._scaled(values)
        array = np.asarray(values)
        return (self.sign * array[self.index].T).T

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The matrix S with S a = sign * a[index], (n, n)."""
        return np.diag(self.sign) @ np.eye(self.index.size)[self.index]

    def _scaled(self, values: Any) -> Any:
        return ca.vertcat(*(s * values[int(i), :] for s, i in zip(self.sign, self.index, strict=True)))


@dataclass(frozen=True)
class Mirror:
    """The left-right mirror image of a robot's motion.

    Attributes:
        coordinates: q and v -> mirrored q and v.
        joints: joint angles, rates and torques -> mirrored ones.
        forces: vectors at all feet in foot order (positions, velocities, forces), world axes -> mirrored ones.
        feet: foot label -> label of its twin.
        asymmetry: the largest relative deviation from exact symmetry that was found.
    """

    coordinates: SignedPermutation
    joints: SignedPermutation
    forces: SignedPermutation
    feet: Mapping[str, str]
    asymmetry: float

    def position(self, q: Any) -> Any:
        """Mirror coordinates q (or their rates), (n_q,)."""
        return self.coordinates(q)

    def state(self, x: Any) -> Any:
        """Mirror a state (q, v), (2 n_q,)."""
        n = self.coordinates.index.size
        parts = self.coordinates(x[:n]), self.coordinates(x[n:])
        return ca.vertcat(*parts) if isinstance(x, (ca.SX, ca.MX, ca.DM)) else np.concatenate(parts)

    def torque(self, u: Any) -> Any:
        """Mirror joint torques, (n_joints,)."""
        return self.joints(u)

    def force(self, f: Any) -> Any:
        """Mirror vectors at all feet in foot order, (3 n_feet,)."""
        return self.forces(f)


class AsymmetryError(InputError):
    """A robot is not as symmetric as its mirror needs.

    Attributes:
        asymmetry: the largest relative deviation.
        what: what deviates.
    """

    def __init__(self, robot: Robot, asymmetry: float, what: str) -> None:
        self.asymmetry, self.what = asymmetry, what
        remedy = (
            "symmetrize averages left and right: symmetrize = true in [robot], --symmetrize, or "
            "amble.symmetrized(robot)"
            if asymmetry < LARGEST_MENDED
            else "are the twins named right, and does the base have x forward and z up (base_rotation in [robot])?"
        )
        super().__init__(
            f"robot '{robot.name}' is not left-right symmetric: {what} deviates by {asymmetry:.2g} of its size, "
            f"the tolerance is {robot.symmetry_tolerance:.2g}; {remedy}"
        )


def find_mirror(robot: Robot) -> Mirror:
    """Find and verify the left-right mirror of a robot.

    Joints are paired along the legs of twin feet; a joint moves the other way where its axis, a pseudo-vector of one
    that turns, is the reverse of the mirrored axis of its twin at the zero pose. The result is then verified at random
    poses: mirrored foot positions, mass matrix and gravity forces agree within ``robot.symmetry_tolerance``, relative
    to the lengths and inertias of the robot.

    Raises:
        AsymmetryError: the robot is not symmetric.
        InputError: feet have no twins.
    """
    feet, partner = _twin_feet(robot), partners(robot)
    sign = np.array([_axis_sign(robot, j, partner[j]) for j in range(len(robot.joints))])
    index = np.array([partner[j] for j in range(len(robot.joints))])
    base = robot.base
    coordinates = SignedPermutation(
        np.concatenate([np.arange(base.size), base.size + index]),
        frozen([*(BASE_SIGNS[place] for place in base.places), *sign]),
    )
    order = [robot.foot_names.index(feet[name]) for name in robot.foot_names]
    forces = SignedPermutation(
        np.array([3 * i + k for i in order for k in range(3)]), frozen(np.tile(np.diag(REFLECTION), len(order)))
    )
    asymmetry, what = _asymmetry(robot, coordinates, feet)
    if not asymmetry <= robot.symmetry_tolerance:
        raise AsymmetryError(robot, asymmetry, what)
    return Mirror(coordinates, SignedPermutation(index, frozen(sign)), forces, feet, asymmetry)


def _twin_feet(robot: Robot) -> dict[str, str]:
    feet: dict[str, str] = {}
    for left, right in robot.twins:
        if left in feet or right in feet:
            raise InputError(f"robot '{robot.name}' pairs the foot '{left if left in feet else right}' twice")
        feet[left], feet[right] = right, left
    single = [name for name in robot.foot_names if name not in feet]
    if single or not feet:
        listing = ", ".join(single) or "none at all"
        raise InputError(f"robot '{robot.name}' has feet without a left-right twin ({listing}); name pairs in 'twins'")
    return {name: feet[name] for name in robot.foot_names}


def partners(robot: Robot) -> dict[int, int]:
    """Pair joints along the legs of twin feet, and the joints on no leg by where they are at the zero pose.

    Raises:
        InputError: where feet have no twins, joints do not pair, or no leg has a length to measure deviations by.
    """
    feet = _twin_feet(robot)
    if not robot.leg_length > 0.0:
        raise InputError(f"no leg of robot '{robot.name}' has a length: its feet are where the base is")
    partner: dict[int, int] = {}
    for name, twin in feet.items():
        own, other = (robot.chain(robot.foot(label).link) for label in (name, twin))
        if len(own) != len(other):
            raise InputError(f"robot '{robot.name}': leg '{name}' has {len(own)} joints, '{twin}' {len(other)}")
        for j, k in zip(own, other, strict=True):
            if robot.joints[j].prismatic != robot.joints[k].prismatic or partner.setdefault(j, k) != k:
                raise InputError(f"robot '{robot.name}': the legs of '{name}' and '{twin}' do not mirror each other")
    loose = [j for j in range(len(robot.joints)) if j not in partner]
    for j in loose:
        kin = [k for k in loose if robot.joints[k].prismatic == robot.joints[j].prismatic]
        partner[j] = min(kin, key=lambda k: _distance(robot, j, k))
    if sorted(partner.values()) != list(range(len(robot.joints))) or any(partner[k] != j for j, k in partner.items()):
        raise InputError(f"robot '{robot.name}': its joints do not form left-right pairs")
    return partner


def _distance(robot: Robot, j: int, k: int) -> float:
    """How far joint k is from the mirror image of joint j at the zero pose: distance of origins plus angle of axes."""
    (axis_j, origin_j), (axis_k, origin_k) = _at_zero(robot, j), _at_zero(robot, k)
    return float(np.linalg.norm(REFLECTION @ origin_j - origin_k) + 1.0 - abs(axis_k @ REFLECTION @ axis_j))


def _axis_sign(robot: Robot, j: int, k: int) -> float:
    (axis_j, _), (axis_k, _) = _at_zero(robot, j), _at_zero(robot, k)
    sense = 1.0 if robot.joints[j].prismatic else -1.0  # an axis of rotation is a pseudo-vector
    return 1.0 if axis_k @ (sense * REFLECTION @ axis_j) > 0.0 else -1.0


def _at_zero(robot: Robot, j: int) -> tuple[Vector, Vector]:
    """Axis and origin of a joint in the base at the zero pose."""
    rotation, origin = zero_poses(robot)[robot.joints[j].child]
    return rotation @ robot.joints[j].axis, origin


def _asymmetry(robot: Robot, mirrored: SignedPermutation, feet: Mapping[str, str]) -> tuple[float, str]:
    """Return the largest relative deviation from symmetry and what deviates."""
    generator = np.random.default_rng(0)
    worst = (0.0, "nothing")
    size = robot.leg_length  # deviations of positions are measured by it
    for pose in [np.zeros(robot.size), *generator.uniform(-1.0, 1.0, (POSES, robot.size))]:
        image = mirrored(pose)
        for name, twin in feet.items():
            expected = REFLECTION @ _array(foot_position(robot, name, pose))
            deviation = float(np.abs(_array(foot_position(robot, twin, image)) - expected).max())
            worst = max(worst, (deviation / size, f"the position of foot '{twin}'"))
        inertia, at_image = np.asarray(mass_matrix(robot, pose)), np.asarray(mass_matrix(robot, image))
        if not np.all(np.diag(inertia) > 0.0):
            raise InputError(f"robot '{robot.name}' has a mass matrix that is not positive definite")
        root = np.sqrt(np.diag(inertia))
        with np.errstate(over="ignore"):  # infinitely asymmetric
            apart = np.abs(mirrored.matrix.T @ at_image @ mirrored.matrix - inertia) / root / root[:, None]
        deviation = float(apart.max())
        worst = max(worst, (deviation, "the mass matrix"))
        weight = robot.mass * robot.gravity or 1.0
        height = abs(float(potential_energy(robot, image)) - float(potential_energy(robot, pose)))
        worst = max(worst, (height / weight / size, "the height of the centre of mass"))
    return worst


def _array(values: ca.DM) -> Vector:
    return np.asarray(values).ravel()
