"""Private folders and files of the user: compiled kernels, and cached results."""

import hashlib
import os
import pickle
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

from ehl.common.errors import InputError
from ehl.common.files import write_file

T = TypeVar("T")

# number of cached results of one kind; the least recently used are removed
ENTRIES = 64
_DIGEST = hashlib.sha256().digest_size


def private_folder(folder: Path) -> Path:
    """A folder that only this user can access; it is created if it does not exist.

    folder: must not be a symbolic link and must have mode 0700. Its parent folders must belong to this user or the
        administrator, and others must not be able to replace their contents.
    Returns: path without symbolic links.
    Raises `OSError`: the folder cannot be created, or others have access to it.
    """
    folder = Path(os.path.abspath(folder))
    folder = Path(os.path.realpath(folder.parent), folder.name)
    for part in reversed((folder, *folder.parents)):
        part.mkdir(mode=0o700, exist_ok=True)
    if not hasattr(os, "getuid"):  # the folders of a user are private under Windows
        return folder
    user = os.getuid()
    # in a user namespace the administrator has the number of the owner of the root folder
    trusted = {0, user, os.stat("/").st_uid}
    for part in folder.parents:
        found = part.lstat()
        if found.st_uid not in trusted or (found.st_mode & 0o022 and not found.st_mode & stat.S_ISVTX):
            raise PermissionError(f"other users can modify {part}")
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

    The candidates are `first`, the cache folder of the user, and the folder for temporary files. The first one that is
    private (see `private_folder`) and writable is used.

    kind: name of the folder.
    first: a folder chosen by the user.
    refused: called with the reason if `first` is not used.
    Raises `OSError`: there is no such folder.
    """
    user = os.getuid() if hasattr(os, "getuid") else 0
    own = os.environ.get("XDG_CACHE_HOME", "")
    cache = Path(own if os.path.isabs(own) else os.path.expanduser("~/.cache"), "mixed-ehl")
    reason = ""
    for place in (first, cache / kind, Path(tempfile.gettempdir(), f"mixed-ehl-{kind}-{user}")):
        if place is None:
            continue
        try:
            if not place.is_absolute() and place is not first:  # no home folder
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
    """A result from the private folder of its kind; if it is not there, it is computed and stored.

    Entries that are damaged or belong to another user are ignored. With ``MIXED_EHL_CACHE=off`` nothing is read or
    written; a path in this variable is the folder of the entries.

    kind: name of the folder.
    key: hash of all inputs of the result, including the versions of the program and its packages.
    make: computes the result, which must be picklable.
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
        with suppress(Exception):  # a class that has changed may raise any error
            found: T = pickle.loads(content[_DIGEST:])
            os.utime(path)
            return found
    result = make()
    content = pickle.dumps(result, pickle.HIGHEST_PROTOCOL)
    with suppress(InputError, OSError):  # disk full: the result is computed again next time
        write_file(path, hashlib.sha256(content).digest() + content)
        for entry in sorted(path.parent.iterdir(), key=lambda entry: entry.stat().st_mtime)[:-ENTRIES]:
            entry.unlink(missing_ok=True)
    return result


def _own_content(path: Path) -> bytes:
    """Content of a file of this user; empty if there is none."""
    try:
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0))
    except OSError:
        return b""
    with open(number, "rb") as file:
        found = os.fstat(number)
        user = os.getuid() if hasattr(os, "getuid") else found.st_uid
        return file.read() if stat.S_ISREG(found.st_mode) and found.st_uid == user else b""
