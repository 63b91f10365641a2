"""Cards of a page: one an experiment, in HTML in which no text from a file is more than text."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from diffdrive_mj.report._replay_data import replay_json
from diffdrive_mj.report._results import Result, clean
from diffdrive_mj.report._rooms import Room, escaped
from diffdrive_mj.report._shrinking import shrunk
from diffdrive_mj.report.experiment import Bound

# How the identifiers of the page's own parts begin, and those of cards without a plain name.
_TAKEN = ("results", "k-by-hand", "player", "result-")
# What is wider than a narrow page scrolls, by keys too.
_SCROLLS = 'role="group" tabindex="0"'
_NO_ROOM = "is left out, or the page would be too large"
# So many bounds have no room for sure.
_MANY = 300


@dataclass
class Rooms:
    """What the cards of a page share: room for texts, for pictures and for replays."""

    texts: Room
    pictures: Room
    replays: Room


def anchor(result: Result, index: int) -> str:
    """The identifier of a card: its name, if an address can hold it and no other part of the page can have it."""
    plain = re.fullmatch(r"[A-Za-z][\w-]{,99}", result.name, re.ASCII)
    free = not result.name.startswith(_TAKEN) and not result.name.endswith("-title")
    return result.name if plain and free else f"result-{index + 1}"


def overview(results: Iterable[Result]) -> str:
    """A line for each experiment: what it asks, and whether its bounds hold."""
    return "\n".join(
        f'<li><a href="#{anchor(result, index)}">{escaped(_question(result), 300)}</a>{_verdict(result)}</li>'
        for index, result in enumerate(results)
    )


def _question(result: Result) -> str:
    return result.question or result.name


def _verdict(result: Result) -> str:
    """In words as well as in colour."""
    if not result.bounds:
        unreadable = result.notes and not result.finding
        return f'<span class="verdict">{"cannot be read" if unreadable else "no bounds"}</span>'
    look, mark = ("bad", "✗") if result.broken else ("good", "✓")
    return f'<span class="verdict {look}">{mark} {_held(result)}</span>'


def _held(result: Result) -> str:
    """How many bounds hold, in words."""
    count, broken = len(result.bounds), len(result.broken)
    if broken:
        return f"{broken} of {count} bounds broken"
    return f"all {count} bounds hold" if count > 1 else "1 bound holds"


def card(result: Result, index: int, rooms: Rooms) -> str:
    """Everything that is known of an experiment, in an article."""
    most, name = rooms.texts.share(), anchor(result, index)
    parts = [
        f'<p class="kicker">{escaped(result.name, 200)}</p>',
        f'<h2 id="{name}-title">{escaped(_question(result), most // 8)}</h2>',
        *_finding(result.finding, most // 6),
    ]
    notes = list(result.notes)
    seen = [*_pictures(result, rooms.pictures, notes), *_replays(result, rooms.replays, notes)]
    parts += _notes(notes, most // 6)
    told = [*_bounds(result, most // 3), *_table(result.table, most // 3), *_again(result, most // 6)]
    rooms.texts.take(sum(len(part.encode()) for part in (*parts, *told)))
    return "\n".join(
        [f'<article class="card" id="{name}" aria-labelledby="{name}-title">', *parts, *seen, *told, "</article>"]
    )


def _notes(notes: list[str], most: int) -> list[str]:
    """What is missing or broken, a line each; of many the first."""
    made: list[str] = []
    for note in notes:
        line = f'<p class="note">{escaped(note, 400)}</p>'
        if made and sum(map(len, made)) + len(line) > most:
            return [*made, f'<p class="note">and {len(notes) - len(made)} more faults like these</p>']
        made.append(line)
    return made


def _finding(finding: str, most: int) -> list[str]:
    if not finding:
        return []
    lines = finding.split("\n", 1)
    rest = [f"<p>{escaped(lines[1], most)}</p>"] if len(lines) > 1 and lines[1].strip() else []
    return ['<div class="finding">', f"<p>{escaped(lines[0], most)}</p>", *rest, "</div>"]


def _pictures(result: Result, room: Room, notes: list[str]) -> list[str]:
    made = []
    for path in result.pictures:
        share = room.share()
        try:
            small = shrunk(path, share) if share else None
        except Exception as error:  # Pillow's decoders raise whatever they meet in a broken file
            notes.append(f"{path.name} cannot be shown ({error if isinstance(error, ValueError) else 'not a picture'})")
            continue
        if small is None:
            notes.append(f"{path.name} {_NO_ROOM}")
            continue
        room.take(len(small.source))
        about = escaped(f"{path.stem.replace('_', ' ')}: {_first_line(result)}", 500)
        made.append(
            f'<div class="picture" {_SCROLLS} aria-label="Picture, wider than a narrow page">'
            f'<img src="{small.source}" alt="{about}" width="{small.width}" height="{small.height}"></div>'
        )
    return made


def _first_line(result: Result) -> str:
    return (result.finding or _question(result)).split("\n", 1)[0]


def _bounds(result: Result, most: int) -> list[str]:
    if not result.bounds:
        return []
    # Where not all have room, the broken ones have.
    few = len(result.bounds) < _MANY and sum(len(_row(bound)) for bound in result.bounds) <= most
    rows: list[str] = []
    for bound in result.bounds if few else sorted(result.bounds, key=lambda bound: bound.holds):
        row = _row(bound)
        if rows and sum(map(len, rows)) + len(row) > most:
            break
        rows.append(row)
    left_out = len(result.bounds) - len(rows)
    opened = " open" if result.broken or len(result.bounds) <= 8 else ""
    more = [f"<p>and {left_out} more, in the experiment's metrics.json</p>"] if left_out else []
    return [
        f"<details{opened}><summary>Bounds: {_held(result)}</summary>",
        f'<div class="scroll" {_SCROLLS} aria-label="Bounds"><table class="bounds">',
        "<thead><tr><th>bound</th><th>value</th><th>limit</th><th>verdict</th></tr></thead><tbody>",
        *rows,
        "</tbody></table></div>",
        *more,
        "</details>",
    ]


def _row(bound: Bound) -> str:
    relation, unit = "≥" if bound.at_least else "≤", escaped(bound.unit, 60)
    verdict = '<td class="good number">✓ holds</td>' if bound.holds else '<td class="bad number">✗ BROKEN</td>'
    value = "not a number" if bound.value != bound.value else f"{bound.value:.4g}"
    return (
        f'<tr><td>{escaped(bound.name, 300)}</td><td class="number">{value}</td>'
        f"<td>{relation} {bound.limit:.4g} {unit}</td>{verdict}</tr>"
    )


def _table(table: str, most: int) -> list[str]:
    if not table.strip():
        return []
    text = escaped(table, most)
    return [f'<details><summary>The table</summary><pre tabindex="0">{text}</pre></details>']


def _again(result: Result, most: int) -> list[str]:
    """What it takes to get the same again."""
    rows = {
        "options": ", ".join(f"{name} = {value or '(none)'}" for name, value in result.options.items()),
        "versions": ", ".join(f"{name} {value}" for name, value in result.versions.items()),
        "date": result.date.replace("T", " ").removesuffix("+00:00") + " UTC" * result.date.endswith("+00:00"),
    }
    listed = [f"<dt>{name}</dt><dd>{escaped(text, most)}</dd>" for name, text in rows.items() if text]
    if result.command:
        head = [f'<pre class="command" tabindex="0">{escaped(result.command, most)}</pre>']
    else:
        head = ['<p class="aside">The command that made it is not recorded.</p>'] if result.versions else []
    if not head and not listed:
        return []
    return ["<h3>Run it again</h3>", *head, *(['<dl class="again">', *listed, "</dl>"] if listed else [])]


def _replays(result: Result, room: Room, notes: list[str]) -> list[str]:
    made = []
    for replay in result.replays:
        share = room.share()
        text = replay_json(replay, share) if share else None
        if text is None:
            notes.append(f"the replay {clean(replay.title[:80])!r} {_NO_ROOM}")
            continue
        room.take(len(text))
        made.append(f'<script type="application/json">{text}</script>')
    if not made:
        return []
    heading = f"Replay{f': {escaped(clean(result.replays[0].title), 200)}' if len(result.replays) == 1 else ''}"
    return [f'<div class="replay scripted-only"><h3>{heading}</h3>', *made, '<div class="player"></div></div>']
