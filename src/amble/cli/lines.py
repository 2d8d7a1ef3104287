"""One line or one entry about what a step found, the same in every command that takes the step."""

from __future__ import annotations

from typing import TYPE_CHECKING

from amble.cli.output import result, show

if TYPE_CHECKING:
    from amble.gait import Gait
    from amble.simulation import Trace
    from amble.stability import Certificate
    from amble.stability.stabilize import Stabilized


def show_synthesized(gait: Gait) -> None:
    """Say how a gait was found."""
    from dataclasses import asdict

    report = gait.solver
    systems = f" (linear systems: {report.linear_solver})" if report.linear_solver else ""
    show(
        f"{report.solver}{systems}: {report.status}, {report.iterations} iterations in {report.seconds:.2f} s "
        f"({report.variables} variables, {report.constraints} constraints), objective {report.objective:.6g} "
        f"{gait.cost.unit}"
    )
    result(solver=asdict(report))


def show_stabilized(found: Stabilized) -> None:
    """Say how a stabilisation went."""
    show(
        f"spectral radius of the full cycle {found.initial:.4g} -> {found.radius:.4g}, contraction bound "
        f"{found.bound:.4g}, in {len(found.steps) - 1} steps and {found.seconds:.1f} s ({found.parameters} free): "
        f"{found.reason}"
    )
    result(
        stabilization={
            "initial": found.initial,
            "radius": found.radius,
            "steps": len(found.steps) - 1,
            "seconds": found.seconds,
            "parameters": found.parameters,
            "bound": found.bound,
            "reason": found.reason,
        }
    )


def show_bounds(gait: Gait) -> None:
    """Say what a gait was held against, what of that is absurd, and what a certificate does not say."""
    from amble.stability.gait_certificate import bounds_sentences, does_not_say, held_against

    for sentence in bounds_sentences(gait):
        show(sentence)
    result(held_against=held_against(gait), does_not_say=list(does_not_say(gait)))


def show_certified(gait: Gait, certificate: Certificate) -> None:
    """Say what was certified, and what has to be known about it."""
    show(
        f"spectral radius of the full cycle {certificate.radius:.6f} (estimated error {certificate.error:.1e}), "
        f"fixed point to {certificate.residual:.1e}, period {certificate.period:.6f} s"
    )
    disturbance = certificate.disturbance
    if disturbance is not None:
        show(str(disturbance))
    show_bounds(gait)
    for warning in certificate.warnings:
        show(f"WARNING: {warning}")
    numbers = {"error": certificate.error, "residual": certificate.residual, "period_s": certificate.period}
    result(
        certificate={
            "spectral_radius": certificate.radius,
            **numbers,
            "disturbance": None if disturbance is None else disturbance.to_dict(),
            "warnings": list(certificate.warnings),
        }
    )


def show_simulated(trace: Trace) -> None:
    """Say how far a simulation came."""
    show(f"{trace.cycles} cycles, {trace.time[-1]:.3f} s of walking, simulated in {trace.seconds:.2f} s")
    result(
        simulation={
            "cycles": trace.cycles,
            "time_s": float(trace.time[-1]),
            "seconds": trace.seconds,
            "ended": trace.ended,
        }
    )


def show_switches(trace: Trace) -> None:
    """Say how often feet of a unilateral motion were released or touched out of their turn."""
    from amble.gait.unilateral_loop import RELEASED, TOUCHED

    entered = [event.transition.partition("->")[2].split() for event in trace.events]
    counts = {what: sum(words[-1] == what for words in entered) for what in (RELEASED, TOUCHED)}
    show(f"feet that would have pulled were released {counts[RELEASED]} times, others touched {counts[TOUCHED]} times")
    result(contact=counts)
