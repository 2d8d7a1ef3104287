"""One line or one entry about what a step found, the same in every command that takes the step."""

from __future__ import annotations

from typing import TYPE_CHECKING

from amble.cli.output import result, show

if TYPE_CHECKING:
    from amble.gait import Gait
    from amble.simulation import Trace
    from amble.stability import Certificate
    from amble.stability.stabilize import Stabilized


def tell_synthesized(gait: Gait) -> None:
    """Say how a gait was found."""
    from dataclasses import asdict

    report = gait.solver
    show(
        f"{report.solver}: {report.status}, {report.iterations} iterations in {report.seconds:.2f} s "
        f"({report.variables} variables, {report.constraints} constraints), objective {report.objective:.6g} "
        f"{gait.cost.unit}"
    )
    result(solver=asdict(report))


def tell_stabilized(found: Stabilized) -> None:
    """Say how a stabilisation went."""
    show(
        f"spectral radius of the full cycle {found.initial:.4g} -> {found.radius:.4g}, contraction bound "
        f"{found.bound:.4g}, in {len(found.steps) - 1} steps and {found.seconds:.1f} s ({found.parameters} weights): "
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


def tell_bounds(gait: Gait) -> None:
    """Say in one sentence what a gait was held against, and what of that is absurd."""
    from amble.stability.gait_certificate import held_against

    held = held_against(gait)
    torques = gait.limits.torques.values()
    range_of = f"{min(torques):g} to {max(torques):g} N m" if torques else "none"
    absurd = f"; ABSURD: {', '.join(held['absurd'])}" if held["absurd"] else ""
    show(
        f"held against: friction {held['friction']:g}, normal forces above 0, gravity {held['gravity_m_s2']:g} m/s^2; "
        f"not held against: torque limits ({range_of}) and other limits of joints, which `amble check` looks at{absurd}"
    )
    result(held_against=held)


def tell_certified(gait: Gait, certificate: Certificate) -> None:
    """Say what was certified."""
    show(
        f"spectral radius of the full cycle {certificate.radius:.6f} (estimated error {certificate.error:.1e}), "
        f"fixed point to {certificate.residual:.1e}, period {certificate.period:.6f} s"
    )
    tell_bounds(gait)
    numbers = {"error": certificate.error, "residual": certificate.residual, "period_s": certificate.period}
    result(certificate={"spectral_radius": certificate.radius, **numbers})


def tell_simulated(trace: Trace) -> None:
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
