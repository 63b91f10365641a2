"""The process that draws: reads a job from its standard input, writes the frames' bytes to its standard output.

It is a process of its own since MUJOCO_GL must be set before MuJoCo is imported, and since OpenGL may crash it.
"""

from __future__ import annotations

import os
import pickle
import queue
import sys
import threading
from typing import BinaryIO

# Frames that are drawn ahead while the ones before are being written.
_AHEAD = 4
# The exit status where OpenGL cannot be used.
NO_OPENGL = 3


def main() -> None:
    """Draw; what standard error says last is why it fails."""
    sink = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # whatever else prints does not print into a frame
    job = pickle.load(sys.stdin.buffer)
    try:
        import mujoco  # and with it OpenGL

        mujoco.GLContext(8, 8).make_current()
    except Exception as error:  # whatever the driver says
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        sys.stderr.flush()
        os._exit(NO_OPENGL)
    import numpy as np

    from diffdrive_mj.report.filming._stage import Stage

    stages = [Stage(scene, job.smooth) for scene in job.scenes]
    waiting: queue.Queue[bytes | None] = queue.Queue(_AHEAD)
    writer = threading.Thread(target=_write, args=(sink, waiting), daemon=True)
    writer.start()
    for k in range(job.frames):
        waiting.put(np.concatenate([stage.frame(k) for stage in stages], axis=1).tobytes())
    waiting.put(None)
    writer.join()
    sys.stderr.flush()
    os._exit(0)  # OpenGL's own ending may crash


def _write(sink: BinaryIO, waiting: queue.Queue[bytes | None]) -> None:
    try:
        while (frame := waiting.get()) is not None:
            rest = memoryview(frame)
            while rest:
                rest = rest[sink.write(rest) :]
    except OSError:  # nobody reads any more
        os._exit(1)


if __name__ == "__main__":
    main()
