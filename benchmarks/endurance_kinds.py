"""Kinds of file the endurance campaign mutates: sound ones, their readers, and the commands that take them."""

from __future__ import annotations

import contextlib
import io
import json
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

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
from efficiency.design.design import load_design
from efficiency.ltca.external_load import _table as read_load_table
from efficiency.machine_settings.inputs import SettingsInput
from efficiency.output.solid import read_stl
from ehl.common.data import data_path
from ehl.common.validation import read_toml, validate
from ehl.fluid.oil import Oil
from ehl.material import Material
from ehl.surface.finish import _AdditiveFile, _FinishFile
from ehl.surface.measured_profile import load_profile
from regression.calibration.measurement import read_measurement
from regression.calibration.setup import load_setup
from regression.data.store import read_file
from regression.friction.formula import _checksum
from regression.friction.models import FrictionFlag
from regression.plan.plan import Plan

EXAMPLES = Path(__file__).resolve().parents[1] / "docs" / "examples"
POINT = {"pressure_hertz": "1 GPa", "radius_equivalent": "15 mm", "speed_entrainment": "3 m/s", "slide_to_roll": 0.3}
OPTIONS = ("--pressure", "1 GPa", "--radius", "15 mm", "--speed", "3 m/s", "--slide-to-roll", "0.3",
           "--temperature", "90 degC")  # fmt: skip
DESIGN, TARGETS = "fm_spiral_bevel_14x39", "fh_spiral_bevel_12x37"
CONSTANT = ("--friction", "constant:0.05")
POINTS = 300  # of a plan that is expanded


class Reached(BaseException):
    """A command accepted its input and begins to solve."""


class Impossible(Exception):
    """An answer that no input has."""


@dataclass(frozen=True)
class Kind:
    """One kind of file.

    Parameters
    ----------
    suffix : str
    seeds : sequence of bytes
        Sound files.
    read : callable
        Takes a path; raises `Impossible` where the answer is.
    commands : tuple of tuple of str
        Arguments of the whole commands that take it, in turn; FILE, OUT and OUT.SUFFIX are put in place.
    repair : callable
        What is done after a mutation, so that it comes through an outer check such as a checksum.
    """

    suffix: str
    seeds: Sequence[bytes]
    read: Callable[[Path], object]
    commands: tuple[tuple[str, ...], ...] = ()
    repair: Callable[[bytes], bytes] = bytes


def finite(values: object, where: str, low: float = -np.inf) -> None:
    """Raise `Impossible` unless all numbers are finite and above a bound."""
    array = np.asarray(values, float)
    if not np.all(np.isfinite(array)) or not np.all(array > low):
        raise Impossible(f"{where}: {array.ravel()[:5]}")


@contextlib.contextmanager
def stopped() -> Iterator[None]:
    """Whole commands end where solving begins."""

    def reach(*given: object, **named: object) -> None:
        raise Reached

    import efficiency.contact.flank_pair
    import efficiency.contact.measured_flank
    import efficiency.machine_settings.solve
    import efficiency.pair
    import ehl.solve
    import regression.calibration.calibrate
    import regression.fitting.fit

    with contextlib.ExitStack() as stack:
        stack.enter_context(mock.patch.object(efficiency.pair.GearPair, "mesh", reach))
        for module, name in (
            (ehl.solve, "_solve"),
            (efficiency.contact.flank_pair, "flank_pair"),
            (efficiency.contact.measured_flank, "measured_flank"),
            (efficiency.machine_settings.solve, "conjugate_start"),
            (regression.calibration.calibrate, "solver_of"),
            (regression.fitting.fit, "fit_families"),
        ):
            function = getattr(module, name)
            for holder in list(sys.modules.values()):
                if getattr(holder, name, None) is function:
                    stack.enter_context(mock.patch.object(holder, name, reach))
        yield


def _oil(path: Path) -> None:
    oil = Oil.load(str(path))
    for temperature in (280.0, 313.15, 373.15):
        lubricant = oil.at(temperature)
        for name in ("viscosity_inlet", "pressure_viscosity", "eyring_stress"):
            finite(getattr(lubricant, name), f"{name} at {temperature} K", 0.0)
        finite(oil.density(temperature), f"density at {temperature} K", 0.0)


def _plan(path: Path) -> None:
    plan = Plan.from_file(path)
    if plan.count <= POINTS:
        for name, values in plan.columns.items():
            finite(values, name)


def _formula(path: Path) -> None:
    found = regression.friction_model(str(path)).mu(**POINT, temperature="90 degC", roughness_rms="0.4 um")
    if (found.flag != FrictionFlag.UNDEFINED).all():  # said in words where there is none
        finite(found.mu, "mu", 0.0)


def _blank(path: Path) -> None:
    pair = pair_blank(validate(PairBlankInput, read_toml(path)))

    def numbers(value: Any, name: str) -> None:
        if isinstance(value, dict):
            for key, inner in value.items():
                numbers(inner, f"{name}.{key}")
        elif isinstance(value, float):
            finite(value, name)

    numbers(pair.to_dict(), "blank")


