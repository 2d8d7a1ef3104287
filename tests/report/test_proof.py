"""A proof beside the certificate, as a table, a sentence and an entry of results.json."""

from __future__ import annotations

from amble.report.proof import proof_results, proof_summary, proof_table
from tests.proof.forged import forged


def test_both_are_shown() -> None:
    table = proof_table(forged(), {"spectral_radius": {"stabilized": 0.2041, "error": 3e-5}})
    rows = {what: (estimated, enclosed) for what, estimated, enclosed in table.rows}
    assert rows["spectral radius of the full cycle"] == ("0.2041, error bar 3.0e-05", "at most 0.250001")
    assert rows["stable up to"][1] == "x, turn about the vertical"
    assert rows["smallest margin: normal force (N)"][1] == "4.32 (hr)"
    assert rows["smallest margin: friction, mu^2 less the square of what is used"][1] == "0.012 (fl)"
    assert rows["smallest margin: height of the base above that of a fall (m)"][1] == "0.1"
    assert rows["fixed point, widest coordinate"][1] == "1e-7"
    assert rows["missed of the robot record's decimals at 5 points, force_N"][1] == "at most 2.27e-14"
    assert "again" in table.notes[0]


def test_a_run_without_a_certificate_has_the_proof_alone() -> None:
    table = proof_table(forged(), None)
    assert table.rows[0] == ("spectral radius of the full cycle", "-", "at most 0.250001")


def test_what_is_not_proved_is_not_said() -> None:
    proof = forged(rate=None)
    assert proof_table(proof, None).rows[0][2] == "not proved to be stable"
    assert "that it is stable is not" in proof_summary(proof)
    assert "stable up to a turn about the vertical, with" in proof_summary(forged())
    assert "cycle of at most 0.25001" in proof_summary(forged())
    assert proof_results(proof)["proof"]["stable"] is False


def test_a_basin_is_rounded_down() -> None:
    weight, reach = {"basin_weight": [[1.0]], "basin_size": 1.0, "basin_steps": [["1p-5"], ["1p-5"]]}, 9.99e-11
    proof = forged(**weight, proved={"basin_rate": 0.84785, "basin_extent": [reach - 1e-14]})
    rows = {what: enclosed for what, _, enclosed in proof_table(proof, None).rows}
    assert rows["basin, in the coordinate that may change most"] == "9.98e-11"
    assert rows["of the distance from the orbit left after a half cycle there"] == "at most 0.8479"
