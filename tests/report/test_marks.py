"""Marks in plots: robots to scale, dimensions, notes, end values that never overlap; legends and titles that fit."""

import numpy as np
import pytest
from figure_checks import check_layout, problems
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import numbers, poses, robots

import diffdrive_mj as dd
from diffdrive_mj.report import marks, plots

T = np.linspace(0, 5, 51)
ARC = dd.se2.exp(np.stack([T, 0 * T, 0.3 * T], axis=-1))


@given(robots, poses, numbers(1.0, 10.0))
def test_a_robot_is_drawn_to_scale_at_its_pose(robot, pose, enlarged):
    """Seen from the robot, the wheels are rectangles a track apart, as long as they are high."""
    _, ax = plots.figure("A finding")
    marks.robot_from_above(ax, robot, pose, enlarged=enlarged)
    body, left, right = (patch.get_xy()[:-1] for patch in ax.patches)
    for wheel, side, radius in ((left, 1, robot.left_radius), (right, -1, robot.right_radius)):
        seen = dd.se2.rotate(wheel - np.array(pose[:2]), -pose[2]) / enlarged
        assert seen.mean(axis=0) == pytest.approx((0, side * robot.track_width / 2), abs=1e-9)
        assert np.ptp(seen, axis=0) == pytest.approx((2 * radius, robot.tyres.width))
    seen = dd.se2.rotate(body - np.array(pose[:2]), -pose[2]) / enlarged
    back, front = sorted((robot.caster.x - robot.caster.radius, robot.mean_radius))
    assert seen[:, 0].min() >= back - 1e-9
    assert seen[:, 0].max() > 0
    assert front > 0


def test_a_dimension_joins_two_places_and_names_its_length():
    _, ax = plots.figure("A finding")
    marks.dimension(ax, (1, 0), (1, 8), "8 m")
    arrow, text = ax.texts
    assert (*arrow.xy, *arrow.get_position()) == (1, 8, 1, 0)
    assert text.get_text() == "8 m"
    assert text.xy == (1, 4)


@settings(max_examples=6)
@given(st.lists(numbers(-1.0, 1.0), min_size=1, max_size=5), st.booleans())
def test_end_values_are_in_order_and_never_over_each_other(values, log):
    figure, ax = plots.figure("A finding", size=(8.0, 4.0))
    drawn = [10**value if log else value for value in values]
    plots.errors(
        ax, [0.0, 1.0], {f"curve {k}": [0.0 if not log else 1.0, v] for k, v in enumerate(drawn)}, scale=1, log=log
    )
    ax.get_legend().remove()
    assert [problem for problem in problems(figure) if "overlap" in problem] == []
    heights = [text.xy[1] for text in ax.texts]
    order = np.argsort(drawn, kind="stable")
    assert sorted(heights) == [heights[k] for k in range(len(heights))]
    assert [float(text.get_text()) for text in ax.texts] == pytest.approx([drawn[k] for k in order], rel=0.6, abs=1e-3)


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0, "0"), (0.5, "0.5"), (2156.4, "2156"), (6.56e-6, "7e-06"), (-147.53, "-148"), (1e7, "1e+07")],
)
def test_end_values_are_short(value, shown):
    _, ax = plots.figure("A finding")
    marks.ends(ax, [("black", value)])
    assert ax.texts[0].get_text() == shown


def test_a_legend_below_names_each_curve_once_and_covers_nothing():
    figure, axes = plots.figure("A finding", columns=2)
    for ax in axes:
        plots.errors(ax, T, {"one": T, "other": 2 * T}, name_ends=False)
    plots.legend_below(figure, *axes)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["one", "other"]
    assert all(ax.get_legend() is None for ax in axes)
    check_layout(figure)


def test_a_long_title_is_wrapped():
    figure, ax = plots.figure(
        "A finding of many words that nobody could read in one line of the picture " * 2, columns=2
    )
    for part in ax:
        plots.errors(part, T, {"one": T})
    check_layout(figure)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e4])
def test_a_summary_is_legible_with_nothing_over_the_data(scale):
    wide, turned = ARC * (1 + 0.02 * scale, 1, 1), ARC + np.array([0, 0, 0.1 * scale])
    estimates = {"track too wide": wide, "turned": turned, "true parameters": ARC}
    check_layout(
        plots.summary("What drifts, and how far, where the track is too wide or the start turned?", T, ARC, estimates)
    )
