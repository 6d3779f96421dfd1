"""Mutated files of every kind that the program reads: each gives an answer or one clear refusal.

Sound files are mutated: bits, pieces and lines at random, and values, keys and units in place. Inputs with a new answer
or refusal join the sound files and are mutated further. Each kind goes through its reader and what is checked and
computed before solving. Anything but an answer or an `InputError` of readable length is a traceback; more than ten
seconds of processor time is a hang; numbers that are not finite, or of the wrong sign, are impossible answers.
"""

import io
import json
import random
import re
import signal
import traceback
import zipfile
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
import openpyxl

import efficiency
import ehl
import regression
from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.pair import pair_blank
from efficiency.conditions.duty import read_duty
from efficiency.contact.conjugate import COLUMNS as MAP_COLUMNS
from efficiency.contact.conjugate import read_ease_off_map
from efficiency.contact.grid_flank import read_point_grid
from efficiency.cutting.summary import read_summary
from efficiency.design.design import bevel_names, load_design
from efficiency.ltca.external_load import _table as read_load_table
from efficiency.machine_settings.inputs import SettingsInput
from ehl.common.data import data_path
from ehl.common.units import parse_quantity
from ehl.common.validation import read_toml, validate
from ehl.fluid.oil import Oil
from ehl.material import Material
from ehl.surface.finish import Additive, _FinishFile
from ehl.surface.measured_surface import load_profile
from regression.calibration.calibrate import setup_of
from regression.calibration.measurement import read_measurement
from regression.data.result_files import merge, read_file
from regression.friction.fitted import _checksum
from regression.friction.models import FrictionFlag
from regression.plan.plan import Plan

HANG = 10.0  # s of processor time; and ten times that on the clock, for what only waits
CLOCKS = ((signal.SIGPROF, signal.ITIMER_PROF, HANG), (signal.SIGALRM, signal.ITIMER_REAL, 10.0 * HANG))
CORPUS = 300  # files kept for further mutation because of what they give
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
EXAMPLES = Path(__file__).resolve().parents[1] / "docs" / "examples"
POINT = {"pressure_hertz": "1 GPa", "radius_equivalent": "15 mm", "speed_entrainment": "3 m/s", "slide_to_roll": 0.3}
DESIGN = "fm_spiral_bevel_14x39"
SPELLINGS = [
    line.split("\t") for line in (EXAMPLES.parent / "spellings.tsv").read_text(encoding="utf-8").splitlines()[1:]
]
SI_UNITS = {line[0] for line in SPELLINGS}
POINTS = 300  # of a plan that is expanded


class Impossible(Exception):
    """An answer that no input has."""


@dataclass(frozen=True)
class Kind:
    """One kind of file."""

    suffix: str
    seeds: Sequence[bytes]  # sound files
    read: Callable[[Path], object]  # raises `Impossible` where the answer is
    repair: Callable[[bytes], bytes] = bytes  # after a mutation, so that it comes through a checksum


def finite(values: object, where: str, low: float = -np.inf) -> None:
    """Raise `Impossible` unless all numbers are finite and above a bound."""
    array = np.asarray(values, float)
    if not np.all(np.isfinite(array)) or not np.all(array > low):
        raise Impossible(f"{where}: {array.ravel()[:5]}")


def _oil(path: Path) -> None:
    oil = Oil.load(str(path))
    for temperature in (280.0, 313.15, 373.15):
        lubricant = oil.at(temperature)
        for name in ("viscosity_inlet", "pressure_viscosity"):
            finite(getattr(lubricant, name), f"{name} at {temperature} K", 0.0)
        stress = lubricant.shear_law.scale(np.array([0.0, 1e9]))
        finite(stress, f"eyring_stress at {temperature} K", 0.0)
        finite(oil.density(temperature), f"density at {temperature} K", 0.0)


def _quantities(path: Path) -> None:
    """Every text of a file as a quantity of its unit: line by line the unit, a tab, texts between tabs."""
    for unit, *texts in (line.split("\t") for line in path.read_bytes().decode(errors="replace").split("\n")):
        for text in texts:
            with suppress(ehl.InputError):
                finite(parse_quantity(text, unit if unit in SI_UNITS else "m"), text[:50])


