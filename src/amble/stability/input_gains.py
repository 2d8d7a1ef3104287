"""What errors of the plant and pushes do to a stable gait from cycle to cycle, to first order.

With w a disturbance that acts in every cycle, xi the deviation from the orbit at its entry modulo the symmetries,

    xi_(k+1) = A xi_k + b w_k,   |xi_(k+1)|_W <= r |xi_k|_W + |b|_W |w_k|,

where W and r are those of the certificate, r^2 W - A^T W A > 0: so |xi|_W comes below gamma sup |w| with the
input-to-state gain gamma = |b|_W / (1 - r) (docs/theory/robustness.md, section 5). W is scaled so that |xi|_W is at
least the size of xi in units of l and sqrt(l / g). b is a central difference of a walk through one cycle. Where feet
land one by one A and b are those of an order of landing: W and r serve all orders of half a cycle, and b is the larger
of the slopes to both sides, whose orders differ.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from amble.errors import FallError, InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.plant_errors import PlantErrors
from amble.gait.unilateral_loop import on_unilateral_ground
from amble.gait.unilateral_state import NO_PUSH, Push, unilateral_start
from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport, silent
from amble.robot import Robot
from amble.robot.natural_units import natural_units
from amble.simulation.flow import Flow
from amble.simulation.prepared import PreparedDomain
from amble.simulation.walk import HybridArc, walk
from amble.stability.common_bound import common_bound
from amble.stability.disturbance import to_units
from amble.stability.group import closest_shift
from amble.stability.landing_orders import orders_of
from amble.stability.lyapunov import quadratic_bound
from amble.stability.spectrum import Spectrum, multipliers
from amble.types import Json, Matrix, Vector

TOLERANCE = 1e-10
TIME_LIMIT = 10.0

STEP = 1e-4
"""Size of the disturbances of the differences, in natural units."""

STICKY = 1e6
"""Friction of the ground in the differences: the model's feet do not slip."""


@dataclass(frozen=True, kw_only=True)
class InputGain:
    """A disturbance and what it does.

    Attributes:
        name: of the disturbance.
        unit: of its size.
        natural: its size in that unit that counts as one: m l^2 of an inertia, sqrt(l / g) of a time, ...
        direct: size of what one of it does to the next entry, in units of l and sqrt(l / g).
        later: size of what is left of that one cycle later.
        weighted: |b|_W.
        gain: gamma = |b|_W / (1 - r).
    """

    name: str
    unit: str
    natural: float
    direct: float
    later: float
    weighted: float
    gain: float

    def to_dict(self) -> Json:
        """Return it as a dictionary for a JSON file."""
        return dict(vars(self))


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """A kind of error of the plant.

    Attributes:
        name: in words.
        unit: of its size.
        natural: the size that counts as one.
        key: the field of ``PlantErrors`` that it is.
        foot: of a step, the foot under it.
        both_signs: whether a negative size has a meaning.
    """

    name: str
    unit: str
    natural: float
    key: str
    foot: str = ""
    both_signs: bool = False

    def errors(self, size: float, friction: float | None) -> PlantErrors:
        """Return the error of a size, in natural units."""
        value = self.natural * size
        if self.foot:
            return PlantErrors(friction=friction, steps={self.foot: value})
        changed: Json = {self.key: 1.0 + value if self.key == "trunk" else value}
        return PlantErrors(friction=friction, **changed)


def disturbances(robot: Robot) -> tuple[Disturbance, ...]:
    """List the errors of a robot's plant that are looked at."""
    length, time = robot.leg_length, float(np.sqrt(robot.leg_length / robot.gravity))
    torque = robot.mass * robot.gravity * length
    steps = [
        Disturbance(name=f"step under {foot}", unit="m", natural=length, key="steps", foot=foot, both_signs=True)
        for foot in robot.foot_names
    ]
    return (
        Disturbance(name="damping of the joints", unit="N m s/rad", natural=torque * time, key="damping"),
        Disturbance(name="dry friction of the joints", unit="N m", natural=torque, key="dry_friction"),
        Disturbance(name="mass of the base link", unit="share", natural=1.0, key="trunk", both_signs=True),
        Disturbance(name="delay of the torques", unit="s", natural=time, key="delay"),
        Disturbance(name="late switching", unit="s", natural=time, key="lateness"),
        *steps,
    )


