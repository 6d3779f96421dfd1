"""Commands in odd surroundings: no HOME, no room for temporary files, other locales, paths with any sign, no compiler.

    python -m benchmarks environments [NAME ...] [--commands COMMAND ...]

Every command runs in a process and a folder of its own. It must end with 0 and its answer, or with 2 and one sentence;
answers must be those of an ordinary surrounding, digit for digit. Needs /dev/full for the full disk.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from common import OUT, command_line, one_of, write_rows

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "docs" / "examples" / "contact.toml"
MAIN = (sys.executable, "-c", "from efficiency.cli import main; main()")
NAME = "Öl für 歯車 & 'co' $x [1]"
POINT = ("--pressure", "1 GPa", "--radius", "15 mm", "--speed", "3 m/s", "--slide-to-roll", "0.3",
         "--temperature", "90 degC")  # fmt: skip
COMMANDS: dict[str, tuple[str, ...]] = {
    "solve": ("solve", "case.toml", "--report", "page.html", "--plot", "figure.svg"),
    "mu": ("mu", "75w90", *POINT, "--json"),
    "sweep": ("sweep", "demo", "-o", "run", "--with", "xu_kahraman_2007", "--jobs", "2"),
    "fit": ("fit", "gear_fva3", "-o", "formula.json", "--family", "power_law"),
    "blank": ("blank", "iso23509_f2", "--json"),
    "gear": ("gear", "fm_spiral_bevel_14x39", "--friction", "75w90", "--xlsx", "book.xlsx", "--json"),
    "export": ("export", "75w90", "-o", "mu.py"),
}
LIGHT = ("solve", "mu", "blank", "export")  # what is fast enough without compiler


def ordinary(folder: Path) -> dict[str, str]:
    """The surroundings of the reference."""
    return {}


def no_home(folder: Path) -> dict[str, str]:
    """No HOME, and nothing else that says where to write."""
    return {"HOME": "", "XDG_CACHE_HOME": "", "MPLCONFIGDIR": "", "USER": ""}


def home_not_there(folder: Path) -> dict[str, str]:
    """HOME names a folder that cannot be made."""
    return {"HOME": "/proc/nowhere", "XDG_CACHE_HOME": "/proc/nowhere"}


def no_room(folder: Path) -> dict[str, str]:
    """Temporary files can be put nowhere."""
    return dict.fromkeys(("TMPDIR", "TEMP", "TMP"), "/proc/nowhere")


def turkish(folder: Path) -> dict[str, str]:
    """A locale with other rules for i, decimal comma, and messages in another language."""
    return {"LC_ALL": "tr_TR.UTF-8", "LANG": "tr_TR.UTF-8", "LANGUAGE": "tr"}


def ascii_only(folder: Path) -> dict[str, str]:
    """A locale and streams that know ASCII alone."""
    return {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"}


def other_zone(folder: Path) -> dict[str, str]:
    """A time zone that does not exist."""
    return {"TZ": "Nowhere/City"}


def narrow(folder: Path) -> dict[str, str]:
    """A terminal of ten columns without colours."""
    return {"COLUMNS": "10", "TERM": "dumb", "NO_COLOR": "1"}


def without_compiler(folder: Path) -> dict[str, str]:
    """Kernels run as plain Python."""
    return {"NUMBA_DISABLE_JIT": "1"}


def read_only(folder: Path) -> dict[str, str]:
    """The installed packages, and the cache of compiled kernels, cannot be written."""
    place = folder.parent / "packages"
    if not place.exists():
        for name in ("ehl", "regression", "efficiency", "data"):
            shutil.copytree(ROOT / name, place / name, ignore=shutil.ignore_patterns("__pycache__"))
        for path in (place, *place.rglob("*")):
            path.chmod(0o555 if path.is_dir() else 0o444)
    return {"PYTHONPATH": str(place), "PYTHONDONTWRITEBYTECODE": "1", "NUMBA_CACHE_DIR": "/proc/nowhere"}


SURROUNDINGS: dict[str, Callable[[Path], dict[str, str]]] = {
    found.__name__: found
    for found in (
        ordinary, no_home, home_not_there, no_room, turkish, ascii_only, other_zone, narrow, without_compiler, read_only
    )
}  # fmt: skip


def run(command: Sequence[str], changes: Mapping[str, str], folder: Path) -> subprocess.CompletedProcess[str]:
    """One command in one surrounding; empty values take a variable away."""
    folder.mkdir(parents=True)
    shutil.copy(EXAMPLE, folder / "case.toml")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **changes}
    environment = {name: value for name, value in environment.items() if value}
    return subprocess.run(
        [*MAIN, *command], cwd=folder, env=environment, capture_output=True, text=True, errors="replace", timeout=900
    )


def numbers(text: str) -> list[str]:
    """Lines that hold an answer; times of the run left out."""
    return [line for line in text.splitlines() if "seconds" not in line and " s" not in line and "/" not in line]


def main(argv: Sequence[str] | None = None) -> int:
    """Run all commands in all surroundings; 1 where one ends in another way than it must."""
    parser = command_line(__doc__)
    parser.add_argument("names", nargs="*", type=one_of(SURROUNDINGS))
    parser.add_argument("--commands", nargs="*", choices=COMMANDS, default=list(COMMANDS))
    options = parser.parse_args(argv)
    names = ["ordinary", *(options.names or list(SURROUNDINGS)[1:])]
    rows, answers, wrong = [], dict[str, list[str]](), 0
    with tempfile.TemporaryDirectory() as place:
        for name in names:
            for command in options.commands:
                if name == "without_compiler" and command not in LIGHT:
                    continue
                folder = Path(place) / name / NAME / command
                clock = time.perf_counter()
                done = run(COMMANDS[command], SURROUNDINGS[name](Path(place) / name), folder)
                outcome = {0: "answer", 2: "refusal"}.get(done.returncode, f"exit code {done.returncode}")
                if "Traceback" in done.stderr:
                    outcome = "traceback"
                if outcome == "answer" and "--json" in COMMANDS[command]:
                    same = answers.setdefault(command, numbers(done.stdout)) == numbers(done.stdout)
                    outcome = "answer" if same else "another answer"
                wrong += outcome not in ("answer", "refusal")
                seconds = round(time.perf_counter() - clock, 1)
                said = " ".join(done.stderr.split())[:300]
                rows.append(
                    {"surrounding": name, "command": command, "outcome": outcome, "seconds": seconds, "said": said}
                )
                print(*rows[-1].values(), flush=True)
                write_rows(OUT / "environments.csv", rows)
        for path in Path(place).rglob("*"):
            path.chmod(0o755)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
