"""Paths as the package takes them, and files written whole or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from diffdrive_mj._text import shown
from diffdrive_mj.errors import DiffdriveError, InvalidType, InvalidValue, MissingFile


def as_path(name: str, value: object) -> Path:
    """The path of a file or a folder.

    Raises:
        InvalidType: neither a string nor a path.
        InvalidValue: empty, with a character that no file name has, too long, or behind a locked folder.
    """
    text = os.fspath(value) if isinstance(value, os.PathLike) else value
    if not isinstance(text, str):
        raise InvalidType(f"{name} = {shown(value)}: must be a path, as a string or a Path")
    if not text or "\0" in text:
        raise InvalidValue(f"{name} = {shown(text)}: must name a file or a folder")
    path = Path(text)
    try:
        path.exists()
    except OSError as error:
        raise InvalidValue(f"{name} = {shown(text)}: {error.strerror}") from None
    return path


def folder_with(name: str, value: object, parts: Iterable[str]) -> Path:
    """The path of a folder that is there, and holds some other folders.

    Raises:
        InvalidType, InvalidValue: not a path.
        MissingFile: it is not there, or lacks a part; the message names it.
    """
    root = as_path(name, value)
    for place in (root, *(root / part for part in parts)):
        if not place.is_dir():
            raise MissingFile(f"{name} = {shown(str(value))}: {place} is not a folder")
    return root


def write_whole(path: str | Path, content: str | bytes | Iterable[str]) -> None:
    """Write a file whole or not at all; an earlier one stays until the new one is complete.

    A link is followed, and an earlier file's permissions are kept.

    Args:
        path: of the file.
        content: bytes; or a text for a file in UTF-8, or its parts, one after the other.

    Raises:
        InvalidType: not a path.
        InvalidValue: it cannot be written.
    """
    # "x": nothing that is there already, not even a link, is written to.
    with made_whole(path) as new, new.open("xb") as file:
        parts = [content] if isinstance(content, str | bytes) else content
        file.writelines(part.encode() if isinstance(part, str) else part for part in parts)


@contextmanager
def made_whole(path: str | Path, folder: bool = False) -> Iterator[Path]:
    """Give the path of a new file, or of a new folder, that takes the place of `path` when the block has made it.

    A file replaces an earlier one and keeps its permissions; a folder replaces nothing. A link is followed.

    Args:
        path: of the file or the folder.
        folder: whether it is a folder.

    Raises:
        InvalidType: not a path.
        InvalidValue: it cannot be written, is a device or a pipe, or a folder where there is something already.
    """
    path = as_path("path", path)
    if not path.name:
        raise InvalidValue(f"path = {shown(str(path))}: must name a {'folder' if folder else 'file'}")
    try:
        target = path.resolve()
        if folder and target.exists():
            raise InvalidValue(f"{path}: is there already, and no folder is overwritten")
        if target.exists() and not target.is_file() and not target.is_dir():
            raise InvalidValue(f"{path}: is a device or a pipe, which no file replaces")
        # Of the same name: what is made may hold it. Its ending is the path's, not that of what a link leads to.
        # A name has at most 255 bytes, a character up to four.
        place = target.with_name(f".{target.name[:50]}-{secrets.token_hex(8)}")
        try:
            place.mkdir()
            new = place / path.name
            yield new
            if target.exists():
                new.chmod(stat.S_IMODE(target.stat().st_mode))
            new.replace(target)
        finally:
            shutil.rmtree(place, ignore_errors=True)
    except DiffdriveError:
        raise
    except (OSError, ValueError, RuntimeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InvalidValue(f"{path}: cannot be written ({reason})") from None


def own_files(folder: Path, names: Iterable[str], listed: Callable[[Path], set[str]], foreign: str) -> set[str]:
    """What an earlier run has left in a folder.

    Args:
        folder: which need not be there.
        names: of the files that shall be written into it.
        listed: reads from the folder which files an earlier run says it has left; none where there is no such list.
        foreign: what to say of a file that is in the way and is not one of these.

    Raises:
        InvalidValue: there is such a file.
    """
    # Looked up before the list is read, so that what another run is just writing is in it.
    there = [name for name in names if os.path.lexists(folder / name)]
    own = listed(folder)
    for name in there:
        if name not in own:
            raise InvalidValue(f"{folder / name}: {foreign}")
    return own


def refuse_existing(path: Path, kind: str = "file") -> None:
    """Refuse a file or folder of the user's that is there already.

    Args:
        path: that is to be new.
        kind: what it is, for the message.

    Raises:
        InvalidValue: it is there, or a link to nowhere is.
    """
    if path.exists() or path.is_symlink():
        raise InvalidValue(f"{path}: is there already and is not overwritten; name another {kind}")


def replace_all(folder: Path, files: Mapping[str, str | bytes], earlier: set[str]) -> None:
    """Write files into a folder, each whole or not at all, and remove earlier ones that are no longer made.

    Args:
        folder: it and its parents are made.
        files: their contents by name. The first is the list that says which files are one's own: whoever writes at the
            same time finds it.
        earlier: the files that are one's own already.

    Raises:
        InvalidValue: the folder cannot be made, or a file cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidValue(f"{folder}: cannot be written ({error.strerror})") from None
    for name, content in files.items():
        write_whole(folder / name, content)
    for name in earlier.difference(files):
        (folder / name).unlink(missing_ok=True)
