"""Folders and files that belong to this user alone: compiled kernels, and results kept between processes."""

from __future__ import annotations

import hashlib
import os
import pickle
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")

# results of one kind that are kept, the least recently used go first
ENTRIES = 64
_DIGEST = hashlib.sha256().digest_size


def private_folder(folder: Path) -> Path:
    """A folder that belongs to this user alone, made where there is none.

    folder: must be no symbolic link, and have mode 0700; the folders above it must belong to this user or the
        administrator, and nobody else may be able to replace what they hold.
    Returns: without symbolic links.
    Raises `OSError`: it cannot be made, or belongs to others as well.
    """
    folder = Path(os.path.abspath(folder))
    folder = Path(os.path.realpath(folder.parent), folder.name)
    for part in reversed((folder, *folder.parents)):
        part.mkdir(mode=0o700, exist_ok=True)
    if not hasattr(os, "getuid"):  # under Windows the folders of a user are the user's own
        return folder
    user = os.getuid()
    # in a user namespace the administrator of the machine has another number: that of the owner of the root folder
    trusted = {0, user, os.stat("/").st_uid}
    for part in folder.parents:
        found = part.lstat()
        if found.st_uid not in trusted or (found.st_mode & 0o022 and not found.st_mode & stat.S_ISVTX):
            raise PermissionError(f"others can replace what is in {part}")
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode):
        raise PermissionError(f"{folder} is a symbolic link or a file")
    if found.st_uid != user:
        raise PermissionError(f"{folder} belongs to another user")
    if found.st_mode & 0o077:
        raise PermissionError(f"{folder} is open to others (chmod 700 makes it private)")
    return folder


def user_folder(kind: str, first: Path | None = None, refused: Callable[[str], None] | None = None) -> Path:
    """The private folder for one kind of files.

    It is `first`, else one in the user's cache folder, else one for temporary files: the first that belongs to this
    user alone, as of `private_folder`, and can be written.

    kind: name of the folder.
    first: a folder that the user names.
    refused: called with the reason where `first` is not used.
    Raises `OSError`: there is none.
    """
    user = os.getuid() if hasattr(os, "getuid") else 0
    own = os.environ.get("XDG_CACHE_HOME", "")
    cache = Path(own if os.path.isabs(own) else os.path.expanduser("~/.cache"), "mixed-ehl")
    reason = ""
    for place in (first, cache / kind, Path(tempfile.gettempdir(), f"mixed-ehl-{kind}-{user}")):
        if place is None:
            continue
        try:
            if not place.is_absolute() and place is not first:  # no home
                continue
            folder = private_folder(place)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError as error:
            if place is first and refused is not None:
                refused(f"{error}")
            reason = f"{error}"
        else:
            return folder
    raise PermissionError(reason)


def kept(kind: str, key: str, make: Callable[[], T]) -> T:
    """A result from the private folder of its kind; computed, and kept there, where it is not found.

    An entry that is damaged, or belongs to another user, counts as none. With ``MIXED_EHL_CACHE=off`` nothing is read
    or written; a path there is the folder of the entries.

    kind: name of the folder.
    key: hash of all that the result follows from, versions of the program and its packages among it.
    make: computes the result; it must pickle.
    """
    place = os.environ.get("MIXED_EHL_CACHE", "")
    if place.lower() == "off":
        return make()
    try:
        path = user_folder(kind, Path(place, kind) if place else None) / key
    except OSError:
        return make()
    content = _own_content(path)
    if content[:_DIGEST] == hashlib.sha256(content[_DIGEST:]).digest():
        with suppress(Exception):  # whatever a class that has changed since raises
            found: T = pickle.loads(content[_DIGEST:])
            os.utime(path)
            return found
    result = make()
    content = pickle.dumps(result, pickle.HIGHEST_PROTOCOL)
    with suppress(OSError):  # a full disk: it is computed again
        _replace(path, hashlib.sha256(content).digest() + content)
    return result


def _own_content(path: Path) -> bytes:
    """Content of a file of this user; empty where there is none."""
    try:
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0))
    except OSError:
        return b""
    with open(number, "rb") as file:
        found = os.fstat(number)
        user = os.getuid() if hasattr(os, "getuid") else found.st_uid
        return file.read() if stat.S_ISREG(found.st_mode) and found.st_uid == user else b""


def _replace(path: Path, content: bytes) -> None:
    """Write a file under a temporary name and rename it; of its folder the least recently used files go."""
    number, draft = tempfile.mkstemp(dir=path.parent)
    try:
        with open(number, "wb") as file:
            file.write(content)
        os.replace(draft, path)
    except OSError:
        os.unlink(draft)
        raise
    entries = sorted(path.parent.iterdir(), key=lambda entry: entry.stat().st_mtime)
    for entry in entries[:-ENTRIES]:
        entry.unlink(missing_ok=True)
