"""The engine's own log: quiet while drives run, and as it was found when the last of them ends."""

import threading

import mujoco
import numpy as np

import diffdrive_mj as dd
from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.physics._log import QuietEngine

ROBOT = dd.Robot.load("matched")
SHORT = dd.maneuvers.straight(ROBOT, speed=0.5, distance=0.3)


def written_to():
    """Whether the engine writes to the console, and whether to its file."""
    log = mujoco.MjLogConfig.get()
    return log.logto_console, log.logto_file


def test_the_log_is_off_inside_and_as_before_outside_time_and_again():
    before, quiet = written_to(), QuietEngine()
    assert before != (False, False)
    for _ in range(2):
        with quiet:
            assert written_to() == (False, False)
            with quiet:
                assert written_to() == (False, False)
            assert written_to() == (False, False)
        assert written_to() == before


def test_the_engines_log_is_put_back_whatever_the_order_of_threads():
    """Drives that end in another order than they began leave the log as the first of them found it."""
    before = mujoco.MjLogConfig.get()
    quiet, leave, inside = QuietEngine(), [threading.Event() for _ in range(3)], threading.Barrier(4)

    def drive(k):
        with quiet:
            inside.wait(10)
            leave[k].wait(10)

    threads = [threading.Thread(target=drive, args=(k,)) for k in range(3)]
    for thread in threads:
        thread.start()
    inside.wait(10)
    for k in (1, 2, 0):
        assert mujoco.MjLogConfig.get().logto_console is False
        leave[k].set()
        threads[k].join(10)
    after = mujoco.MjLogConfig.get()
    assert (after.logto_console, after.logto_file) == (before.logto_console, before.logto_file)


def test_drives_in_many_threads_are_each_right_and_leave_the_log_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = mujoco.MjLogConfig.get()
    alone = dd.simulate(ROBOT, SHORT, threads=1).truth
    thrown = dd.World(pushes=(dd.Push(start=0.1, duration=0.1, acceleration=(0.0, 0.0, 1e13)),))
    seen = [None] * 6

    def drive(k):
        try:
            seen[k] = dd.simulate(ROBOT, SHORT, world=thrown if k % 2 else dd.World(), threads=1).truth
        except DiffdriveError as error:
            seen[k] = error

    threads = [threading.Thread(target=drive, args=(k,)) for k in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(isinstance(seen[k], DiffdriveError) if k % 2 else np.array_equal(seen[k], alone) for k in range(6))
    after = mujoco.MjLogConfig.get()
    assert (after.logto_console, after.logto_file) == (before.logto_console, before.logto_file)
    assert list(tmp_path.iterdir()) == []
