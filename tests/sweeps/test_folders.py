"""A sweep's folder: what is there is used once, what is not whole is run again, what is not its own is refused."""

import errno
import os
import subprocess
import sys
import time

import numpy as np
import pytest
from sweeping import assert_same, small

import diffdrive_mj as dd
from diffdrive_mj import _files
from diffdrive_mj.errors import DiffdriveError, InvalidValue, MissingFile
from diffdrive_mj.sweeps import Normal, _chunk, _store
from diffdrive_mj.sweeps.failures import SweepWarning

STUDY = small(10, truth="kinematics", figures=("final_position", "position_along"))


@pytest.fixture(scope="module")
def whole():
    return dd.sweep(STUDY)


@pytest.fixture
def swept(tmp_path):
    """A folder with three chunks of four, four and two trials."""
    dd.sweep(STUDY, tmp_path / "out", chunk=4, workers=1)
    return tmp_path / "out"


def chunks(folder):
    return sorted((folder / "chunks").iterdir())


def refuse_to_run(*_):
    raise AssertionError("nothing is left to be run")


def test_a_folder_that_is_whole_is_read_and_nothing_is_run(swept, whole, monkeypatch):
    monkeypatch.setattr(_chunk, "run", refuse_to_run)
    assert_same(dd.sweep(STUDY, swept), whole)
    assert_same(dd.sweep(STUDY, swept, chunk=3), whole)
    assert_same(dd.sweeps.load(swept), whole)


def test_only_what_is_missing_is_run_whatever_the_chunk(swept, whole, monkeypatch):
    chunks(swept)[1].unlink()
    assert dd.sweeps.load(swept).index.tolist() == [0, 1, 2, 3, 8, 9]
    run, asked = _chunk.run, []
    monkeypatch.setattr(_chunk, "run", lambda study, *span: asked.append(span) or run(study, *span))
    assert_same(dd.sweep(STUDY, swept, chunk=3, workers=1), whole)
    assert asked == [(4, 7), (7, 8)]
    assert_same(dd.sweeps.load(swept), whole)


def test_a_study_of_more_trials_goes_on_and_one_of_fewer_is_its_beginning(swept, monkeypatch):
    more = STUDY.replace(trials=13)
    assert_same(dd.sweep(more, swept, workers=1), dd.sweep(more))
    monkeypatch.setattr(_chunk, "run", refuse_to_run)
    assert len(dd.sweep(more, swept)) == len(dd.sweeps.load(swept)) == 13
    fewer = dd.sweep(STUDY.replace(trials=6), swept)
    assert fewer.index.tolist() == list(range(6))
    assert len(dd.sweeps.load(swept)) == 13


def test_trials_that_stand_in_two_files_count_once(swept, whole):
    _store.write(swept, STUDY, _chunk.run(STUDY, 2, 7))
    assert_same(dd.sweep(STUDY, swept), whole)


def test_a_design_of_more_trials_that_has_other_ones_is_refused(swept, monkeypatch):
    monkeypatch.setattr(
        type(STUDY), "shares", lambda study, first, last: np.full((last - first, 2), 0.5 / study.trials)
    )
    with pytest.raises(InvalidValue, match=r"another number of trials.*; name another folder"):
        dd.sweep(STUDY.replace(trials=13), swept)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"seed": 1}, "with 'seed = 0' in the place of 'seed = 1'"),
        ({"sample_rate": 50.0}, "sample_rate"),
        ({"vary": {"robot.track_width": Normal(mean=0.4, sigma=0.1)}}, ""),
    ],
)
def test_another_studys_folder_is_refused_and_kept(swept, changes, named, whole):
    with pytest.raises(InvalidValue, match=f"holds another study.*{named}.*; name another folder") as caught:
        dd.sweep(STUDY.replace(**changes), swept)
    assert "\n" not in str(caught.value)
    assert_same(dd.sweeps.load(swept), whole)


def test_a_chunk_of_another_study_is_refused(swept, tmp_path):
    dd.sweep(STUDY.replace(seed=1), tmp_path / "other", chunk=4, workers=1)
    chunks(tmp_path / "other")[0].replace(chunks(swept)[0])
    with pytest.raises(InvalidValue, match=r"00000000-00000004\.npz: is a chunk of another study; take it away"):
        dd.sweep(STUDY, swept)


def test_a_chunk_of_another_version_is_refused(swept, monkeypatch):
    monkeypatch.setattr(_store, "version", lambda name: "3.9.0")
    with pytest.raises(InvalidValue, match=r"was made by diffdrive_mj .* with MuJoCo 4\..*, and this is .* 3\.9\.0"):
        dd.sweep(STUDY, swept)


@pytest.mark.parametrize("seed", range(3))
def test_a_chunk_that_is_not_whole_is_run_again_and_said(swept, whole, seed):
    """Truncated, a byte changed, emptied: each on another file."""
    rng, fingerprint = np.random.default_rng(seed), _store._fingerprint(STUDY.to_toml())
    for k, path in enumerate(chunks(swept)):
        content = bytearray(path.read_bytes())
        if k == 0 and seed:
            content = content[: rng.integers(1, len(content))]
        elif k == 1:
            content = content[:0]
        elif k == 2:
            # Any byte of an array; what an archive says of names and dates decides nothing.
            at = content.find(b"position_along")
            content[at + int(rng.integers(200, 300))] ^= 1 + int(rng.integers(255))
        path.write_bytes(content)
    with pytest.warns(SweepWarning, match="is not whole.*; its trials are left out"):
        assert len(_store._distinct(_store._chunks(swept, fingerprint, aside=False), 10)) == (0 if seed else 1)
    with pytest.warns(SweepWarning, match="is not whole.*; its trials are run again") as said:
        assert_same(dd.sweep(STUDY, swept, workers=1), whole)
    assert len(said) == (3 if seed else 2)
    assert_same(dd.sweep(STUDY, swept), whole)


