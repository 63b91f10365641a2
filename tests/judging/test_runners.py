"""The runners of the suite in each language, where its tools are installed: right ones pass, broken ones fail."""

import shutil
import subprocess
import sys
import time

import pytest
from helpers import ROOT

from diffdrive_mj.judging import suite

STRICT = ("-O2", "-Wall", "-Wextra", "-Werror")
# The file, how it is built into a folder, how it is run from there, and what breaks it: arcs for chords.
RUNNERS = {
    "Python": ("suite.py", None, [sys.executable, "suite.py"], "math.sin(half) / half if half else 1.0"),
    "C": (
        "suite.c", ["cc", "-std=c99", *STRICT, "-o", "suite", "suite.c", "-lm"], ["./suite"],
        "half == 0 ? 1 : sin(half) / half",
    ),
    "C++": (
        "suite.cpp", ["c++", "-std=c++17", *STRICT, "-o", "suite", "suite.cpp"], ["./suite"],
        "half == 0 ? 1 : std::sin(half) / half",
    ),
    "JavaScript": ("suite.js", None, ["node", "suite.js"], "half === 0 ? 1 : Math.sin(half) / half"),
    "Java": (
        "Suite.java", ["javac", "-Xlint:all", "-Werror", "Suite.java"], ["java", "-cp", ".", "Suite"],
        "half == 0 ? 1 : Math.sin(half) / half",
    ),
    "Rust": (
        "suite.rs", ["rustc", "--edition", "2021", "-O", "-D", "warnings", "-o", "suite", "suite.rs"], ["./suite"],
        "if half == 0.0 { 1.0 } else { half.sin() / half }",
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return suite.write(tmp_path_factory.mktemp("cases"))


def run(language, folder, files, source):
    """Exit status, lines and seconds of a runner."""
    name, build, command, _ = RUNNERS[language]
    for tool in {build[0] if build else command[0], command[0]} - {"./suite"}:
        if shutil.which(tool) is None:
            pytest.skip(f"{language}: {tool} is not installed")
    (folder / name).write_text(source)
    if build:
        subprocess.run(build, cwd=folder, check=True, timeout=100)
    begin = time.perf_counter()
    done = subprocess.run([*command, *files], cwd=folder, capture_output=True, text=True, check=False, timeout=30)
    assert done.stderr == ""
    return done.returncode, done.stdout.splitlines(), time.perf_counter() - begin


@pytest.mark.parametrize("language", RUNNERS)
def test_the_runner_passes_quickly_and_a_broken_one_fails(language, files, tmp_path):
    source = (ROOT / "examples" / RUNNERS[language][0]).read_text()
    assert len(source.splitlines()) <= 60
    assert all(len(line) <= 120 for line in source.splitlines())
    status, lines, seconds = run(language, tmp_path, files, source)
    assert (status, len(lines)) == (0, len(files))
    assert all(line.startswith("ok ") for line in lines)
    # A second on a machine that has nothing else to do.
    assert seconds < 4
    broken = RUNNERS[language][3]
    assert broken in source
    status, lines, _ = run(language, tmp_path, files, source.replace(broken, "1.0"))
    failed = {line.split()[1].rpartition("/")[2].rstrip(":") for line in lines if line.startswith("FAIL ")}
    assert status == 1
    assert failed == {file.name for file in files} - {"straight.csv", "unequal_straight.csv", "standstill.csv"}


def test_a_runner_sees_wraps_faults_and_tolerances(files, tmp_path):
    """One in Python stands for all: what it leaves out, a case of the suite shows."""
    source = (ROOT / "examples" / "suite.py").read_text()
    for left_out, instead, shown in (
        (" if self.bits else ticks", " if self.bits > 16 else ticks", "wrap_16_forwards"),
        (" if self.bits else ticks", " if self.bits == 16 else ticks", "wrap_32_backwards"),
        ("t <= self.last[1]", "t < self.last[1]", "zero_dt"),
        ("self.last and t <= self.last[1]", "False", "reversed_time"),
        ("not all(map(math.isfinite, (t, *wheels)))", "False", "nan"),
        ('header["x"], header["y"], header["theta"]', "0.0, 0.0, 0.0", "standstill"),
    ):
        assert left_out in source
        status, lines, _ = run("Python", tmp_path, files, source.replace(left_out, instead))
        failed = {line.split()[1].rpartition("/")[2] for line in lines if line.startswith("FAIL ")}
        assert status == 1
        assert f"{shown}.csv:" in failed
