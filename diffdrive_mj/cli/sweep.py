"""`diffdrive sweep`: thousands of robots before one is built, and how far off their odometry ends."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import tyro

from diffdrive_mj.cli._left_out import Whole
from diffdrive_mj.cli._outcome import AsJson
from diffdrive_mj.sweeps.studies import Study

# Which percentiles the JSON has.
_SHARES = (0.5, 0.9, 0.95, 0.99)


def command(
    study: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="STUDY", help_behavior_hint="(required)")],
    /,
    output: Annotated[Path, tyro.conf.arg(metavar="FOLDER")],
    trials: Whole = None,
    workers: Whole = None,
    chunk: Whole = None,
    scheduler: Annotated[str | None, tyro.conf.arg(metavar="ADDRESS")] = None,
    as_json: AsJson = False,
) -> None:
    """Drive the trials of a study, and say how far off the robots' odometry ends.

      diffdrive sweep squares --output results/squares --trials 200

    What is done stays: the same command goes on where an interrupted one ended. At the end the folder has trials.csv, a
    row a trial.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong; 130 where it is interrupted.

    Args:
        study: the name of a preset, or a TOML file.
        output: the sweep's folder, which keeps every chunk of trials that is done.
        trials: how many; as many as the study says if not given.
        workers: processes that drive; as many as the machine has cores if not given.
        chunk: how many trials are driven together; it changes no number.
        scheduler: the address of a Dask scheduler whose workers drive, such as tcp://10.0.0.1:8786.
        as_json: print the outcome as JSON.

    Raises:
        DiffdriveError: bad input.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["sweep", "sqares", "--output", "results"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    from diffdrive_mj.sweeps.runner import sweep

    described = Study.load(study)
    if trials is not None:
        described = described.replace(trials=trials)
    options: dict[str, Any] = {"workers": workers, "chunk": chunk, "scheduler": scheduler}
    done = sweep(described, output, **{name: value for name, value in options.items() if value is not None})
    table = output / "trials.csv"
    done.to_csv(table)
    if as_json:
        figures = {
            name: {f"{100 * share:g} %": done.percentile(name, share).value.item() for share in _SHARES}
            for name, values in done.figures.items()
            if values.ndim == 1
        }
        print(json.dumps({"study": described.name, "outcomes": done.counted, "figures": figures, "table": str(table)}))
    else:
        print(f"{done}\n\nwritten: {table}")
