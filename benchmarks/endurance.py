"""Endurance: mutated inputs of every kind of file the program reads; each gives an answer or one clear refusal.

    python -m benchmarks endurance [--count N] [--kinds KIND ...] [--commands N] [--seed S] [--minutes M]

Sound files are mutated: bits, pieces and lines at random, and values, keys and units where they stand. What runs a line
of the program that no input of its kind ran before, or gives an answer or a refusal not seen before, joins the sound
files and is mutated further (guidance by coverage, from Python 3.12 on, and by outcome). Each kind goes
through its reader and what is checked and computed before solving; ``--commands`` puts files through whole commands,
which stop where solving begins. Anything but an answer or an `InputError` of readable length is a traceback; more than
ten seconds of processor time is a hang; numbers that are not finite, or of the wrong sign, are impossible answers.
Inputs of all three are kept below ``--out``.
"""

from __future__ import annotations

import contextlib
import io
import random
import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from common import OUT, command_line, write_rows
from endurance_kinds import Impossible, Kind, Reached, kinds, stopped

import efficiency
import ehl
import regression
from efficiency.cli import main as mixed_ehl
from ehl import MixedEhlError

HANG = 10.0  # s of processor time; and ten times that on the clock, for what only waits
CLOCKS = ((signal.SIGPROF, signal.ITIMER_PROF, HANG), (signal.SIGALRM, signal.ITIMER_REAL, 10.0 * HANG))
SUFFIXES = ("", ".toml", ".json", ".csv", ".py")  # of what commands write
CORPUS = 300  # files kept for further mutation because of what they give; those that reach new lines all
NUMBERS = (
    "0", "-1", "1e308", "-1e308", "1e-320", "nan", "inf", "-inf", "1e400", "9" * 400, "0x10", "1_0", "1,5", "-0.0",
    "true", '"x"', '""', "[]", "{}", "[1, 2]", "null", '"1 GPa"', '"5 degC"', '"-300 degC"', '"1 m m"', '"1e999 m"',
    "2", "100000", "0.5", "1e-12", "1e",
)  # fmt: skip
TOKENS = (b"=", b"[", b"]", b"{", b"}", b'"', b"'", b",", b";", b"\t", b"\n", b"\r", b"\x00", b"\xff", b"#",
          b"\xef\xbb\xbf", b"\xe2\x80\xae", b"[[", b"]]", b"..", b"\\u", b"$", b"%s", b"NaN", b"1e999", b"-", b"=1+1",
          b"[/bold]")  # fmt: skip
NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])")
NAME = re.compile(rb"[A-Za-z_][A-Za-z_0-9]{2,}")


class Hang(BaseException):
    """The alarm rang."""


class Coverage:
    """Lines of the program that run for the first time; before Python 3.12 none are seen."""

    OWN = tuple(str(Path(package.__file__).parent) for package in (ehl, regression, efficiency))

    def __init__(self) -> None:
        self.lines = 0
        self.monitoring: Any = getattr(sys, "monitoring", None)

    def __enter__(self) -> Coverage:
        if self.monitoring:
            tool, line = self.monitoring.COVERAGE_ID, self.monitoring.events.LINE
            self.monitoring.use_tool_id(tool, "endurance")
            self.monitoring.register_callback(tool, line, self._line)
            self.monitoring.set_events(tool, line)
        return self

    def __exit__(self, *given: object) -> None:
        if self.monitoring:
            self.monitoring.set_events(self.monitoring.COVERAGE_ID, 0)
            self.monitoring.free_tool_id(self.monitoring.COVERAGE_ID)

    def _line(self, code: Any, line: int) -> object:
        self.lines += code.co_filename.startswith(self.OWN)
        return self.monitoring.DISABLE  # each line is heard of once, so that this costs next to nothing

    def restart(self) -> None:
        """Hear of every line once more."""
        self.lines = 0
        if self.monitoring:
            self.monitoring.restart_events()


@dataclass
class Tally:
    """Outcomes of one kind."""

    kind: str
    counts: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    lines: int = 0  # of the program that ran
    seconds: float = 0.0

    def add(self, other: Tally) -> None:
        """Add the outcomes of another round."""
        self.counts += other.counts
        self.faults += other.faults
        self.lines = max(self.lines, other.lines)
        self.seconds += other.seconds

    def row(self) -> dict[str, object]:
        """As a row of the table."""
        names = ("answer", "refusal", "traceback", "hang", "impossible")
        counts = {name: self.counts[name] for name in names}
        return {"kind": self.kind, "inputs": sum(self.counts.values()), **counts, "lines": self.lines}


