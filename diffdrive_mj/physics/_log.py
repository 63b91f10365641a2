"""The engine's own log, kept quiet while drives run: its warnings are counted, and raised as errors."""

from __future__ import annotations

import threading
from types import TracebackType

from diffdrive_mj.physics._mujoco import mujoco


class QuietEngine:
    """Keep the engine from writing to the console and to MUJOCO_LOG.TXT.

    The log is the whole process's: the first of the drives that run at the same time turns it off, the last one puts it
    back as it was.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._drives = 0
        self._before = None

    def __enter__(self) -> None:
        with self._lock:
            if not self._drives:
                self._before = mujoco.MjLogConfig.get()
                quiet = mujoco.MjLogConfig.get()
                quiet.logto_console = quiet.logto_file = False
                quiet.set()
            self._drives += 1

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        with self._lock:
            self._drives -= 1
            if not self._drives and self._before is not None:
                self._before.set()


QUIET_ENGINE = QuietEngine()
