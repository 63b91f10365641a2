"""`diffdrive completion`: a script with which a shell completes commands and options."""

from __future__ import annotations

import contextlib
import io
import re
from typing import Annotated, Literal

import tyro

from diffdrive_mj.cli.program import commands, run

_BASH = """\
_diffdrive() {{
    local words
    case "$COMP_CWORD,${{COMP_WORDS[1]}}" in
    1,*) words="{commands}" ;;
{cases}
    esac
    COMPREPLY=($(compgen -W "$words" -- "${{COMP_WORDS[COMP_CWORD]}}"))
}}
complete -o default -F _diffdrive diffdrive
"""
_ZSH = "autoload -U +X bashcompinit && bashcompinit\n"
_FISH = """\
complete -c diffdrive -n __fish_use_subcommand -f -a "{commands}"
{cases}
"""


def command(
    shell: Annotated[
        Literal["bash", "zsh", "fish"],
        tyro.conf.Positional,
        tyro.conf.arg(metavar="bash|zsh|fish", help_behavior_hint="(required)"),
    ],
    /,
) -> None:
    """Print a script with which a shell completes commands and options.

      diffdrive completion bash >> ~/.bashrc

    Args:
        shell: bash, zsh or fish.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["completion", "bash"])
        _diffdrive() {
        ...
    """
    options = {name: _options(name) for name in commands()}
    if shell == "fish":
        cases = [
            f'complete -c diffdrive -n "__fish_seen_subcommand_from {name}" -l {option.removeprefix("--")}'
            for name, found in options.items()
            for option in found
        ]
        print(_FISH.format(commands=" ".join(options), cases="\n".join(cases)), end="")
        return
    lines = [f'    *,{name}) words="{" ".join(found)}" ;;' for name, found in options.items()]
    script = _BASH.format(commands=" ".join(options), cases="\n".join(lines))
    print(f"{_ZSH if shell == 'zsh' else ''}{script}", end="")


def _options(name: str) -> list[str]:
    """What a command's help names."""
    said = io.StringIO()
    with contextlib.suppress(SystemExit), contextlib.redirect_stdout(said):
        run(name, "--help")
    return sorted(set(re.findall(r"(?<![\w-])--[a-z][\w-]*", said.getvalue())))
