"""Every number of the Python front door that sets an amount of work has a most; beyond it is one sentence, at once."""

from __future__ import annotations

import importlib
import inspect
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.amounts import check_amount
from amble.analysis import reference_motion, samples_of_gait
from amble.analysis.survival import survived_cycles
from amble.control import joint_outputs
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.simulation import simulate
from amble.stability import assess, certify, difference_check, fixed_point, monodromy, multipliers, poincare_map
from amble.stability.robustness import TrialSettings
from amble.synthesis import GaitProblem, gait_problem, refine, sweep, synthesize
from amble.validation import validate
from amble.verification.check import check
from amble.view import replay, replay_of_samples
from amble.workflow.reproduce import reproduce
from amble.workflow.robustness import robustness
from tests.hybrids import bouncing_ball

STATE = np.array([0.0, 1.0])
BALL = bouncing_ball()

PACKAGES = (
    "amble", "amble.analysis", "amble.control", "amble.gait", "amble.hybrid", "amble.robot", "amble.simulation",
    "amble.stability", "amble.synthesis", "amble.validation", "amble.verification", "amble.view",
)  # fmt: skip

RECORDS = {
    "CaseResult", "Certificate", "CertificateError", "CheckReport", "ContactReport", "Contraction", "FixedPoint",
    "Foot", "Joint", "NotSolvedError", "Outcome", "ProgressReport", "Replay", "RunReport", "SolverReport", "Trace",
    "Transition", "Validation",
}  # fmt: skip
"""What says how much was done, or names a place."""

OTHERS = {
    *(
        ("simulate", "seed"),
        ("validate", "seed"),
        ("TrialSettings", "seed"),
        ("Settings", "bits"),
        ("Settings", "order"),
    )
}
"""Seeds set no work; those of proofs are tested in tests/proof."""


@pytest.fixture(scope="module")
def gait() -> Gait:
    return load_gait(Path(__file__).parent / "data" / "stabilised-amble.json")


@pytest.fixture(scope="module")
def problem(gait: Gait) -> GaitProblem:
    return gait_problem(gait.pattern.robot, "trot", speed=0.2)


Call = Callable[[Gait, GaitProblem, int], object]

CALLS: dict[tuple[str, str], Call] = {
    ("simulate", "cycles"): lambda gait, _, n: simulate(gait, cycles=n),
    ("simulate", "samples"): lambda _g, _p, n: simulate(BALL, STATE, 1, samples=n),
    ("check", "grid"): lambda gait, _, n: check(gait, n),
    ("samples_of_gait", "cycles"): lambda gait, _, n: samples_of_gait(gait, n),
    ("survived_cycles", "starts"): lambda gait, _, n: survived_cycles(gait, [0.0], n),
    ("survived_cycles", "cycles"): lambda gait, _, n: survived_cycles(gait, [0.0], 1, n),
    ("replay", "cycles"): lambda gait, _, n: replay(gait, cycles=n),
    ("replay_of_samples", "cycles"): lambda gait, _, n: replay_of_samples(samples_of_gait(gait), "one", n),
    ("validate", "cycles"): lambda gait, _, n: validate(replace(gait, control=Impedance()), cycles=n),
    ("reproduce", "cycles"): lambda _g, _p, n: reproduce(cycles=n),
    ("joint_outputs", "order"): lambda gait, _, n: joint_outputs(gait.pattern, n),
    ("Outputs", "order"): lambda gait, _, n: replace(gait.outputs, order=n),
    ("fixed_point", "iterations"): lambda _g, _p, n: fixed_point(BALL, STATE, iterations=n),
    ("fixed_point", "cycles"): lambda _g, _p, n: fixed_point(BALL, STATE, cycles=n),
    ("monodromy", "cycles"): lambda _g, _p, n: monodromy(BALL, STATE, cycles=n),
    ("multipliers", "cycles"): lambda _g, _p, n: multipliers(BALL, STATE, cycles=n),
    ("poincare_map", "cycles"): lambda _g, _p, n: poincare_map(BALL, STATE, cycles=n),
    ("difference_check", "cycles"): lambda _g, _p, n: difference_check(BALL, STATE, cycles=n),
    ("assess", "cycles"): lambda _g, _p, n: assess(BALL, STATE, cycles=n),
    ("certify", "cycles"): lambda _g, _p, n: certify(BALL, STATE, cycles=n),
    ("gait_problem", "intervals"): lambda gait, _, n: gait_problem(gait.pattern.robot, "trot", speed=0.2, intervals=n),
    ("GaitProblem", "intervals"): lambda _, problem, n: replace(problem, intervals=n),
    ("synthesize", "most_iterations"): lambda _, problem, n: synthesize(problem, most_iterations=n),
    ("sweep", "most_iterations"): lambda _, problem, n: next(sweep([problem], most_iterations=n)),
    ("reference_motion", "cycles"): lambda gait, _, n: reference_motion(gait, 100.0, n),
    ("TrialSettings", "cycles"): lambda _g, _p, n: TrialSettings(cycles=n),
    ("robustness", "trials"): lambda gait, _, n: robustness(gait, "nowhere", trials=n),
    ("robustness", "workers"): lambda gait, _, n: robustness(gait, "nowhere", workers=n),
    ("refine", "factor"): lambda gait, problem, n: refine(problem, gait, n),
}


def test_every_number_of_the_front_door_is_tried() -> None:
    found = set()
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in getattr(module, "__all__", ()):
            value = getattr(module, name)
            if callable(value) and getattr(value, "__module__", "").startswith("amble") and name not in RECORDS:
                try:
                    signature = inspect.signature(value)
                except (TypeError, ValueError):
                    continue
                found |= {(name, key) for key, p in signature.parameters.items() if p.annotation in (int, "int")}
    assert found - OTHERS <= set(CALLS)
    assert len(found) > 20


@pytest.mark.parametrize("place", CALLS, ids="-".join)
@pytest.mark.parametrize("value", [10**20, -1])
def test_too_much_is_one_sentence_at_once(place: tuple[str, str], value: int, gait: Gait, problem: GaitProblem) -> None:
    began = time.process_time()
    with pytest.raises(InputError) as caught:
        CALLS[place](gait, problem, value)
    assert "\n" not in str(caught.value)
    assert time.process_time() - began < 10.0


@pytest.mark.parametrize("value", [1.5, True, None, "3", 10**5000, -(10**5000), float("nan")], ids=range(7))
def test_what_is_no_such_number_is_refused(value: object) -> None:
    with pytest.raises(InputError, match=r"a whole number from 1 to 5 can be$"):
        check_amount("cycles", value, 1, 5)


def test_the_range_is_closed() -> None:
    for value in (1, 5, np.int64(3)):
        check_amount("cycles", value, 1, 5)
