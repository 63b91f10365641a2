"""Signals that come while something starts are kept until it can be ended."""

import os
import signal
import threading

import pytest

from diffdrive_mj._signals import held

pytestmark = pytest.mark.skipif(os.name == "nt", reason="no such signals")


@pytest.fixture
def raises():
    """SIGTERM raises here, as in the program."""

    def end(number, _):
        raise SystemExit(128 + number)

    earlier = signal.signal(signal.SIGTERM, end)
    yield
    signal.signal(signal.SIGTERM, earlier)


def test_a_signal_waits_until_it_is_let_go(raises):
    seen = []

    def start():
        with held() as let_go:
            signal.raise_signal(signal.SIGTERM)
            seen.append("started")
            try:
                let_go()
                seen.append("never")
            finally:
                seen.append("ended")

    with pytest.raises(SystemExit) as ended:
        start()
    assert seen == ["started", "ended"]
    assert ended.value.code == 143


def test_a_signal_is_not_lost_where_the_start_fails(raises):
    def start():
        with held():
            signal.raise_signal(signal.SIGTERM)
            raise OSError

    with pytest.raises(SystemExit):
        start()


def test_afterwards_all_is_as_before(raises):
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    with held():
        assert signal.getsignal(signal.SIGTERM) is not before[1]
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before


def test_other_threads_are_left_alone():
    failed = []

    def work():
        try:
            with held() as let_go:
                let_go()
        except ValueError as error:  # signal only works in main thread
            failed.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert not failed
