"""Pinocchio as an independent oracle, in amble's coordinates and joint order."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pinocchio as pin

from amble.robot import Robot
from amble.types import Matrix, Vector
from tests import robots


class Oracle:
    """The same URDF file read by Pinocchio; the base is the composite joint x, y, z, roll, pitch, yaw.

    The planar biped's own file has the joints of its base.

    Pinocchio sorts joints its own way, so every vector and matrix is permuted to the robot's own order.
    """

    def __init__(self, robot: Robot, path: str) -> None:
        self.robot = robot
        if robot.base.in_space:
            base = pin.JointModelComposite()
            for joint in ("PX", "PY", "PZ", "RX", "RY", "RZ"):
                base.addJoint(getattr(pin, f"JointModel{joint}")())
            self.model = pin.buildModelFromUrdf(path, base)
        else:
            self.model = pin.buildModelFromUrdf(path)
        self.model.gravity.linear = np.array([0.0, 0.0, -robot.gravity])
        self.data = self.model.createData()
        moving = [self.model.joints[self.model.getJointId(name)].idx_v for name in robot.joint_names]
        self.order = np.array([*range(robot.base.size), *moving])
        self.frames = [self.model.getFrameId(foot.frame, pin.FrameType.BODY) for foot in robot.feet]

    def theirs(self, values: Vector) -> Vector:
        """From amble's order to Pinocchio's."""
        result = np.empty(values.size)
        result[self.order] = values
        return result

    def mass_matrix(self, q: Vector) -> Matrix:
        """D, (n_q, n_q)."""
        half = np.triu(pin.crba(self.model, self.data, self.theirs(q)))
        return (half + np.triu(half, 1).T)[np.ix_(self.order, self.order)]

    def bias(self, q: Vector, v: Vector) -> Vector:
        """h, (n_q,)."""
        return pin.nonLinearEffects(self.model, self.data, self.theirs(q), self.theirs(v))[self.order]

    def inverse_dynamics(self, q: Vector, v: Vector, a: Vector) -> Vector:
        """D a + h, (n_q,)."""
        return pin.rnea(self.model, self.data, self.theirs(q), self.theirs(v), self.theirs(a))[self.order]

    def positions(self, q: Vector) -> Matrix:
        """World positions of the feet in foot order, (n_feet, 3)."""
        pin.framesForwardKinematics(self.model, self.data, self.theirs(q))
        return np.array([self.data.oMf[frame].translation for frame in self.frames])

    def jacobian(self, q: Vector) -> Matrix:
        """J of all feet in foot order, world axes, (3 n_feet, n_q)."""
        pin.computeJointJacobians(self.model, self.data, self.theirs(q))
        pin.updateFramePlacements(self.model, self.data)
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        blocks = [pin.getFrameJacobian(self.model, self.data, frame, aligned)[:3] for frame in self.frames]
        return np.vstack(blocks)[:, self.order]

    def jacobian_bias(self, q: Vector, v: Vector) -> Vector:
        """(dJ/dt) v of all feet in foot order, world axes, (3 n_feet,)."""
        still = np.zeros(self.robot.size)
        pin.forwardKinematics(self.model, self.data, self.theirs(q), self.theirs(v), still)
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        parts = [pin.getFrameClassicalAcceleration(self.model, self.data, f, aligned).linear for f in self.frames]
        return np.concatenate(parts)

    def kinetic_energy(self, q: Vector, v: Vector) -> float:
        """Kinetic energy, J."""
        return float(pin.computeKineticEnergy(self.model, self.data, self.theirs(q), self.theirs(v)))

    def potential_energy(self, q: Vector) -> float:
        """Potential energy above z = 0, J."""
        return float(pin.computePotentialEnergy(self.model, self.data, self.theirs(q)))

    def center_of_mass(self, q: Vector) -> Vector:
        """World position of the centre of mass, (3,)."""
        return np.array(pin.centerOfMass(self.model, self.data, self.theirs(q)))

    def momentum(self, q: Vector, v: Vector) -> Vector:
        """Linear momentum, then angular momentum about the world origin, (6,)."""
        about_center = pin.computeCentroidalMomentum(self.model, self.data, self.theirs(q), self.theirs(v))
        shift = np.cross(self.data.com[0], about_center.linear)
        return np.concatenate([about_center.linear, about_center.angular + shift])


@lru_cache(maxsize=16)
def oracle(name: str) -> Oracle:
    """The oracle of a robot of ``tests.robots``."""
    return Oracle(robots.robot(name), str(robots.path(name)))