def _plan(path: Path) -> None:
    plan = Plan.from_file(path)
    if plan.count <= POINTS:
        for name, values in plan.columns.items():
            finite(values, name)


def _formula(path: Path) -> None:
    found = regression.friction_model(str(path)).mu(**POINT, temperature="90 degC", roughness_rms="0.4 um")
    if (found.flag != FrictionFlag.UNDEFINED).all():  # otherwise a message states it
        finite(found.mu, "mu", 0.0)


def _blank(path: Path) -> None:
    pair = pair_blank(validate(PairBlankInput, read_toml(path)))
    try:
        json.dumps(asdict(pair), allow_nan=False, default=str)
    except ValueError as error:
        raise Impossible(f"blank: {error}") from None


def _formula_checksum(content: bytes) -> bytes:
    try:
        found = json.loads(content)
        found.pop("checksum", None)
        return json.dumps(found | {"checksum": _checksum(found)}).encode()
    except (ValueError, AttributeError, TypeError, RecursionError):
        return content


def _workbook(rows: Sequence[Sequence[object]]) -> bytes:
    book, file = openpyxl.Workbook(), io.BytesIO()
    for row in rows:
        book.active.append(row)
    book.save(file)
    return file.getvalue()


def _shipped(*folder: str, most: int = 40) -> list[bytes]:
    return [path.read_bytes() for path in sorted(data_path(*folder).glob("*.toml"))[:most]]


def _bevel_designs() -> list[bytes]:
    return [data_path("designs", f"{name}.toml").read_bytes() for name in bevel_names()]


def kinds(folder: Path) -> dict[str, Kind]:
    """All kinds; some sound files are made by the program, in a folder."""
    calibration = EXAMPLES / "synthetic_traction.csv"
    setup = (EXAMPLES / "calibration.toml").read_bytes()
    fixed = {"radius_equivalent": 0.0095, "temperature_oil": 353.15, "roughness_rms": 8e-8}
    duty = [["torque [N m]", "speed [rpm]", "temperature [degC]", "hours [h]"], [200, 1500, 80, 3], [-50, 800, 60, 1]]
    text = "\n".join(",".join(map(str, row)) for row in duty).encode()
    (folder / "duty.csv").write_bytes(text)
    traction = [line.split(",") for line in calibration.read_text().splitlines() if not line.startswith("#")]
    pair = efficiency.load(DESIGN)
    pair.export(folder / "design", ["summary", "grid"], rows=5, columns=7)
    grids = [path.read_bytes() for path in sorted((folder / "design").glob("*_con*.csv"))]
    summaries = [(folder / "design" / "setting_sheet.csv").read_bytes()]
    pair.mesh(side="drive", positions=4, points_per_line=9).load("200 N m").write_load(folder / "load.csv")
    load = "\n".join((folder / "load.csv").read_text().splitlines()[:60]).encode()
    regression.sweep("demo", folder / "run", formula="xu_kahraman_2007", jobs=1)
    results = folder / "run.h5"
    merge(folder / "run", results)
    table = b"pressure_hertz [GPa],radius_equivalent [mm],speed_entrainment,slide_to_roll,temperature_oil [degC]\n"
    points = folder / "points.csv"
    relief = "\n".join(
        [MAP_COLUMNS, *(f"{x / 2 - 1},{y / 2 - 1},{10 * (x - 2) ** 2 + 2 * y}" for x in range(5) for y in range(5))]
    )
    profile = "x [um];z [um]\n" + "\n".join(f"{0.5 * k:.1f};{np.sin(0.3 * k):.4f}" for k in range(400))
    contacts = [path.read_bytes() for path in sorted(EXAMPLES.glob("contact*.toml"))]
    # that of a table is a kind of its own
    ranges = [found for found in _shipped("plans") if b"[table]" not in found]
    plans = [re.sub(rb"size = \d+", b"size = 16", found) for found in ranges]
    plan = b'name = "points"\n[table]\nfile = "points.csv"\n[lubricant]\noil = "fva3"\n'

    def table_plan(path: Path) -> None:
        points.write_bytes(path.read_bytes())
        (folder / "plan.toml").write_bytes(plan)
        _plan(folder / "plan.toml")

    formulas = [data_path("formulas", f"{name}.json").read_bytes() for name in ("fva3", "75w90")]
    texts = ["\t".join((line[0], *line[2:])) for line in SPELLINGS]
    return {
        "quantities": Kind(".txt", ["\n".join(texts[k::3]).encode() for k in range(3)], _quantities),
        "contact": Kind(".toml", contacts, ehl.Contact.from_file),
        "oil card": Kind(".toml", _shipped("oils"), _oil),
        "material": Kind(".toml", _shipped("materials"), lambda path: validate(Material, read_toml(path))),
        "finish": Kind(".toml", _shipped("finishes"), lambda path: validate(_FinishFile, read_toml(path))),
        "additive": Kind(".toml", _shipped("additives"), lambda path: validate(Additive, read_toml(path))),
        "plan": Kind(".toml", plans, _plan),
        "table of a plan": Kind(".csv", [table + b"1.0,15,3,0.2,80\n0.8,12,5,0.1,90\n"], table_plan),
        "result file": Kind(".h5", [results.read_bytes()], read_file),
        "formula": Kind(".json", formulas, _formula, _formula_checksum),
        "calibration data": Kind(".csv", [calibration.read_bytes()], lambda path: read_measurement(path, fixed)),
        "calibration workbook": Kind(".xlsx", [_workbook(traction)], lambda path: read_measurement(path, fixed)),
        "calibration setup": Kind(".toml", [setup], setup_of),
        "design": Kind(".toml", _bevel_designs(), load_design),
        "blank": Kind(".toml", _shipped("blanks"), _blank),
        "targets": Kind(".toml", _shipped("targets"), lambda path: validate(SettingsInput, read_toml(path))),
        "duty cycle": Kind(".csv", [text], read_duty),
        "duty workbook": Kind(".xlsx", [_workbook(duty)], read_duty),
        "load distribution": Kind(".csv", [load], read_load_table),
        "machine summary": Kind(".csv", summaries, lambda path: read_summary(path).toml()),
        "inspection grid": Kind(".csv", grids, read_point_grid),
        "ease-off map": Kind(".csv", [relief.encode()], read_ease_off_map),
        "measured profile": Kind(
            ".csv", [profile.encode()], lambda path: load_profile(path, cutoff_long=None, cutoff_short=2.5e-6)
        ),
    }


