"""The exported controller of a gait that turns: it keeps the heading that earlier cycles led to."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from amble.codegen import compiler
from amble.export import export_controller, exported_loop
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.simulation import simulate

GAIT = Path(__file__).parents[1] / "data" / "turning-trot.json"

pytestmark = [pytest.mark.slow, pytest.mark.skipif(compiler() is None, reason="there is no C compiler")]


@pytest.fixture(scope="module")
def gait() -> Gait:
    """Stabilised: forward 0.2 m/s, to the left 0.05 m/s, 0.5 rad/s."""
    return load_gait(GAIT)


def test_the_exported_c_walks_it(gait: Gait) -> None:
    there, own = simulate(gait, cycles=2, loop=exported_loop), simulate(gait, cycles=2)
    assert there.completed
    np.testing.assert_allclose(there.section, own.section, atol=1e-8)


HARNESS = """
#include "amble_controller.h"
#include <stdio.h>
int main(void) {
  amble_controller c;
  double t, q[AMBLE_COORDINATES], qd[AMBLE_COORDINATES], u[AMBLE_JOINTS], force[AMBLE_FORCES];
  int i, flag;
  unsigned char contact[AMBLE_FEET];
  amble_enter(&c, 0, 0.0);
  while (scanf("%lf", &t) == 1) {
    for (i = 0; i < AMBLE_COORDINATES; i++) if (scanf("%lf", q + i) != 1) return 1;
    for (i = 0; i < AMBLE_COORDINATES; i++) if (scanf("%lf", qd + i) != 1) return 1;
    for (i = 0; i < AMBLE_FEET; i++) { if (scanf("%d", &flag) != 1) return 1; contact[i] = (unsigned char)flag; }
    printf("%u", amble_step(&c, t, q, qd, contact, u, force));
    for (i = 0; i < AMBLE_JOINTS; i++) printf(" %.17g", u[i]);
    for (i = 0; i < AMBLE_FORCES; i++) printf(" %.17g", force[i]);
    printf("\\n");
  }
  return 0;
}
"""


def test_the_exported_c_follows_the_heading_by_itself(
    gait: Gait, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Fed with the world's states of 25 cycles, yaw within +-pi, it answers the trace's torques and forces."""
    exported = export_controller(gait, None, tmp_path / "controller")
    assert "by the landing rule 'simultaneous' the feet of D1->D2, D2->D1 stop at one instant" in caplog.text
    (exported.folder / "harness.c").write_text(HARNESS)
    tool = compiler()
    assert tool is not None
    names = [path.name for path in exported.sources]
    strict = [tool.path, "-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "harness.c", *names, "-lm", "-o", "harness"]
    subprocess.run(strict, cwd=exported.folder, check=True)
    trace = simulate(gait, cycles=25, samples=4)
    assert abs(trace.state[:, 5]).max() > np.pi
    feet = gait.robot.foot_names
    state = trace.state.copy()
    state[:, 5] = np.arctan2(np.sin(state[:, 5]), np.cos(state[:, 5]))
    last = np.diff(trace.domain, append=0) != 0  # the state before an impact, at whose time the next stance begins
    lines = []
    for row in np.flatnonzero(~last):
        down = [int(foot in gait.pattern.stances[trace.domain[row]].feet) for foot in feet]
        numbers = [*map(repr, map(float, (trace.time[row], *state[row]))), *down]
        lines.append(" ".join(str(number) for number in numbers))
    done = subprocess.run(
        ["./harness"], cwd=exported.folder, input="\n".join(lines), capture_output=True, text=True, check=True
    )
    answers = np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])
    assert len(answers) == len(lines)
    torque, force = trace.signals["torque"][~last], trace.signals["force"][~last]
    joints = len(gait.robot.joints)
    np.testing.assert_allclose(answers[:, 1 : 1 + joints], torque, atol=1e-7 * np.abs(torque).max())
    np.testing.assert_allclose(answers[:, 1 + joints :], force, atol=1e-7 * np.abs(force).max())
