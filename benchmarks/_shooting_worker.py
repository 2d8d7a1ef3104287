"""A cycle of a gait by crocoddyl, in an environment of its own: a task on standard input, what came of it on output.

Differential dynamic programming over a fixed sequence of contacts with fixed durations: Euler steps between the rows
of a reference, point contacts, impulses where feet land. The cost is the squared torques (``TORQUE``), small weights
on the reference's states, penalties outside the friction cone, swing feet that are to follow the reference's.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import crocoddyl
import numpy as np
import pinocchio

STATE, TORQUE, CONE, SWING, END = 1e-2, 1e-3, 1e1, 1e4, 1e4
"""Weights."""

STIFF = np.array([0.0, 50.0])
"""Baumgarte gains of contacts, which hold a foot's place."""


class Cycle:
    """The problem of one cycle."""

    def __init__(self, task: dict[str, Any]) -> None:
        self.task, self.step = task, 1.0 / task["rate"]
        self.model = pinocchio.buildModelFromUrdf(task["urdf"], pinocchio.JointModelFreeFlyer())
        self.feet = [self.model.getFrameId(frame, pinocchio.FrameType.BODY) for frame in task["feet"]]
        self.state = crocoddyl.StateMultibody(self.model)
        self.actuation = crocoddyl.ActuationModelFloatingBase(self.state)
        self.states = [self._state(q, v) for q, v in zip(task["qpos"], task["qvel"], strict=True)]

    def _state(self, qpos: list[float], qvel: list[float]) -> Any:
        """From place, quaternion (w, x, y, z), joints to pinocchio's order; velocities of the base in its own axes."""
        joints = [self.model.joints[self.model.getJointId(name)].idx_q - 7 for name in self.task["joints"]]
        w, x, y, z = qpos[3:7]
        turn = pinocchio.Quaternion(w, x, y, z).toRotationMatrix()
        q, v = np.zeros(self.model.nq), np.zeros(self.model.nv)
        q[:7], v[:3], v[3:6] = [*qpos[:3], x, y, z, w], turn.T @ np.array(qvel[:3]), qvel[3:6]
        q[7:][joints], v[6:][joints] = qpos[7:], qvel[6:]
        return np.concatenate([q, v])

    def places(self, row: int) -> list[Any]:
        """Places of all feet at a row of the reference."""
        data = self.model.createData()
        pinocchio.framesForwardKinematics(self.model, data, self.states[row][: self.model.nq])
        return [data.oMf[frame].translation.copy() for frame in self.feet]

    def node(self, row: int) -> Any:
        """One step on the feet of a row."""
        nu, costs = self.actuation.nu, crocoddyl.CostModelSum(self.state, self.actuation.nu)
        contacts = crocoddyl.ContactModelMultiple(self.state, nu)
        ahead = self.places(min(row + 1, len(self.states) - 1))
        cone = crocoddyl.FrictionCone(np.eye(3), self.task["friction"], 4, False)
        bounds = crocoddyl.ActivationModelQuadraticBarrier(crocoddyl.ActivationBounds(cone.lb, cone.ub))
        for number, (frame, down) in enumerate(zip(self.feet, self.task["contacts"][row], strict=True)):
            if down:
                contact = crocoddyl.ContactModel3D(
                    self.state, frame, np.zeros(3), pinocchio.LOCAL_WORLD_ALIGNED, nu, STIFF
                )
                contacts.addContact(f"foot {number}", contact)
                force = crocoddyl.ResidualModelContactFrictionCone(self.state, frame, cone, nu, True)
                costs.addCost(f"cone {number}", crocoddyl.CostModelResidual(self.state, bounds, force), CONE)
            else:
                place = crocoddyl.ResidualModelFrameTranslation(self.state, frame, ahead[number], nu)
                costs.addCost(f"swing {number}", crocoddyl.CostModelResidual(self.state, place), SWING)
        near = crocoddyl.ResidualModelState(self.state, self.states[row], nu)
        costs.addCost("state", crocoddyl.CostModelResidual(self.state, near), STATE)
        torque = crocoddyl.ResidualModelControl(self.state, nu)
        costs.addCost("torque", crocoddyl.CostModelResidual(self.state, torque), TORQUE)
        dynamics = crocoddyl.DifferentialActionModelContactFwdDynamics(
            self.state, self.actuation, contacts, costs, 0.0, True
        )
        return crocoddyl.IntegratedActionModelEuler(dynamics, self.step)

    def landing(self, row: int, landed: list[int]) -> Any:
        """The impact on the feet of a row."""
        impulses = crocoddyl.ImpulseModelMultiple(self.state)
        for number, (frame, down) in enumerate(zip(self.feet, self.task["contacts"][row], strict=True)):
            if down:
                impulse = crocoddyl.ImpulseModel3D(self.state, frame, pinocchio.LOCAL_WORLD_ALIGNED)
                impulses.addImpulse(f"foot {number}", impulse)
        costs = crocoddyl.CostModelSum(self.state, 0)
        for number in landed:
            place = crocoddyl.ResidualModelFrameTranslation(self.state, self.feet[number], self.places(row)[number], 0)
            costs.addCost(f"landed {number}", crocoddyl.CostModelResidual(self.state, place), SWING)
        return crocoddyl.ActionModelImpulseFwdDynamics(self.state, impulses, costs, 0.0, 0.0, True)

    def problem(self) -> Any:
        """The whole cycle; its last state is to be the first one, further on."""
        flags, running = self.task["contacts"], []
        for row in range(len(self.states) - 1):
            landed = [k for k, down in enumerate(flags[row]) if row and down and not flags[row - 1][k]]
            running += [self.landing(row, landed)] if landed else []
            running.append(self.node(row))
        costs = crocoddyl.CostModelSum(self.state, self.actuation.nu)
        end = crocoddyl.ResidualModelState(self.state, self.states[-1], self.actuation.nu)
        costs.addCost("end", crocoddyl.CostModelResidual(self.state, end), END)
        contacts = crocoddyl.ContactModelMultiple(self.state, self.actuation.nu)
        last = crocoddyl.DifferentialActionModelContactFwdDynamics(
            self.state, self.actuation, contacts, costs, 0.0, True
        )
        return crocoddyl.ShootingProblem(self.states[0], running, crocoddyl.IntegratedActionModelEuler(last, 0.0))

    def answer(self) -> dict[str, Any]:
        """Solve from a robot that keeps its first posture, and say what the solution is."""
        began = time.process_time()
        problem = self.problem()
        built, solver = time.process_time() - began, crocoddyl.SolverFDDP(problem)
        start = [self.states[0]] * (problem.T + 1)
        quasi = problem.quasiStatic(start[:-1])
        began = time.process_time()
        solved = solver.solve(start, quasi, self.task["iterations"], False)
        spent = time.process_time() - began
        torques = np.array([u for u in solver.us if u.size])
        return {
            "solved": bool(solved),
            "iterations": int(solver.iter),
            "nodes": int(problem.T),
            "build_s": built,
            "solve_s": spent,
            "rms_torque": float(np.sqrt(np.mean(torques**2))),
            "peak_torque": float(np.abs(torques).max()),
            "end_error": float(np.abs(self.state.diff(self.states[-1], solver.xs[-1])).max()),
            **self._forces(solver),
        }

    def _forces(self, solver: Any) -> dict[str, Any]:
        """Least normal force, and the largest share of it that friction carries, of feet that press."""
        normal, share = [], []
        for data in solver.problem.runningDatas:
            if not hasattr(data, "differential"):
                continue
            for contact in data.differential.multibody.contacts.contacts.todict().values():
                force = contact.f.linear
                normal.append(force[2])
                share.append(np.hypot(force[0], force[1]) / max(force[2], 1.0))
        return {"least_normal": float(min(normal)), "most_friction": float(max(share))}


if __name__ == "__main__":
    print(json.dumps(Cycle(json.load(sys.stdin)).answer()))