def _summary(path: Path) -> None:
    summary = read_summary(path)
    summary.toml()


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
    pair.export(folder / "design", ["summary", "grid", "tooth"], rows=5, columns=7)
    grids = [path.read_bytes() for path in sorted((folder / "design").glob("*_con*.csv"))]
    summaries = [(folder / "design" / "setting_sheet.csv").read_bytes()]
    solid = (folder / "design" / "gear_tooth_space.stl").read_bytes()
    pair.mesh(side="drive", positions=4, points_per_line=9).load("200 N m").write_load(folder / "load.csv")
    load = "\n".join((folder / "load.csv").read_text().splitlines()[:60]).encode()
    regression.sweep("demo", folder / "run", formula="xu_kahraman_2007", jobs=1)
    (results,) = (folder / "run").glob("*.h5")
    table = b"pressure_hertz [GPa],radius_equivalent [mm],speed_entrainment,slide_to_roll,temperature_oil [degC]\n"
    points = folder / "points.csv"
    relief = "\n".join(
        [MAP_COLUMNS, *(f"{x / 2 - 1},{y / 2 - 1},{10 * (x - 2) ** 2 + 2 * y}" for x in range(5) for y in range(5))]
    )
    profile = "x [um];z [um]\n" + "\n".join(f"{0.5 * k:.1f};{np.sin(0.3 * k):.4f}" for k in range(400))
    contacts = [path.read_bytes() for path in sorted(EXAMPLES.glob("contact*.toml"))]
    plans = [re.sub(rb"size = \d+", b"size = 16", found) for found in _shipped("plans")]
    plan = b'name = "points"\n[table]\nfile = "points.csv"\n[lubricant]\noil = "fva3"\n'

    def table_plan(path: Path) -> None:
        points.write_bytes(path.read_bytes())
        (folder / "plan.toml").write_bytes(plan)
        _plan(folder / "plan.toml")

    return {
        "contact": Kind(".toml", contacts, lambda path: ehl.Contact.from_file(path), (("solve", "FILE"),)),
        "oil card": Kind(".toml", _shipped("oils"), _oil, (
                ("oil", "FILE"),
                ("mu", "75w90", *OPTIONS, "--oil", "FILE"),
                ("gear", DESIGN, *CONSTANT, "--oil", "FILE"),
            )),
        "material": Kind(".toml", _shipped("materials"), lambda path: validate(Material, read_toml(path))),
        "finish": Kind(".toml", _shipped("finishes"), lambda path: validate(_FinishFile, read_toml(path))),
        "additive": Kind(".toml", _shipped("additives"), lambda path: validate(_AdditiveFile, read_toml(path))),
        "plan": Kind(".toml", plans, _plan, (("sweep", "FILE", "--estimate"),)),
        "table of a plan": Kind(".csv", [table + b"1.0,15,3,0.2,80\n0.8,12,5,0.1,90\n"], table_plan),
        "result file": Kind(".h5", [results.read_bytes()], read_file, (
                ("sweep", "status", "FILE"),
                ("fit", "FILE", "-o", "OUT.json"),
            )),
        "formula": Kind(
            ".json", [data_path("formulas", f"{name}.json").read_bytes() for name in ("fva3", "75w90")], _formula,
            (
                ("mu", "FILE", *OPTIONS),
                ("export", "FILE", "-o", "OUT.py"),
                ("gear", DESIGN, "--friction", "FILE"),
                ("compare", DESIGN, "--friction", "FILE"),
            ),
            _formula_checksum,
        ),
        "calibration data": Kind(
            ".csv", [calibration.read_bytes()], lambda path: read_measurement(path, fixed),
            (("calibrate", "FILE", "--setup", str(EXAMPLES / "calibration.toml")),),
        ),
        "calibration workbook": Kind(".xlsx", [_workbook(traction)], lambda path: read_measurement(path, fixed)),
        "calibration setup": Kind(
            ".toml", [setup], lambda path: load_setup(path, {}), (("calibrate", str(calibration), "--setup", "FILE"),)
        ),
        "design": Kind(".toml", _shipped("designs"), load_design, (
                ("gear", "FILE", *CONSTANT),
                ("compare", "FILE", *CONSTANT),
                ("study", "FILE", *CONSTANT, "--torque", "100, 200 N m", "-o", "OUT"),
                ("misalignment", "FILE", "--E", "-0.1, 0.1 mm"),
                ("export", "FILE", "--what", "summary", "-o", "OUT"),
                ("loss-map", "FILE", *CONSTANT, "--torque", "100, 200 N m", "--speed", "500, 1500 rpm"),
                ("axle-test", "FILE", *CONSTANT, "--torque-max", "1000 N m", "-o", "OUT.csv"),
                ("plan", "FILE", "--duty", str(folder / "duty.csv"), "-o", "OUT.toml"),
            )),
        "blank": Kind(".toml", _shipped("blanks"), _blank, (("blank", "FILE"),)),
        "targets": Kind(
            ".toml", _shipped("targets"), lambda path: validate(SettingsInput, read_toml(path)), (
                ("settings", "FILE"),
                ("optimise", "FILE", "-o", "OUT"),
            )
        ),
        "duty cycle": Kind(
            ".csv", [text], read_duty, (
                ("gear", DESIGN, "--duty", "FILE", *CONSTANT),
                ("optimise", TARGETS, "--duty", "FILE", "-o", "OUT"),
            )
        ),
        "duty workbook": Kind(
            ".xlsx", [_workbook(duty)], read_duty, (("plan", DESIGN, "--duty", "FILE", "-o", "OUT.toml"),)
        ),
        "load distribution": Kind(".csv", [load], read_load_table),
        "machine summary": Kind(".csv", summaries, _summary, (("import", "FILE", "-o", "OUT.toml"),)),
        "inspection grid": Kind(
            ".csv", grids, read_point_grid, (("correct", DESIGN, "FILE", "--uncertainty", "1 um", "-o", "OUT.toml"),)
        ),
        "ease-off map": Kind(".csv", [relief.encode()], read_ease_off_map),
        "measured profile": Kind(
            ".csv", [profile.encode()], lambda path: load_profile(path, cutoff_long=None, cutoff_short=2.5e-6)
        ),
        "solid": Kind(".stl", [solid], read_stl),
    }  # fmt: skip
