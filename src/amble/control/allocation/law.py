"""What an allocation law is: the choice among all torques that realise the same motion (theory.md, section 2)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class Redundancy:
    """All torques that realise the motion at one state: u(s) = torques + null @ s, forces(s) = forces + squeeze @ s.

    Attributes:
        torques: the minimum-norm torques, (n_joints,), N m.
        null: basis of the torques that cause no acceleration, (n_joints, k), N m.
        forces: contact forces that go with ``torques``, world frame, (3 n_c,), N.
        squeeze: internal contact forces that go with ``null``, (3 n_c, k), N.
        speeds: joint velocities, (n_joints,), rad/s.
    """

    torques: ca.SX
    null: ca.SX
    forces: ca.SX
    squeeze: ca.SX
    speeds: ca.SX

    @property
    def size(self) -> int:
        """Number k of free directions: 0, 1, 3, 6 for 1, 2, 3, 4 point feet."""
        return int(self.null.shape[1])


class AllocationLaw(ABC):
    """One rule, used three ways: rows of the gait problem, closed form in the controller, entry of a comparison."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Short name, as used in files and on the command line."""

    @abstractmethod
    def rows(self, torques: ca.SX, null: ca.SX) -> ca.SX:
        """Return k expressions that vanish exactly where ``torques`` obey the law; they close the gait problem."""

    @abstractmethod
    def choose(self, redundancy: Redundancy) -> ca.SX:
        """Return s, (k,): the closed form of the law in the controller."""
