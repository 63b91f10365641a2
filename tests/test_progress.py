"""Progress on a terminal: how far work has come, of how much and in which unit; nothing is left when it is done."""

import io
import time

from diffdrive_mj import _progress
from diffdrive_mj._progress import progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def terminal(monkeypatch):
    """What a person sees from here on."""
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    return screen


def test_work_of_less_than_two_seconds_shows_nothing(monkeypatch):
    screen = terminal(monkeypatch)
    assert _progress.DELAY == 2.0
    with progress("reading a.csv", 6000, "B") as advance:
        advance(3000)
        advance(3000)
    assert screen.getvalue() == ""


def test_longer_work_is_shown_with_its_total_and_unit_and_goes_away(monkeypatch):
    screen = terminal(monkeypatch)
    monkeypatch.setattr(_progress, "DELAY", 0.0)
    with progress("reading a.csv", 6000, "B") as advance:
        for _ in range(2):
            time.sleep(0.15)  # what follows sooner is not drawn
            advance(1500)
    shown = screen.getvalue()
    assert "reading a.csv" in shown
    assert "/6.00k " in shown
    assert "B/s" in shown
    assert shown.rsplit("\r", 2)[1].strip() == ""
    assert shown.endswith("\r")


def test_work_of_unknown_size_counts_up(monkeypatch):
    screen = terminal(monkeypatch)
    monkeypatch.setattr(_progress, "DELAY", 0.0)
    with progress("waiting", None, "line") as advance:
        time.sleep(0.15)
        advance(1)
    assert "waiting: 1" in screen.getvalue()
