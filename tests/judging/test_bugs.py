"""The museum of bugs and other wrong odometries: the suite fails each, and says why."""

import re

import pytest
from other_odometries import ONE, TWO, UNKNOWN

import diffdrive_mj as dd
from diffdrive_mj.errors import CandidateFailed
from diffdrive_mj.judging.bugs import MUSEUM
from diffdrive_mj.judging.candidates import poses_of
from diffdrive_mj.judging.causes import distance_between
from diffdrive_mj.judging.suite import cases

REASONS = {
    "TurnsTheWrongWay": "it turns clockwise where the wheels turn it counter-clockwise",
    "YInverted": "y grows to the right: it grows to the left",
    "TurnIsARate": "a step's turn is its yaw rate: multiply it by the time between readings",
    "StepIsASpeed": "steps are speeds: multiply them by the time between readings",
    "SmallAngles": "a turn is its arc tangent, a formula for small angles",
    "WheelsSwapped": "left and right are swapped",
    "OneWheelForBoth": "the right wheel is read for both",
    "OneWheelForTheRobot": "the way of the right wheel is taken for the robot's: take the mean",
    "WholeDegrees": "each turn is cut to whole degrees: keep the rest",
    "StartForgotten": "the start pose is forgotten: begin at x, y and theta of the header",
    "Euler": "steps are taken along the heading before them (Euler): use the exact arc",
    "Midpoint": "steps are chords as long as their arcs (midpoint): use the exact arc",
    "ArcWithThreshold": "rad and less are driven straight on: the chord is",
    "ArcWithoutThreshold": "rad and less are lost in rounding, divided by their turn: the chord is",
    "HeadingNotCarried": "the heading is not carried from step to step: add each turn to it",
    "MeanOfHeadings": "headings on both sides of 180 degrees are averaged",
    "SinglePrecision": "the answers are in single precision: add up in double precision",
    "DiameterForRadius": "wheels roll 2 times the right way (diameters for radii)",
    "SumForMean": "distances are 2 times the right ones (a sum where the mean belongs)",
    "DividesByPi": "wheels roll 0.3183 times the right way (pi is missing)",
    "TrackMissing": "times the right ones (the track width is missing)",
    "OneRadiusForBoth": "both wheels are taken for the left one: their radii differ",
    "WrapForwardsOnly": "wraps are undone forwards only: take steps modulo 2^16, from -2^15 on",
    "WrapNotUndone": "wraps of the counter are not undone: take steps modulo 2^16, from -2^15 on",
    # Undone at 32 bits, those of 16 are not undone.
    "WrapAtTheWrongWidth": "wraps of the counter are not undone: take steps modulo 2^16, from -2^15 on",
    "EightBits": "counts are kept in 8 bits, unsigned: keep all of their bits",
    "WholeTurns": "cut to whole turns (integer division): keep the fraction",
    "WholeTicksPerTurn": "the ticks of a turn are cut to a whole number: keep the fraction",
    "FirstReadingIsMotion": "the first reading is taken for motion since zero: it is where the wheels begin",
    "StampOfZero": "the first step is timed from a stamp of zero: time it from the first reading",
    "NanSwallowed": "a reading that does not count is taken in (it is not a number): hold the pose",
    "NanForgets": "the motion across readings that do not count is lost: hold the pose",
    "ZeroPeriodDropsMotion": "the motion of readings at the time of the one before is lost: hold the pose",
    "LateReadingsTakenIn": "readings are taken in whose time is not later than that of the last one: hold the pose",
    "ReadingLate": "each pose is that of the reading before: take a reading in, then answer",
    "NominalPeriod": "a fixed period of 0.05 s is taken for the time between readings",
}
# Few and short ones, on which every fault shows; all of them take a minute.
SHORT = (
    "first_reading", "unequal_straight", "across_180", "ten_hertz", "steps", "geared_ticks", "wrap_16_backwards",
    "wrap_16_fast", "jitter", "zero_dt", "reversed_time", "nan",
)  # fmt: skip
ALL = cases()
FEW = [case for case in ALL if case.name in SHORT]
OTHERS = [case for case in (*FEW[::-1], *ALL) if case.name in ("missing", "jitter", *SHORT[2:])]
PAIR = [case for case in ALL if case.name in ("ten_hertz", "wrap_16_backwards")]


def passes(candidate, case):
    try:
        return distance_between(case, poses_of(candidate, case), case.poses) <= case.tolerance
    except CandidateFailed:
        return False


def failed_by(candidate, cases, most=6):
    """The first cases that fail it."""
    return [case for case in cases if not passes(candidate, case)][:most]


def test_the_museum_is_large_and_each_piece_has_its_reason():
    assert len(MUSEUM) >= 22
    assert MUSEUM.keys() == REASONS.keys()


@pytest.mark.parametrize("name", MUSEUM)
def test_the_suite_fails_every_piece_of_the_museum(name):
    failed = [case.name for case in ALL if not passes(MUSEUM[name], case)]
    assert failed
    # And the few that reasons are tested on show it, too.
    assert {*failed} & {*SHORT}


@pytest.mark.parametrize("name", MUSEUM)
def test_every_piece_says_what_it_is_and_names_threads_in_full(name):
    words = MUSEUM[name].__doc__
    assert re.match(r"[A-Z][a-z]+ [^\n]*\.(\n|$)", words)
    assert "#" not in re.sub(r"[\w-]+/[\w-]+ #\d+(, #\d+)*", "", words)


@pytest.mark.parametrize("name", MUSEUM)
def test_the_verdict_names_the_fault(name):
    verdict = dd.judge(MUSEUM[name], failed_by(MUSEUM[name], FEW))
    assert REASONS[name] in verdict.reason
    assert REASONS[name] in str(verdict)


@pytest.mark.slow
@pytest.mark.parametrize("name", MUSEUM)
def test_on_the_whole_suite_nearly_every_drive_names_the_fault(name):
    verdict = dd.judge(MUSEUM[name], ALL)
    failed = [row for row in verdict.rows if not row.holds]
    named = [row for row in failed if REASONS[name].replace("2^16", "2^32").replace("2^15", "2^31") in row.reason
             or REASONS[name] in row.reason]  # fmt: skip
    assert len(named) >= 0.9 * len(failed) - 1


@pytest.mark.parametrize("name", ONE)
def test_the_faults_of_others_are_named(name):
    candidate, words = ONE[name]
    verdict = dd.judge(candidate, failed_by(candidate, OTHERS))
    assert words in verdict.reason


@pytest.mark.parametrize("name", TWO)
def test_two_faults_at_once_are_both_named(name):
    candidate, words = TWO[name]
    verdict = dd.judge(candidate, PAIR)
    assert not verdict.holds
    assert all(word in verdict.reason for word in words), verdict.reason


@pytest.mark.parametrize("name", UNKNOWN)
def test_of_what_no_table_has_nothing_is_said(name):
    verdict = dd.judge(UNKNOWN[name], PAIR)
    assert not verdict.holds
    assert verdict.reason == ""
