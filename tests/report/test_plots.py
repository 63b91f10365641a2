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
    drawn = next(line for line in ax.lines if line.get_label() == "one")
    assert np.array_equal(drawn.get_xydata(), ESTIMATES["one"][:, :2])


def test_errors_are_drawn_in_their_unit_with_the_prediction():
    ax = axes()
    values = {label: np.full(51, 0.002) for label in ESTIMATES}
    assert plots.errors(ax, T, values, predicted={"one": np.full(51, 0.003)}) is ax
    heights = {line.get_label(): line.get_ydata()[0] for line in ax.lines}
    assert heights == {"one": 2.0, "other": 2.0, "predicted": 3.0}
    assert "[mm]" in ax.get_ylabel()
    assert "[m]" in ax.get_xlabel()


def test_convergence_is_logarithmic_and_names_the_orders():
    ax = axes()
    rates = np.array([1.0, 10.0, 100.0])
    assert (
        plots.convergence(ax, rates, {"euler": 1 / rates}, orders={"euler": 1.0}, predicted={"euler": 1 / rates}) is ax
    )
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert ax.get_legend_handles_labels()[1][0] == "euler: order 1.00"


def test_a_summary_shows_paths_position_and_heading():
    figure = plots.summary("What drifts?", T, TRUTH, ESTIMATES)
    assert figure.get_suptitle() == "What drifts?"
    assert [ax.get_ylabel() for ax in figure.axes] == ["y [m]", "position error [mm]", "heading error [deg]"]


def test_curves_differ_without_colour():
    looks = [(str(look["linestyle"]), look["marker"]) for look in plots.STYLES]
    assert all(a != b for a, b in itertools.combinations(looks, 2))


def test_plots_refuse_what_is_no_path():
    with pytest.raises(dd.DiffdriveError, match="truth has shape"):
        plots.paths(axes(), T, {})
