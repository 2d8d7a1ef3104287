"""500 cycles of the closed loop at tolerance 1e-8, against MuJoCo stepping the same robot at 1 kHz."""

from __future__ import annotations

from amble.gait.closed_loop import closed_loop, start_state
from amble.simulation import simulate
from benchmarks.figures import Figure, show, timed
from benchmarks.gaits import walking_gait
from benchmarks.mujoco_model import model_of

CYCLES = 500
TOLERANCE = 1e-8


def measure() -> list[Figure]:
    """Measure both."""
    gait = walking_gait()
    system, start = closed_loop(gait), start_state(gait)
    simulate(system, start, 1, TOLERANCE)  # fills the compile cache
    seconds, trace = timed(lambda: simulate(system, start, CYCLES, TOLERANCE))
    simulated = CYCLES * gait.period
    theirs, _ = timed(lambda: _mujoco(simulated))
    return [
        Figure(
            "500 cycles at 1e-8", seconds, "s", most=5.0, runs=3, note=f"{simulated:.1f} s simulated, {trace.ended}"
        ),
        Figure(
            "MuJoCo, the same simulated time at 1 kHz",
            theirs,
            "s",
            runs=3,
            note="one call, four point feet on a plane, joints held by servos",
        ),
        Figure("MuJoCo over ours", theirs / seconds, "times", least=1.0),
    ]


def _mujoco(simulated: float) -> None:
    """Step the same robot, standing on its feet; building its model takes some milliseconds of it."""
    import mujoco

    gait = walking_gait()
    model = mujoco.MjModel.from_xml_string(model_of(gait.robot))
    model.opt.timestep = 1e-3
    data = mujoco.MjData(model)
    pose = gait.domains[0].positions[0]
    data.qpos[2] = pose[2]
    data.qpos[7:] = pose[6:]
    data.ctrl[:] = pose[6:]
    mujoco.mj_step(model, data, nstep=round(simulated / 1e-3))


def main() -> None:
    """Print what is measured."""
    show(measure())


if __name__ == "__main__":
    main()
