"""The report page: one file that shows a folder's results, to be opened in a browser and sent to a colleague."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from string import Template

from diffdrive_mj import __version__
from diffdrive_mj._files import as_path, own_files, write_whole
from diffdrive_mj.errors import InvalidValue, MissingFile
from diffdrive_mj.report import _inline
from diffdrive_mj.report._cards import Rooms, card, overview
from diffdrive_mj.report._results import Result, clean, read_results
from diffdrive_mj.report._rooms import Room, escaped

NAME = "index.html"
# Bytes of a page, whatever there is to show; its parts share them.
LARGEST = 3_000_000
_CARDS, _TEXTS, _PICTURES, _REPLAYS = 200, 500_000, 1_100_000, 700_000
_MARK = '<meta name="generator" content="diffdrive_mj report">'


def page(folder: str | Path) -> Path:
    """Write the page of a folder's results, `index.html`: one file below 3 MB that needs no network.

    A card an experiment has its question, answer, pictures, replays, bounds and table, and the command, options and
    versions to run it again. What is missing, half written or of an older version, the card says. An earlier page is
    replaced; a file of that name that is no such page stays.

    Args:
        folder: whose folders hold the results, as `Report.write` leaves them; or that of one experiment.

    Returns:
        The path of the page.

    Raises:
        MissingFile: no such folder.
        InvalidValue: no results in it, another's `index.html` is in the way, or it cannot be written.

    Example:
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as results:
        ...     dd.report.Report("How far off?", "Hardly.", "", []).write(Path(results, "mine"))
        ...     dd.report.page(results).name
        'index.html'
    """
    place = as_path("folder", folder)
    makes = "diffdrive experiment mismatched_radii makes some"
    if not place.is_dir():
        raise MissingFile(f"{place}: no such folder of results; {makes}")
    refuse_foreign(place)
    try:
        results = read_results(place)
    except OSError as error:
        raise InvalidValue(f"{place}: cannot be read ({error.strerror})") from None
    if not results:
        raise InvalidValue(f"{place}: holds no results; {makes}")
    write_whole(place / NAME, html_of(results, place.resolve().name))
    return place / NAME


def refuse_foreign(folder: Path) -> None:
    """Refuse a folder whose `index.html` is not a page of results.

    Args:
        folder: which need not be there.

    Raises:
        InvalidValue: another's file is in the way.

    Example:
        >>> refuse_foreign(Path("nowhere"))
    """
    own_files(folder, [NAME], _own, "is not a page of results: move it, or choose another folder")


def _own(folder: Path) -> set[str]:
    try:
        with (folder / NAME).open(encoding="utf-8") as file:
            return {NAME} if _MARK in file.read(1000) else set()
    except (OSError, ValueError):
        return set()


def html_of(results: list[Result], name: str) -> str:
    """Put results into a page.

    Args:
        results: as `read_results` returns them.
        name: of their folder.

    Returns:
        The page, of less than `LARGEST` bytes.

    Example:
        >>> html_of([], "results").splitlines()[0]
        '<!DOCTYPE html>'
    """
    cards = _CARDS
    # The rooms hold what is usual; names and numbers of any length may still fill a page with fewer cards.
    while len((text := _html(results, name, cards)).encode()) >= LARGEST:
        cards //= 2
    return text


def _html(results: list[Result], name: str, most: int) -> str:
    """The page with so many cards at most; where not all have room, those that have something wrong come first."""
    kept = results if len(results) <= most else sorted(results, key=_harmless)[:most]
    rooms = Rooms(
        texts=Room(_TEXTS, len(kept), least=1_000, most=40_000),
        pictures=Room(_PICTURES, sum(len(result.pictures) for result in kept), least=8_000, most=250_000),
        replays=Room(_REPLAYS, sum(len(result.replays) for result in kept), least=6_000, most=80_000),
    )
    cards = "\n".join(card(result, index, rooms) for index, result in enumerate(kept))
    return Template(_inline.template()).substitute(
        policy=_inline.policy(),
        style=_inline.styles(),
        scripts=_inline.scripts(),
        title=f"{escaped(clean(name), 200)}: diffdrive_mj",
        folder=escaped(clean(name), 200),
        summary=_summary(results, len(kept)),
        overview=overview(kept),
        cards=cards,
        version=__version__,
        date=f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
    )


def _harmless(result: Result) -> bool:
    return not (result.broken or result.notes)


def _summary(results: list[Result], shown: int) -> str:
    """How many experiments, how many bounds, and what is broken."""
    bounds, broken = sum(len(result.bounds) for result in results), [result for result in results if result.broken]
    unread = sum(not result.question for result in results)
    asked = len(results) - unread
    count = f"{asked} question{'s' * (asked != 1)} asked"
    if broken:
        lost = sum(len(result.broken) for result in broken)
        names = escaped(", ".join(result.name for result in broken), 500)
        held = f'{bounds - lost} of {bounds} bounds hold; <strong class="bad">{lost} broken</strong>, in {names}'
    else:
        held = f"all {bounds} bounds hold" if bounds else "no bounds"
    left_out = f"; {len(results) - shown} results are left out, or the page would be too large" * (shown < len(results))
    unreadable = f"; {unread} result{'s' * (unread != 1)} cannot be read" * bool(unread)
    return f"{count}; {held}{unreadable}{left_out}."
