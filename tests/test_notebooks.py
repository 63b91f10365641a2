"""In a notebook results show as tables and figures as pictures, whatever robots are called."""

from xml.etree import ElementTree

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj._text import html_table
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.estimation.sensitivities import error_budget
from diffdrive_mj.metrics import drift, stacked
from diffdrive_mj.recording import Recording

NAME = "<script>alert('&')</script>"
ROBOT = dd.Robot(left_radius=0.05, right_radius=0.05, track_width=0.3, name=NAME)
TRUTH = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0)], dtype=float)
OFF = drift(TRUTH, TRUTH + np.array([0, 0.001, 0]))


def recording(robot, truth=TRUTH):
    angles = truth[..., :2] / 0.05
    return Recording(np.arange(3.0), angles, truth, robot, None, dd.World(), dd.Physics())


def calibration():
    return Calibration(
        NAME, ROBOT, ROBOT, (NAME, "track_width"), np.array([0.1, 0.3]), np.diag([1e-6, 4e-6]), np.zeros(1),
        before=OFF, after=stacked([OFF]), warnings=(NAME,), details={NAME: 1.5},
    )  # fmt: skip


def report():
    made, _ = dd.plots.figure("A finding")
    bounds = [dd.report.Bound(NAME, 0.5, 1.0, "mm"), dd.report.Bound("at least", 0.5, 1.0, at_least=True)]
    return dd.report.Report(NAME, NAME, NAME, bounds, pictures={"one": made})


SHOWN = {
    "recording": recording(ROBOT),
    "many runs": recording((ROBOT, ROBOT.replace(name="other")), np.stack([TRUTH, TRUTH])),
    "drift": dd.metrics.Drift(**{**vars(OFF), "warnings": (NAME,)}),
    "calibration": calibration(),
    "report": report(),
    "budget": error_budget(ROBOT),
}


def parsed(html):
    """The document, which must be well formed."""
    return ElementTree.fromstring(f"<div>{html}</div>")


@pytest.mark.parametrize("result", SHOWN.values(), ids=SHOWN)
def test_results_show_as_tables_in_which_names_are_only_names(result):
    html = result._repr_html_()
    document = parsed(html)
    assert document.find(".//table") is not None
    assert document.find(".//script") is None
    assert NAME in "".join(document.itertext())
    assert len(html) < 100_000


def cells(html):
    return [["".join(cell.itertext()) for cell in row] for row in parsed(html).iter("tr")]


def test_what_the_tables_say():
    assert cells(OFF._repr_html_()) == [
        ["distance driven", "2 m", ""],
        ["largest position error", "1 mm", "500 um/m"],
        ["final position error", "1 mm", "500 um/m"],
        ["largest heading error", "0 deg", ""],
        ["final heading error", "0 deg", ""],
    ]
    rows = dict(map(tuple, cells(SHOWN["many runs"]._repr_html_())))
    assert rows == {"robot": f"{NAME}, other", "runs": "2", "samples": "3", "duration": "2 s", "distance driven": "2 m"}
    assert cells(calibration()._repr_html_())[:3] == [
        [NAME, "0.1", "± 0.001"], ["track_width", "0.3", "± 0.002"], ["before", OFF.summary(), ""],
    ]  # fmt: skip
    assert cells(report()._repr_html_())[1:] == [[NAME, "0.5", "≤ 1 mm", "True"], ["at least", "0.5", "≥ 1 ", "False"]]
    assert len(cells(SHOWN["budget"]._repr_html_())) == 1 + 8 + 4


def test_a_recording_says_what_happened():
    sliding = dd.World(patches=(dd.Patch(x=(0.1, 0.6), y=(-1, 1), friction=0.01),))
    robot = dd.Robot.load("mismatched")
    with pytest.warns(dd.errors.PhysicsWarning):
        slipped = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=1.0), world=sliding)
    assert ["warning", slipped.events[0]] in cells(slipped._repr_html_())


def test_a_table_is_escaped_everywhere():
    assert cells(html_table([("<b>", 0.123456)], ("&", "<i>"))) == [["&", "<i>"], ["<b>", "0.1235"]]
    assert "<caption>a &lt; b</caption>" in html_table([], caption="a < b")


def test_figures_show_as_pictures():
    figures = [
        dd.plots.figure("A finding")[0],
        dd.plots.figure("A finding", columns=2)[0],
        dd.plots.summary("A finding", [0, 1, 2], TRUTH, {NAME: TRUTH}),
    ]
    for made in figures:
        assert made._repr_png_().startswith(b"\x89PNG\r\n")
    assert SHOWN["report"]._repr_html_().count("data:image/png;base64,iVBORw0KGgo") == 1
