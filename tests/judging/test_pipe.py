"""A program over a pipe leaves nothing behind that holds anybody up."""

import subprocess
import sys
import time


def test_what_a_program_has_detached_does_not_hold_up_the_end():
    """It keeps the pipe open, and is in no process group of ours."""
    code = (
        "import subprocess, sys; subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(20)'], "
        "start_new_session=True)"
    )
    judging = (
        "import sys, diffdrive_mj as dd; from diffdrive_mj.judging.candidates import poses_of; "
        "robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4); "
        f"poses_of([sys.executable, '-c', {code!r}], dd.Task('a', robot, [0.0, 1.0], [(0, 0), (1, 1)]), seconds=0.5)"
    )
    begin = time.perf_counter()
    ended = subprocess.run([sys.executable, "-c", judging], capture_output=True, text=True, check=False)
    assert "what it has started did not within 0.5 s" in ended.stderr
    assert time.perf_counter() - begin < 15
