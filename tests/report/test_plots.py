"""Plots: what is drawn, that axes have units, that curves differ without colour."""

import itertools

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.report import plots

T = np.linspace(0, 5, 51)
TRUTH = dd.se2.exp(np.stack([T, 0 * T, 0.3 * T], axis=-1))
ESTIMATES = {"one": TRUTH + np.array([0.01, 0, 0]), "other": TRUTH * (1.02, 1, 1)}


def axes():
    return plots.figure("A finding")[1]


def test_paths_have_equal_aspect_and_mark_start_and_headings():
    ax = axes()
    assert plots.paths(ax, TRUTH, ESTIMATES) is ax
    assert ax.get_aspect() == 1
    labels = ax.get_legend_handles_labels()[1]
    assert set(labels) == {"truth", "one", "other", "start"}
    assert len(ax.texts) == 4  # an arrow for the start and for each of the three ends
    assert ax.get_xlabel() == "x [m]"
    drawn = {line.get_label(): line for line in ax.lines}
    for label, poses in {"truth": TRUTH, **ESTIMATES, "start": TRUTH[:1]}.items():
        assert np.array_equal(drawn[label].get_xydata(), poses[:, :2]), label
    # The truth is the broadest, behind all others.
    assert all(drawn["truth"].get_linewidth() > 3 * drawn[label].get_linewidth() for label in ESTIMATES)
    assert min(drawn.values(), key=lambda line: line.get_zorder()) is drawn["truth"]
    for text, pose in zip(ax.texts, (TRUTH[-1], ESTIMATES["one"][-1], ESTIMATES["other"][-1], TRUTH[0]), strict=True):
        assert text.xy == pytest.approx(pose[:2])
        assert np.arctan2(*text.get_position()[::-1]) == pytest.approx(dd.se2.wrap_angle(pose[2]))


def test_a_map_has_few_ticks_a_pale_grid_behind_and_no_frame_around():
    ax = plots.paths(axes(), TRUTH, ESTIMATES)
    ax.figure.canvas.draw()
    assert max(len(axis.get_major_locator()()) for axis in (ax.xaxis, ax.yaxis)) <= 8
    assert all(line.get_visible() for line in (*ax.get_xgridlines(), *ax.get_ygridlines()))
    assert ax.get_axisbelow() is True
    assert [side for side, spine in ax.spines.items() if spine.get_visible()] == ["left", "bottom"]


def test_without_a_truth_the_first_estimate_starts():
    ax = plots.paths(axes(), None, ESTIMATES)
    drawn = {line.get_label(): line for line in ax.lines}
    assert "truth" not in drawn
    assert np.array_equal(drawn["start"].get_xydata(), ESTIMATES["one"][:1, :2])


def test_errors_are_drawn_in_their_unit_with_the_prediction():
    ax = axes()
    values = {label: np.full(51, 0.002) for label in ESTIMATES}
    assert plots.errors(ax, T, values, predicted={"one": np.full(51, 0.003)}) is ax
    heights = {line.get_label(): line.get_ydata()[0] for line in ax.lines}
    assert heights == {"one": 2.0, "other": 2.0, "predicted": 3.0}
    assert "[mm]" in ax.get_ylabel()
    assert "[m]" in ax.get_xlabel()
    assert [text.get_text() for text in ax.texts] == ["2", "2"]  # the ends are named
    assert all(line.get_linestyle() == ":" for line in ax.lines if line.get_label() == "predicted")
    # The curves fill the width, but for a little at the ends.
    (low, high), span = ax.get_xlim(), np.ptp(T)
    assert 0 < T[0] - low < 0.04 * span
    assert 0 < high - T[-1] < 0.04 * span


def test_ends_are_left_unnamed_and_errors_drawn_over_powers_of_ten_on_request():
    ax = plots.errors(axes(), T, {"one": 1 + T}, scale=180 / np.pi, log=True, name_ends=False)
    assert len(ax.texts) == 0
    assert ax.get_yscale() == "log"
    assert ax.lines[0].get_ydata() == pytest.approx(np.degrees(1 + T))


def test_convergence_is_logarithmic_and_names_the_orders():
    ax = axes()
    rates = np.array([1.0, 10.0, 100.0])
    assert (
        plots.convergence(ax, rates, {"euler": 1 / rates}, orders={"euler": 1.0}, predicted={"euler": 1 / rates}) is ax
    )
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert ax.get_legend_handles_labels()[1] == ["euler: order 1.00", "predicted"]
    for line in ax.lines:
        assert np.allclose(line.get_xydata(), np.stack([rates, 1e3 / rates], axis=-1))


def test_a_summary_shows_paths_position_and_heading():
    figure = plots.summary("What drifts?", T, TRUTH, ESTIMATES)
    assert figure.get_suptitle() == "What drifts?"
    assert [ax.get_ylabel() for ax in figure.axes] == ["y [m]", "position error [mm]", "heading error [deg]"]
    _, position, heading = figure.axes
    turned = plots.summary("", T, TRUTH, {"turned": TRUTH + np.array([0.003, 0.004, 0.01])}).axes
    assert turned[1].lines[0].get_xydata()[-1] == pytest.approx((5.0, 5.0), rel=1e-3)  # 5 mm at the end of 5 m
    assert turned[2].lines[0].get_xydata()[-1] == pytest.approx((T[-1], np.degrees(0.01)))
    assert (position.get_xlabel(), heading.get_xlabel()) == ("distance driven [m]", "time [s]")


def test_curves_differ_without_colour():
    looks = [(str(look["linestyle"]), look["marker"]) for look in plots.STYLES]
    assert all(a != b for a, b in itertools.combinations(looks, 2))


def test_plots_refuse_what_is_no_path():
    with pytest.raises(dd.DiffdriveError, match="truth has shape"):
        plots.paths(axes(), T, {})