def test_any_broken_byte_gives_the_same_trials_or_none(swept, whole):
    path = chunks(swept)[2]
    content, rng = path.read_bytes(), np.random.default_rng(0)
    before = _store._read_chunk(path)
    for at in rng.integers(len(content), size=300).tolist():
        broken = bytearray(content)
        broken[at] ^= 1 + int(rng.integers(255))
        path.write_bytes(broken)
        found = _store._read_chunk(path)
        if found is not None:
            assert all(
                np.array_equal(found[name], values, equal_nan=values.dtype.kind == "f")
                for name, values in before.items()
            )


def test_a_chunk_under_anothers_name_is_not_written_over(swept, whole):
    first, second, _ = chunks(swept)
    first.replace(second)
    with pytest.warns(SweepWarning, match=r"00000004-00000008\.npz: is not whole, or not what its name says"):
        assert_same(dd.sweep(STUDY, swept, chunk=4, workers=1), whole)
    assert_same(dd.sweeps.load(swept), whole)
    assert second.with_suffix(".broken").exists()


def test_a_folder_with_something_else_is_refused_and_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(InvalidValue, match=r"holds something else already, such as 'thesis\.tex'; name another folder"):
        dd.sweep(STUDY, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]
    (tmp_path / "study.toml").write_text('name = "mine"')
    with pytest.raises(InvalidValue, match=r"study\.toml: was not left by a sweep"):
        dd.sweep(STUDY, tmp_path)
    with pytest.raises(MissingFile, match="no sweep has been kept there"):
        dd.sweeps.load(tmp_path / "nowhere")
    with pytest.raises(InvalidValue, match=r"Not a directory|cannot be"):
        dd.sweep(STUDY, tmp_path / "thesis.tex")


def test_files_beside_a_sweeps_own_stay(swept, whole):
    for place in (swept / "plot.png", swept / "chunks" / "notes.txt"):
        place.write_text("mine")
    assert_same(dd.sweep(STUDY, swept), whole)
    assert (swept / "plot.png").exists()
    assert (swept / "chunks" / "notes.txt").exists()


def test_what_a_killed_process_has_half_written_does_no_harm(tmp_path, whole):
    out = tmp_path / "out"
    half = (
        f".study.toml-{'0' * 16}",
        f"chunks/.00000000-00000004.npz-{'a' * 16}",
        f"chunks/.00000004-00000008.npz-{'b' * 16}",
    )
    (out / "chunks").mkdir(parents=True)
    for name in half[:2]:
        (out / name).mkdir()
        os.utime(out / name, (time.time() - 100, time.time() - 100))
    (out / half[2]).mkdir()
    (out / "chunks").rename(tmp_path / "chunks")
    first = out / half[0]
    assert first.exists()
    dd.sweep(STUDY, out, chunk=4, workers=1)
    (tmp_path / "chunks" / half[1].partition("/")[2]).rename(out / half[1])
    (tmp_path / "chunks" / half[2].partition("/")[2]).rename(out / half[2])
    assert_same(dd.sweep(STUDY, out), whole)
    # Old ones are taken away, one that may just be written is not.
    assert not first.exists()
    assert [(out / name).exists() for name in half[1:]] == [False, True]


def test_a_full_disk_is_one_line_and_nothing_half_written(tmp_path, whole, monkeypatch):
    write, done = _files.write_whole, []

    def full(path, content):
        if len(done) == 2:
            raise InvalidValue(f"{path}: cannot be written ({os.strerror(errno.ENOSPC)})")
        done.append(path)
        write(path, content)

    monkeypatch.setattr(_store, "write_whole", full)
    with pytest.raises(InvalidValue, match=r"cannot be written \(No space left on device\)"):
        dd.sweep(STUDY, tmp_path / "out", chunk=4, workers=1)
    monkeypatch.undo()
    assert dd.sweeps.load(tmp_path / "out").index.tolist() == [0, 1, 2, 3]
    assert_same(dd.sweep(STUDY, tmp_path / "out"), whole)


FULL = """
import resource, signal, sys
import diffdrive_mj as dd
from sweeping import small
from diffdrive_mj.errors import DiffdriveError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
try:
    study = small(10, truth="kinematics", figures=("final_position", "position_along"))
    dd.sweep(study, sys.argv[1], workers=1)
except DiffdriveError as error:
    print(error)
"""


def test_a_file_that_the_system_cuts_off_leaves_nothing_behind(tmp_path):
    """The limit of a process stands for a disk's: a file of one trial fits, one of ten does not."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    said = subprocess.run(
        [sys.executable, "-c", FULL, str(tmp_path / "out")],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "cannot be written (File too large)" in said.stdout
    assert said.stdout.count("\n") == 1
    assert chunks(tmp_path / "out") == []


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(DiffdriveError, match="file"):
        dd.sweep(STUDY, tmp_path / "file" / "out")