@dataclass(frozen=True, kw_only=True)
class CycleMap:
    """A stable gait with what its deviations are measured by.

    Attributes:
        gait: the gait.
        loop: its closed loop over the whole cycle.
        state: the fixed point, (2 n_q,).
        spectrum: A with its basis.
        metric: W, scaled, (m, m).
        rate: r.
        change: T with |T xi| the size of a deviation in units of l and sqrt(l / g), (m, m).
    """

    gait: Gait
    loop: HybridSystem
    state: Vector
    spectrum: Spectrum
    metric: Matrix
    rate: float
    change: Matrix

    @classmethod
    def of(cls, gait: Gait) -> CycleMap:
        """Find the spectrum and W at the gait's start, which is that of its closed loop's own orbit.

        Raises:
            FallError: the motion does not come back.
            InputError: the gait is not stable, in every order of landing, or not stabilised.
        """
        if gait.feedback is None:
            raise InputError("the gait does not hold its closed loop's own orbit; stabilise it first")
        loop, state = closed_loop(gait), start_state(gait)
        spectrum = multipliers(loop, state, TOLERANCE)
        if not spectrum.radius < 1.0:
            raise InputError(
                f"the gait is not stable (spectral radius {spectrum.radius:.4g}), so disturbances add up: stabilise it "
                "under this control law"
            )
        change = to_units(spectrum, natural_units(gait.robot, gait.robot.leg_length))
        metric, rate = _contraction(gait, state, spectrum)
        back = np.linalg.inv(change)
        least = float(np.linalg.eigvalsh(back.T @ metric @ back).min())
        return cls(
            gait=gait, loop=loop, state=state, spectrum=spectrum, metric=metric / least, rate=rate, change=change
        )

    def reduced(self, moved: Vector) -> Vector:
        """Return a change of the entry state one cycle later modulo the symmetries, in the basis of the spectrum."""
        return np.asarray(self.spectrum.basis.T @ np.linalg.solve(self.shift, moved))

    @cached_property
    def walker(self) -> HybridSystem:
        """The unilateral loop on sticky ground."""
        return on_unilateral_ground(self.gait, self.loop, PlantErrors(friction=STICKY))

    @cached_property
    def usual(self) -> HybridArc:
        """One cycle of it."""
        return walk(self.walker, unilateral_start(self.gait, self.state), 1, TOLERANCE, 2, TIME_LIMIT)

    @cached_property
    def shift(self) -> Matrix:
        """Derivative of the symmetry that the entry is moved along in a cycle, (2 n_q, 2 n_q)."""
        return closest_shift(self.loop, self.state, self.usual.events[-1].after[: self.state.size]).matrix

    def response(self, kind: Disturbance) -> Vector:
        """Return b of a disturbance of natural size one."""
        ahead, behind = (self._walked(kind, sign * STEP) for sign in (1.0, -1.0))
        if not orders_of(self.gait):
            return self.reduced((ahead - behind) / (2.0 * STEP))
        usual = self.usual.events[-1].after[: self.state.size]
        return max((self.reduced(moved / STEP) for moved in (ahead - usual, usual - behind)), key=self.weighted)

    def _walked(self, kind: Disturbance, size: float) -> Vector:
        """Walk one cycle with an error of a size."""
        system = on_unilateral_ground(self.gait, self.loop, kind.errors(size, STICKY))
        return entered(self.gait, system, self.state)

    def weighted(self, response: Vector) -> float:
        """Return |b|_W of a response."""
        return float(np.sqrt(response @ self.metric @ response))

    def gain(self, name: str, unit: str, natural: float, response: Vector) -> InputGain:
        """Describe a disturbance by its response b, per natural size."""
        weighted, after = self.weighted(response), self.spectrum.matrix @ response
        return InputGain(
            name=name,
            unit=unit,
            natural=natural,
            direct=float(np.linalg.norm(self.change @ response)),
            later=float(np.linalg.norm(self.change @ after)),
            weighted=weighted,
            gain=weighted / (1.0 - self.rate),
        )


def _contraction(gait: Gait, state: Vector, spectrum: Spectrum) -> tuple[Matrix, float]:
    """Return W and r of a gait cycle; where feet land one by one they serve every order of landing.

    Raises:
        InputError: nothing serves all orders.
    """
    orders = orders_of(gait)
    if not orders:
        bound = quadratic_bound(spectrum.matrix)
        return bound.metric, bound.rate
    loops = [closed_loop(gait, half=True, orders=order) for order in orders]
    common = common_bound([multipliers(loop, state, TOLERANCE).matrix for loop in loops])
    if not common.rate < 1.0:
        raise InputError(
            f"no quadratic function contracts in all orders of landing (the best to {common.rate:.4g}), so "
            "disturbances may add up: stabilise the gait under this control law"
        )
    return common.metric, common.rate ** (2 if gait.pattern.mirrored else 1)


def entered(
    gait: Gait,
    system: HybridSystem,
    state: Vector,
    push: Push = NO_PUSH,
    cycles: int = 1,
    prepared: dict[str, tuple[PreparedDomain, Flow]] | None = None,
) -> Vector:
    """Return the entry state after some cycles of a unilateral walk, (2 n_q,).

    Raises:
        FallError: the walk ends before.
    """
    found = walk(system, unilateral_start(gait, state, push), cycles, TOLERANCE, 2, TIME_LIMIT, prepared=prepared)
    if found.cycles < cycles:
        raise FallError(found.ended)
    return np.asarray(found.events[-1].after[: state.size])


def input_gains(cycle: CycleMap, progress: Progress | None = None) -> tuple[InputGain, ...]:
    """Differentiate a walk through one cycle in every error of the plant.

    Args:
        cycle: the gait.
        progress: called with what is differentiated.

    Raises:
        FallError: a walk with a small error does not come back.
    """
    notify, kinds = progress or silent, disturbances(cycle.gait.robot)
    found = []
    for number, kind in enumerate(kinds):
        notify(ProgressReport(what=f"gain of {kind.name}", done=number, of=len(kinds)))
        response = cycle.response(kind)
        found.append(cycle.gain(kind.name, kind.unit, kind.natural, response))
    return tuple(found)
