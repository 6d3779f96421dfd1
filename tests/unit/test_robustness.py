"""Each fault of docs/robustness.md is provoked and reported in one sentence; output files."""

import json
import os
import re
import subprocess
import sys
import tracemalloc
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import h5py
import numpy as np
import openpyxl
import pytest
from matplotlib.figure import Figure
from refusals import refused, refuses
from small_plans import GEAR_VARIABLES, point_options

import efficiency.cli
import ehl
import regression
from ehl.common.errors import InputError
from ehl.common.figures import save_figure
from ehl.common.files import MAX_BYTES, MAX_DEPTH, MAX_KEYS, parse_json, parse_toml, replacing, write_file
from ehl.common.pages import picture_svg
from ehl.common.sections import Picture
from ehl.common.table import Table
from ehl.common.table_reader import MAX_CELLS, MAX_ROWS, harmless, read_table
from ehl.common.units import ValueRange, parse_quantity
from regression.data.result_files import read_file

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"
CONTACT = (EXAMPLES / "contact.toml").read_text(encoding="utf-8")
TORQUES = {"torque": ValueRange("N*m", gt=0.0), "label": None}
POINT = point_options()


def case(folder: Path, text: str, name: str = "case.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    """Exit code and message of a command that fails in a way that the program does not foresee."""

    def command(fail: Callable[[], object], place: Path = tmp_path) -> tuple[object, str]:
        monkeypatch.setattr(efficiency, "doctor", lambda **options: fail())
        monkeypatch.setattr("tempfile.tempdir", str(place))
        with pytest.raises(SystemExit) as end:
            efficiency.cli.main()
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        return end.value.code, said

    return command


def test_a_lack_of_memory_is_one_sentence_and_no_fault_of_the_program(failing: Any, tmp_path: Path) -> None:
    assert failing(lambda: bytearray(2**60))[0] == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("error", [RuntimeError("[/bold] unforeseen"), OSError(5, "unforeseen")])
def test_a_fault_of_the_program_is_one_sentence_and_a_log(error: Exception, failing: Any, tmp_path: Path) -> None:
    code, said = failing(Mock(side_effect=error))
    (log,) = tmp_path.glob("mixed-ehl-fault-*.log")
    assert code == 70
    assert "unforeseen" in said
    assert str(log) in said
    assert log.stat().st_mode & 0o077 == 0 or os.name == "nt"
    assert "Traceback" in log.read_text(encoding="utf-8")
    assert ehl.__version__ in log.read_text(encoding="utf-8")


def test_a_fault_without_a_place_for_its_log(failing: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "deleted").mkdir()
    monkeypatch.chdir(tmp_path / "deleted")
    (tmp_path / "deleted").rmdir()
    assert failing(lambda: 1 // 0, tmp_path / "gone")[0] == 70


@contextmanager
def memory_below(limit: float) -> Iterator[None]:
    """A block that takes no more memory [byte]."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < limit
    finally:
        tracemalloc.stop()


DEEP = {
    "toml": ("x = " + "[" * 100_000, "x = " + "[" * 60 + "]" * 60, "x" + ".x" * 60 + " = 1"),
    "json": ("[" * 100_000, "[" * 60 + "]" * 60, '{"a":' * 60 + "1" + "}" * 60),
}


@pytest.mark.parametrize("kind", DEEP)
def test_files_nested_too_deep_are_refused(kind: str, mixed_ehl: Any, tmp_path: Path) -> None:
    for text in DEEP[kind]:
        path = case(tmp_path, text, f"case.{kind}")
        refused(mixed_ehl("solve", path) if kind == "toml" else mixed_ehl("mu", path, *POINT))
    inner = "[" * (MAX_DEPTH - 2) + "]" * (MAX_DEPTH - 2)
    assert parse_toml(f"x = {inner}", "file", "name") if kind == "toml" else parse_json(inner, "file", "name")


def test_a_file_with_thousands_of_keys_is_a_readable_message(mixed_ehl: Any, tmp_path: Path) -> None:
    for count in (MAX_KEYS // 4, MAX_KEYS + 1):
        keys = "\n".join(f"k{k} = 1" for k in range(count))
        refused(mixed_ehl("solve", case(tmp_path, f"[contact]\n{keys}\n")))


@pytest.mark.parametrize("number", ["9" * 10_000, "1" + 400 * "0", "0x" + "f" * 10_000, "1e400", "-inf", "nan"])
def test_numbers_without_measure_are_refused(number: str, mixed_ehl: Any, tmp_path: Path) -> None:
    text = CONTACT.replace("slide_to_roll = ", f"slide_to_roll = {number} # ")
    assert text != CONTACT
    refused(mixed_ehl("solve", case(tmp_path, text)))
    formula = f'{{"schema": {number.replace("inf", "Infinity").replace("nan", "NaN")}}}'
    refused(mixed_ehl("mu", case(tmp_path, formula, "formula.json"), *POINT))


@pytest.mark.parametrize(
    "text", ["1" * 100_000, "1" * 100_000 + " m", "1 m**9**9**9", "1 m**999999999", "1 m^9^9^9^9", "1 " + "(" * 190]
)
def test_no_text_of_a_quantity_takes_long(text: str) -> None:
    with pytest.raises(InputError) as error:
        parse_quantity(text, "m")
    assert len(str(error.value)) < 600


@pytest.mark.parametrize("name", ["n" * 5000, "two\nlines", "\x1b[31mred", ""])
def test_names_fit_a_line(name: str, mixed_ehl: Any, tmp_path: Path) -> None:
    plan = (Path(regression.__file__).parents[1] / "data" / "plans" / "demo.toml").read_text(encoding="utf-8")
    old = next(line for line in plan.splitlines() if line.startswith("name"))
    path = case(tmp_path, plan.replace(old, f"name = {json.dumps(name)}"))
    refused(mixed_ehl("sweep", path, "-o", tmp_path / "run"))


def test_a_path_of_5000_characters_is_refused(mixed_ehl: Any, tmp_path: Path) -> None:
    long = "n" * 5000
    for command in (
        ("solve", long), ("solve", f"{long}.toml"), ("sweep", long, "-o", "run"), ("sweep", "demo", "-o", long),
        ("mu", long, *POINT), ("gear", long), ("settings", long), ("sweep", "status", long), ("calibrate", long),
        ("fit", long, "-o", tmp_path / "f.json"), ("fit", "gear_fva3", "-o", tmp_path / long),
    ):  # fmt: skip
        refused(mixed_ehl(*command))


def test_many_problems_at_once_are_a_readable_message() -> None:
    many = [InputError(f"key_{k}", "x" * 500, "y" * 900, "z" * 900) for k in range(60)]
    assert len(InputError.of(many).problems) == 60
    assert len(str(InputError.of(many))) < 8000
    error = InputError("field" * 2000, "v" * 10_000, "a" * 10_000, "h\x1b[2J" * 5000)
    assert len(str(error)) < 5000
    assert "\x1b" not in str(error)
    assert len(str(InputError("n", 16**20_000, "less"))) < 5000


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
@pytest.mark.parametrize("kind", ["fifo", "device", "folder"])
def test_pipes_devices_and_folders_are_refused_as_input(kind: str, mixed_ehl: Any, tmp_path: Path) -> None:
    path = {"fifo": tmp_path / "pipe.toml", "device": Path("/dev/zero"), "folder": tmp_path}[kind]
    if kind == "fifo":
        os.mkfifo(path)
    for command in (
        ("solve", path), ("mu", path, *POINT), ("sweep", path, "-o", tmp_path / "run"), ("calibrate", path),
        ("gear", path), ("settings", path),
        ("gear", "fm_spiral_bevel_14x39", "--load-from", path, "--friction", "constant:0.05"),
    ):  # fmt: skip
        refused(mixed_ehl(*command))
    if kind != "folder":
        refused(mixed_ehl("sweep", "status", path))
        refused(mixed_ehl("fit", path, "-o", tmp_path / "formula.json"))


def test_a_file_too_large_is_refused_before_it_is_read(mixed_ehl: Any, tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    with path.open("wb") as file:
        file.truncate(10 * MAX_BYTES)  # sparse
    with memory_below(50e6):
        refused(mixed_ehl("solve", path))


def workbook(path: Path, place: tuple[int, int] = (2, 1)) -> Path:
    book = openpyxl.Workbook()
    book.active["A1"] = "torque [N m]"
    book.active.cell(*place, 100.0)
    book.save(path)
    return path


def test_a_cell_far_down_a_sheet_takes_no_memory(tmp_path: Path) -> None:
    assert read_table(workbook(tmp_path / "last.xlsx", (1_048_570, 1)), TORQUES)[0] == {"torque": (100.0,)}
    path = workbook(tmp_path / "far.xlsx", (100_000, 1))
    with memory_below(10e6):  # an empty cell for every row would take more
        assert read_table(path, TORQUES)[0] == {"torque": (100.0,)}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        pytest.param(b'<row r="2"', b'<row r="' + 100 * b"9" + b'"', id="a row number without end"),
        pytest.param(rb"<v>[0-9.]+</v>", b"<v>" + 400 * b"9" + b"</v>", id="a cell of 400 digits"),
    ],
)
def test_a_cell_or_row_without_measure_is_refused(old: bytes, new: bytes, tmp_path: Path) -> None:
    path = tmp_path / "far.xlsx"
    with zipfile.ZipFile(workbook(tmp_path / "sound.xlsx")) as sound, zipfile.ZipFile(path, "w") as far:
        for name in sound.namelist():
            far.writestr(name, re.sub(old, new, sound.read(name)))
    with pytest.raises(InputError):
        read_table(path, TORQUES)


def test_a_truncated_sheet_is_refused(tmp_path: Path) -> None:
    sound = workbook(tmp_path / "sound.xlsx")
    for share in (0.0, 0.3, 0.6, 0.9):
        with zipfile.ZipFile(sound) as old, zipfile.ZipFile(tmp_path / "cut.xlsx", "w") as new:
            for name in old.namelist():
                content = old.read(name)
                new.writestr(name, content[: int(share * len(content))] if "sheet1" in name else content)
        with pytest.raises(InputError):
            read_table(tmp_path / "cut.xlsx", TORQUES)
    content = sound.read_bytes()
    for length in range(0, len(content), 500):
        (tmp_path / "cut.xlsx").write_bytes(content[:length])
        with pytest.raises(InputError):
            read_table(tmp_path / "cut.xlsx", TORQUES)


def test_a_workbook_that_unpacks_without_end_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ehl.common.table_reader.MAX_UNPACKED", 5000)
    with pytest.raises(InputError):
        read_table(workbook(tmp_path / "bomb.xlsx"), TORQUES)


@pytest.mark.parametrize(
    "text",
    [
        "torque\n" + "1\n" * (MAX_ROWS + 1),
        f"torque{',' * 100_000}\n1\n",
        f"torque{',' * 900}\n" + "1\n" * (MAX_CELLS // 900),
    ],
    ids=["rows", "columns", "cells"],
)
def test_tables_too_large_are_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(InputError):
        read_table(case(tmp_path, text, "table.csv"), TORQUES)


@pytest.mark.parametrize("text", ["=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)"])
def test_cells_a_spreadsheet_would_compute_are_quoted(text: str, tmp_path: Path) -> None:
    assert harmless(text) == f"'{text}"
    assert harmless("-2.5") == "-2.5"
    path = tmp_path / "back.csv"
    path.write_text(f'torque,label\n1,"{harmless(text)}"\n', encoding="utf-8")
    assert read_table(path, TORQUES)[0]["label"] == (text,)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    regression.sweep("demo", folder, formula="xu_kahraman_2007", jobs=1).merge(folder / "merged.h5")
    return folder / "merged.h5"


def test_flipped_bits_in_the_attributes_of_a_result_file(results: Path, mixed_ehl: Any, tmp_path: Path) -> None:
    """Every bit of the beginning of a text, in turn: refused in a sentence, or the file reads."""
    content = bytearray(results.read_bytes())
    with h5py.File(results) as file:
        words = [str(file.attrs[name]).encode()[:2] for name in ("writer", "plan_name", "oil", "solver_version")]
    path = tmp_path / "flipped.h5"
    read = broken = 0
    for word in words:
        at = content.index(word)
        for bit in range(8 * len(word)):
            content[at + bit // 8] ^= 1 << bit % 8
            path.write_bytes(content)
            content[at + bit // 8] ^= 1 << bit % 8
            try:
                read_file(path)
                read += 1
            except InputError:
                last, broken = path.read_bytes(), broken + 1
    assert read > 0
    assert broken > 0
    path.write_bytes(last)
    refused(mixed_ehl("sweep", "status", path))


@pytest.mark.parametrize("value", [np.array([1, 2]), "1", b"\xff\xfe", -(2**40), np.nan])
@pytest.mark.parametrize("name", ["schema", "plan_name", "count", "oil"])
def test_attributes_of_another_kind_are_refused(name: str, value: Any, results: Path, tmp_path: Path) -> None:
    path = tmp_path / "other.h5"
    path.write_bytes(results.read_bytes())
    with h5py.File(path, "r+") as file:
        file.attrs[name] = value
    if name in ("plan_name", "oil") and isinstance(value, str):
        assert read_file(path)[0][name] == "1"
    else:
        with pytest.raises(InputError):
            read_file(path)


def test_declared_arrays_are_refused_before_memory_is_taken(results: Path, mixed_ehl: Any, tmp_path: Path) -> None:
    path = tmp_path / "huge.h5"
    path.write_bytes(results.read_bytes())
    with h5py.File(path, "r+") as file:
        for name, column in list(file.items()):
            if column.shape:
                kind = column.dtype
                del file[name]
                file.create_dataset(name, (10**12,), kind, chunks=(1024,))
    with memory_below(50e6):
        refused(mixed_ehl("sweep", "status", path))


def test_a_plan_too_large_is_refused_before_its_points_are_made(mixed_ehl: Any, tmp_path: Path) -> None:
    plan = 'name = "huge"\n[sampling]\nmethod = "factorial"\nlevels = 32\n' + GEAR_VARIABLES  # 1e9 points
    windowed = plan + "[constraints]\nfilm_ratio = { low = 0.1, high = 5.0 }\n"
    with memory_below(100e6):
        for text in (plan, windowed):
            refused(mixed_ehl("sweep", case(tmp_path, text), "-o", tmp_path / "run"))


@pytest.mark.parametrize(
    ("field", "work"),
    [
        ("positions", lambda pair: pair.mesh(positions=10**9)),
        *(("positions", partial(efficiency.GearPair.mesh, positions=number)) for number in (2, 5, 4.5)),
        *(("points_per_line", partial(efficiency.GearPair.mesh, points_per_line=number)) for number in (3, 10**4)),
        ("rows", lambda pair: pair.export(".", ["grid"], rows=10**6)),
        ("torque", lambda pair: pair.over(torque=[100.0] * 10**6)),
        ("torque, speed", lambda pair: pair.over(torque="1:2:10000 N m", speed="1:2:10000 rpm")),
        ("torque, speed", lambda pair: pair.loss_map("1:2:10000 N m", "1:2:10000 rpm")),
        ("E", lambda pair: pair.misalignment(E=[0.0] * 10**6)),
    ],
)
def test_numbers_of_points_within_reason(field: str, work: Callable[[efficiency.GearPair], object]) -> None:
    with refuses(field):
        work(efficiency.load("fm_spiral_bevel_14x39"))


def test_jobs_within_reason(mixed_ehl: Any, tmp_path: Path) -> None:
    for command in (
        ("sweep", "demo", "-o", tmp_path / "run"), ("sweep", "demo", "--estimate"), ("demo", "-o", tmp_path / "demo"),
        ("calibrate", EXAMPLES / "synthetic_traction.csv", "--setup", EXAMPLES / "calibration.toml", "-o", "card.toml"),
    ):  # fmt: skip
        for jobs in (0, -1, 100_000, 10**30):
            assert mixed_ehl(*command, "--jobs", jobs).code == 2
    assert not (tmp_path / "run").exists()


MAIN = (sys.executable, "-c", "from efficiency.cli import main; main()")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full device here")
@pytest.mark.parametrize("command", [("--version",), ("sweep", "demo", "--estimate"), ("gear", "--help")])
def test_a_full_device_is_one_sentence(command: tuple[str, ...]) -> None:
    with open("/dev/full", "w") as full:
        run = subprocess.run([*MAIN, *command], stdout=full, stderr=subprocess.PIPE, text=True)
    assert run.returncode == 74
    assert run.stderr.count("\n") == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full device here")
def test_a_file_on_a_full_device_is_one_sentence(mixed_ehl: Any) -> None:
    refused(mixed_ehl("export", "75w90", "-o", "/dev/full"))


@pytest.mark.parametrize("closed", [(), (0,), (1,), (0, 1, 2)], ids=str)
def test_files_are_written_whatever_becomes_of_standard_output(closed: tuple[int, ...], tmp_path: Path) -> None:
    """Its reader has gone, or the shell has closed streams."""
    page = tmp_path / "page.html"
    command = [*MAIN, "solve", str(case(tmp_path, CONTACT)), "--report", str(page)]
    shut = partial(os.closerange, min(closed), max(closed) + 1) if closed else None
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=shut) as run:
        run.stdout.close()
        assert run.wait() == (0 if 1 in closed else 1)
    assert page.read_text(encoding="utf-8").rstrip().endswith("</html>")


@pytest.mark.parametrize("option", ["--time-cap=-5 s", "--time-cap=5 m", "--retries=-1", "--slurm=0", "--jobs=-3"])
def test_options_are_checked_for_an_estimate_as_well(option: str, mixed_ehl: Any) -> None:
    refused(mixed_ehl("sweep", "demo", "--estimate", option))


DESIGN = "fm_spiral_bevel_14x39"


@pytest.mark.parametrize(
    "command",
    [
        ("gear", DESIGN, "--save-load"),
        *((name, DESIGN, option) for name in ("gear", "map", "compare") for option in ("--report", "--xlsx", "--csv")),
        ("geometry", DESIGN, "--plot"), ("misalignment", DESIGN, "--csv"),
        ("loss-map", DESIGN, "--torque", "1:9:3 N m", "--speed", "1:9:3 rpm", "--model"),
        ("axle", "truck_hypoid", "--report"), ("blank", "fm_hypoid_10x41", "--xlsx"),
        ("settings", "fh_hypoid_9x34", "--sized", "-o"), ("import", "sheet.csv", "-o"),
        ("correct", DESIGN, "grid.csv", "-o"), ("plan", DESIGN, "--duty", "duty.csv", "-o"), ("export", DESIGN, "-o"),
        ("study", DESIGN, "-o"), ("optimise", "fh_hypoid_9x34", "-o"), ("sweep", "merge", "gear_fva3", "-o"),
    ],
    ids=" ".join,
)  # fmt: skip
def test_outputs_are_checked_before_anything_is_computed(command, mixed_ehl, tmp_path, monkeypatch):
    """A path below a file, and a folder, or file, in place of the other."""
    begun = Mock(side_effect=AssertionError)
    names = ("load", "Axle", "blank", "sized_for_load", "import_design", "machine_corrections", "study", "optimise")
    for name in names:
        monkeypatch.setattr(efficiency, name, begun)
    monkeypatch.setattr(regression, "Run", begun)
    option = command[-1].lstrip("-")
    suffix = {"report": ".html", "xlsx": ".xlsx", "model": ".vtlm"}.get(option, ".toml" if command[0] == "plan" else "")
    (tmp_path / "file").write_text("")
    (tmp_path / f"folder{suffix}").mkdir()
    folders = option in ("csv", "plot") or command[0] in ("export", "study", "optimise")
    for path in (tmp_path / "file" / f"below{suffix}", tmp_path / ("file" if folders else f"folder{suffix}")):
        refused(mixed_ehl(*command, path))


def test_a_terminal_without_greek_letters() -> None:
    command, ascii_only = [*MAIN, "sweep", "demo", "--estimate", "--set", 'name="μ"'], {"PYTHONIOENCODING": "ascii"}
    run = subprocess.run(command, env=os.environ | ascii_only, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


NAMES = ["[/bold] [red]x[/red] [1]", "歯車の油 ☃", "cost $100 and \\frac{ $", "n" * 3000, "{0} %s \\u0041"]


@pytest.mark.parametrize("name", NAMES)
def test_any_name_is_printed_as_it_is(name, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "4000")
    Table(("name", "value"), ((name, 1.0),), name).print()
    assert capsys.readouterr().out.count(name) == 2


@pytest.mark.parametrize(("name", "suffix"), list(zip(NAMES, [".svg", ".png", ".svg", ".pdf", ".pdf"], strict=True)))
def test_any_name_is_drawn(name: str, suffix: str, tmp_path: Path) -> None:
    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    axes.loglog([1.0, 10.0], [1.0, 10.0], label=name)
    axes.set_title(name)
    axes.set_xticks([1.0, 10.0], [name[:20], "b"])
    axes.legend()
    save_figure(figure, tmp_path / f"figure{suffix}")
    assert (tmp_path / f"figure{suffix}").stat().st_size > 1000
    assert suffix != ".svg" or "☃" not in name or f">{name}<" in picture_svg(Picture(lambda: figure, ""))


def test_brackets_in_an_option_are_no_markup(mixed_ehl: Any) -> None:
    for command in (("mu", "[/bold]", *POINT), ("gear", "[/red]"), ("sweep", "[bold]", "-o", "[/x]"), ("solve", "[/]")):
        refused(mixed_ehl(*command))
    refused(mixed_ehl("demo", "--jobs", "[/bold]"))


def test_doctor_without_the_installed_distribution(monkeypatch: pytest.MonkeyPatch) -> None:
    import importlib.metadata

    monkeypatch.setattr(importlib.metadata, "requires", Mock(side_effect=importlib.metadata.PackageNotFoundError))
    failed = [check for check in efficiency.doctor() if not check.passed]
    assert [check.name for check in failed] == ["dependencies"]


@pytest.mark.parametrize(("name", "constant"), [("B", "1e400"), ("B", "3e5"), ("C", "1e308"), ("C", "-1e200")])
def test_oils_without_a_viscosity_are_refused(name: str, constant: str, mixed_ehl: Any, tmp_path: Path) -> None:
    card = (Path(regression.__file__).parents[1] / "data" / "oils" / "fva3.toml").read_text(encoding="utf-8")
    old = next(line for line in card.splitlines() if line.startswith(f"{name} = "))
    refused(mixed_ehl("oil", case(tmp_path, card.replace(old, f"{name} = {constant}"))))


def test_no_duration_comes_from_a_clock_that_jumps() -> None:
    """Only monotonic and processor clocks: the wall clock may be set while a sweep runs."""
    packages = (Path(package.__file__).parent for package in (ehl, regression, efficiency))
    sources = [path for package in packages for path in package.rglob("*.py")]
    assert len(sources) > 200
    for path in sources:
        assert not re.search(r"\btime\.time(_ns)?\(|datetime\.now|utcnow", path.read_text(encoding="utf-8")), path


def test_a_file_is_replaced_only_when_it_is_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "result.json"
    write_file(path, "before")

    def stopped() -> None:
        with replacing(path) as draft:
            draft.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()

    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", Mock(side_effect=OSError("No space left on device")))
        with refuses("output"):
            write_file(path, "after", "output")
    assert path.read_text() == "before"
    assert os.listdir(tmp_path) == ["result.json"]


def test_links_modes_and_folders_stay(tmp_path: Path) -> None:
    path, link = tmp_path / "new" / "result.json", tmp_path / "link"
    write_file(path, b"one")
    path.chmod(0o640)
    link.symlink_to(path)
    write_file(link, "two")
    assert link.is_symlink()
    assert path.read_text() == "two"
    assert path.stat().st_mode & 0o777 == 0o640
    write_file(Path(os.devnull), "nothing")
    with pytest.raises(InputError):
        write_file(tmp_path, "a folder")


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give links to others")
@pytest.mark.parametrize("kind", ["file", "folder"])
def test_links_that_others_planted_are_not_followed(kind: str, tmp_path: Path) -> None:
    """In a folder open to all, such as /tmp; Linux refuses to open them, but a rename does not open the link."""
    shared, own = tmp_path / "shared", tmp_path / "own"
    shared.mkdir()
    shared.chmod(0o1777)
    own.mkdir()
    (own / "kept").write_text("before")
    link = shared / "link"
    link.symlink_to(own if kind == "folder" else own / "kept")
    path = link / "kept" if kind == "folder" else link
    for owner, content in ((12345, "before"), (os.getuid(), "after")):
        os.lchown(link, owner, owner)
        with nullcontext() if owner == os.getuid() else refuses("path"):
            write_file(path, "after")
        assert (own / "kept").read_text() == content
        assert sorted(file.name for file in own.iterdir()) == ["kept"]


def test_drafts_of_killed_processes_are_removed(tmp_path: Path) -> None:
    old, new, other = (tmp_path / name for name in (".mixed-ehl-0123.json", ".mixed-ehl-4567.json", ".other"))
    for path in (old, new, other):
        path.write_text("half")
    for path in (old, other):
        os.utime(path, (0.0, 0.0))
    write_file(tmp_path / "result.json", "whole")
    assert sorted(os.listdir(tmp_path)) == [new.name, other.name, "result.json"]
