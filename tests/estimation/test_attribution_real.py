"""The errors of a real robot split among its causes; skipped where its recordings are not."""

import numpy as np
import pytest
from real_data import optiodom_folder

import diffdrive_mj as dd
from diffdrive_mj.estimation.attribution import RATIO, REST, SCALE, TRACK
from diffdrive_mj.judging import optiodom

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def recordings():
    return optiodom.read_recordings(optiodom_folder())


def test_parts_add_up_and_the_rest_is_what_the_reference_leaves(recordings):
    nominal, reference = dd.Robot.load("optiodom"), optiodom.fit(recordings[optiodom.FREE])
    for drive in (drive for drives in recordings.values() for drive in drives):
        found = dd.attribute(drive, nominal, true=reference)
        assert set(found.causes) == {SCALE, RATIO, TRACK, REST}
        np.testing.assert_allclose(found.parts.sum(axis=0), found.error, atol=1e-12)
        assert np.hypot(*found.error[:2]) == pytest.approx(drive.drift(nominal).final_position, abs=1e-12)
        rest = found.sizes[found.causes.index(REST)]
        assert rest == pytest.approx(drive.drift(reference).final_position, abs=1e-12)


def test_a_reference_from_other_recordings_explains_more_than_it_leaves(recordings):
    for name, found in optiodom.explained(recordings).items():
        rest, parameters = (
            np.median([np.hypot(*sum(each.parts[each.causes.index(cause)] for cause in causes)[:2]) for each in found])
            for causes in ((REST,), (SCALE, RATIO, TRACK))
        )
        assert rest < parameters, name
