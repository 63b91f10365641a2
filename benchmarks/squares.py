"""Thousands of squares of 16 m with the fast setting: a sweep's time against the engine's own.

The bare engine drives a sample of the trials before, during and after the sweep, on as many threads as the sweep has
processes; its mean time is scaled up to all the trials. With `--out` the sweep is cut into parts of 2500 for that.

    python benchmarks/squares.py --trials 10000
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from sweeps import bare, squares

import diffdrive_mj as dd
from diffdrive_mj.sweeps import _workers
from diffdrive_mj.sweeps.runner import CHUNK


def main() -> None:
    """Run them, a tenth at a time, and print both times."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=1000, help="how many (default: %(default)s)")
    parser.add_argument("--workers", type=int, default=_workers.cores(), help="processes (default: %(default)s)")
    parser.add_argument("--out", default=None, help="a folder for the chunks; it must be new")
    options = parser.parse_args()
    study, sample = squares(options.trials), CHUNK * options.workers
    parts = [*range(2500, options.trials, 2500), options.trials] if options.out else [options.trials]
    engine, swept = [bare(study, range(sample), options.workers)], 0.0
    for trials in parts:
        begin = time.perf_counter()
        found = dd.sweep(study.replace(trials=trials), options.out, workers=options.workers)
        swept += time.perf_counter() - begin
        engine.append(bare(study, range(sample), options.workers))
    alone = float(np.mean(engine)) / sample * options.trials
    error = found.figures["final_position"][found.ok]
    print(f"{found!r}; final position error, 99th percentile: {1e3 * np.percentile(error, 99):.4g} mm")
    print(f"sweep, {options.workers} processes:        {swept:.1f} s")
    print(f"bare engine, {options.workers} threads:    {alone:.1f} s (from {len(engine)} samples of {sample} trials)")
    print(f"sweep / bare engine:       {swept / alone:.3f}")


if __name__ == "__main__":
    main()
