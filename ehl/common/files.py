"""Reading and writing of files, with an `InputError` if that fails.

All files given by users are read here: pipes and devices, files that are too large, and data that are nested too deep
are refused before memory is allocated.
"""

import errno
import json
import os
import re
import secrets
import shutil
import stat
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ehl.common.errors import InputError

PAGE = (".html", ".htm")
FIGURE = (".png", ".svg", ".pdf")
MAX_BYTES = 100_000_000  # largest size of a text file, about 10^6 rows of a table
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x19\x1b-\x1f]")  # \x1a is the end mark of old programs
_DRAFT, _DRAFT_AGE = ".mixed-ehl-", 3600.0  # name of a temporary file; time [s] after which it is abandoned
_cleaned: set[Path] = set()  # folders that this process has cleaned of abandoned ones
MAX_KEYS = 10_000  # in all tables of a file; input files have a few hundred
MAX_DEPTH = 50  # nesting of tables and lists; input files have at most 7 levels


def read_bytes(path: str | Path, field: str, allowed: str) -> bytes:
    """Content of a file given by the user.

    field, allowed: of the error.
    Raises `InputError`: the file does not exist, is not a regular file, is too large, or cannot be read.
    """
    name = str(path)
    try:
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            kind = "folder" if stat.S_ISDIR(status.st_mode) else "pipe or device"
            raise InputError(field, name, allowed, f"It is a {kind}, not a file.")
        if status.st_size > MAX_BYTES:
            raise InputError(field, name, allowed, f"It has {status.st_size} bytes; at most {MAX_BYTES} are read.")
        with open(path, "rb") as file:
            return file.read(status.st_size)
    except FileNotFoundError:
        raise InputError(field, name, allowed, "The file does not exist; check the path.") from None
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(field, name, allowed, f"It could not be read: {error}.") from None


def read_text(path: str | Path, field: str, allowed: str) -> str:
    """Content of a text file in UTF-8, UTF-16 or, as the last choice, cp1252; `InputError` for other content."""
    content = read_bytes(path, field, allowed)
    try:
        return _decoded(content)
    except ValueError:
        raise InputError(field, str(path), allowed, "The file is not a text.") from None


def _decoded(content: bytes) -> str:
    """Text with its encoding determined from its content: byte order mark, zero bytes, validity as UTF-8.

    Raises `ValueError`: control characters, or an invalid encoding: the file is of another kind.
    """
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        text = content.decode("utf-16")
    elif content[:200].count(0) > 0.3 * len(content[:200]):  # digits and separators in UTF-16 without a mark
        text = content.decode("utf-16-le" if content[1:2] == b"\0" else "utf-16-be")
    else:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("cp1252", errors="replace")
    if _CONTROL.search(text):
        raise ValueError("control characters")
    return text


def parse_toml(text: str, field: str, name: str) -> dict[str, Any]:
    """Content of a TOML text; `InputError` with `field` and the `name` of the file if it is invalid."""
    try:
        content: dict[str, Any] = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a number of 10 000 digits is a plain ValueError
        raise InputError(field, name, "valid TOML", f"{_reason(error)}.") from None
    _check_depth(content, field, name, "valid TOML")
    return content


def parse_json(text: str | bytes, field: str, name: str, allowed: str = "valid JSON") -> Any:
    """Content of a JSON text; `InputError` with `field` and the `name` of the file if it is invalid."""
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(field, name, allowed, f"It could not be read: {_reason(error)}.") from None
    _check_depth(content, field, name, allowed)
    return content


def _reason(error: Exception) -> str:
    return f"it is nested deeper than {MAX_DEPTH} levels" if isinstance(error, RecursionError) else str(error)


def _check_depth(content: Any, field: str, name: str, allowed: str) -> None:
    """Raise an `InputError` for data nested too deep for recursive functions, or with too many keys."""
    level, keys = [content] if isinstance(content, (dict, list)) else [], 0
    for _ in range(MAX_DEPTH):
        keys += sum(len(part) for part in level if isinstance(part, dict))
        if keys > MAX_KEYS:
            raise InputError(field, name, allowed, f"It has more than {MAX_KEYS} entries.")
        level = [
            item
            for part in level
            for item in (part.values() if isinstance(part, dict) else part)
            if isinstance(item, (dict, list))
        ]
        if not level:
            return
    raise InputError(field, name, allowed, f"It is nested deeper than {MAX_DEPTH} levels.")


