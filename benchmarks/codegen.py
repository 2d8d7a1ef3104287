"""Compiling generated C in parts against in one piece, and running it against casadi's interpreter."""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path

import casadi as ca
import numpy as np

from amble.codegen import compiler
from amble.codegen.parts import cut_into_parts
from amble.robot import catalogue, dynamics
from amble.robot.model import Robot

CALLS = 300


def main() -> None:
    """Print compile time and median time per call for the Jacobian of ASTRo's inverse dynamics."""
    tool = compiler()
    if tool is None:
        print("no C compiler: nothing to compare")
        return
    function = inverse_dynamics(catalogue.astro()).jacobian()
    print(f"{function.n_instructions()} instructions")
    print(f"{'':12} {'compile (s)':>12} {'call (us)':>10}")
    print(f"{'interpreted':12} {'-':>12} {call(function):10.1f}")
    generator = ca.CodeGenerator("code.c", {"with_header": False})
    generator.add(function)
    whole = str(generator.dump())
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("one piece", whole), ("in parts", cut_into_parts(whole, [function]))):
            source, library = Path(folder, f"{len(name)}.c"), Path(folder, f"{len(name)}.so")
            source.write_text(text)
            began = time.perf_counter()
            tool.build(source, library)
            seconds = time.perf_counter() - began
            print(f"{name:12} {seconds:12.2f} {call(ca.external(function.name(), str(library))):10.1f}")


def inverse_dynamics(robot: Robot) -> ca.Function:
    """Return (q, v, a) -> D a + h."""
    q, v, a = (ca.SX.sym(name, robot.size) for name in "qva")
    forces = dynamics.mass_matrix(robot, q) @ a + dynamics.bias(robot, q, v)
    return ca.Function("inverse_dynamics", [q, v, a], [forces], ["q", "v", "a"], ["forces"])


def call(function: ca.Function) -> float:
    """Return the median time of a call, microseconds, through preallocated buffers."""
    buffer, evaluate = function.buffer()
    random = np.random.default_rng(0)
    inputs = [random.normal(size=function.nnz_in(i)) for i in range(function.n_in())]
    outputs = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
    for place, array in enumerate(inputs):
        if array.size:
            buffer.set_arg(place, array.data)
    for place, array in enumerate(outputs):
        if array.size:
            buffer.set_res(place, array.data)
    times = []
    for _ in range(CALLS):
        began = time.perf_counter()
        evaluate()
        times.append(time.perf_counter() - began)
    return 1e6 * statistics.median(times)


if __name__ == "__main__":
    main()
