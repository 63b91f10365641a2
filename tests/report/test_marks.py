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
    # The body lies between the wheels, as long as the way from ahead of the axle to the far side of the caster.
    room = robot.track_width / 2 - robot.tyres.width / 2
    assert np.abs(seen[:, 1]).max() <= room
    assert seen[:, 1] == pytest.approx(-seen[[3, 2, 1, 0, 4], 1])
    far = robot.caster.x + np.copysign(robot.caster.radius, robot.caster.x)
    assert seen[1:3, 0] == pytest.approx(far)
    assert seen[:, 0].max() == pytest.approx(1.08 * robot.mean_radius)  # the nose


def test_a_robot_is_drawn_as_large_as_it_is_unless_enlarged():
    _, ax = plots.figure("A finding")
    robot = dd.Robot.load("matched")
    marks.robot_from_above(ax, robot, (0.0, 0.0, 0.0))
    _, left, right = (patch.get_xy()[:-1].mean(axis=0) for patch in ax.patches)
    assert left - right == pytest.approx((0, robot.track_width))


def test_the_wheels_have_the_robots_colour_and_the_body_is_outlined_in_it():
    _, ax = plots.figure("A finding")
    marks.robot_from_above(ax, dd.Robot.load("matched"), (0.0, 0.0, 0.0), color="red")
    body, *wheels = ax.patches
    red, white = (1, 0, 0, 1), (1, 1, 1, 1)
    assert (body.get_edgecolor(), body.get_facecolor()) == (red, white)
    assert [(wheel.get_edgecolor(), wheel.get_facecolor()) for wheel in wheels] == [(red, red)] * 2
    assert {patch.get_zorder() for patch in ax.patches} == {5}  # over paths


def test_a_heading_is_an_arrow_of_one_length_on_paper():
    _, ax = plots.figure("A finding")
    for scale, theta in ((1.0, 0.5), (100.0, 2.5)):
        ax.set_xlim(0, scale)
        marks.heading(ax, (scale / 2, 0.5, theta), "black")
        arrow = ax.texts[-1]
        ax.figure.canvas.draw()
        head, tail = arrow.get_position(), arrow.xy
        assert np.hypot(*head) == pytest.approx(22)
        assert np.arctan2(head[1], head[0]) == pytest.approx(theta)
        assert tail == (scale / 2, 0.5)
        assert arrow.get_anncoords() == "offset points"


def test_a_dimension_joins_two_places_and_names_its_length():
    _, ax = plots.figure("A finding")
    marks.dimension(ax, (1, 0), (1, 8), "8 m")
    arrow, text = ax.texts
    assert (*arrow.xy, *arrow.get_position()) == (1, 8, 1, 0)
    assert text.get_text() == "8 m"
    assert text.xy == (1, 4)
    assert arrow.arrowprops["arrowstyle"] == "<|-|>"


@pytest.mark.parametrize(("side", "right", "up"), [("right", 1, 0), ("left", -1, 0), ("above", 0, 1)])
def test_a_measure_stands_beside_its_line(side, right, up):
    figure, ax = plots.figure("A finding")
    ax.set(xlim=(0, 2), ylim=(0, 2))
    marks.dimension(ax, (1, 1), (1, 1), "8 m", side=side)
    figure.canvas.draw()
    box, (x, y) = ax.texts[-1].get_window_extent(), ax.transData.transform((1, 1))
    assert np.sign([box.x0 - x, box.x1 - x]).sum() / 2 == right
    assert np.sign([box.y0 - y, box.y1 - y]).sum() / 2 == up
    if not up:
        assert (box.y0 + box.y1) / 2 == pytest.approx(y, abs=2)
    if not right:
        assert (box.x0 + box.x1) / 2 == pytest.approx(x, abs=0.5)


def test_a_note_stands_at_its_place_or_beside_it():
    figure, ax = plots.figure("A finding")
    ax.set(xlim=(0, 2), ylim=(0, 2))
    figure.canvas.draw()
    for offset in ((0, 0), (12, -30)):
        marks.note(ax, "here", (1, 1), *([offset] if any(offset) else []), color="red")
        figure.canvas.draw()
        box, place = ax.texts[-1].get_window_extent(), ax.transData.transform((1, 1))
        moved = (np.array((box.x0, box.y0)) - place) * 72 / figure.dpi
        assert moved == pytest.approx(offset, abs=4)  # but for the letters' own bearing
        assert ax.texts[-1].get_color() == "red"


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


@pytest.mark.parametrize(("value", "height"), [(0.25, 0.25), (0.8, 0.8), (-0.5, 0.0), (1.5, 1.0)])
def test_an_end_value_is_as_high_as_its_curve_and_within_the_axes(value, height):
    _, ax = plots.figure("A finding")
    ax.set_ylim(0, 1)
    marks.ends(ax, [("black", value)])
    assert ax.texts[0].xy[1] == pytest.approx(height)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (0.5, "0.5"),
        (0.001, "0.001"),
        (0.0012, "0.0012"),
        (999.0, "999"),
        (1000.0, "1000"),
        (2156.4, "2156"),
        (6.56e-6, "7e-06"),
        (-147.53, "-148"),
        (1e7, "1e+07"),
    ],
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
