"""A gait as a reference motion for learning: exported, loaded with MuJoCo, its kinematics compared body by body.

amble export gait.json --rate 200 --out reference.npz
python examples/mujoco_reference.py reference.npz robot.urdf
"""

from __future__ import annotations

import sys
from pathlib import Path

import mujoco
import numpy as np


def free_model(path: Path) -> mujoco.MjModel:
    """Load a robot's file and let its base move freely."""
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compiler.balanceinertia, spec.compiler.discardvisual = True, True
    spec.compiler.fusestatic = False
    base = spec.worldbody.first_body()
    if not base.joints:
        base.add_freejoint(name="base")
    return spec.compile()


def largest_difference(motion: dict[str, np.ndarray], model: mujoco.MjModel) -> tuple[float, float]:
    """Largest distance of a body from where the motion has it, m, and of its velocity from that of the states, m/s."""
    data, joints = mujoco.MjData(model), [str(name) for name in motion["joints"]]
    order = [model.joint(place).name for place in range(model.njnt) if model.jnt_type[place] == 3]
    if order != joints:
        raise SystemExit(f"the file's joints are {order}, the motion's {joints}")
    bodies = [model.body(str(name)).id for name in motion["bodies"]]
    apart = slip = 0.0
    for row in range(len(motion["time"])):
        data.qpos[:], data.qvel[:] = motion["qpos"][row], motion["qvel"][row]
        mujoco.mj_forward(model, data)
        apart = max(apart, float(np.abs(data.xpos[bodies] - motion["body_positions"][row]).max()))
        if (
            0 < row < len(motion["time"]) - 1
            and (motion["contacts"][row - 1 : row + 2] == motion["contacts"][row]).all()
        ):
            twist = np.zeros(6)
            for place, body in enumerate(bodies):
                mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, twist, 0)
                step = motion["body_positions"][row + 1, place] - motion["body_positions"][row - 1, place]
                slip = max(slip, float(np.abs(step * motion["rate"] / 2.0 - twist[3:]).max()))
    return apart, slip


def main(arguments: list[str]) -> None:
    """Compare and say how far the two are apart."""
    if len(arguments) != 2:
        print(__doc__)
        return
    with np.load(arguments[0]) as file:
        motion = dict(file)
    apart, slip = largest_difference(motion, free_model(Path(arguments[1])))
    print(f"bodies are at most {apart:.1e} m apart, velocities and differences of positions {slip:.1e} m/s")


if __name__ == "__main__":
    main(sys.argv[1:])
