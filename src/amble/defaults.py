"""Choices that the library and the command line share: plain values, so that ``amble --help`` imports nothing else."""

from __future__ import annotations

from typing import Literal, get_args

Method = Literal["bilinear"]
"""What may choose the weights of a stabilisation: the paper's bilinear matrix inequalities."""

METHODS: tuple[Method, ...] = get_args(Method)

METHOD: Method = "bilinear"
"""What chooses them where nothing is said."""

FREE = ("roll", "pitch", "yaw")
"""Coordinates whose weights a stabilisation may choose."""

TOLERANCE = 1e-8
"""Relative and absolute tolerance of a simulation."""

CYCLES, REPRODUCED_CYCLES = 20, 500
"""Gait cycles of a simulation, and of the one that reproduces the paper."""

SHOWN_CYCLES = 10
"""The most gait cycles of a replay."""

GRID = 4
"""Points that a check looks at in every spacing of a gait's nodes."""

ENGINE = "native"
"""What moves the system in a simulation."""

Order = Literal["mujoco", "file"]
"""Order of joints and bodies: depth first from the base, as MuJoCo has them, or that of the robot's file."""

ORDERS: tuple[Order, ...] = get_args(Order)

CERTIFICATE = "certificate.json"
"""File of a certificate, or of why there is none."""
