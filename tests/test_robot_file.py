"""A robot's file: line ends of any machine, and how large it may be."""

import pytest
from helpers import refused

import diffdrive_mj as dd

TEXT = "left_radius = 0.1\nright_radius = 0.09\ntrack_width = 0.4\nname = '''two\nlines'''\n[tyres]\nwidth = 0.03\n"


def test_windows_line_ends_make_the_same_robot(tmp_path):
    for name, end in (("unix", "\n"), ("windows", "\r\n")):
        (tmp_path / f"{name}.toml").write_bytes(TEXT.replace("\n", end).encode())
    unix, windows = (dd.Robot.load(tmp_path / f"{name}.toml") for name in ("unix", "windows"))
    assert unix == windows
    assert windows.name == "two\nlines"


@pytest.mark.parametrize("beyond", [0, 1])
def test_a_file_of_a_million_bytes_is_read_and_no_larger_one(tmp_path, beyond):
    path = tmp_path / "large.toml"
    path.write_text(TEXT + "#" * (1_000_000 - len(TEXT) + beyond))
    if beyond:
        with refused(ValueError, "large.toml", "larger than 1000000 bytes"):
            dd.Robot.load(path)
    else:
        assert dd.Robot.load(path).track_width == 0.4
