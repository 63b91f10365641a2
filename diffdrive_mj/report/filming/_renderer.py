"""Frames from a process that draws them, which is ended whatever happens, and whose death is one line."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import tempfile
from collections.abc import Generator
from contextlib import closing, suppress
from pathlib import Path
from typing import IO

from PIL import Image

from diffdrive_mj.errors import RenderingFailed
from diffdrive_mj.report.filming._child import NO_OPENGL
from diffdrive_mj.report.filming._scene import Job


def pictures(job: Job) -> Generator[Image.Image, None, None]:
    """The frames of a job one after the other, drawn ahead while the caller works on those before.

    Raises:
        RenderingFailed: OpenGL cannot be used, or the process died.
    """
    width = sum(scene.size[0] for scene in job.scenes) * job.smooth
    height = job.scenes[0].size[1] * job.smooth
    with tempfile.TemporaryFile() as said:
        process = _start(said)
        try:
            assert process.stdin is not None
            assert process.stdout is not None
            with suppress(OSError), process.stdin as pipe:  # where it has died, its output says so
                pickle.dump(job, pipe)
            with closing(process.stdout) as pipe:
                for _ in range(job.frames):
                    frame = pipe.read(3 * width * height)
                    if len(frame) < 3 * width * height:
                        raise RenderingFailed(_why(process.wait(), said))
                    picture = Image.frombuffer("RGB", (width, height), frame, "raw", "RGB", 0, 1)
                    yield picture.reduce(job.smooth) if job.smooth > 1 else picture
        finally:
            process.kill()
            process.wait()


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
