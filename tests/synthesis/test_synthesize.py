"""A coarse gait from beginning to end, and the ways in which a solve may end without one."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.control import DropActuator, joint_outputs
from amble.errors import InputError, NotSolvedError, UnknownNameError
from amble.gait import Gait, SolverReport
from amble.gait.files import load_gait, save_gait
from amble.hybrid import SIMULTANEOUS, Plane, gait_pattern
from amble.progress import Progress, ProgressReport
from amble.robot import Adaptation, Robot, catalogue, load_robot
from amble.robot.catalogue import Posture
from amble.synthesis import GaitProblem, gait_problem, synthesize
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.landing_rows import SLOW_RELEASE
from amble.synthesis.layout import build_layout
from amble.synthesis.possible import require_possible
from amble.synthesis.program import GaitProgram, build_program, require_full_rank
from amble.synthesis.result import from_gait, to_gait
from amble.synthesis.solve import SOLVERS, Solution, Solver, Start, ipopt, ipopt_structured
from amble.synthesis.synthesize import GaitNotSolvedError, regular_outputs
from amble.verification.check import check
from tests import quadruped
from tests.robots import ROBOTS, robot

EXACT = ("acceleration", "torque", "force", "dynamics", "law", "guard", "impact", "continuity", "periodicity", "clock")
"""Kinds that hold at the nodes whatever the mesh."""


def changed(problem: GaitProblem, **positions: tuple[float, float]) -> GaitProblem:
    limits = replace(problem.limits, positions={**problem.limits.positions, **positions})
    return replace(problem, limits=limits)


@pytest.mark.parametrize("name", ROBOTS)
def test_problems_by_default_are_possible(name: str, caplog: pytest.LogCaptureFixture) -> None:
    problem = gait_problem(robot(name), "trot", speed=0.3)
    caplog.clear()
    require_possible(problem)
    assert not caplog.records


@pytest.fixture(scope="module")
def sagittal(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """A quadruped whose legs move fore, aft, up and down only."""
    file = quadruped.write(tmp_path_factory.mktemp("sagittal"))
    held = {f"{leg}_hx": 0.0 for leg in quadruped.PLACES}
    return load_robot(file, quadruped.FEET, adaptation=Adaptation(locked=held))


@pytest.mark.parametrize(("gait", "feet"), [("walk", "fr, rl, rr"), ("bound", "fl, fr"), ("crawl", "fl, fr, rl, rr")])
def test_stances_that_legs_without_sideways_joints_cannot_hold_are_refused(
    sagittal: Robot, gait: str, feet: str
) -> None:
    """Feet at the same x hold their distance along y whatever the joints do; so do three feet (y and yaw are two)."""
    with pytest.raises(InputError, match=rf"cannot stand on {feet} .*\b[fr][lr] y, [fr][lr] y depend on each other"):
        synthesize(gait_problem(sagittal, gait, speed=0.2))


def test_rows_that_are_no_numbers_are_named(sagittal: Robot) -> None:
    """Outputs that cannot be decoupled divide by zero; a program may be built of them without ``synthesize``."""
    problem = gait_problem(sagittal, "bound", speed=0.2, intervals=4)
    program = build_program(problem)
    with pytest.raises(NotSolvedError, match="no numbers") as caught:
        require_full_rank(program, initial_guess(problem, program.layout) / program.layout.scale)
    assert "law" in caught.value.rows[0].name


@pytest.mark.parametrize("gait", ["trot", "pace", "amble"])
def test_two_feet_one_behind_the_other_stand(sagittal: Robot, gait: str) -> None:
    require_possible(gait_problem(sagittal, gait, speed=0.2))


def test_a_slope_is_possible() -> None:
    require_possible(gait_problem(catalogue.astro(), "trot", speed=0.2, ground=Plane(slope=0.17)))


IMPOSSIBLE: dict[str, tuple[Callable[[GaitProblem], GaitProblem], str]] = {
    "higher than legs are long": (lambda problem: changed(problem, z=(1.5, 2.0)), "the base must keep above 1.5 m"),
    "feet in the air": (
        lambda problem: replace(problem, posture=Posture(1.0, problem.posture.angles)),
        r"foot '..' is 0\.\d+ m above the ground; with these angles the height of the posture would be about 0\.297 m",
    ),
    "feet in the ground": (
        lambda problem: replace(problem, posture=Posture(0.02, problem.posture.angles)),
        r"foot '..' is -0\.\d+ m above the ground",
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_what_cannot_work_is_refused_before_the_solver(name: str, small_problem: GaitProblem) -> None:
    change, says = IMPOSSIBLE[name]
    with pytest.raises(InputError, match=says):
        synthesize(change(small_problem))


def test_a_posture_outside_its_bounds_is_told(small_problem: GaitProblem, caplog: pytest.LogCaptureFixture) -> None:
    """It was moved in silence."""
    require_possible(changed(small_problem, fl_knee=(1.5, 2.0)))
    assert "the posture has fl_knee at 1.16, outside 1.5 to 2; it is moved inside" in caplog.text


@pytest.fixture(scope="module")
def iterations() -> list[ProgressReport]:
    return []


@pytest.fixture(scope="module")
def coarse_gait(small_problem: GaitProblem, iterations: list[ProgressReport]) -> Gait:
    return synthesize(small_problem, most_iterations=200, progress=iterations.append)


def test_a_coarse_gait_holds_at_its_nodes(coarse_gait: Gait) -> None:
    report = check(coarse_gait)
    for kind in EXACT:
        assert report.worst[kind].passed, str(report.worst[kind])
    # five intervals of up to 60 ms: the motion between the nodes is accurate to a few mrad/s and a tenth of a mm
    assert check(coarse_gait, tolerance=5e-3, slack=0.05).passed


def test_the_gait_keeps_what_the_problem_asked(coarse_gait: Gait, small_problem: GaitProblem) -> None:
    assert coarse_gait.speed == small_problem.speed
    assert coarse_gait.law == small_problem.law
    assert [domain.name for domain in coarse_gait.domains] == ["D1", "D2"]
    assert coarse_gait.domains[0].times.size == 2 * small_problem.intervals + 1
    assert coarse_gait.solver.status == "Solve_Succeeded"
    assert coarse_gait.solver.violation < 1e-6
    assert set(coarse_gait.versions) == {"amble", "casadi", "numpy"}


def test_progress_names_rows(coarse_gait: Gait, iterations: list[ProgressReport], small_program: GaitProgram) -> None:
    assert [iteration.done for iteration in iterations] == list(range(coarse_gait.solver.iterations + 1))
    worst = [
        re.fullmatch(r"worst row '(.*)' violated by (\S+?)(?: [^,]+)?(?:, \d+ start values .*)?", iteration.detail)
        for iteration in iterations
    ]
    names, violations = zip(*[found.groups() for found in worst if found is not None], strict=True)
    assert len(names) == len(iterations)
    assert set(names) <= set(small_program.program.row_names)
    assert float(violations[-1]) < 1e-6 < float(violations[0])
    assert iterations[-1].quantity == "objective"
    assert iterations[-1].value == pytest.approx(coarse_gait.solver.objective, rel=1e-6)


def test_the_objective_is_the_mean_squared_torque(coarse_gait: Gait) -> None:
    """(1/T) integral of |u|^2 with Simpson's weights, summed here by hand."""
    work = duration = 0.0
    for domain in coarse_gait.domains:
        squares, step = np.sum(domain.torques**2, axis=1), domain.duration / (domain.times.size - 1)
        work += step / 3.0 * (squares[0] + 4.0 * squares[1::2].sum() + 2.0 * squares[2:-1:2].sum() + squares[-1])
        duration += domain.duration
    assert work / duration == pytest.approx(coarse_gait.solver.objective, rel=1e-9)


