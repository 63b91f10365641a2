"""Frames from a process that draws them, which is ended whatever happens, and whose death is one line."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Generator, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import IO

from PIL import Image

from diffdrive_mj._signals import held
from diffdrive_mj.errors import RenderingFailed
from diffdrive_mj.report.filming._child import NO_OPENGL
from diffdrive_mj.report.filming._scene import Job

# How long a frame may take [s]: the largest takes a few seconds without a graphics card, and a driver may hang.
_LONGEST = 60.0


def pictures(job: Job) -> Generator[Image.Image, None, None]:
    """The frames of a job one after the other, drawn ahead while the caller works on those before.

    Raises:
        RenderingFailed: OpenGL cannot be used, or the process died or hangs.
    """
    width = sum(scene.size[0] for scene in job.scenes) * job.smooth
    height = job.scenes[0].size[1] * job.smooth
    with tempfile.TemporaryFile() as said, held() as let_go:
        process = _start(said)
        try:
            let_go()
            assert process.stdin is not None
            assert process.stdout is not None
            with closing(process.stdout) as pipe:
                with _patience(process), suppress(OSError), process.stdin as wanted:  # its death shows below
                    pickle.dump(job, wanted)
                for _ in range(job.frames):
                    with _patience(process):
                        frame = pipe.read(3 * width * height)
                    if len(frame) < 3 * width * height:
                        raise RenderingFailed(_why(process.wait(), said))
                    picture = Image.frombuffer("RGB", (width, height), frame, "raw", "RGB", 0, 1)
                    yield picture.reduce(job.smooth) if job.smooth > 1 else picture
        finally:
            process.kill()
            process.wait()


@contextmanager
def _patience(process: subprocess.Popen[bytes]) -> Iterator[None]:
    """End a process that keeps its reader or its writer waiting for too long."""
    late = threading.Event()

    def end() -> None:
        late.set()
        process.kill()

    timer = threading.Timer(_LONGEST, end)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
    if late.is_set():
        raise RenderingFailed(
            f"the process that draws sent nothing for {_LONGEST:g} s: the graphics driver hangs; on Linux "
            "MUJOCO_GL=egl, osmesa or glfw chooses another"
        )


def _start(said: IO[bytes]) -> subprocess.Popen[bytes]:
    environment = dict(os.environ)
    if sys.platform.startswith("linux"):
        environment.setdefault("MUJOCO_GL", "egl")  # needs no screen
    package = str(Path(__file__).parents[3])
    environment["PYTHONPATH"] = os.pathsep.join([package, *filter(None, [environment.get("PYTHONPATH")])])
    # -P: what lies in the working folder is not imported. A session of its own: Ctrl-C is answered here.
    command = [sys.executable, "-P", "-m", "diffdrive_mj.report.filming._child"]
    return subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said, env=environment, start_new_session=True
    )


def _why(status: int, said: IO[bytes]) -> str:
    """What a process that ended too early said last, and how it ended."""
    said.seek(0)
    lines = said.read().decode(errors="replace").strip().splitlines()
    if status == NO_OPENGL and lines:
        chosen = os.environ.get("MUJOCO_GL")
        cure = (
            f"MUJOCO_GL={chosen} was chosen in the environment"
            if chosen
            else "on Linux install libegl1 and libgl1-mesa-dri"
        )
        return f"OpenGL cannot be used ({lines[-1]}); {cure}"
    with suppress(ValueError):
        if status < 0:
            return f"the process that draws was ended by {signal.Signals(-status).name}"
    return f"the process that draws ended with exit status {status}" + (f" ({lines[-1]})" if lines else "")
