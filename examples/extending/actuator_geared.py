"""An actuator of one's own: a brushless motor by its datasheet, behind its gear. One model, one registration."""

from __future__ import annotations

from math import pi, sqrt

from amble.control.actuator import ACTUATORS, Actuator


def brushless(name: str, *, kv: float, phase_resistance: float, gear_ratio: float, source: str) -> Actuator:
    """Return the model of a brushless motor with sinusoidal currents and a gear without friction.

    With the current i of amplitude I in a phase, the torque is K_t I and the heat of the three windings 3/2 R I^2; a
    line-to-line speed constant K_V says K_t = sqrt(3)/2 * 60 / (2 pi K_V). Reckoned as one winding, R is 3/2 of a
    phase's.

    Args:
        name: name of the model.
        kv: speed constant K_V, line to line, rpm per volt of amplitude.
        phase_resistance: of one phase, ohm.
        gear_ratio: joint torque over motor torque.
        source: where the numbers come from.
    """
    return Actuator(
        name=name,
        torque_constant=sqrt(3.0) / 2.0 * 60.0 / (2.0 * pi * kv),
        resistance=1.5 * phase_resistance,
        gear_ratio=gear_ratio,
        source=source,
    )


GEARED = brushless("geared", kv=100.0, phase_resistance=0.1, gear_ratio=9.0, source="An invented motor of 100 rpm/V.")

ACTUATORS.register(GEARED.name, GEARED)