def test_a_gait_is_its_own_starting_point(coarse_gait: Gait, small_program: GaitProgram) -> None:
    layout = small_program.layout
    natural = from_gait(small_program.problem, coarse_gait, layout)
    solution = Solution(
        variables=natural / layout.scale, multipliers=None, report=coarse_gait.solver, rows=(), solved=True
    )
    again = to_gait(small_program.problem, layout, solution)
    for ours, theirs in zip(again.domains, coarse_gait.domains, strict=True):
        for kind in ("coefficients", "positions", "velocities", "accelerations", "torques", "forces", "impulse"):
            # interpolation at the nodes themselves, whose phases round at 1e-16
            np.testing.assert_allclose(getattr(ours, kind), getattr(theirs, kind), atol=1e-9)
        assert ours.duration == pytest.approx(theirs.duration)


def test_a_gait_that_was_saved_starts_its_neighbour(
    coarse_gait: Gait, small_problem: GaitProblem, tmp_path: Path
) -> None:
    neighbour = replace(small_problem, speed=small_problem.speed - 0.01)
    saved = load_gait(save_gait(coarse_gait, tmp_path / "gait.json"))
    warm = synthesize(neighbour, start=saved)
    assert warm.solver.iterations < coarse_gait.solver.iterations / 2
    bare = synthesize(neighbour, start=replace(saved, multipliers=None))
    assert warm.solver.iterations < bare.solver.iterations
    # the same optimum, to the solver's tolerance
    assert warm.solver.objective == pytest.approx(bare.solver.objective, rel=1e-5)


