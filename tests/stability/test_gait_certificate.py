"""The certificate's file: which gait it is about, and what a refusal says."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from amble.errors import CertificateError, FallError
from amble.gait import Gait
from amble.gait.files import content_hash, load_gait, save_gait
from amble.residual import Residual
from amble.stability.gait_certificate import bounds_sentences, does_not_say, identity, refusal_to_dict
from tests.grounds import on_friction


def test_the_hash_is_that_of_the_content(stabilised_gait: Gait, tmp_path: Path) -> None:
    hashed = content_hash(stabilised_gait)
    assert content_hash(load_gait(save_gait(stabilised_gait, tmp_path / "gait.json"))) == hashed
    # how a gait was found, and by which versions, is not what it is
    elsewhere = replace(stabilised_gait, versions={}, solver=replace(stabilised_gait.solver, seconds=1.0))
    assert content_hash(elsewhere) == hashed
    changed = (
        replace(stabilised_gait, feedback=None),
        replace(stabilised_gait, speed=0.3),
        on_friction(stabilised_gait, 0.5),
    )
    assert len({hashed, *(content_hash(gait) for gait in changed)}) == 4


def test_a_gait_is_named(stabilised_gait: Gait) -> None:
    found = identity(stabilised_gait)
    assert (found["name"], found["robot"], found["allocation_law"], found["speed_m_s"]) == (
        "amble",
        "astro",
        {"name": "pinv", "parameters": {}},
        0.2,
    )
    assert found["robot_hash"] == stabilised_gait.robot.hash


def test_a_refusal_names_the_rows_and_claims_nothing(stabilised_gait: Gait) -> None:
    rows = (Residual("D1 fl friction", 0.0, 0.7, 0.6), Residual("spectral radius plus its error bar", 0.0, 0.5, 1.0))
    tree = json.loads(json.dumps(refusal_to_dict(stabilised_gait, CertificateError(rows)), allow_nan=False))
    assert tree["certified"] is False
    assert "spectral_radius" not in tree
    assert [(row["name"], row["holds"]) for row in tree["conditions"]] == [(rows[0].name, False), (rows[1].name, True)]
    assert any("D1 fl friction" in line for line in tree["refused_because"])


def test_a_fall_is_a_reason_without_rows(stabilised_gait: Gait) -> None:
    tree = refusal_to_dict(stabilised_gait, FallError("the motion fell"))
    assert tree["refused_because"] == ["the motion fell"]
    assert tree["conditions"] == []


def test_what_a_certificate_does_not_say_names_the_switches_where_feet_land_together(stabilised_gait: Gait) -> None:
    trot = load_gait(Path(__file__).parents[1] / "data" / "trot-front-feet-in-the-air.json")
    (told,) = [line for line in does_not_say(trot) if "different times" in line]
    assert all(switch.name in told for switch in trot.pattern.all_switches)
    for gait in (trot, stabilised_gait):
        held, open_points = bounds_sentences(gait)
        assert f"friction {gait.pattern.ground.friction:g}" in held
        assert all(line in open_points for line in does_not_say(gait))
        assert refusal_to_dict(gait, FallError("the motion fell"))["does_not_say"] == list(does_not_say(gait))
