"""A rough fit finds a robot near the believed one and where its marker is, with pushes left out."""

import numpy as np
import pytest
from hypothesis import given
from planted import BELIEVED, ideal, mixed
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.diagnosis._rough_fit import rough_fit
from diffdrive_mj.diagnosis._windows import misfit, motions, windows


def seen_by_a_marker(drive, offset):
    """The drive whose true poses are those of a marker ahead and left of the axle's midpoint."""
    truth = dd.se2.compose(drive.truth, (*offset, 0.0))
    return dd.Drive(drive.t, drive.wheel_angles, truth, drive.clock)


def fitted(drive):
    pairs = windows(drive.clock)
    return rough_fit(drive, BELIEVED, pairs, motions(drive.truth, pairs, BELIEVED))


SHARE = numbers(-0.12, 0.12)


@given(SHARE, SHARE, numbers(0.7, 1.5), numbers(-0.2, 0.2), numbers(-0.2, 0.2))
def test_a_similar_robot_and_a_marker_anywhere_on_it_are_found(left, right, scale, ahead, aside):
    """Of what looked unlike nearly all is explained: wheels an eighth apart, of another size, a marker off the axle."""
    true = BELIEVED.replace(
        left_radius=0.1 * scale * (1 + left), right_radius=0.1 * scale * (1 + right), track_width=0.4 * scale
    )
    drive = seen_by_a_marker(ideal(true, mixed(period=0.05)), (0.4 * ahead, 0.4 * aside))
    assert misfit(*fitted(drive)) < 0.02


def test_wheels_that_are_too_unlike_stay_unexplained():
    """Twice as large as the other is no wheel of a robot near the believed one, nor are wheels of a third."""
    for changes in ({"left_radius": 0.05}, {"right_radius": 0.2}, {"left_radius": 0.03, "right_radius": 0.03}):
        assert misfit(*fitted(ideal(BELIEVED.replace(**changes), mixed(period=0.05)))) > 0.05


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("apart", "explained"), [(0.13, True), (0.2, False)])
def test_neither_wheel_differs_from_their_mean_by_more_than_an_eighth(sign, apart, explained):
    radii = {"left_radius": 0.1 * (1 - sign * apart), "right_radius": 0.1 * (1 + sign * apart)}
    found = misfit(*fitted(ideal(BELIEVED.replace(**radii), mixed(period=0.05))))
    assert found < 0.01 if explained else found > 0.08


def test_a_push_does_not_bend_the_fit():
    """Half a metre in one step: the windows that saw it stay odd, all others fit."""
    true = BELIEVED.replace(left_radius=0.105, right_radius=0.098)
    drive = ideal(true, mixed(period=0.05))
    truth = drive.truth.copy()
    truth[len(truth) // 2 :, :2] += (0.3, -0.4)
    wheels, seen = fitted(dd.Drive(drive.t, drive.wheel_angles, truth))
    gap = np.linalg.norm(wheels - seen, axis=1)
    assert np.count_nonzero(gap > 0.3) == pytest.approx(20, abs=2)
    assert np.median(gap) < 2e-3
    assert np.sort(gap)[-25] < 0.01


def test_a_marker_is_on_the_robot():
    """At most three tenths of the track off the axle; what lies farther is not explained away."""
    near, far = (seen_by_a_marker(ideal(BELIEVED, mixed(period=0.05)), (x, 0.0)) for x in (0.11, 0.6))
    assert misfit(*fitted(near)) < 0.01
    assert misfit(*fitted(far)) > 0.1