def test_multipliers_of_another_mesh_do_not_reach_the_solver(
    coarse_gait: Gait, small_problem: GaitProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    class ReachedError(Exception):
        pass

    reached: list[object] = []

    def solver(_: GaitProgram, start: Start, *__: object, **___: object) -> Solution:
        reached.append(start.multipliers)
        raise ReachedError

    monkeypatch.setitem(SOLVERS._entries, "ipopt", solver)
    for intervals in (small_problem.intervals, small_problem.intervals + 1):
        with pytest.raises(ReachedError):
            synthesize(replace(small_problem, intervals=intervals), start=coarse_gait)
    assert reached[0] is not None
    assert reached[1] is None


@pytest.mark.parametrize("first", [1, 5])
def test_what_is_not_solved_is_tried_from_a_coarser_mesh(
    small_problem: GaitProblem, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, first: int
) -> None:
    """A solver that gives up: the first time, and every time; the reason is the first one."""
    tried: list[int] = []

    def giving_up(program: GaitProgram, start: Start, tolerance: float, most: int, *_: object) -> Solution:
        tried.append(program.problem.intervals)
        return ipopt(program, start, tolerance, 1 if len(tried) <= first else most, None)

    monkeypatch.setitem(SOLVERS._entries, "giving up", giving_up)
    problem = replace(small_problem, intervals=8)
    if first == 1:
        gait = synthesize(problem, solver="giving up")
        assert tried == [8, 4, 8]
        assert (gait.domains[0].times.size - 1) // 2 == 8
        assert "not solved on 8 intervals from the kinematic walk (Maximum_Iterations_Exceeded" in caplog.text
        failed = {row.kind for row in check(gait).failed}
        assert not failed & set(EXACT)
    else:
        with pytest.raises(GaitNotSolvedError, match="Maximum_Iterations_Exceeded") as caught:
            synthesize(problem, solver="giving up")
        # the third is the one whose feet land as fast as they like; feet of the last two leave slowly
        assert tried == [8, 4, 4, 4, 8]
        assert (caught.value.last.domains[0].times.size - 1) // 2 == 8


def test_a_refused_system_is_left_to_half_the_intervals_before_mumps(
    small_problem: GaitProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The structured solver refuses on both meshes; the whole mesh alone comes to MUMPS, and the reason stays."""
    tried: list[tuple[str, int, int]] = []
    why = "IPOPT regularises the equality rows"

    def solver(name: str, refused: str) -> Solver:
        def solve(
            program: GaitProgram, start: Start, tolerance: float, most: int, _: Progress | None, reason: str = ""
        ) -> Solution:
            tried.append((name, program.problem.intervals, most))
            assert reason == ("" if refused else why)
            return replace(ipopt_structured(program, start, tolerance, 1, None), refused=refused)

        return solve

    module = sys.modules["amble.synthesis.synthesize"]
    monkeypatch.setattr(module, "ipopt_structured", solver("structured", why))
    monkeypatch.setattr(module, "ipopt_mumps", solver("MUMPS", ""))
    with pytest.raises(GaitNotSolvedError) as caught:
        synthesize(replace(small_problem, intervals=8))
    assert tried == [("structured", 8, 250), *[("structured", 4, 125)] * 3, ("structured", 8, 125), ("MUMPS", 8, 495)]
    assert caught.value.refused == why


def test_a_gait_whose_released_feet_leave_slowly_starts_one_that_may(
    coarse_gait: Gait, small_problem: GaitProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between half of the slow speed and half of the speed asked for; the slowest of ASTRo's amble is read first."""
    asked: list[float] = []

    def solver(program: GaitProgram, *_: object, **__: object) -> Solution:
        asked.append(program.problem.release)
        raise InputError("asked for")

    monkeypatch.setitem(SOLVERS._entries, "none", solver)
    for release in (0.3, small_problem.release):  # so much that the gait's feet are slow, and as it was found
        with pytest.raises(InputError, match="asked for"):
            synthesize(replace(small_problem, release=release), coarse_gait, solver="none")
    assert asked == [SLOW_RELEASE, small_problem.release]


@pytest.mark.slow
def test_multipliers_of_another_mesh_are_not_used(coarse_gait: Gait, small_problem: GaitProblem) -> None:
    finer = replace(small_problem, intervals=small_problem.intervals + 1)
    with_them = synthesize(finer, start=coarse_gait)
    without = synthesize(finer, start=replace(coarse_gait, multipliers=None))
    assert with_them.solver.iterations == without.solver.iterations


def test_a_start_that_is_not_near_is_tried_again_without_its_multipliers(
    coarse_gait: Gait, small_problem: GaitProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One warm iteration is too few for any start; all iterations are counted."""
    monkeypatch.setattr(sys.modules["amble.synthesis.solve_near"], "WARM_ITERATIONS", 1)
    neighbour = replace(small_problem, speed=small_problem.speed - 0.01)
    found = synthesize(neighbour, start=coarse_gait)
    bare = synthesize(neighbour, start=replace(coarse_gait, multipliers=None))
    assert found.solver.iterations == 1 + bare.solver.iterations
    assert found.solver.objective == bare.solver.objective


def test_twenty_metres_a_second_is_refused_with_rows(small_problem: GaitProblem) -> None:
    with pytest.raises(NotSolvedError) as raised:
        synthesize(replace(small_problem, speed=20.0), most_iterations=30)
    rows = raised.value.rows
    assert rows
    assert rows[0].violation == max(row.violation for row in rows) > 1e-3
    assert str(rows[0]) in str(raised.value)
    assert any("node" in row.name or "->" in row.name for row in rows)


def test_a_gait_without_a_mirror_needs_no_more_torque_than_with_one(
    small_problem: GaitProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A trot solved over its whole cycle, two feet landing at once; every mirrored trot is among those it may take."""
    monkeypatch.setenv("AMBLE_COMPILER", "none")  # compiling its blocks takes longer than solving
    gaits = []
    for mirrored in (False, True):
        pattern = gait_pattern(
            small_problem.pattern.robot, (("fr", "rl"), ("fl", "rr")), mirrored, "trot", landing_rule=SIMULTANEOUS
        )
        limits = replace(small_problem.limits, durations={stance.name: (0.1, 0.3) for stance in pattern.solved})
        outputs = joint_outputs(pattern)
        trot = replace(small_problem, pattern=pattern, outputs=outputs, limits=limits, intervals=3)
        gaits.append(synthesize(trot, tolerance=1e-7))
    whole, half = gaits
    assert [len(gait.domains) for gait in gaits] == [2, 1]
    assert all(domain.impulse.size == 6 for domain in whole.domains)
    assert whole.solver.objective <= half.solver.objective * (1.0 + 1e-6)
    report = check(whole, grid=1)
    for kind in EXACT:
        assert report.worst[kind].passed, str(report.worst[kind])


def test_a_start_outside_its_bounds_is_moved_onto_them_and_counted(small_program: GaitProgram) -> None:
    """Three values are put outside; progress, solution and the failure's message say three more than without them."""
    program, generator = small_program, np.random.default_rng(2)
    guess = initial_guess(program.problem, program.layout) / program.layout.scale
    bounded = np.flatnonzero(np.isfinite(program.upper) & (program.lower < program.upper))
    inside = np.clip(guess, program.lower, program.upper)
    outside = inside.copy()
    outside[generator.choice(bounded, 3, replace=False)] += 1e3
    told: list[str] = []
    for start, count in ((inside, 0), (outside, 3)):
        solution = ipopt(program, Start(start), 1e-8, 1, lambda report: told.append(report.detail))
        assert solution.projected == count
        assert told
        said = f", {count} start values moved onto their bounds" if count else ""
        assert all(detail.endswith(said) and ("moved" in detail) == bool(said) for detail in told)
        told.clear()
        error = GaitNotSolvedError(solution, to_gait(program.problem, program.layout, solution))
        assert (f"{count} start values lay outside their bounds" in str(error)) == (count > 0)


def test_an_interrupt_during_the_solve_arrives(small_program: GaitProgram) -> None:
    seen: list[int] = []

    def interrupt(iteration: ProgressReport) -> None:
        assert iteration.done is not None
        seen.append(iteration.done)
        if iteration.done == 2:
            raise KeyboardInterrupt

    start = initial_guess(small_program.problem, small_program.layout) / small_program.layout.scale
    with pytest.raises(KeyboardInterrupt):
        ipopt(small_program, Start(start), progress=interrupt)
    assert seen == [0, 1, 2]


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        ({"speed": 1e3}, InputError, "the speed is 1000.0 m/s"),
        ({"speed": float("nan")}, InputError, "the speed is nan m/s"),
        ({"intervals": 1}, InputError, "from 2 to"),
        ({"gains": (100.0, 0.0)}, InputError, "both must be positive"),
    ],
)
def test_bad_problems(small_problem: GaitProblem, change: dict[str, float], error: type[InputError], says: str) -> None:
    with pytest.raises(error, match=says):
        replace(small_problem, **change)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        ({"durations": {"D1": (0.1, 0.2)}}, InputError, "no bounds for the duration of domain 'D2'"),
        (
            {"durations": {"D1": (0.1, 0.2), "D2": (0.1, 0.2), "D3": (0.1, 0.2)}},
            UnknownNameError,
            "unknown domain 'D3'; known: D1, D2",
        ),
    ],
)
def test_limits_fit_the_pattern(
    small_problem: GaitProblem, change: dict[str, object], error: type[InputError], says: str
) -> None:
    with pytest.raises(error, match=says):
        replace(small_problem, limits=replace(small_problem.limits, **change))  # type: ignore[arg-type]


