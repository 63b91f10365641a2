"""A program that answers lines on a pipe: it may hang, die or chatter, and leaves nothing behind."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import IO

from diffdrive_mj._signals import held

# What a program may write for each answer [bytes], and of its standard error is kept.
_ANSWER, _SAID = 200, 2000
# How long a program that was told to end may take [s].
_GRACE = 1.0


class Talk:
    """What a program answered to some lines, and how it ended.

    Attributes:
        answer: its standard output.
        said: the end of its standard error.
        status: its exit status; None if it was stopped.
        late: whether it, or what it has started and left with its output, did not end in time.
        endless: whether it was stopped for writing too much.
    """

    def __init__(self, command: Sequence[str], text: str, answers: int, seconds: float) -> None:
        """Run a program, hand it a text and close its input, read what it answers.

        Args:
            command: the program and its arguments.
            text: for its standard input.
            answers: how many lines are expected.
            seconds: after which it is stopped.

        Raises:
            OSError: it cannot be started.
        """
        self._out, self._err, self._most = bytearray(), bytearray(), _ANSWER * (answers + 10)
        self.late = self.endless = False
        self.status: int | None = None
        with held() as let_go:
            process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
            )
            threads = self._threads(process, text.encode())
            try:
                let_go()
                # No lock waits for centuries.
                self._follow(process, threads, min(seconds, threading.TIMEOUT_MAX))
            finally:
                _end(process)
                for thread in threads:
                    thread.join(_GRACE)
        self.answer, self.said = bytes(self._out), self._err.decode(errors="replace")

    def _threads(self, process: subprocess.Popen[bytes], data: bytes) -> list[threading.Thread]:
        """What writes to the program, reads its answers and listens to its errors, already at work."""
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        threads = [
            threading.Thread(target=self._write, args=(process.stdin, data), daemon=True),
            threading.Thread(target=self._read, args=(process.stdout,), daemon=True),
            threading.Thread(target=self._listen, args=(process.stderr,), daemon=True),
        ]
        for thread in threads:
            thread.start()
        return threads

    def _follow(self, process: subprocess.Popen[bytes], threads: list[threading.Thread], seconds: float) -> None:
        """Wait until the program has answered and ended, or its time is over."""
        begin = time.monotonic()
        threads[1].join(seconds)
        self.late = threads[1].is_alive()
        self.endless = len(self._out) > self._most
        if self.late:
            self.status = process.poll()
        elif not self.endless:
            try:
                self.status = process.wait(max(_GRACE, seconds - (time.monotonic() - begin)))
            except subprocess.TimeoutExpired:
                self.late = True

    @staticmethod
    def _write(pipe: IO[bytes], data: bytes) -> None:
        # Where it has ended or does not read, its answers say so.
        with suppress(OSError), pipe:
            pipe.write(data)

    def _read(self, pipe: IO[bytes]) -> None:
        with pipe:
            while piece := pipe.read1(1 << 16):  # type: ignore[attr-defined]
                self._out += piece
                if len(self._out) > self._most:
                    return

    def _listen(self, pipe: IO[bytes]) -> None:
        with pipe:
            while piece := pipe.read1(1 << 12):  # type: ignore[attr-defined]
                self._err = (self._err + piece)[-_SAID:]


def _end(process: subprocess.Popen[bytes]) -> None:
    """Stop a program with all that it has started."""
    with suppress(ProcessLookupError, PermissionError):  # it has ended, and nothing of it is left
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
