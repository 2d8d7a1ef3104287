"""The closed loop that runs the exported C: rigid-body dynamics in casadi, torques from the compiled controller."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca

from amble.codegen import compiler
from amble.codegen.cache import content_key, kept, writable_folder
from amble.codegen.compiler import Compiler
from amble.control import AllocationLaw
from amble.control.landing import compiled_plant
from amble.control.stance_functions import ARGUMENTS
from amble.errors import WorkError
from amble.export.code import filled, template
from amble.export.controller import export_state_controller
from amble.export.stances import exported_stances
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.hybrid import Domain, GaitPattern, HybridSystem
from amble.io.storage import workplace
from amble.names import identifier

FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", "-fPIC", "-shared")


def exported_loop(gait: Gait, law: AllocationLaw | None = None) -> HybridSystem:
    """Close the loop of a gait through the exported controller, for simulation.

    Every torque is what ``amble_step`` answers for the state, the clock of the domain, and the domain's own feet on the
    ground: mirror, saturation and fallback included. Guards and resets are those of ``closed_loop``.

    Args:
        gait: the gait; with feedback its stabilised outputs are used.
        law: another allocation law than the gait's.

    Raises:
        WorkError: where there is no C compiler, or it fails.
    """
    tool = compiler()
    if tool is None:
        raise WorkError("the exported controller needs a C compiler; none was found")
    library = _library(gait, law, tool)
    system, stances = closed_loop(gait, law), exported_stances(gait)
    domains = []
    for number, entry in enumerate(stances):
        original = next(other.stance for other in stances if other.law == entry.law and not other.mirrored)
        moved = compiled_plant(gait.pattern.contacts(original))
        if entry.mirrored:
            moved = _mirrored(gait.pattern, moved)
        controller = ca.external(f"stance_{number}", str(library))
        domains.append(_domain(system.domain(entry.stance.name), controller, moved))
    return HybridSystem(tuple(domains), system.transitions, system.symmetries, system.state_names)


def _mirrored(pattern: GaitPattern, moved: ca.Function) -> ca.Function:
    """The mirror image of a plant: mirror the arguments, evaluate the same code, mirror the results."""
    robot = pattern.robot
    x, u = ca.MX.sym("x", moved.numel_in(0)), ca.MX.sym("u", moved.numel_in(1))
    rate, force = moved(robot.mirror.state(x), robot.mirror.torque(u))
    results = [robot.mirror.state(rate), pattern.all_contacts.mirror(force)]
    return ca.Function("mirrored_plant", [x, u], results, ["x", "u"], ["rate", "force"])


def _domain(domain: Domain, controller: ca.Function, moved: ca.Function) -> Domain:
    """Return a domain whose torques come from the library."""
    t, x, p = (ca.MX.sym(name, domain.field.numel_in(i)) for i, name in enumerate(ARGUMENTS))
    torque = controller(t, x)
    rate, force = moved(x, torque)
    field = ca.Function(f"exported_{identifier(domain.name)}", [t, x, p], [rate], ARGUMENTS, ["rate"])
    if domain.signals is None:
        return replace(domain, field=field, jacobian=None)
    recorded = dict(zip(domain.signals.name_out(), domain.signals(t, x, p), strict=True))
    recorded.update(torque=torque, force=force)
    signals = ca.Function("signals", [t, x, p], list(recorded.values()), ARGUMENTS, list(recorded))
    return replace(domain, field=field, jacobian=None, signals=signals)


def _library(gait: Gait, law: AllocationLaw | None, tool: Compiler) -> Path:
    """Export, compile with an interface for casadi, and keep by content."""
    folder = writable_folder()
    with workplace(folder) as work:
        exported = export_state_controller(gait, law, work / "controller")
        source = exported.folder / "casadi_interface.c"
        source.write_text(_interface(len(gait.pattern.visited)), encoding="utf-8")
        texts = [
            path.read_text(encoding="utf-8")
            for path in (source, *exported.sources, exported.folder / "amble_controller.h")
        ]
        key = content_key([*texts, tool.path, tool.version, *FLAGS])
        flags = (*FLAGS, *(str(path) for path in exported.sources))
        return kept(folder / f"controller-{key}.so", lambda output: tool.build(source, output, flags))


def _interface(stances: int) -> str:
    """C functions stance_0, stance_1, ... (clock, x) -> u that casadi can load."""
    head, body = template("casadi_interface.c").split("/* one stance */\n")
    return head + "".join(filled(body, {"NUMBER": str(number)}) for number in range(stances))
