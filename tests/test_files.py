"""Files written whole or not at all."""

import os
import stat
from pathlib import Path

import pytest
from helpers import refused

from diffdrive_mj._files import as_path, made_whole, write_whole


def test_what_is_written_is_read(tmp_path):
    path = tmp_path / "text.toml"
    for text in ("first\nline\n", "second ü\n"):
        write_whole(str(path), text)
        assert path.read_bytes() == text.encode()
    assert list(tmp_path.iterdir()) == [path]


def test_what_fails_leaves_the_earlier_file_and_nothing_else(tmp_path):
    path = tmp_path / "text.toml"
    write_whole(path, "earlier")
    with refused(ValueError, f"{path}: cannot be written"):
        write_whole(path, "\ud800")
    assert path.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [path]
    with refused(ValueError, "cannot be written (No such file or directory)"):
        write_whole(tmp_path / "nowhere" / "text.toml", "text")


def test_a_link_stays_a_link_and_a_file_keeps_its_permissions(tmp_path):
    real, link = tmp_path / "real.toml", tmp_path / "link.toml"
    real.write_text("earlier")
    real.chmod(0o600)
    link.symlink_to(real)
    write_whole(link, "new")
    assert link.is_symlink()
    assert real.read_text() == "new"
    assert stat.S_IMODE(real.stat().st_mode) == 0o600


def test_a_new_file_has_the_usual_permissions(tmp_path):
    umask = os.umask(0o027)
    try:
        write_whole(tmp_path / "new.toml", "text")
    finally:
        os.umask(umask)
    assert stat.S_IMODE((tmp_path / "new.toml").stat().st_mode) == 0o640


def test_a_long_name_is_no_obstacle_of_ours(tmp_path):
    path = tmp_path / ("n" * 250 + ".csv")
    write_whole(path, "text")
    assert path.read_text() == "text"
    wide = tmp_path / ("漢" * 83 + ".csv")  # 253 bytes
    write_whole(wide, "text")
    assert wide.read_text() == "text"
    with refused(ValueError, "path = ", "File name too long"):
        write_whole(tmp_path / ("n" * 300), "text")


def test_what_somebody_else_makes_takes_its_place_when_it_is_whole(tmp_path):
    with made_whole(tmp_path / "new.bin") as path:
        assert path.name == "new.bin"
        assert not (tmp_path / "new.bin").exists()
        path.write_bytes(b"whole")
    assert (tmp_path / "new.bin").read_bytes() == b"whole"

    def fail():
        with made_whole(tmp_path / "new.bin") as path:
            path.write_bytes(b"half")
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert (tmp_path / "new.bin").read_bytes() == b"whole"
    assert [path.name for path in tmp_path.iterdir()] == ["new.bin"]


def test_a_folder_is_made_whole_and_replaces_nothing(tmp_path):
    with made_whole(tmp_path / "new", folder=True) as path:
        path.mkdir()
        (path / "part").write_text("whole")
    assert (tmp_path / "new" / "part").read_text() == "whole"
    with (
        refused(ValueError, "new: is there already, and no folder is overwritten"),
        made_whole(tmp_path / "new", folder=True),
    ):
        raise AssertionError
    assert [path.name for path in tmp_path.iterdir()] == ["new"]


@pytest.mark.parametrize("value", [None, b"bytes.toml", 3, ["a"]])
def test_what_cannot_be_a_path(value):
    with refused(TypeError, f"path = {value!r}: must be a path, as a string or a Path"):
        as_path("path", value)


@pytest.mark.parametrize("value", ["", "nul\0byte", Path("nul\0byte")])
def test_what_cannot_name_a_file(value):
    with refused(ValueError, "path = ", "must name a file"):
        as_path("path", value)
