"""Signals that end programs, held back while something starts that must be ended with them."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_ENDING = ("SIGINT", "SIGTERM", "SIGHUP")


@contextmanager
def held() -> Iterator[Callable[[], None]]:
    """Hold back the signals that would raise an exception here, until the function that is given is called.

    Between a process that has been started and the `try` that ends it no exception may come:

        with held() as let_go:
            process = subprocess.Popen(...)
            try:
                let_go()
                ...
            finally:
                process.kill()
    """
    came: list[int] = []
    earlier = {}
    if threading.current_thread() is threading.main_thread():  # the others are told of no signals
        for number in (getattr(signal, name) for name in _ENDING if hasattr(signal, name)):
            if callable(handler := signal.getsignal(number)):
                earlier[number] = handler
                signal.signal(number, lambda number, _: came.append(number))

    def let_go() -> None:
        while earlier:
            signal.signal(*earlier.popitem())
        while came:
            signal.raise_signal(came.pop())

    try:
        yield let_go
    finally:
        let_go()