def mutate(content: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    """One to four changes of a file."""
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        content = rng.choice(MUTATIONS)(content, others, rng)
    return content


def _bits(content: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 3))):
        if data:
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def _piece(content: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    start = rng.randrange(len(content) + 1)
    stop = min(len(content), start + rng.choice((1, 5, 50, 1000)))
    piece = rng.choice((b"", content[start:stop] * 2, rng.choice(TOKENS), rng.choice(TOKENS) + content[start:stop]))
    return content[:start] + piece + content[stop:]


def _cut(content: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


def _lines(content: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    lines = content.split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    way = rng.randrange(4)
    if way == 0:
        del lines[i]
    elif way == 1:
        lines.insert(j, lines[i])
    elif way == 2:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines.insert(i, rng.choice(rng.choice(others).split(b"\n")))
    return b"\n".join(lines)


def _number(content: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    places = list(NUMBER.finditer(content[:200_000]))
    if not places:
        return _piece(content, others, rng)
    place = rng.choice(places)
    value = rng.choice(NUMBERS).encode()
    if rng.random() < 0.4:
        value = repr(float(place[0]) * rng.choice((0.1, 0.5, 0.9, 1.1, 2.0, 10.0, 1e3, 1e-3, -1.0))).encode()
    return content[: place.start()] + value + content[place.end() :]


def _name(content: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    places = list(NAME.finditer(content[:200_000]))
    if len(places) < 2:
        return _piece(content, others, rng)
    place, other = rng.choice(places), rng.choice(places)[0]
    new = rng.choice((other, other, place[0][:-1], b"unknown", b"n" * 5000, "歯車".encode(), b""))
    return content[: place.start()] + new + content[place.end() :]


MUTATIONS = (_bits, _piece, _cut, _lines, _lines, _number, _number, _number, _name)


def mutate_workbook(content: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    """Bits of the whole file, or changes of one part inside."""
    if rng.random() < 0.2:
        return rng.choice((_bits, _cut, _piece))(content, others, rng)
    try:
        book, new = zipfile.ZipFile(io.BytesIO(content)), io.BytesIO()
        parts = {name: book.read(name) for name in book.namelist()}
    except Exception:
        return _bits(content, others, rng)
    name = rng.choice([*parts, *[part for part in parts if "sheet1" in part or "shared" in part] * 5])
    with zipfile.ZipFile(new, "w") as changed:
        for part, old in parts.items():
            changed.writestr(part, mutate(old, [old], rng) if part == name else old)
    return new.getvalue()


def outcome(task: Callable[[], object]) -> tuple[str, str]:
    """What a task gives, and a signature of it."""

    def ring(number: int, frame: object) -> None:
        raise Hang

    for number, timer, seconds in CLOCKS:
        signal.signal(number, ring)
        signal.setitimer(timer, seconds)
    try:
        task()
        return "answer", "answer"
    except Reached:
        return "answer", "reached"
    except MixedEhlError as error:
        text = str(error)
        if len(text) > 5000 or not text.strip():
            return "traceback", f"{len(text)} characters"
        place = re.sub(r"\d+", "0", str(getattr(error, "field", "")).rpartition("/")[2])[:60]
        return "refusal", f"{place}: {re.sub(r'[0-9]+', '0', str(getattr(error, 'allowed', '')))[:60]}"
    except Hang:
        return "hang", "".join(traceback.format_exc().splitlines()[-6:-1])[-300:]
    except Impossible as error:
        return "impossible", str(error)[:200]
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        own = [step for step in traceback.extract_tb(error.__traceback__) if "benchmarks" not in step.filename]
        steps = " < ".join(f"{Path(step.filename).stem}:{step.lineno}" for step in (own or [where])[-1:-4:-1])
        return "traceback", f"{type(error).__name__}: {str(error)[:100]} [{steps}]"
    finally:
        for _, timer, _ in CLOCKS:
            signal.setitimer(timer, 0.0)


def command(arguments: Sequence[str]) -> None:
    """Run a whole command; its refusal is an exit code 2 and one sentence."""
    out, said = io.StringIO(), io.StringIO()
    code: object = 0
    with (
        mock.patch.object(sys, "argv", ["mixed-ehl", *arguments]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(said),
    ):
        try:
            mixed_ehl()
        except SystemExit as end:
            code = end.code
    words = said.getvalue()
    if code == 2:
        if not words.strip() or "Traceback" in words:
            raise RuntimeError(f"exit code 2 says {words[:100]!r}")
        raise ehl.InputError("command", None, words.replace(tempfile.gettempdir(), "")[:60])
    if code not in (0, 1):
        raise RuntimeError(f"exit code {code}: {words[-300:]}")


def run(
    name: str, kind: Kind, count: int, folder: Path, seed: int, keep: Path, until: float, whole: bool, covered: Coverage
) -> Tally:
    """Mutate, read and count."""
    covered.restart()
    rng = random.Random(f"{seed} {name} {whole}")
    tally, corpus, seen = Tally(f"{name} by command" if whole else name), list(kind.seeds), set[str]()
    change = mutate_workbook if kind.suffix == ".xlsx" else mutate
    path, began = folder / f"input{kind.suffix}", time.perf_counter()
    places = {"FILE": str(path)} | {f"OUT{suffix}": str(folder / f"out{suffix}") for suffix in SUFFIXES}

    def task() -> None:
        if whole:
            command([places.get(word, word) for word in kind.commands[number % len(kind.commands)]])
        else:
            kind.read(path)

    for number in range(count):
        if time.perf_counter() > until:
            break
        # the sound files first; then half of the mutations from them, half from what was found
        sound = number < len(kind.seeds) * (len(kind.commands) if whole else 1)
        start = (
            kind.seeds[number % len(kind.seeds)] if sound else rng.choice(kind.seeds if rng.random() < 0.5 else corpus)
        )
        content = start if sound else kind.repair(change(start, corpus, rng))
        path.write_bytes(content)
        lines = covered.lines
        what, signature = outcome(task)
        if sound and what != "answer":
            what, signature = "impossible", f"sound file {number} gives {what}: {signature}"
        tally.counts[what] += 1
        if what in ("answer", "refusal"):
            new = covered.lines > lines or (signature not in seen and len(corpus) < CORPUS)
            if new and len(content) < 10 * len(start) + 1000:
                corpus.append(content)
            seen.add(signature)
        else:
            if signature not in tally.faults:
                keep.mkdir(parents=True, exist_ok=True)
                (keep / f"{name}_{what}_{number}{kind.suffix}").write_bytes(content)
            tally.faults[signature] += 1
    tally.lines, tally.seconds = covered.lines, time.perf_counter() - began
    return tally


def main(argv: Sequence[str] | None = None) -> int:
    """Run the campaign; 1 where anything but answers and refusals came."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=500, help="inputs of each kind through its reader, each round")
    parser.add_argument("--commands", type=int, default=10, help="inputs of each kind through commands, each round")
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--kinds", nargs="*", help="these alone")
    parser.add_argument("--seed", type=int, default=1, help="of the first round")
    parser.add_argument("--minutes", type=float, default=60.0, help="start nothing after this time")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args(argv)
    tallies = campaign(
        options.count, options.commands, range(options.seed, options.seed + options.rounds), options.minutes,
        options.out, options.kinds,
    )  # fmt: skip
    return int(any(tally.faults for tally in tallies))


def campaign(
    count: int, commands: int, seeds: Sequence[int], minutes: float, out: Path, names: Sequence[str] | None = None
) -> list[Tally]:
    """All kinds in every round; prints and writes the table."""
    until, tallies = time.perf_counter() + 60.0 * minutes, dict[tuple[str, bool], Tally]()
    with tempfile.TemporaryDirectory() as place, contextlib.ExitStack() as ends, np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        folder = Path(place)
        found = kinds(folder)
        ends.enter_context(stopped())
        covered = ends.enter_context(Coverage())
        for seed in seeds:
            for name, kind in found.items():
                for number, whole in ((count, False), (commands if kind.commands else 0, True)):
                    if number and (not names or name in names):
                        tally = run(name, kind, number, folder, seed, out / "endurance", until, whole, covered)
                        for signature, times in tally.faults.most_common():
                            print(f"{tally.kind}, seed {seed}: {times} x {signature}", flush=True)
                        tallies.setdefault((name, whole), Tally(tally.kind)).add(tally)
            write_rows(out / "endurance.csv", [tally.row() for tally in tallies.values()])
    for tally in tallies.values():
        print(*tally.row().values(), f"{tally.seconds:.0f} s")
    total = sum((tally.counts for tally in tallies.values()), Counter())
    print(f"{sum(total.values())} inputs: {dict(total)}")
    return list(tallies.values())


if __name__ == "__main__":
    sys.exit(main())
