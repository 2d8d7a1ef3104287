"""Draw allocation.png: the line of torques at one instant of the amble, and the torques of one stance under the laws.

Run from the folder of the project: python docs/theory/allocation_figure.py
"""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np

from amble.analysis import samples_of_gait, with_laws
from amble.control import (
    AllocationLaw,
    BoundedMinimumNorm,
    MinimumPeak,
    MinimumPower,
    PseudoInverse,
    Redundancy,
)
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.report.figures.style import LAW_COLOURS, LAW_STYLES, PAGE, panels, paper_style

FRICTION = 0.45
"""Less than the pseudo-inverse uses on this gait, so that the bounded law has something to do."""

NODE = 1
LAWS: dict[str, AllocationLaw] = {
    "pinv": PseudoInverse(),
    "power (datasheet)": MinimumPower("datasheet"),
    "peak": MinimumPeak(),
    f"bounded, friction {FRICTION}": BoundedMinimumNorm(FRICTION, 5.0),
}


def instant(gait: Gait, node: int) -> Redundancy:
    """All torques of one node of the first domain, as numbers."""
    part, contacts = gait.domains[0], gait.pattern.contacts(gait.pattern.solved[0])
    q, v = ca.SX(ca.DM(part.positions[node])), ca.SX(ca.DM(part.velocities[node]))
    null, squeeze = (ca.sparsify(basis) for basis in contacts.torque_null_space(q))
    u, forces = ca.SX(ca.DM(part.torques[node])), ca.SX(ca.DM(part.forces[node]))
    back = -ca.dot(null, u) / ca.dot(null, null)
    least = u + null * back, forces + squeeze * back
    return Redundancy.at(contacts, (q, v), least, (null, squeeze))


def main() -> None:
    """Write allocation.png beside this file."""
    gait = load_gait(Path(__file__).parents[2] / "tests" / "data" / "stabilised-amble.json")
    redundancy = instant(gait, NODE)
    u, n = (np.asarray(ca.DM(part)).ravel() for part in (redundancy.torques, redundancy.torque_basis))
    s = np.linspace(-80.0, 80.0, 401)
    with paper_style():
        figure, (line, time) = panels(1, 2, PAGE, 2.9)
        _draw_line(line, gait, redundancy, u, n, s)
        samples = samples_of_gait(gait)
        stance = samples.segments == 0
        joint = gait.robot.joint_index("fr_knee")
        for number, (label, torques) in enumerate(with_laws(samples, LAWS).torques.items()):
            time.plot(
                samples.times[stance],
                torques[stance, joint],
                color=LAW_COLOURS[number],
                linestyle=LAW_STYLES[number],
                label=label,
            )
        time.set_xlabel("time (s)")
        time.set_title("torque of the fr knee in the first stance (N m)")
        handles, labels = time.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
        figure.savefig(Path(__file__).with_name("allocation.png"), dpi=110, metadata={"Software": None})


def _draw_line(axes: object, gait: Gait, redundancy: Redundancy, u: np.ndarray, n: np.ndarray, s: np.ndarray) -> None:
    """Draw |u_j + n_j s| of the stance legs, where friction allows, and where each law stands."""
    from matplotlib.axes import Axes

    if not isinstance(axes, Axes):
        raise TypeError("one panel was asked for")
    forces, squeeze = (np.asarray(ca.DM(part)).ravel() for part in (redundancy.forces, redundancy.force_basis))
    for joint in np.flatnonzero(n):
        axes.plot(s, np.abs(u[joint] + n[joint] * s), color="#7F7F7F", linewidth=0.7)
    total = forces[:, None] + squeeze[:, None] * s
    used = np.maximum(np.hypot(total[0], total[1]) / total[2], np.hypot(total[3], total[4]) / total[5])
    inside = s[used <= FRICTION]
    axes.axvspan(inside[0], inside[-1], color="#E0E0E0", zorder=0)
    for number, law in enumerate(LAWS.values()):
        at = float(ca.DM(law.allocate(redundancy)))
        axes.axvline(at, color=LAW_COLOURS[number], linestyle=LAW_STYLES[number])
    axes.set_xlabel("s (N of squeeze per m between the feet)")
    axes.set_title(f"|u(s)| of the stance legs (N m); grey: friction {FRICTION}")
    axes.set_ylim(0.0, gait.robot.joints[0].effort)


if __name__ == "__main__":
    main()
