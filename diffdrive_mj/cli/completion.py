"""`diffdrive completion`: a script with which a shell completes commands and options."""

from __future__ import annotations

import contextlib
import io
import re
from typing import Annotated, Literal, NamedTuple

import tyro

from diffdrive_mj.cli import experiment
from diffdrive_mj.cli.program import commands, run
from diffdrive_mj.robot import presets

# What is offered goes by the words before the cursor and the one at it; where nothing is, bash offers files.
_BASH = """\
_diffdrive() {{
    local IFS=$' \\t\\n' word="${{COMP_WORDS[COMP_CWORD]}}" words=""
    case "${{COMP_WORDS[*]:1:COMP_CWORD-1}} ,$word" in
    " ,"*) words="{commands}" ;;
    *" -- "*) ;;
{cases}
    esac
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o default -F _diffdrive diffdrive
"""
_ZSH = "autoload -U +X bashcompinit && bashcompinit\n"
_FISH = """\
complete -c diffdrive -n __fish_use_subcommand -f -a "{commands}"
{cases}
"""
# With or without a frame around it, and with its values if these are few.
_OPTION = re.compile(r"^[│| ] +((?:-h, )?--[a-z][\w-]*(?:, --[a-z][\w-]*)?)(?: \{([\w,]+)\})?", re.MULTILINE)
_ROBOTS = ("--robot", "--believed")


class Offer(NamedTuple):
    """What may follow a command: words, and options with the values that they take, if these are few.

    Example:
        >>> _offer("completion").words
        ['bash', 'zsh', 'fish']
    """

    words: list[str]
    options: dict[str, list[str]]


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
    offers: dict[tuple[str, ...], Offer] = {(name,): _offer(name) for name in commands()}
    # The first that fits is taken: what an action has comes before what its command has.
    offers = {("robots", action): _offer("robots", action) for action in offers["robots",].words} | offers
    cases = [line for words, offer in offers.items() for line in (_fish if shell == "fish" else _bash)(words, offer)]
    template = {"bash": _BASH, "zsh": _ZSH + _BASH, "fish": _FISH}[shell]
    print(template.format(commands=" ".join(commands()), cases="\n".join(cases)), end="")


def _bash(command: tuple[str, ...], offer: Offer) -> list[str]:
    """The cases of a command."""
    name = " ".join(command)
    found = {f'"{name} "*"{option} ,"*': values for option, values in offer.options.items() if values}
    found |= {f'"{name} ,"*': offer.words} if offer.words else {}
    found |= {f'"{name} "*",-"*': list(offer.options)}
    return [f'    {pattern}) words="{" ".join(words)}" ;;' for pattern, words in found.items()]


def _fish(command: tuple[str, ...], offer: Offer) -> list[str]:
    """The lines of a command."""
    seen = "; and ".join(f"__fish_seen_subcommand_from {word}" for word in command)
    start = f'complete -c diffdrive -n "{seen}"'
    values = {option: f' -x -a "{" ".join(few)}"' if few else "" for option, few in offer.options.items()}
    words = [f'{start} -f -a "{" ".join(offer.words)}"'] if offer.words else []
    return words + [f"{start} -l {option.removeprefix('--')}{few}" for option, few in values.items()]


def _offer(*command: str) -> Offer:
    """What a command's help names: at the head of a line an option, in braces its values or the command's actions."""
    if command == ("experiment",):  # each has options of its own
        return Offer(list(experiment.scripts()), {"--help": []})
    said = io.StringIO()
    with contextlib.suppress(SystemExit), contextlib.redirect_stdout(said):
        run(*command, "--help")
    usage, _, rest = said.getvalue().partition("\n")
    actions = re.search(r" \{([\w,]+)\}$| ([\w|]+\|\w+)$", usage)
    options: dict[str, list[str]] = {}
    for names, values in _OPTION.findall(rest):
        for option in re.findall(r"--[\w-]+", names):
            few = [value for value in values.split(",") if value not in ("", "None")]
            options[option] = list(presets()) if option in _ROBOTS else few
    return Offer(re.split(r"[,|]", next(filter(None, actions.groups()))) if actions else [], options)
