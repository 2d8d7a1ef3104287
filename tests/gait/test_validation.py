"""A gait record whose parts do not fit together is refused in one sentence, from a file and from Python."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amble.control import DomainOutputs, Outputs
from amble.errors import AmbleError, InputError
from amble.gait import DomainTrajectory, Gait
from amble.gait.files import load_gait
from tests.cli.run import exit_code
from tests.gait.example import random_gait

DATA = Path(__file__).parents[1] / "data" / "stabilised-amble.json"


def first(gait: Gait) -> DomainTrajectory:
    return gait.domains[0]


def with_first(gait: Gait, **fields: Any) -> Gait:
    return replace(gait, domains=(replace(gait.domains[0], **fields), *gait.domains[1:]))


def fewer_outputs(gait: Gait) -> Gait:
    head, *rest = gait.outputs.domains
    short = Outputs((DomainOutputs(head.domain, head.coordinates[1:]), *rest), gait.outputs.order)
    domains = (replace(first(gait), coefficients=first(gait).coefficients[1:]), *gait.domains[1:])
    return replace(gait, outputs=short, domains=domains, feedback=None)


def other_durations(gait: Gait, value: float) -> Gait:
    assert gait.feedback is not None
    durations = dict.fromkeys(gait.feedback.durations, value)
    return replace(gait, feedback=replace(gait.feedback, durations=durations))


def higher_references(gait: Gait) -> Gait:
    assert gait.feedback is not None
    references = {name: np.zeros((len(values), 16)) for name, values in gait.feedback.references.items()}
    return replace(gait, feedback=replace(gait.feedback, references=references))


REFUSED: dict[str, tuple[Callable[[Gait], object], str]] = {
    "negative duration": (lambda g: with_first(g, duration=-1.0), "duration of domain 'D1' is -1 s"),
    "no duration": (lambda g: with_first(g, duration=0.0), "duration of domain 'D1' is 0 s"),
    "endless": (lambda g: with_first(g, duration=np.inf), "positive and finite"),
    "other duration": (lambda g: with_first(g, duration=2.0 * first(g).duration), "but its clock runs from 0 to"),
    "clock backwards": (lambda g: with_first(g, times=first(g).times[::-1]), "does not run forward"),
    "one node": (
        lambda g: with_first(
            g,
            times=first(g).times[:1],
            **{n: getattr(first(g), n)[:1] for n in ("positions", "velocities", "accelerations", "torques", "forces")},
        ),
        "has 1 nodes",
    ),
    "no node": (
        lambda g: with_first(
            g,
            times=first(g).times[:0],
            **{n: getattr(first(g), n)[:0] for n in ("positions", "velocities", "accelerations", "torques", "forces")},
        ),
        "has 0 nodes",
    ),
    "fewer nodes": (lambda g: with_first(g, torques=first(g).torques[:-2]), "its torques have the shape 5 x 12"),
    "NaN": (lambda g: with_first(g, positions=first(g).positions * np.nan), "positions hold a number that is not"),
    "too large": (lambda g: with_first(g, forces=1e100 * first(g).forces), "forces hold a number above 1e\\+12"),
    "too fast": (lambda g: replace(g, speed=1e300), "speed of the gait is 1e\\+300"),
    "standing": (lambda g: with_first(g, velocities=0.0 * first(g).velocities), "nothing moves"),
    "pulling": (lambda g: with_first(g, forces=-np.abs(first(g).forces)), "no foot pushes on the ground"),
    "forces of another stance": (lambda g: with_first(g, forces=first(g).forces[:, :3]), "the forces of domain 'D1'"),
    "impulse": (lambda g: with_first(g, impulse=np.zeros(3)), "the impulse of domain 'D1' have the shape 3, not 6"),
    "fewer outputs": (fewer_outputs, "10 different outputs of 10; standing on rl, fr it needs 11"),
    "order": (lambda g: Outputs(g.outputs.domains, 0), "order of the output curves is 0; at least 3"),
    "high order": (lambda g: replace(g, outputs=Outputs(g.outputs.domains, 20)), "takes up to 14"),
    "domains": (lambda g: replace(g, domains=g.domains[:1]), "name the domains D1, not D1, D2"),
    "speed": (lambda g: replace(g, speed=float("nan")), "speed of the gait is nan"),
    "feedback duration": (lambda g: other_durations(g, 0.0), "feedback's duration of domain 'D1' is 0 s"),
    "feedback start": (lambda g: feedback(g, start=np.zeros(3)), "start of the feedback have the shape 3, not 36"),
    "feedback order": (higher_references, "order of the references of domain 'D1' is 15"),
    "feedback domains": (lambda g: feedback(g, weights={}), "the feedback of the gait name the domains"),
}


def feedback(gait: Gait, **fields: Any) -> Gait:
    assert gait.feedback is not None
    return replace(gait, feedback=replace(gait.feedback, **fields))


@pytest.mark.parametrize("case", REFUSED)
def test_what_does_not_fit_is_refused(case: str) -> None:
    change, says = REFUSED[case]
    with pytest.raises(InputError, match=says) as caught:
        change(random_gait())
    assert "\n" not in str(caught.value)


COMMANDS = ("compare", "export", "certify", "check")


def cut_output(tree: Any) -> None:
    """One output less, and everything else in the file as it must then be."""
    tree["outputs"]["domains"]["D1"].pop()
    tree["domains"]["D1"]["coefficients"]["value"].pop()
    tree["feedback"] = None


def zero(tree: Any) -> None:
    for domain in tree["domains"].values():
        for name in ("positions", "velocities", "accelerations", "torques", "forces"):
            domain[name]["value"] = [[0.0] * len(row) for row in domain[name]["value"]]


FILES: dict[str, tuple[Callable[[Any], object], str]] = {
    "duration": (
        lambda t: t["domains"]["D1"]["duration"].update(value=-1.0),
        "duration is -1; it must be",
    ),
    "feedback": (
        lambda t: t["feedback"]["durations"]["D2"].update(value=0.0),
        "durations, D2 is 0; it must",
    ),
    "order": (lambda t: t["outputs"].update(order=0), "order is 0; it must be from 1"),
    "output": (cut_output, "it needs 11"),
    "zeros": (zero, "nothing moves"),
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("case", FILES)
def test_a_file_that_does_not_fit_is_bad_input(
    command: str, case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change, says = FILES[case]
    tree = json.loads(DATA.read_text())
    change(tree)
    path = tmp_path / "gait.json"
    path.write_text(json.dumps(tree))
    out = ["--out", str(tmp_path / "out")] if command != "check" else []
    assert exit_code(command, str(path), *out) == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert says in last
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("seed", range(40))
def test_a_random_field_of_a_file_cut_or_spoilt_never_loads_as_a_gait(seed: int, tmp_path: Path) -> None:
    """One array of numbers loses a row or gets a number that JSON has but a motion has not."""
    draw = np.random.default_rng(seed)
    tree = json.loads(DATA.read_text())
    domain = tree["domains"][str(draw.choice(["D1", "D2"]))]
    name = str(draw.choice(sorted(set(domain) - {"duration"})))
    values = domain[name]["value"]
    if draw.random() < 0.5:
        del values[int(draw.integers(len(values)))]
    else:
        spoilt = str(draw.choice(["inf", "-inf", "nan"]))
        target = values[int(draw.integers(len(values)))] if isinstance(values[0], list) else values
        target[int(draw.integers(len(target)))] = spoilt
    path = tmp_path / "gait.json"
    path.write_text(json.dumps(tree))
    with pytest.raises(AmbleError):
        load_gait(path)
