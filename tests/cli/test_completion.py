"""What a shell completes: every command and every option, as a real shell sees it."""

import shutil
import subprocess

import pytest

from diffdrive_mj import cli
from diffdrive_mj.cli.program import commands


@pytest.fixture(scope="module")
def scripts():
    """The scripts by shell."""
    from contextlib import redirect_stdout
    from io import StringIO

    found = {}
    for shell in ("bash", "zsh", "fish"):
        with redirect_stdout(StringIO()) as said:
            cli.main(["completion", shell])
        found[shell] = said.getvalue()
    return found


def completed(script, *words):
    """What bash offers for the last word."""
    line = f"COMP_WORDS=({' '.join(f'{word!r}' for word in words)}); COMP_CWORD={len(words) - 1}"
    code = f'{script}\n{line}; _diffdrive; printf "%s\\n" "${{COMPREPLY[@]}}"'
    return subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True).stdout.split()


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
def test_bash_completes_commands_and_their_options(scripts):
    assert completed(scripts["bash"], "diffdrive", "") == sorted(commands())
    assert completed(scripts["bash"], "diffdrive", "ev") == ["evaluate"]
    assert completed(scripts["bash"], "diffdrive", "judge", "--ro") == ["--robot"]
    assert set(completed(scripts["bash"], "diffdrive", "explain", "ct_bot", "--")) >= {
        "--tolerance",
        "--json",
        "--rate",
    }


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (("robots", ""), ["list", "show", "new", "mjcf"]),
        (("robots", "new", "--left"), ["--left-radius"]),
        (("robots", "show", "--left"), []),
        (("experiment", "umb"), ["umbmark"]),
        (("completion", ""), ["bash", "zsh", "fish"]),
        (("judge", "--robot", "ct"), ["ct_bot"]),
        (("simulate", "square", "log.csv", "--believed", "opt"), ["optiodom"]),
        (("judge", "--suite", "--unit", ""), ["rad", "ticks"]),
        (("calibrate", "--method", "u"), ["umbmark"]),
        (("calibrate", "--counter-bits", ""), ["16", "32"]),
        (("robots", "new", "---"), []),  # the help draws lines
        (("robots", "--mj"), []),  # the help speaks of another program's option
        # Where files belong bash offers them by itself.
        (("evaluate", ""), []),
        (("judge", "--robot", "ct_bot", "--", ""), []),
        (("judge", "--robot", "ct_bot", "--", "./mine", "--r"), []),
        (("nothing", "--x"), []),
    ],
)
def test_bash_offers_what_belongs_there(scripts, words, offered):
    assert completed("set -u; " + scripts["bash"], "diffdrive", *words) == offered


def test_the_other_shells_know_as_much(scripts):
    assert scripts["bash"] in scripts["zsh"]
    lines = scripts["fish"].splitlines()
    for name in commands():
        assert name in lines[0]
    judge = 'complete -c diffdrive -n "__fish_seen_subcommand_from judge"'
    assert f"{judge} -l suite" in lines
    assert f'{judge} -l unit -x -a "rad ticks"' in lines
    assert 'complete -c diffdrive -n "__fish_seen_subcommand_from robots" -f -a "list show new mjcf"' in lines


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_script_ends_with_its_last_line(scripts, shell):
    assert scripts[shell].endswith("\n")
    assert not scripts[shell].endswith("\n\n")


def test_zsh_alone_loads_what_understands_bash(scripts):
    assert scripts["zsh"].startswith("autoload ")
    assert not any("autoload" in scripts[shell] for shell in ("bash", "fish"))
