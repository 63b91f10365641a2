"""How many small faults the tests see: mutants of every module, each run against the tests that reach its line.

    python benchmarks/mutation.py                              25 mutants of each module
    python benchmarks/mutation.py metrics/drifts odometry      of some
    python benchmarks/mutation.py --survivors                  those that survived last time, once more

The first run finds out which test reaches which line (some minutes). Mutants that no test can tell from the original
are in equivalent_mutants.toml, with a reason each, and do not count.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import queue
import shutil
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# Some of these for their sake alone: loaded here once, and not by the process of each mutant.
import coverage
import hypothesis  # noqa: F401
import matplotlib.pyplot  # noqa: F401
import mujoco.batch  # noqa: F401
import pytest
import scipy.optimize
import scipy.stats  # noqa: F401
import tyro  # noqa: F401
from mutants import Mutant, mutants

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "results" / "mutation"
PACKAGE = ROOT / "diffdrive_mj"
COPIED = (
    "diffdrive_mj",
    "tests",
    "experiments",
    "examples",
    "models",
    "docs",
    "benchmarks",
    "*.toml",
    "*.md",
    "*.cff",
    "Makefile",
)
# Quick, without files of its own, and silent about plugins that are loaded already.
PYTEST = (
    *("-p", "no:cacheprovider", "-p", "no:xdist", "-p", "no:unraisableexception", "--assert=plain"),
    *("-W", "ignore:Module already imported"),
)
FORK = multiprocessing.get_context("fork")


class TestMap:
    """A plugin for pytest: which lines each test reaches, and how long it takes [s]."""

    __test__ = False

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.coverage = coverage.Coverage(data_file=None, source=[str(folder / "diffdrive_mj")], config_file=False)
        self.seconds: dict[str, float] = {}
        self.passed: set[str] = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> object:
        """A context for each test."""
        self.coverage.switch_context(item.nodeid)
        begin = time.perf_counter()
        try:
            return (yield)
        finally:
            self.seconds[item.nodeid] = time.perf_counter() - begin

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """What fails or is skipped without a mutant says nothing of one."""
        if report.when == "call" and report.passed:
            self.passed.add(report.nodeid)

    def save(self, path: Path) -> None:
        """Seconds by test, and by module and line the tests."""
        data = self.coverage.get_data()
        lines = {
            str(Path(file).relative_to(self.folder / "diffdrive_mj")): {
                line: [test for test in tests if test in self.passed]
                for line, tests in data.contexts_by_lineno(file).items()
            }
            for file in data.measured_files()
        }
        seconds = {test: self.seconds[test] for test in self.passed}
        path.write_text(json.dumps({"seconds": seconds, "lines": lines}))


def copied(folder: Path) -> Path:
    """A copy of the checkout, to be mutated."""
    for pattern in COPIED:
        for path in ROOT.glob(pattern):
            copy = shutil.copytree if path.is_dir() else shutil.copy
            copy(path, folder / path.name)
    return folder


def in_child(folder: Path, work: Callable[[], int], seconds: float) -> int | None:
    """The exit status of work in a process of its own, in a copy of the checkout; None if it takes too long."""

    def run() -> None:
        os.chdir(folder)
        os.environ["PYTHONPATH"] = str(folder)
        sys.path.insert(0, str(folder))
        sys.dont_write_bytecode = True
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        os._exit(int(work()))

    process = FORK.Process(target=run)
    process.start()
    process.join(seconds)
    if process.is_alive():
        process.kill()
        process.join()
        return None
    return process.exitcode


def map_of_tests(folders: queue.Queue[Path], jobs: int) -> dict[str, dict]:
    """Seconds by test, and by module and line the tests; measured once and kept."""
    kept = RESULTS / "tests.json"
    if not kept.exists():
        files = sorted(path.relative_to(ROOT) for path in (ROOT / "tests").rglob("test_*.py"))

        def measured(file: Path) -> None:
            folder = folders.get()

            def work() -> int:
                plugin = TestMap(folder)
                plugin.coverage.start()
                status = pytest.main([*PYTEST, "-m", "not slow", str(file)], plugins=[plugin])
                plugin.coverage.stop()
                plugin.save(RESULTS / f"{file.stem}.part")
                return status

            print(f"{file}: {in_child(folder, work, 3600)}", file=sys.stderr, flush=True)
            folders.put(folder)

        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(measured, files))
        whole: dict[str, dict] = {"seconds": {}, "lines": {}}
        for part in RESULTS.glob("*.part"):
            found = json.loads(part.read_text())
            whole["seconds"] |= found["seconds"]
            for module, lines in found["lines"].items():
                into = whole["lines"].setdefault(module, {})
                for line, tests in lines.items():
                    into.setdefault(line, []).extend(tests)
            part.unlink()
        kept.write_text(json.dumps(whole))
    return json.loads(kept.read_text())


def chosen(tests: dict[str, dict], module: str, mutant: Mutant, longest: float) -> list[str]:
    """The tests that reach a fault, for so long in all [s]; any of them, where it runs on import or in other processes.

    All those in the test module of its name come first, then those of its module, then the quick ones.
    """
    lines, seconds = tests["lines"].get(module, {}), tests["seconds"]
    of_module = {test for reached in lines.values() for test in reached}
    every = set(seconds)
    path = Path(module)
    own = f"tests/{path.with_name('test_' + path.name.strip('_'))}::"
    reaching = set(lines.get(str(mutant.line), []) if mutant.called else ()) or every
    # A fixture that several tests share reaches lines for the first of them alone.
    reaching = reaching | {test for test in every if own in test}
    order, left = [], longest
    for test in sorted(reaching, key=lambda test: (own not in test, test not in of_module, seconds[test])):
        left -= seconds[test]
        if left < 0 and order:
            break
        order.append(test)
    return order


def survives(folder: Path, module: str, mutant: Mutant, tests: list[str], seconds: float) -> bool:
    """Whether no test sees the fault."""
    path = folder / "diffdrive_mj" / module
    original = path.read_text()
    path.write_text(mutant.source)
    try:
        status = in_child(folder, lambda: pytest.main([*PYTEST, "-x", *tests]), 10 + 4 * seconds)
    finally:
        path.write_text(original)
    return status == 0


def run(options: argparse.Namespace) -> int:
    """Try the mutants and print the scores."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    log = RESULTS / "mutants.jsonl"
    before = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    known = tomllib.loads((Path(__file__).parent / "equivalent_mutants.toml").read_text())
    modules = [str(path.relative_to(PACKAGE)) for path in sorted(PACKAGE.rglob("*.py")) if path.name != "__init__.py"]
    if options.modules:
        modules = [module for module in modules if module.removesuffix(".py") in options.modules]
    survived = {(found["module"], found["key"]) for found in before if found["survives"]}
    work = [
        (module, mutant)
        for module in modules
        for mutant in mutants((PACKAGE / module).read_text(), options.count, f"{options.seed} {module}")
        if not (options.survivors and (module, mutant.key) not in survived)
    ]
    folders: queue.Queue[Path] = queue.Queue()
    with tempfile.TemporaryDirectory() as place, ThreadPoolExecutor(options.jobs) as pool:
        for k in range(options.jobs):
            folder = Path(place) / str(k)
            folder.mkdir()
            folders.put(copied(folder))
        tests = map_of_tests(folders, options.jobs)

        def tried(one: tuple[str, Mutant]) -> dict[str, object]:
            module, mutant = one
            reaching = chosen(tests, module, mutant, options.seconds)
            equivalent = mutant.key in known.get(module, {})
            folder = folders.get()
            needed = sum(tests["seconds"][test] for test in reaching)
            alive = not equivalent and (not reaching or survives(folder, module, mutant, reaching, needed))
            folders.put(folder)
            found = {"module": module, "line": mutant.line, "key": mutant.key, "survives": alive} | {
                "equivalent": equivalent, "tests": len(reaching)
            }  # fmt: skip
            with log.open("a") as file:
                file.write(json.dumps(found) + "\n")
            if alive:
                print(f"{module}:{mutant.line}: {mutant.key}   [{len(reaching)} tests]", flush=True)
            return found

        results = list(pool.map(tried, work))
    return summary(results)


def summary(results: list[dict[str, object]]) -> int:
    """Scores by module, the lowest first, and over all."""
    counted = [found for found in results if not found["equivalent"]]
    scores = {}
    for module in {str(found["module"]) for found in counted}:
        own = [found for found in counted if found["module"] == module]
        scores[module] = (sum(not found["survives"] for found in own) / len(own), len(own))
    for module, (score, count) in sorted(scores.items(), key=lambda item: item[1]):
        print(f"{100 * score:5.1f} % of {count:3d}  {module}")
    killed = sum(not found["survives"] for found in counted)
    print(
        f"{100 * killed / max(len(counted), 1):5.1f} % of {len(counted)}  all; {len(results) - len(counted)} equivalent"
    )
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modules", nargs="*", help="such as metrics/drifts; all without one")
    parser.add_argument("--count", type=int, default=25, help="mutants of each module, at most")
    parser.add_argument("--seed", type=int, default=0, help="of the choice")
    parser.add_argument("--seconds", type=float, default=30.0, help="of tests for each mutant")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--survivors", action="store_true", help="only those that survived last time")
    raise SystemExit(run(parser.parse_args()))
