"""Figures by content: what is drawn, where, with which labels."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amble.analysis import Motion, Samples, samples_of_gait, samples_of_trace, torque_metrics
from amble.control.actuator import PAPER
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.report.figures import (
    base_portraits,
    contact_forces,
    cycle_portraits,
    foot_paths,
    footfall,
    joint_portraits,
    joint_power,
    left_joints,
    multiplier_circle,
    save,
    section_distance,
    survival,
    torque_lines,
    torque_magnitudes,
    torque_speed,
)
from amble.report.figures.portraits import axis_labels, chosen_cycles
from amble.report.figures.style import plain_text, with_gaps
from amble.types import Vector
from tests.hostile import allowed, hostile_name
from tests.synthetic import DURATIONS, PERIOD, amble_pattern, synthetic_gait, synthetic_trace


@pytest.fixture(scope="module")
def optimised() -> Samples:
    return samples_of_gait(synthetic_gait())


@pytest.fixture(scope="module")
def simulated() -> Samples:
    return samples_of_trace(synthetic_trace(6), amble_pattern())


@pytest.fixture(scope="module")
def two_cycles() -> Motion:
    samples = samples_of_gait(synthetic_gait(), cycles=2)
    return samples.motion({"drop": 1.25 * samples.torques, "pinv": samples.torques})


def finite(line: Line2D) -> np.ndarray:
    points = np.column_stack(line.get_data())
    return points[np.all(np.isfinite(points), axis=1)]


def test_base_portraits_draw_both_motions_and_the_initial_value(optimised: Samples, simulated: Samples) -> None:
    figure = base_portraits(optimised, simulated)
    assert len(figure.axes) == 4
    for axes, name in zip(figure.axes, ("z", "roll", "pitch", "yaw"), strict=True):
        solid, dashed, dot = axes.lines
        for line, samples in ((solid, optimised), (dashed, simulated)):
            assert np.allclose(finite(line), np.column_stack(samples.coordinate(name)))
        assert finite(dot).tolist() == [[each[0] for each in simulated.coordinate(name)]]
        assert dot.get_color() == "#CC0000"
        assert (dashed.get_linestyle(), dot.get_marker()) == ("--", "o")
    assert figure.axes[0].get_xlabel() == "$z$ (m)"
    assert figure.axes[0].get_ylabel() == r"$\dot{z}$ (m/s)"
    assert figure.axes[3].get_ylabel() == r"$\dot{\psi}$ (rad/s)"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["optimised", "simulated", "initial value"]


def test_no_line_runs_across_an_impact(optimised: Samples) -> None:
    figure = base_portraits(optimised, optimised)
    drawn = figure.axes[0].lines[0].get_xdata()
    assert np.sum(np.isnan(drawn)) == 3  # four domains


def test_gaps() -> None:
    first, second = with_gaps(np.array([0, 0, 1, 2, 2]), np.arange(5.0), np.arange(5))
    assert np.array_equal(first, [0, 1, np.nan, 2, np.nan, 3, 4], equal_nan=True)
    assert np.array_equal(first, second, equal_nan=True)


def test_joint_portraits_show_every_joint_once(optimised: Samples, simulated: Samples) -> None:
    figure = joint_portraits(optimised, simulated)
    labels = [axes.get_xlabel() for axes in figure.axes]
    assert sorted(labels) == sorted(f"{name.replace('_', ' ')} (rad)" for name in optimised.robot.joint_names)
    axes = figure.axes[labels.index("rl hip pitch (rad)")]
    assert np.allclose(finite(axes.lines[0]), np.column_stack(optimised.coordinate("rl_hip_pitch")))


def test_footfall_bars_are_the_stance_phases() -> None:
    pattern = amble_pattern()
    axes = footfall(pattern, DURATIONS).axes[0]
    bars = sorted((round(bar.get_y() + 0.31), bar.get_x(), bar.get_width()) for bar in axes.patches)
    edges = np.concatenate([[0.0], np.cumsum(DURATIONS * 2)])
    expected = sorted(
        (row, edges[number], (DURATIONS * 2)[number])
        for row, foot in enumerate(pattern.robot.foot_names)
        for number, stance in enumerate(pattern.stances)
        if foot in stance.feet
    )
    assert np.allclose(bars, expected)
    assert [label.get_text() for label in axes.get_yticklabels()] == list(pattern.robot.foot_names)
    assert axes.get_xlim() == pytest.approx((0.0, PERIOD))
    with pytest.raises(InputError, match="3 durations"):
        footfall(pattern, [0.1, 0.1, 0.1])


def test_torque_magnitudes_of_both_laws(two_cycles: Motion) -> None:
    joints = left_joints(amble_pattern().robot)
    assert joints == ("fl_hip_yaw", "fl_hip_pitch", "fl_knee", "rl_hip_yaw", "rl_hip_pitch", "rl_knee")
    figure = torque_magnitudes(two_cycles, joints)
    assert [axes.get_title() for axes in figure.axes] == [name.replace("_", " ") for name in joints]
    for axes, joint in zip(figure.axes, joints, strict=True):
        drop, pinv = axes.lines
        expected = np.abs(two_cycles.torques["pinv"][:, two_cycles.joints.index(joint)])
        assert np.allclose(finite(pinv)[:, 1], expected)
        assert np.allclose(finite(drop)[:, 1], 1.25 * expected)
        assert axes.get_xlim() == pytest.approx((0.0, 2.0 * PERIOD))
        assert axes.get_ylim()[0] == 0.0
    assert figure.axes[0].get_ylabel() == r"$|\tau|$ (N m)"
    assert figure.axes[5].get_xlabel() == "time (s)"
    assert "Ma et al. 2019" in figure.legends[0].get_texts()[0].get_text()
    with pytest.raises(UnknownNameError, match="unknown joint 'elbow'"):
        torque_magnitudes(two_cycles, ["elbow"])


def test_torque_lines_keep_the_sign_and_name_every_law(two_cycles: Motion) -> None:
    laws = {name: two_cycles.torques["pinv"] * (k + 1) for k, name in enumerate("abcdefg")}
    motion = Motion(
        label="nominal",
        joints=two_cycles.joints,
        times=two_cycles.times,
        segments=two_cycles.segments,
        speeds=two_cycles.speeds,
        torques=laws,
        distance=two_cycles.distance,
        mass=two_cycles.mass,
        gravity=two_cycles.gravity,
    )
    figure = torque_lines(motion, ["fl_knee", "rl_knee"])
    lines = figure.axes[0].lines
    assert len({(line.get_color(), str(line._dash_pattern)) for line in lines}) == 7
    assert finite(lines[0])[:, 1].min() < 0.0
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list("abcdefg")


def test_multipliers_and_their_radii() -> None:
    before = np.array([17.0, -0.3 + 0.4j, -0.3 - 0.4j])
    after = np.array([0.44, 0.1j, -0.1j])
    whole, near = multiplier_circle(before, after).axes
    for axes in (whole, near):
        circle, crosses, dots = axes.lines
        assert np.allclose(np.hypot(*circle.get_data()), 1.0)
        assert np.allclose(crosses.get_xdata() + 1j * crosses.get_ydata(), before)
        assert np.allclose(dots.get_xdata() + 1j * dots.get_ydata(), after)
        assert axes.get_aspect() == 1.0
    assert whole.get_xlim()[1] > 17.0
    assert near.get_title() == "near the unit circle (1 of the initial ones lie outside)"
    assert "17" in crosses.get_label()
    assert "0.44" in dots.get_label()


def test_section_distance_on_a_log_axis() -> None:
    distances = np.maximum(1e-3 * 0.4 ** np.arange(101), 1e-11)
    distances[50] = 0.0
    axes, approach = section_distance(distances, 0.4).axes
    assert 20.0 < approach.get_xlim()[1] < 35.0  # 0.4^k reaches 1e-8 at k = 20
    dots, line = axes.lines
    assert axes.get_yscale() == "log"
    assert finite(dots)[:, 0].tolist() == [k for k in range(101) if k != 50]
    assert np.allclose(line.get_ydata(), 1e-3 * 0.4 ** line.get_xdata())
    assert 1e-12 < line.get_ydata()[-1] < 1e-10
    with pytest.raises(InputError, match="nothing to draw"):
        section_distance(np.zeros(4), 0.4)


def test_cycle_portraits_show_first_and_last(simulated: Samples) -> None:
    figure = cycle_portraits(simulated, shown=3)
    lines = figure.axes[1].lines
    assert len(lines) == 3 + 1  # three cycles and the initial value
    for line, cycle in ((lines[0], 0), (lines[2], 5)):
        assert np.allclose(finite(line), np.column_stack(simulated.only(cycle, cycle + 1).coordinate("roll")))


def test_chosen_cycles() -> None:
    found = chosen_cycles(0, 499, 24)
    assert (found[0], found[-1]) == (0, 499)
    assert 18 <= len(found) <= 24
    assert np.all(np.diff(found) > 0)
    assert chosen_cycles(3, 3, 24).tolist() == [3]


def test_saved_files_are_png_and_pdf_and_reproducible(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        figure = footfall(amble_pattern(), DURATIONS)
        png, pdf = save(figure, tmp_path / folder / "foot.fall")
        assert png.read_bytes().startswith(b"\x89PNG")
        assert pdf.read_bytes().startswith(b"%PDF")
        assert (png.name, pdf.name) == ("foot.fall.png", "foot.fall.pdf")
    for name in ("foot.fall.png", "foot.fall.pdf"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    from matplotlib.image import imread

    # 3.5 inch at 200 dpi
    assert imread(tmp_path / "a" / "foot.fall.png").shape[1] == 700


def test_drawing_leaves_the_settings_of_others_alone(optimised: Samples) -> None:
    import matplotlib as mpl

    before = mpl.rcParams["font.size"]
    base_portraits(optimised, optimised)
    assert mpl.rcParams["font.size"] == before


def test_any_name_is_drawn_as_it_is(tmp_path: Path) -> None:
    r"""A foot called ``$\frac$`` was read as a formula, and ended the report with a traceback."""
    from matplotlib.cbook import is_math_text

    random = np.random.default_rng(10)
    for name in ["$\\frac$", "a$b", "\\$", *filter(allowed, (hostile_name(random) for _ in range(300)))]:
        shown = plain_text(name)
        assert not is_math_text(shown)
        assert shown.replace(r"\$", "$") == name  # what matplotlib makes of text that is no formula
    pattern = amble_pattern()
    robot = pattern.robot
    first = robot.foot_names[0]
    feet = (replace(robot.feet[0], name="$\\frac$"), *robot.feet[1:])
    twins = tuple(tuple("$\\frac$" if foot == first else foot for foot in pair) for pair in robot.twins)
    stances = tuple(
        replace(stance, feet=tuple("$\\frac$" if foot == first else foot for foot in stance.feet))
        for stance in pattern.stances
    )
    changed = replace(pattern, robot=replace(robot, feet=feet, twins=twins), stances=stances)
    save(footfall(changed, DURATIONS), tmp_path / "footfall")
    assert axis_labels("$\\frac_a$")[0] == r"\$\frac a\$ (rad)"


def test_foot_paths_touch_the_ground_where_feet_stand(stabilised_gait: Gait) -> None:
    samples = samples_of_gait(stabilised_gait)
    (axes,) = foot_paths(samples).axes
    lines = axes.lines[: len(samples.robot.feet)]
    assert [line.get_label() for line in lines] == list(samples.robot.foot_names)
    for line in lines:
        heights = finite(line)[:, 1]  # mm
        assert abs(heights.min()) < 1.0
        assert heights.max() > 10.0


def test_contact_forces_stay_below_what_the_cone_allows(stabilised_gait: Gait) -> None:
    samples = samples_of_gait(stabilised_gait)
    figure = contact_forces(samples)
    assert [axes.get_title() for axes in figure.axes] == list(samples.robot.foot_names)
    summed = np.zeros(len(samples.times))
    for axes in figure.axes:
        normal, allowed, tangential = (finite(line)[:, 1] for line in axes.lines)
        assert np.all(tangential <= allowed + 1e-6)
        np.testing.assert_allclose(allowed, 0.6 * normal)
        summed += normal
    np.testing.assert_allclose(summed, samples.forces.reshape(len(summed), -1, 3)[:, :, 2].sum(axis=1))


def test_torque_against_speed_shows_the_limits_that_come_near(two_cycles: Motion) -> None:
    robot = amble_pattern().robot
    names = left_joints(robot)[:2]
    largest = float(np.abs(two_cycles.torques["drop"][:, two_cycles.joints.index(names[0])]).max())
    near = replace(
        robot,
        joints=tuple(
            replace(j, effort=0.9 * largest if j.name == names[0] else 1e6, velocity=1e6) for j in robot.joints
        ),
    )
    first, second = torque_speed(two_cycles, near, names).axes[:2]
    assert len(first.lines) in (3, 4)  # two laws, and the limit on the side or sides that the motion reaches
    assert len(second.lines) == 2
    np.testing.assert_allclose(
        finite(first.lines[1])[:, 1], two_cycles.torques["pinv"][:, two_cycles.joints.index(names[0])]
    )
    with pytest.raises(UnknownNameError, match="tail"):
        torque_speed(two_cycles, robot, ["tail"])


def test_bars_of_power_add_up_to_the_metrics(two_cycles: Motion) -> None:
    """The table integrates by splines; trapezia on this mesh agree to a percent."""
    (axes,) = joint_power(two_cycles, "pinv", PAPER).axes
    bars: list[Any] = list(axes.patches)
    heights = [bar.get_height() for bar in bars]
    count = len(two_cycles.joints)
    metrics = torque_metrics(two_cycles, "pinv", PAPER)
    assert sum(heights[:count]) == pytest.approx(metrics.mechanical_power, rel=0.01)
    assert sum(heights[count:]) == pytest.approx(metrics.heat_power, rel=0.01)


def test_survival_is_the_share_that_completed_so_many_cycles() -> None:
    figure = survival({"0.01": [4, 0, 2, 4], "0.1": [1]}, cycles=4)
    first, second = figure.axes[0].lines
    assert list(first.get_ydata()) == [100.0, 75.0, 75.0, 50.0, 50.0]
    assert list(second.get_ydata()) == [100.0, 100.0, 0.0, 0.0, 0.0]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["0.01 (4)", "0.1 (1)"]


@pytest.mark.parametrize("walks", [{}, {"none": []}, {"more": [5]}, {"less": [-1]}])
def test_walks_that_make_no_curve_are_refused(walks: dict[str, list[int]]) -> None:
    with pytest.raises(InputError):
        survival(walks, cycles=4)


def test_every_figure_function_draws_into_a_given_figure(
    optimised: Samples, simulated: Samples, two_cycles: Motion
) -> None:
    robot, multipliers = optimised.robot, np.array([0.5 + 0.1j])
    draws: list[Callable[[Figure], Figure]] = [
        lambda own: base_portraits(optimised, simulated, figure=own),
        lambda own: joint_portraits(optimised, simulated, figure=own),
        lambda own: cycle_portraits(simulated, figure=own),
        lambda own: footfall(optimised.pattern, DURATIONS, figure=own),
        lambda own: contact_forces(optimised, figure=own),
        lambda own: foot_paths(optimised, figure=own),
        lambda own: joint_power(two_cycles, "pinv", PAPER, figure=own),
        lambda own: torque_speed(two_cycles, robot, left_joints(robot), figure=own),
        lambda own: torque_lines(two_cycles, left_joints(robot), figure=own),
        lambda own: torque_magnitudes(two_cycles, left_joints(robot), figure=own),
        lambda own: multiplier_circle(multipliers, multipliers, figure=own),
        lambda own: section_distance(np.array([1.0, 0.1]), 0.1, figure=own),
        lambda own: survival({"all": [1]}, 1, figure=own),
    ]
    for draw in draws:
        own = Figure(figsize=(5.0, 4.0))
        assert draw(own) is own
        assert own.axes
        assert own.get_size_inches().tolist() == [5.0, 4.0]


@pytest.mark.parametrize("values", [np.array([1e300, 1.0]), np.full(2, np.inf), np.ones(200_001)])
def test_what_cannot_be_drawn_is_a_sentence(values: Vector) -> None:
    """Of an earlier results.json that says so; the first ended in matplotlib with an OverflowError."""
    with pytest.raises(InputError, match="cannot be drawn"):
        section_distance(values, 0.4)
    for pair in ((values, values[:1]), (np.ones(1), values)):
        with pytest.raises(InputError, match="cannot be drawn"):
            multiplier_circle(pair[0] + 0j, pair[1] + 0j)


def test_a_radius_of_any_size_is_drawn() -> None:
    for radius in (1e308, -1e308, 0.0):
        _, predicted = section_distance(np.geomspace(1.0, 1e-8, 40), radius).axes[0].get_lines()
        assert np.all(np.isfinite(predicted.get_ydata()))
