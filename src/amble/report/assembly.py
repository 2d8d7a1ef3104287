"""From a gait and its simulation to a whole run: metrics of both laws on both motions, monitors, settings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from amble.analysis import (
    Comparison,
    ContactBounds,
    ContactReport,
    Motion,
    Samples,
    compare,
    contact_report,
    reallocate,
    samples_of_gait,
    samples_of_trace,
)
from amble.control.actuator import ACTUATORS
from amble.control.allocation import AllocationLaw, PseudoInverse
from amble.control.laws import paper_baseline
from amble.errors import FallError
from amble.gait import Gait
from amble.report.allocation import allocation_results, allocation_table, compare_allocations
from amble.report.results import finite_or_none
from amble.report.run import Run, Stability
from amble.report.tables import Table
from amble.report.versions import computing_versions
from amble.simulation import Trace
from amble.types import Json

SHOWN = 2
"""Cycles in the torque figure."""


def paper_laws(gait: Gait) -> tuple[AllocationLaw, ...]:
    """Return the paper's two methods for a gait: one actuator off, and the pseudo-inverse."""
    return (paper_baseline(gait.pattern), PseudoInverse())


def compare_laws(gait: Gait, laws: Sequence[AllocationLaw], trace: Trace | None = None) -> Comparison:
    """Evaluate laws along the optimised motion and, where a trace is given, along the simulated one."""
    motions = [samples_of_gait(gait)]
    if trace is not None:
        motions.append(samples_of_trace(trace, gait.pattern))
    return compare([with_laws(samples, laws) for samples in motions], ACTUATORS)


def with_laws(samples: Samples, laws: Sequence[AllocationLaw]) -> Motion:
    """Return a motion with the torques that each law applies on it."""
    return samples.motion({name: found.torques for name, found in reallocate(samples, laws).items()})


def monitors(gait: Gait, trace: Trace) -> ContactReport:
    """Hold a simulated motion against the limits of its gait."""
    return contact_report(trace, gait.pattern, ContactBounds.of_gait(gait))


def perturbed_results(gait: Gait, trace: Trace, size: float, seed: int) -> Json:
    """Return what is known of a simulation from a perturbed start; N, 1, m.

    ``before_sound`` is about the cycles before the contacts are sound; None where they are from the start.
    Friction used is None where a stance foot pulls.
    """
    report = monitors(gait, trace)
    until = report.sound_from
    return {
        "size": size,
        "seed": seed,
        "cycles": trace.cycles,
        "ended": trace.ended,
        "sound_from_cycle": until,
        "before_sound": None
        if until == 0
        else {
            "min_normal_force": float(report.normal_forces[:until].min()),
            "max_friction": finite_or_none(float(report.frictions[:until].max())),
        },
        "min_normal_force": report.min_normal_force,
        "max_friction": finite_or_none(report.max_friction),
        "max_penetration": report.max_penetration,
    }


def assemble(
    gait: Gait,
    trace: Trace,
    settings: Mapping[str, str],
    seconds: Mapping[str, float],
    stability: Stability | None = None,
    tables: Sequence[Table] = (),
    extra: Json | None = None,
) -> Run:
    """Measure a gait and its simulation for the report.

    Args:
        gait: the gait.
        trace: its simulation, at least one whole cycle.
        settings: name -> value, of the run.
        seconds: step -> wall time, s.
        stability: what the stability analysis found.
        tables: further tables for the page.
        extra: further entries for results.json.

    Raises:
        FallError: the simulation holds no whole cycle.
    """
    if trace.cycles < 1:
        raise FallError(f"the simulated motion has no whole cycle to measure: {trace.ended}")
    laws, allocations = paper_laws(gait), compare_allocations(gait)
    whole = samples_of_trace(trace, gait.pattern).only(0, trace.cycles)
    last = whole.only(max(trace.cycles - SHOWN, 0), trace.cycles)
    return Run(
        gait=gait,
        simulated=whole,
        cycles=trace.cycles,
        two_cycles=with_laws(last, laws),
        comparison=compare([with_laws(samples_of_gait(gait), laws), with_laws(whole, laws)], ACTUATORS),
        contact=monitors(gait, trace),
        speed_achieved=whole.distance / float(whole.times[-1] - whole.times[0]),
        settings=settings,
        seconds=seconds,
        versions=computing_versions(),
        stability=stability,
        tables=(*tables, allocation_table(allocations)),
        extra={"allocation": allocation_results(allocations), **(extra or {})},
    )
