"""crocoddyl on a cycle of the paper's gait, in an environment of its own, beside the gait problem in the same run.

It solves another problem: states and torques over a sequence of contacts with given durations and given paths of the
swing feet, from a given state to a given state. Durations, footholds, periodicity and the way there are what the gait
problem finds; limits of torques, forces, clearances and speeds are rows there and penalties, or nothing, here.
"""

from __future__ import annotations

import json
import subprocess
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from amble.analysis.reference import reference_motion
from amble.gait import Gait
from benchmarks.figures import Figure, show
from benchmarks.gaits import walking_gait

PYTHON = Path("build/crocoddyl/bin/python")
"""Of the environment (`make bench` makes it)."""

RATE, ITERATIONS = 200.0, 500


def task(gait: Gait) -> dict[str, Any]:
    """Lay out a cycle of a gait for the worker: its states at a steady rate, and the first one further on."""
    motion = reference_motion(gait, RATE, cycles=2)
    count = int(np.ceil(gait.period * RATE)) + 1
    return {
        "urdf": str(resources.files("amble.robot.catalogue") / f"{gait.robot.name}.urdf"),
        "feet": [foot.frame for foot in gait.robot.feet],
        "joints": list(motion.joints),
        "qpos": motion.qpos[:count].tolist(),
        "qvel": motion.qvel[:count].tolist(),
        "contacts": motion.contacts[:count].tolist(),
        "friction": gait.pattern.ground.friction,
        "rate": RATE,
        "iterations": ITERATIONS,
    }


def measure() -> list[Figure]:
    """Solve the cycle by crocoddyl, and the gait problem cold and with its structure known."""
    gait = walking_gait()
    if not PYTHON.exists():
        print(f"no crocoddyl: {PYTHON} is not there")
        return []
    ran = subprocess.run(
        [PYTHON, Path(__file__).with_name("_shooting_worker.py")],
        input=json.dumps(task(gait)), capture_output=True, text=True, check=False,
    )  # fmt: skip
    if ran.returncode:
        print(f"crocoddyl failed: {ran.stderr.strip().splitlines()[-1:]}")
        return []
    return figures(json.loads(ran.stdout.splitlines()[-1]), gait)


def figures(found: dict[str, Any], gait: Gait) -> list[Figure]:
    """Say what the worker answered, beside the gait's own numbers."""
    torques = np.concatenate([domain.torques for domain in gait.domains])
    peak = float(np.abs(torques).max())
    how = f"{found['iterations']} iterations, {'solved' if found['solved'] else 'not solved'}"
    return [
        Figure("crocoddyl, build", found["build_s"], "s", note=f"{found['nodes']} nodes, processor time"),
        Figure("crocoddyl, solve from the first posture", found["solve_s"], "s", note=how),
        Figure("crocoddyl, peak torque", found["peak_torque"], "N m", note=f"the gait's: {peak:.3g}"),
        Figure("crocoddyl, last state from the one that was asked for", found["end_error"], "", note="m, rad, m/s"),
        Figure("crocoddyl, least normal force", found["least_normal"], "N", note="the gait's bound: 5"),
        Figure("crocoddyl, largest friction used", found["most_friction"], "", note="0.6 is there"),
    ]


def main() -> None:
    """Print what is measured."""
    show(measure())


if __name__ == "__main__":
    main()