def make_folder(folder: Path, field: str) -> None:
    """Create a folder and its parents if they do not exist.

    Raises `InputError`: the folder of `field` cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        taken = isinstance(error, FileExistsError | NotADirectoryError)
        hint = "There is a file of that name; choose another." if taken else f"{error}."
        raise InputError(field, str(folder), "a folder that can be written", hint) from None


@contextmanager
def replacing(path: Path, field: str = "path") -> Iterator[Path]:
    """Path of a temporary file in which the block writes the content of `path`; afterwards it is synced and renamed.

    A file is therefore complete or unchanged if the process or the machine stops. All output files are written this
    way, except that devices and pipes are written in place. Missing folders are created.

    Raises `InputError`: the file of `field` cannot be written.
    """
    _refuse_planted_links(Path(os.path.abspath(path)), field)
    target = Path(os.path.realpath(path))
    draft = target.with_name(f"{_DRAFT}{secrets.token_hex(8)}{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if os.path.exists(target) and not os.path.isfile(target):
            yield target
            return
        if os.path.isfile(target) and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(target))
        try:
            # a new file, not an existing link
            os.close(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            if target.parent not in _cleaned:
                _remove_drafts(target.parent, draft.stat().st_mtime)
            yield draft
            with open(draft, "rb+") as file:
                os.fsync(file.fileno())
            if os.path.isfile(target):
                shutil.copymode(target, draft)
            os.replace(draft, target)
        finally:
            draft.unlink(missing_ok=True)
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(field, str(path), "a writable file", f"{error}.") from None


def _refuse_planted_links(path: Path, field: str) -> None:
    """Raise an `InputError` for a link of another user in a folder open to all, such as /tmp; it may lead anywhere.

    Linux does not follow these links when a file is opened (``fs.protected_symlinks``), but renaming avoids that.
    """
    for part in (path, *path.parents):
        try:
            link, folder = part.lstat(), part.parent.stat()
        except (OSError, ValueError):  # nothing there
            continue
        shared = folder.st_mode & stat.S_ISVTX and folder.st_mode & stat.S_IWOTH
        if stat.S_ISLNK(link.st_mode) and shared and link.st_uid not in (os.getuid(), folder.st_uid):
            raise InputError(field, str(part), "no link of another user", "Choose a file in a folder of your own.")


def _remove_drafts(folder: Path, now: float) -> None:
    """Remove what killed processes of this user left in a folder; a younger draft may be in use.

    now: modification time of a new file there, as the clocks of two machines may differ.
    """
    _cleaned.add(folder)
    for left in folder.glob(f"{_DRAFT}*"):
        with suppress(OSError):
            status = left.lstat()
            own = not hasattr(os, "getuid") or status.st_uid == os.getuid()
            if own and stat.S_ISREG(status.st_mode) and now - status.st_mtime > _DRAFT_AGE:
                left.unlink()


def write_file(path: Path, content: str | bytes, field: str = "path") -> None:
    """Write a file by `replacing`.

    Raises `InputError`: the file of `field` cannot be written.
    """
    with replacing(path, field) as draft:
        draft.write_bytes(content.encode(errors="replace") if isinstance(content, str) else content)


def toml_text(content: dict[str, Any]) -> str:
    """Tables as TOML text."""
    return "\n".join(_toml_lines(content, ()))


def _toml_lines(table: dict[str, Any], path: tuple[str, ...]) -> list[str]:
    plain = {key: value for key, value in table.items() if not isinstance(value, dict)}
    lines = [f"[{'.'.join(map(_toml_key, path))}]"] if path and (plain or not table) else []
    lines += [f"{_toml_key(key)} = {_toml_literal(value)}" for key, value in plain.items()]
    lines += [""] if lines else []
    for key, value in table.items():
        if isinstance(value, dict):
            lines += _toml_lines(value, (*path, key))
    return lines


def _toml_key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _toml_literal(key)


def _toml_literal(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_toml_key(key)} = {_toml_literal(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(_toml_literal(entry) for entry in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    return repr(value)