class Hang(BaseException):
    """The alarm rang."""


@dataclass
class Tally:
    """Outcomes of one kind."""

    counts: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)


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
    except ehl.MixedEhlError as error:
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
        own = [step for step in traceback.extract_tb(error.__traceback__) if "mutated_files" not in step.filename]
        steps = " < ".join(f"{Path(step.filename).stem}:{step.lineno}" for step in (own or [where])[-1:-4:-1])
        return "traceback", f"{type(error).__name__}: {str(error)[:100]} [{steps}]"
    finally:
        for _, timer, _ in CLOCKS:
            signal.setitimer(timer, 0.0)


def run(kind: Kind, count: int, path: Path, seed: str) -> Tally:
    """Mutate, read and count."""
    rng = random.Random(seed)
    tally, corpus, seen = Tally(), list(kind.seeds), set[str]()
    change = mutate_workbook if kind.suffix == ".xlsx" else mutate
    for number in range(count):
        # the sound files first; then half of the mutations from them, half from what was found
        sound = number < len(kind.seeds)
        start = kind.seeds[number] if sound else rng.choice(kind.seeds if rng.random() < 0.5 else corpus)
        content = start if sound else kind.repair(change(start, corpus, rng))
        path.write_bytes(content)
        what, signature = outcome(lambda: kind.read(path))
        if sound and what != "answer":
            what, signature = "impossible", f"sound file {number} gives {what}: {signature}"
        tally.counts[what] += 1
        if what not in ("answer", "refusal"):
            tally.faults[signature] += 1
        elif signature not in seen and len(corpus) < CORPUS and len(content) < 10 * len(start) + 1000:
            corpus.append(content)
        seen.add(signature)
    return tally
