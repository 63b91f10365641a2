"""A worker process: reads a study and spans of its trials from its standard input, writes the trials to its output."""

from __future__ import annotations

import os
import pickle
import queue
import sys
import threading


def main() -> None:
    """Run what is asked for until the input ends."""
    sink = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever else prints does not print into a result
    sys.path[:] = pickle.load(sys.stdin.buffer)
    asked: queue.SimpleQueue[tuple[int, int]] = queue.SimpleQueue()
    study = pickle.load(sys.stdin.buffer)
    threading.Thread(target=_listen, args=(asked,), daemon=True).start()
    from diffdrive_mj.sweeps import _chunk

    while True:
        try:
            answer: object = _chunk.run(study, *asked.get())
        except BaseException as error:  # told to the parent, which raises it
            answer = error
        pickle.dump(answer, sink)
        sink.flush()


def _listen(asked: queue.SimpleQueue[tuple[int, int]]) -> None:
    """Hear of the input's end even while trials run: the parent has ended then."""
    try:
        while True:
            asked.put(pickle.load(sys.stdin.buffer))
    except EOFError:
        os._exit(0)


if __name__ == "__main__":
    main()