def test_dropping_a_swing_joint_is_refused_when_the_problem_is_built(small_problem: GaitProblem) -> None:
    with pytest.raises(InputError, match="makes the decoupling matrix singular"):
        synthesize(replace(small_problem, law=DropActuator(("fl_knee",))))


def test_the_rank_is_checked_once_for_all_problems_of_a_structure(
    small_problem: GaitProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Problems that differ in speed share a verdict; one with other equations has its own. A failure is told anew."""
    module = sys.modules["amble.synthesis.synthesize"]
    asked: list[float] = []

    def rank(program: GaitProgram, _: object) -> float:
        asked.append(program.problem.speed)
        if program.problem.speed > 0.3:
            raise NotSolvedError("dependent", ())
        return 1.0

    def solver(*_: object, **__: object) -> Solution:
        raise InputError("asked for")

    monkeypatch.setattr(module, "require_full_rank", rank)
    monkeypatch.setitem(SOLVERS._entries, "none", solver)
    limits = small_problem.limits
    held = replace(limits, touchdown_velocity=((0.0, 0.0), *limits.touchdown_velocity[1:]))

    def solve(error: type[Exception], **changes: object) -> None:
        with pytest.raises(error):
            synthesize(replace(small_problem, **changes), solver="none")

    module._require_full_rank.cache_clear()
    try:
        solve(NotSolvedError, speed=0.31)
        solve(NotSolvedError, speed=0.32)
        solve(InputError, speed=0.2)
        solve(InputError, speed=0.21)
        solve(InputError, speed=0.22, limits=held)
        assert asked == [0.31, 0.32, 0.2, 0.22]
    finally:
        module._require_full_rank.cache_clear()


def test_outputs_that_a_motion_makes_singular_are_chosen_again(caplog: pytest.LogCaptureFixture) -> None:
    """A joint of a leg in the air holds no internal torque. Outputs by default are replaced; those asked for stay."""
    problem = gait_problem(catalogue.astro(), "bound", speed=0.2, intervals=2)
    layout = build_layout(problem)
    start = initial_guess(problem, layout) / layout.scale
    numbers = dict.fromkeys(("iterations", "variables", "constraints"), 0)
    report = SolverReport(solver="none", status="none", seconds=0.0, violation=0.0, objective=0.0, **numbers)
    found = to_gait(problem, layout, Solution(variables=start, multipliers=None, report=report, rows=(), solved=True))
    assert regular_outputs(problem, found) is problem.outputs
    assert not caplog.records
    bad = joint_outputs(problem.pattern, free={"D1": ["rl_hip_pitch"]})
    better = regular_outputs(replace(problem, outputs=bad), found)
    assert better.of("D2") == bad.of("D2")
    (out,) = set(problem.pattern.robot.joint_names) - set(better.of("D1").coordinates)
    assert problem.pattern.robot.legs["fl"].count(out) + problem.pattern.robot.legs["fr"].count(out) == 1
    asked = replace(problem, outputs=bad, outputs_by_default=False)
    assert regular_outputs(asked, found) is bad
    assert re.search(r"in D1 to a share of 0; left out there should be .*free", caplog.text)
