"""Twenty plausible mistakes for each command: field, value, what is allowed and what to do next, and no traceback.

A mistake is a value in place of a right one: in the file the command reads, or in its options.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import efficiency
import ehl

Cli = Callable[..., Any]
ROOT = Path(__file__).resolve().parents[2]
PAIR = "fm_spiral_bevel_14x39"

# (what stands in the right file, what the user wrote, field of the message, what it must say besides)
Change = tuple[str, str, str, str]
CONTACT: list[Change] = [
    ('"1.2 GPa"', '"1.2 Gpa s"', "contact.pressure_hertz", "1.2 GPa"),
    ('"1.2 GPa"', '"1200"', "contact.pressure_hertz", "1200"),
    ('"1.2 GPa"', '"120 GPa"', "contact.pressure_hertz", "at most"),
    ('"1.2 GPa"', "-1e9", "contact.pressure_hertz", "at least"),
    ("pressure_hertz", "presure_hertz", "contact.presure_hertz", "'pressure_hertz'"),
    ('"15 mm"', '"15 GPa"', "contact.radius_equivalent", "dimension"),
    ('"15 mm"', "15", "contact.radius_equivalent", "at most 10 m"),
    ('"15 mm"', "true", "contact.radius_equivalent", "10 mm"),
    ('"5 m/s"', '"5 rpm"', "contact.speed_entrainment", "dimension"),
    ('"5 m/s"', '"-5 m/s"', "contact.speed_entrainment", "sign"),
    ('"75w90"', '"75w-90"', "lubricant.oil", "'75w90'"),
    ('"75w90"', '"my_oil.toml"', "lubricant.oil", "my_oil.toml"),
    ('"75w90"', '"minral vg 220"', "lubricant.base", "mineral"),
    ('"90 degC"', '"9000 degC"', "lubricant.temperature_oil", "at most"),
    ('"90 degC"', "90", "lubricant.temperature_oil", "at least"),
    ('"steel"', '"stel"', "solid_1.material", "'steel'"),
    ('"0.3 um"', '"3 mm"', "surface.roughness_rms_1", "at most"),
    ('"EP"', '"EPP"', "surface.additive", "'EP'"),
    ('"deterministic"', '"determinstic"', "model.roughness", "'deterministic'"),
    ('"standard"', '"standart"', "model.accuracy", "'standard'"),
    ("[surface]", "[surfaces]", "surfaces", "surface"),
]
PLAN: list[Change] = [
    ('"2.0 GPa"', '"20 GPa"', "variables.pressure_hertz", "at most"),
    ('"0.3 GPa"', '"0.3 mm"', "variables.pressure_hertz", "dimension"),
    ('"0.3 GPa"', '"3 GPa"', "variables.pressure_hertz", "low"),
    ("pressure_hertz", "pressure_herz", "variables.pressure_herz", "'pressure_hertz'"),
    ('"60 mm"', '"60 m"', "variables.radius_equivalent", "at most"),
    ('scale = "log"', 'scale = "logarithmic"', "variables.radius_equivalent.scale", "log"),
    ('"15 m/s"', '"15 rpm"', "variables.speed_entrainment", "dimension"),
    ("low = 0.01", 'low = "a"', "variables.slide_to_roll", "number"),
    ("high = 1.2", "hihg = 1.2", "variables.slide_to_roll.hihg", "'high'"),
    ('"120 degC"', '"1200 degC"', "variables.temperature_oil", "at most"),
    ('"40 degC"', "40", "variables.temperature_oil", "at least"),
    ('"1.0 um"', '"1.0 mm"', "variables.roughness_rms", "at most"),
    ("size = 256", "size = -1", "sampling.size", "-1"),
    ("size = 256", "size = 10.5", "sampling.size", "whole number"),
    ("seed = 1", 'seed = "x"', "sampling.seed", "whole number"),
    ("[sampling]", "[sample]", "sample", "'sampling'"),
    ('"3000 N/mm"', '"3000 mm"', "constraints.load_per_length", "dimension"),
    ("film_ratio", "film_rato", "constraints.film_rato", "'film_ratio'"),
    ('"75w90"', '"75W90"', "lubricant.oil", "'75w90'"),
    ('"deterministic"', '"load sharing"', "model.roughness", "'load_sharing'"),
    ('"fast"', '"quick"', "model.accuracy", "fast"),
]
TARGETS: list[Change] = [
    ("teeth_pinion = 13", "teeth_pinion = 1", "blank.teeth_pinion", "at least"),
    ("teeth_pinion = 13", "teeth_pinion = 13.5", "blank.teeth_pinion", "whole number"),
    ("teeth_pinion = 13", "teeth_pinion = 50", "blank.teeth_gear", "pinion"),
    ("teeth_pinion", "teeth_pinon", "blank.teeth_pinon", "'teeth_pinion'"),
    ('"170 mm"', '"170"', "blank.outer_pitch_diameter_gear", "at most"),
    ('"170 mm"', '"17 rpm"', "blank.outer_pitch_diameter_gear", "dimension"),
    ('"30 mm"', '"-30 mm"', "blank.face_width_gear", "-30 mm"),
    ('"34 deg"', '"134 deg"', "blank.mean_spiral_angle_gear", "134 deg"),
    ("mean_spiral_angle_gear", "mean_spiral_angle_pinion", "blank.mean_spiral_angle_gear", "Method 2"),
    ('"15 mm"', '"-15 mm"', "blank.hypoid_offset", "at least"),
    ("method = 2", "method = 0", "blank.hypoid_offset", "Method 1, 2 or 3"),
    ("method = 2", "method = 4", "blank.method", "4"),
    ('"face_milling"', '"face_hobbing"', "blank.blade_groups", "number"),
    ('"face_milling"', '"face-milling"', "blank.process", "'face_milling'"),
    ('"20 deg"', '"80 deg"', "blank.pressure_angle.drive", "80 deg"),
    ('"tilted_root"', '"tilted"', "blank.taper.type", "'tilted_root'"),
    ('"0.2 mm"', '"20 mm"', "blank.backlash.value", "at most"),
    ('"each_flank"', '"each"', "cutting.pinion", "each_flank"),
    ("crowning_toe", "crowning_toes", "targets.drive.crowning_toes", "'crowning_toe'"),
    ('"ground"', '"grinded"', "pinion.finish", "ground"),
    ('"250 N m"', '"250 Nm/s"', "operation.torque", "250 N m"),
]
DESIGN: list[Change] = [
    ('"300 N m"', '"300 N"', "operation.torque", "dimension"),
    ('"300 N m"', '"300 kg"', "operation.torque", "250 N m"),
    ('"300 N m"', '"3e9 N m"', "operation.torque", "at most"),
    ('"1200 rpm"', '"1200 Hz m"', "operation.speed", "1500 rpm"),
    ('"1200 rpm"', '"fast"', "operation.speed", "1500 rpm"),
    ('"90 degC"', '"-300 degC"', "operation.temperature", "at least"),
    ("torque =", "torqe =", "operation.torqe", "'torque'"),
    ('"75w90"', '"75w80"', "operation.oil", "'75w90'"),
    ('"ground"', '"groud"', "pinion.finish", "'ground'"),
    ('"steel"', '"Steel"', "pinion.material", "'steel'"),
    ("teeth = 14", "teeth = 0", "pinion.blank.teeth", "0"),
    ("teeth = 14", 'teeth = "fourteen"', "pinion.blank.teeth", "whole number"),
    ('"left"', '"lefthand"', "pinion.blank.hand", "'left'"),
    ('"concave"', '"concav"', "assembly.drive_flank_pinion", "'concave'"),
    ('"0.127 mm"', '"127 MPa"', "assembly.normal_backlash", "dimension"),
    ("shaft_angle", "shaftangle", "assembly.shaftangle", "'shaft_angle'"),
    ('"90 deg"', '"90"', "assembly.shaft_angle", "90"),
    ("hypoid_offset = 0.0", 'hypoid_offset = "31 s"', "assembly.hypoid_offset", "dimension"),
    ("[pinion.blank]", "[pinion.blanks]", "pinion.blanks", "'blank'"),
    ("[operation]", "[operations]", "operations", "'operation'"),
]
SETUP: list[Change] = [
    ('"fva3"', '"fva33"', "oil", "'fva3'"),
    ('"eyring_stress"', '"eyring_stres"', "parameters", "eyring_stress"),
    ('"9.525 mm"', '"9.525 s"', "conditions.radius_equivalent", "dimension"),
    ('"9.525 mm"', '"9525 m"', "conditions.radius_equivalent", "at most"),
    ('"80 degC"', '"80"', "conditions.temperature_oil", "at least"),
    ('"80 nm"', '"80 mm"', "conditions.roughness_rms", "at most"),
    ("roughness_rms", "roughnes_rms", "conditions.roughnes_rms", "'roughness_rms'"),
    ('"point"', '"ball"', "specimens.geometry", "point"),
    ('"hertz_pressure"', '"pressure"', "specimens.match", "hertz_pressure"),
    ("geometry =", "geometri =", "specimens.geometri", "'geometry'"),
    ("absolute = 0.0006", "absolute = -1", "noise.absolute", "-1"),
    ("absolute = 0.0006", 'absolute = "a bit"', "noise.absolute", "a bit"),
    ("absolute =", "absolut =", "noise.absolut", "'absolute'"),
    ('"load_sharing"', '"loadsharing"', "model.roughness", "'load_sharing'"),
    ('"fast"', '"fastest"', "model.accuracy", "'fast'"),
    ("[specimens]", "[specimen]", "specimen", "'specimens'"),
    ("[conditions]", "[condition]", "condition", "'conditions'"),
    ("[noise]", "[noises]", "noises", "'noise'"),
    ("[model]", "[models]", "models", "'model'"),
    ("oil =", "oill =", "oill", "'oil'"),
]
CARD: list[Change] = [
    ('base = "mineral"', 'base = "minerale"', "base", "'mineral'"),
    ("viscosity_kinematic_40 = ", 'viscosity_kinematic_40 = "-220 cSt" #', "viscosity_kinematic_40", "above"),
    ("viscosity_kinematic_40 = ", 'viscosity_kinematic_40 = "220 mPa s" #', "viscosity_kinematic_40", "dimension"),
    ("viscosity_kinematic_40 = ", "viscosity_kinematic_40 = 220 #", "viscosity_kinematic_40", "220"),
    ("viscosity_kinematic_100 = ", "viscosity_kinematic_100 = 3e-4 #", "viscosity_kinematic_100", "exchanged"),
    ("viscosity_kinematic_100", "viscosity_kinematic100", "viscosity_kinematic100", "'viscosity_kinematic_100'"),
    ("density_15 = ", "density_15 = 0.88 #", "density_15", "0.88"),
    ("thermal_conductivity = ", "thermal_conductivity = -", "thermal_conductivity", "-"),
    ("heat_capacity = ", 'heat_capacity = "2 degC" #', "heat_capacity", "dimension"),
    ("[viscosity]", "[viscosities]", "viscosities", "'viscosity'"),
]
CURVES: list[Change] = [
    ("load [N]", "laod [N]", "header", "Did you mean 'load'?"),
    ("load [N]", "load [Pa]", "row 4, load", "dimension"),
    ("load [N]", "normal force [N]", "header", "load_per_length"),
    ("speed_entrainment [m/s]", "speed_entrainment [rpm]", "row 4, speed_entrainment", "dimension"),
    ("speed_entrainment [m/s]", "speed [m/s]", "header", "Did you mean 'speed_entrainment'?"),
    ("slide_to_roll", "srr", "header", "Did you mean 'slide_to_roll'?"),
    ("slide_to_roll", "slide_to_roll [mm]", "row 4, slide_to_roll", "dimension"),
    ("friction_coefficient", "mu", "header", "Did you mean 'friction_coefficient'?"),
    (",0.009010", "", "friction_coefficient", "empty"),
    (",0.009010", ",", "friction_coefficient", "empty"),
    (",0.009010", ",low", "friction_coefficient", "could not be read"),
    (",0.009010", ",0,009010", "row 4", "semicolons"),
    (",0.009010", ",9.010", "friction_coefficient", "at most 2"),
    ("19,2.5,0.005", "-19,2.5,0.005", "row 4, load", "above 0"),
    ("19,2.5,0.005", "19e9,2.5,0.005", "row 4, load", "at most"),
    ("19,2.5,0.005", "19,0,0.005", "row 4, speed_entrainment", "at least"),
    ("19,2.5,0.005", "19,2.5,nan", "row 4, slide_to_roll", "finite"),
    ("19,2.5,0.005", "19,2.5 rpm,0.005", "row 4, speed_entrainment", "dimension"),
    ("curve,", "curve;", "header", "columns named"),
    ("curve,load [N]", "load [N],load [N]", "header", "each column once"),
]
SHEET: list[Change] = [
    ("units, mm", "units, cm", "line 2", "one of inch"),
    ("units, mm", "unit, mm", "mean cone distance", "units, mm"),
    ("member, pinion", "member, pinon", "line 4", "pinion, gear"),
    ("member, pinion", "members, pinion", "line 5", "member, pinion"),
    ("teeth, 14", "teeth, 14.5", "line 5 (teeth)", "whole number"),
    ("teeth, 14", "teeth, 0", "teeth", "at least 3"),
    ("teeth, 14", "teeth, fourteen", "line 5 (teeth)", "number"),
    ("hand, left", "hand, lefthand", "line 6 (hand)", "left, lh"),
    ("hand, left", "", "hand", "'left', 'right'"),
    ("face width, 25.4", "face width, -25.4", "face_width", "above 0"),
    ("face width, 25.4", "face width, 2540", "face_width", "tooth depth falls to 0"),
    ("face width, 25.4", "facewidth, 25.4", "face_width", "above 0"),
    ("pitch angle, 19.7468", "pitch angle, 197.468", "pitch_angle", "below"),
    ("mean addendum, 4.836", "mean addendum, nan", "mean addendum", "finite"),
    ("mean addendum, 4.836", "mean addendum, 4,836 x", "mean addendum", "comma"),
    ("flank, concave", "flank, concav", "line 15", "concave, convex"),
    ("cutter type, face milling", "cutter type, facemilling", "cutter type", "face milling, face hobbing"),
    ("process, generated", "process, generating", "process", "generated, formate"),
    ("radial setting", "raidal setting", "radial_setting", "above 0"),
    ("ratio of roll, 2.98436034987", "ratio of roll, 0", "roll_ratio", "above 0"),
    ("modified roll 2c, 0.0055", "modified roll 2c, 1e9 #", "modified", "at most"),
]
FILES = {
    "solve": ("contact", CONTACT, ("solve", "FILE")),
    "sweep": ("plan", PLAN, ("sweep", "FILE", "--estimate")),
    "settings": ("targets", TARGETS, ("settings", "FILE")),
    "gear": ("design", DESIGN, ("gear", "FILE")),
    "calibrate": ("setup", SETUP, ("calibrate", ROOT / "docs/examples/synthetic_traction.csv", "--setup", "FILE")),
    "oil": ("oil", CARD, ("oil", "FILE")),
    "calibrate ": ("curves", CURVES, ("calibrate", "FILE", "--setup", ROOT / "docs/examples/calibration.toml")),
    "import": ("sheet", SHEET, ("import", "FILE", "-o", "never.toml", "--like", PAIR)),
}
IN_FILES = [(command, change) for command, (_, changes, _) in FILES.items() for change in changes]


@cache
def right_file(kind: str) -> str:
    if kind == "setup":
        return (ROOT / "docs/examples/calibration.toml").read_text(encoding="utf-8")
    if kind == "curves":
        return (ROOT / "docs/examples/synthetic_traction.csv").read_text(encoding="utf-8")
    if kind == "sheet":
        with tempfile.TemporaryDirectory() as folder:
            efficiency.load(PAIR).export(folder, ("summary",))
            return re.sub(", +", ", ", (Path(folder) / "setting_sheet.csv").read_text(encoding="utf-8"))
    return efficiency.new_file(kind)


def told(outcome: Any, field: str, *words: str) -> None:
    """Exit code 2, and a sentence with field, value or what is missing, what is allowed, and what to do."""
    assert outcome.code == 2, outcome
    assert "Traceback" not in outcome.err
    assert field in outcome.err
    for word in words:
        assert word in outcome.err
    _, allowed, rest = outcome.err.partition("allowed: ")
    _, needed, missing = outcome.err.partition("needed: ")
    assert allowed or needed
    assert ". " in (rest or missing), "no next step"


@pytest.mark.parametrize(("command", "change"), IN_FILES, ids=lambda part: part if isinstance(part, str) else part[1])
def test_mistake_in_a_file(mixed_ehl: Cli, tmp_path: Path, command: str, change: Change) -> None:
    kind, _, arguments = FILES[command]
    right, wrong, field, word = change
    text = right_file(kind)
    assert right in text
    file = tmp_path / "file.toml"
    lines = text.splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if right in line and not line.startswith("#"))
    lines[at] = lines[at].replace(right, wrong, 1)
    file.write_text("".join(lines), encoding="utf-8")
    told(mixed_ehl(*(file if part == "FILE" else part for part in arguments)), field, word)


@pytest.mark.parametrize("like", [(), ("--like", PAIR)])
@pytest.mark.parametrize("name", ["contact.toml", "synthetic_traction.csv"])
def test_a_file_without_a_line_of_a_setting_sheet_is_not_imported(
    mixed_ehl: Cli, tmp_path: Path, name: str, like: tuple[str, ...]
) -> None:
    outcome = mixed_ehl("import", ROOT / "docs/examples" / name, "-o", tmp_path / "design.toml", *like)
    told(outcome, "summary", name, "a label and its value a line")
    assert list(tmp_path.iterdir()) == []


def test_twenty_mistakes_for_each_command() -> None:
    for command, (_, changes, _) in FILES.items():
        assert len(changes) + len(OPTIONS.get(command, ((), {}, []))[2]) >= 20
    assert all(len(OPTIONS[command][2]) >= 20 for command in ("mu", "app", "demo"))
    assert sum(len(OPTIONS[command][2]) for command in ("new contact", "new others")) >= 20


POINT = {
    "--pressure": "1 GPa", "--radius": "15 mm", "--speed": "3 m/s", "--slide-to-roll": "0.3", "--temperature": "90 degC",
}  # fmt: skip
# right options of a command, and (option, what the user wrote, what the message must say besides)
# ruff: noqa: E501
OPTIONS: dict[str, tuple[tuple[str, ...], dict[str, str], list[tuple[str, str, str]]]] = {
    "mu": (
        ("mu", "75w90"), POINT,
        [
            ("--pressure", "1", "unit"), ("--pressure", "1 mm", "dimension"), ("--pressure", "100 GPa", "at most"),
            ("--pressure", "-1 GPa", "at least"), ("--pressure", "one GPa", "1.2 GPa"),
            ("--radius", "15", "unit"), ("--radius", "15 s", "dimension"), ("--radius", "0 mm", "at least"),
            ("--radius", "15 km", "at most"), ("--speed", "3", "unit"), ("--speed", "3 rpm", "dimension"),
            ("--speed", "-3 m/s", "at least"), ("--speed", "3000 m/s", "at most"),
            ("--slide-to-roll", "a", "number"), ("--slide-to-roll", "3 m/s", "dimension"),
            ("--slide-to-roll", "nan", "finite"), ("--temperature", "90", "unit"),
            ("--temperature", "9000 degC", "at most"), ("--temperature", "90 mm", "dimension"),
            ("--roughness", "0.5 mm", "at most"), ("--oil", "75w91", "'75w90'"),
        ],
    ),
    "gear": (
        ("gear", PAIR), {},
        [
            ("--torque", "300", "unit"), ("--torque", "300 rpm", "dimension"), ("--torque", "-300 N m", "above"),
            ("--torque", "1:2:3 N m", "one value"), ("--torque", "1, 2 N m", "one value"),
            ("--speed", "1500", "unit"), ("--speed", "1500 N m", "dimension"), ("--speed", "1e9 rpm", "at most"),
            ("--temperature", "90", "unit"), ("--temperature", "900 degC", "at most"),
            ("--oil", "75w-90", "'75w90'"), ("--side", "drives", "drive"), ("--driver", "pinon", "pinion"),
            ("--load-balance", "friction", "frictional"), ("--friction", "constant:2", "at most"),
            ("--friction", "75w91", "75w90"), ("--friction", "ehl:rough", "ehl"),
            ("--friction", "nothing.json", "nothing.json"), ("--units", "si", "metric"), ("--E", "0.1", "unit"),
            ("--report", "x.txt", ".html"),
        ],
    ),
    "map": (
        ("map", PAIR), {},
        [("--torque", "1:2 N m", "from:to:number"), ("--torque", "1, x N m", "N m"), ("--speed", "1,5 rpm", "comma")],
    ),
    "oil": (
        ("oil",), {"--base": "pao", "--nu40": "97.5 cSt", "--nu100": "13.3 cSt"},
        [
            ("--base", "poa", "'pao'"), ("--base", "synthetic", "polyglycol"), ("--nu40", "97 mPa s", "dimension"),
            ("--nu40", "-97 cSt", "above"), ("--nu40", "thick", "cSt"), ("--nu100", "130 cSt", "exchanged"),
            ("--nu100", "0.1 cSt", "above"), ("--density", "0.88 kg/m^3", "at least"), ("--density", "9 m", "dimension"),
            ("--plot", "x.xls", ".png"),
        ],
    ),
    "new contact": (
        ("new", "contact"), {},
        [
            ("--pressure", "100 GPa", "at most"), ("--pressure", "1 mm", "dimension"), ("--radius", "15 s", "dimension"),
            ("--radius", "15", "at most"), ("--speed", "-1 m/s", "sign"), ("--slide-to-roll", "much", "number"),
            ("--roughness", "1 mm", "at most"), ("--model", "rough", "deterministic"), ("--oil", "75W90", "'75w90'"),
            ("--temperature", "90", "at least"), ("--output", "x.csv", ".toml"),
        ],
    ),
    "new others": (
        ("new",), {},
        [
            ("oil --base", "minral", "'mineral'"), ("oil --vg", "221", "220"), ("oil --vg", "thick", "whole number"),
            ("plan --size", "many", "whole number"),
            ("plan --oil", "75w91", "'75w90'"), ("design --like", "fm_bevel", "fm_spiral_bevel_14x39"),
            ("design --torque", "300 mm", "dimension"), ("targets --offset", "5", "unit"),
            ("targets --process", "milling", "'face_milling'"), ("targets --teeth-pinion", "1", "at least"),
            ("targets --finish", "groud", "'ground'"), ("duty --torque", "300", "unit"),
            ("duty --speed", "0 rpm", "above 0"),
        ],
    ),
    "compare": (
        ("compare", PAIR), {},
        [
            ("--torque", "300", "unit"), ("--torque", "1, 2 N m", "one value"), ("--speed", "1 mm", "dimension"),
            ("--friction", "xu_kahraman_2006", "xu_kahraman_2007"), ("--side", "both", "drive"), ("--oil", "oil", "75w90"),
        ],
    ),
    "loss-map": (
        ("loss-map", PAIR), {"--torque": "100, 200 N m", "--speed": "500 rpm"},
        [
            ("--torque", "100", "unit"), ("--speed", "500 N m", "dimension"), ("--friction", "constant:-1", "at least"),
            ("--temperature", "hot", "80 degC"), ("--drag", "2", "unit"), ("--vecto", "x.csv", ".vtlm"),
        ],
    ),
    "misalignment": (
        ("misalignment", PAIR), {"--E": "0, 0.1 mm"},
        [("--E", "0.1", "unit"), ("--P", "1 deg", "dimension"), ("--shaft-angle-error", "1 mm", "dimension"), ("--side", "up", "drive")],
    ),
    "loss-map again": (
        ("loss-map", PAIR), {"--torque": "100, 200 N m", "--speed": "500 rpm"},
        [
            ("--torque", "100:x:3 N m", "a number in N*m"), ("--torque", "1e9 N m", "at least"),
            ("--speed", "-500 rpm", "above"), ("--speed", "500", "unit"),
            ("--friction", "75w9", "constant:VALUE, coleman"), ("--temperature", "900 degC", "at least"),
            ("--drag", "-2 N m", "at least"), ("--drag", "2 mm", "dimension"), ("--load-share", "150 %", "at least"),
            ("--load-share", "-1 %", "at least"), ("--axle-losses", "none.csv", "an existing CSV or"),
            ("--load-balance", "friction", "frictional or frictionless"), ("--xlsx", "x.csv", "a file name ending"),
            ("--vecto", "no/where.vtlm", "a file in a"),
        ],
    ),
    "misalignment again": (
        ("misalignment", PAIR), {"--E": "0, 0.1 mm"},
        [
            ("--E", "0:0.1 mm", "'from:to:number unit' such as"), ("--E", "10 mm", "at least"),
            ("--E", "a mm", "a number in m"), ("--P", "0.1", "unit"), ("--P", "50 mm", "at least"),
            ("--G", "0.1", "unit"), ("--G", "2 s", "dimension"), ("--G", "0.1,,0.2 mm", "a number in m"),
            ("--shaft-angle-error", "2", "unit"), ("--shaft-angle-error", "20 deg", "at least"), ("--shaft-angle-error", "x arcmin", "a number in rad"),
            ("--side", "both sides", "drive, coast or both"), ("--torque", "300", "unit"),
            ("--torque", "-300 N m", "above"), ("--torque", "300 mm", "dimension"),
            ("--friction", "75w91", "no value without a"), ("--speed", "10", "no value without a"),
        ],
    ),
    "compare again": (
        ("compare", PAIR), {"--torque": "300 N m"},
        [
            ("--torque", "-300 N m", "above"), ("--torque", "300 mm", "dimension"), ("--torque", "0 N m", "above"),
            ("--speed", "1500", "unit"), ("--speed", "1e9 rpm", "above"), ("--temperature", "90", "unit"),
            ("--temperature", "900 degC", "at least"), ("--oil", "75w91", "one of 5p4e, 75w90"),
            ("--friction", "constant:two", "constant:VALUE as in constant:0"),
            ("--friction", "constant:3", "at least"), ("--friction", "none.json", "a formula file as"),
            ("--report", "x.pdf", "a file name ending"), ("--driver", "geer", "pinion or gear"),
        ],
    ),
    "axle-test": (
        ("axle-test", PAIR), {},
        [
            ("--application", "singel", "single or tandem"), ("--torque-max", "2500", "unit"),
            ("--torque-max", "-1 N m", "above"), ("--torque-max", "2500 rpm", "dimension"),
            ("--torque-max", "1e9 N m", "above"), ("--revolutions-per-mile", "-650", "at least"),
            ("--revolutions-per-mile", "many", "a number"), ("--revolutions-per-mile", "0", "at least"),
            ("--revolutions-per-mile", "nan", "a finite value"), ("--friction", "constant:2", "at least"),
            ("--friction", "75w91", "constant:VALUE, coleman"), ("--temperature", "80", "unit"),
            ("--temperature", "900 degC", "at least"), ("--axle-losses", "none.csv", "an existing CSV or"),
            ("--drag", "2", "unit"), ("--drag", "-2 N m", "at least"), ("--load-share", "2", "at least"),
            ("--load-share", "a %", "a number without unit"),
            ("--load-balance", "friction", "frictional or frictionless"), ("--xlsx", "x.csv", "a file name ending"),
        ],
    ),
    "export": (
        ("export", PAIR), {"--output": "out"},
        [
            ("--what", "tooths", "some of tooth, member"), ("--what", "gird", "some of tooth, member"),
            ("--what", "", "some of tooth, member"), ("--member", "pinon", "pinion, gear or both"),
            ("--rows", "2", "from 5 to 200"), ("--rows", "-5", "from 5 to 200"), ("--rows", "many", "a whole number"),
            ("--rows", "100000", "from 5 to 200"), ("--columns", "1", "from 5 to 200"),
            ("--columns", "1e3", "a whole number"), ("--margin", "0.6", "from 0 to 0"),
            ("--margin", "-0.1", "from 0 to 0"), ("--margin", "a", "a number"), ("--rim", "6", "unit"),
            ("--rim", "-6 mm", "at least"), ("--rim", "6 s", "dimension"), ("--bore", "-1 mm", "at least"),
            ("--bore", "10 m", "at least"), ("--bore", "10", "unit"), ("--units", "si", "metric or inch"),
        ],
    ),
    "export formula": (
        ("export", "75w90"), {"--output": "mu.py"},
        [
            ("--language", "pyton", "one of python, c"), ("--language", "java", "one of python, c"),
            ("--output", "no/where/mu.py", "a writable file"), ("--oil", "75w91", "one of 75w90"),
            ("--oil", "fva3", "one of 75w90"), ("--what", "grid", "nothing beside a formula"),
            ("--member", "pinion", "nothing beside a formula"),
        ],
    ),
    "correct": (
        ("correct", PAIR, "none.csv"), {},
        [
            ("--order", "3", "1 or 2"), ("--order", "0", "1 or 2"), ("--order", "two", "a whole number"),
            ("--uncertainty", "1", "0"), ("--uncertainty", "-1 um", "0"), ("--uncertainty", "1 s", "dimension"),
            ("--uncertainty", "0 um", "0"), ("--uncertainty", "10 mm", "0"),
        ],
    ),
    "plan": (
        ("plan", PAIR), {"--duty": "duty.csv", "--output": "p.toml"},
        [
            ("--duty", "none.csv", "an existing CSV or"), ("--output", "p.json", "a file name ending"),
            ("--oil", "75w91", "one of 5p4e, 75w90"), ("--size", "0", "at least"), ("--size", "-1", "at least"),
            ("--size", "many", "a whole number"), ("--coverage", "a", "a number"),
            ("--model", "rough", "deterministic or load_sharing"),
        ],
    ),
    "study": (
        ("study", PAIR), {},
        [
            ("--friction", "75w91", "constant:VALUE, coleman"), ("--friction", "constant:-1", "at least"),
            ("--jobs", "0", "at least"), ("--jobs", "-2", "at least"), ("--jobs", "many", "a whole number"),
            ("--jobs", "1000", "at least"), ("--torque", "50", "unit"),
            ("--torque", "50:250 N m", "'from:to:number unit' such as"), ("--torque", "-50 N m", "above"),
            ("--torque", "50:250:100000 N m", "'from:to:number unit' such as"), ("--speed", "100", "unit"),
            ("--speed", "0 rpm", "above"), ("--speed", "1 mm", "dimension"), ("--temperature", "80", "unit"),
            ("--temperature", "800 degC", "at least"), ("--roughness-each", "0.2", "unit"),
            ("--roughness-each", "-0.2 um", "at least"), ("--roughness-each", "2 mm", "at least"),
            ("--oil", "75w91", "one of 5p4e, 75w90"), ("--side", "both", "drive or coast"), ("--E", "0.1", "unit"),
            ("--shaft-angle-error", "4 mm", "dimension"), ("--load-balance", "friction", "frictional or frictionless"),
            ("--P", "10 m", "at least"),
        ],
    ),
    "optimise": (
        ("optimise", "fm_hypoid_13x42"), {},
        [
            ("--vary", "crowning", "one of lengthwise_crowning, profile_crowning"),
            ("--objective", "loss", "one of power_loss, pressure_max"),
            ("--objective", "pressure", "one of power_loss, pressure_max"),
            ("--limit", "presure_max", "one of power_loss, pressure_max"),
            ("--flanks", "drives", "drive, coast or both"), ("--evaluations", "1", "from 9 to 20000"),
            ("--evaluations", "many", "a whole number"), ("--batch", "0", "from 1 to 256"),
            ("--check", "-1", "from 0 to 100"), ("--check", "many", "a whole number"), ("--seed", "-1", "at least"),
            ("--duty", "none.csv", "an existing CSV or"), ("--oil", "none", "one of 5p4e, 75w90"),
            ("--E", "0.05", "unit"), ("--E", "-0.05 mm", "above"), ("--over", "median", "mean or worst"),
            ("--jobs", "0", "at least"), ("--vary", "hypoid_ofset", "one of lengthwise_crowning, profile_crowning"),
            ("--limit", "noise", "one of power_loss, pressure_max"),
            ("--dask", "nowhere.json", "a scheduler file that exists"), ("--dask", "local:x", "local:N with N"),
            ("--check-friction", "75w90", "that solves contacts: ehl"), ("--check-friction", "ehl:rough", "ehl, ehl:load_sharing"),
        ],
    ),
    "fit": (
        ("fit", "gear_fva3_noise"), {"--output": "f.json"},
        [
            ("--family", "shrot", "one of xu, power_law"), ("--family", "neural", "one of xu, power_law"),
            ("--output", "no/where/f.json", "a file in a"), ("--output", "f.toml", "a file name ending"), ("--paths", "none", "a folder or file"),
            ("--noise", "none", "a folder or file"), ("--plot", "x.xls", "a file name ending"),
            ("--report", "x.pdf", "a file name ending"), ("--noise", "gear_75w90_noise", "with the oils of the data, fva3"),
            ("--paths", "gear_75w90_paths", "with the oils of the data, fva3"),
            ("--paths", str(ROOT / "docs/examples/contact.toml"), "It is a contact file"),
            ("--noise", str(ROOT / "README.md"), "mixed-ehl sweep PLAN.toml"), ("--family", "", "one of xu, power_law"),
            ("--paths", str(ROOT / "docs"), "a folder or file"),
        ],
    ),
    "fit names": (
        ("fit", "--output", "f.json"), {},
        [
            (str(ROOT / "data/plans/demo.toml"), "--corners", "It is a plan, for mixed-ehl sweep"),
            (str(ROOT / "data/oils/75w90.toml"), "--corners", "It is an oil card"),
            (str(ROOT / "data/designs/fm_hypoid_13x42.toml"), "--corners", "It is a design"),
            (str(ROOT / "data/formulas/75w90.json"), "--corners", "It is JSON, such as a formula"),
            (str(ROOT / "docs/examples/synthetic_traction.csv"), "--corners", "It is a table"),
            ("75w90", "--corners", "gear_75w90"), ("gear_fva3_nois", "--corners", "gear_fva3_noise"),
        ],
    ),
    "sweep": (
        ("sweep", "demo"), {"--output": "r"},
        [
            ("--jobs", "0", "at least"), ("--jobs", "-3", "at least"), ("--jobs", "many", "a whole number"),
            ("--jobs", "1000", "at least"), ("--shard", "0/4", "i/n with 1 <="), ("--shard", "5/4", "i/n with 1 <="),
            ("--shard", "1of4", "i/n with 1 <="), ("--time-cap", "600", "unit"), ("--time-cap", "-1 s", "above"),
            ("--time-cap", "1 mm", "dimension"), ("--retries", "-1", "at least"),
            ("--retries", "many", "a whole number"),
            ("--with", "xu_kahraman_2006", "one of arana_2019, benedict_kelley_1961"),
            ("--set", "lubricant.oil", "KEY=VALUE such as lubricant"), ("--slurm", "0", "at least"),
            ("--slurm", "many", "a whole number"), ("--dask", "local:0", "local:N with N worker"),
        ],
    ),
    "calibrate": (
        ("calibrate", ROOT / "docs/examples/synthetic_traction.csv"), {"--setup": str(ROOT / "docs/examples/calibration.toml")},
        [
            ("--setup", "none.toml", "an existing TOML file"), ("--output", "x.csv", "a file name ending"),
            ("--plot", "x.xls", "a file name ending"), ("--report", "x.txt", "a file name ending"),
            ("--jobs", "0", "at least"), ("--fit", "eyring_stres", "eyring_stress"), ("--oil", "fva33", "'fva3'"),
            ("--seed", "-1", "at least"),
        ],
    ),
    "demo": (
        ("demo",), {},
        [
            ("--jobs", "0", "at least"), ("--jobs", "many", "a whole number"), ("--jobs", "999", "at most"),
            ("--jobs", "1.5", "a whole number"), ("--jobs", "", "a whole number"), ("--jobs", "-2", "at least"),
            ("--output", "/proc/x", "a folder that can be written"), ("--output", "/dev/null", "There is a file of that name"),
            ("--output", "", "'.' is the folder you are in"), ("-o", "", "'.' is the folder you are in"), ("--output", "x" * 300, "File name too long"),
            ("--output", str(ROOT / "README.md/results"), "There is a file of that name"),
            ("--output", "--jobs", "a file or folder"), ("--jobs --output", "results", "a whole number"),
            ("--jobs", "1,5", "a whole number"), ("--ouput", "results", "Did you mean '--output'?"),
            ("-j", "2", "one of --jobs, --output"), ("--oil", "fva3", "one of --jobs, --output"),
            ("--design", "fm_hypoid_13x42", "one of --jobs, --output"), ("fm_hypoid_13x42", "fva3", "options alone"),
            ("--jobs", "all", "a whole number"),
        ],
    ),
    "app": (
        ("app",), {},
        [
            ("--port", "80", "at least"), ("--port", "many", "a whole number"), ("--port", "70000", "at most"),
            (str(ROOT / "data/oils/75w90.toml"), "--no-browser", "It is an oil card"),
            (str(ROOT / "data/formulas/75w90.json"), "--no-browser", "It is JSON"),
            ("--port", "8642.5", "a whole number"), ("--port", "-1", "at least"), ("--port", "", "a whole number"),
            (str(ROOT / "docs/examples/contact.toml"), "--no-browser", "It is a contact file"),
            (str(ROOT / "docs/examples"), "--no-browser", "It is a folder"),
            (str(ROOT / "docs/examples/synthetic_traction.csv"), "--no-browser", "It is a table (CSV)"),
            (str(ROOT / "README.md"), "--no-browser", "valid TOML"), ("none.toml", "--no-browser", "check the path"),
            ("fm_hypoid_13x43", "--no-browser", "Did you mean 'fm_hypoid_13x42'"),
            (str(ROOT / "data/targets/fm_hypoid_13x42.toml"), "--no-browser", "It is a targets file"),
            (str(ROOT / "data/blanks/fm_hypoid_13x42.toml"), "--no-browser", "It is a blank"),
            ("--host", "0.0.0.0", "one of --browser, --port"), ("--port", "localhost:8642", "a whole number"),
            ("--friction", "75w90", "one of --browser, --port"), ("--browser", "firefox", "a TOML file or one of"),
            (PAIR, "fm_hypoid_13x42", "no more than design"),
        ],
    ),
    "names": (
        (), {},
        [
            ("gear", "fm_spiral_bevel_14x40", "'fm_spiral_bevel_14x39'"), ("gear", "75w90", "is an oil"),
            ("gear", f"{PAIR}.toml", "Without .toml"), ("gear", "mine.toml", "check the path"),
            ("blank", "iso23509_f9", "iso23509_f2"), ("settings", "fh_hypoid_9x35", "'fh_hypoid_9x34'"),
            ("solve", "contact.toml", "check the path"), ("solve", str(ROOT / "docs"), "folder"),
            ("sweep", "demos", "demo"), ("oil", "fva", "fva3"), ("compare", "demo", "is a plan"),
            ("new", "targts", "'targets'"),
        ],
    ),
}  # fmt: skip
IN_OPTIONS = [(command, *mistake) for command, (_, _, mistakes) in OPTIONS.items() for mistake in mistakes]


@pytest.mark.parametrize(("command", "option", "value", "word"), IN_OPTIONS)
def test_mistake_in_an_option(
    mixed_ehl: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, option: str, value: str, word: str
) -> None:
    monkeypatch.chdir(tmp_path)
    start, right, _ = OPTIONS[command]
    *before, last = option.split()
    given = {name: text for name, text in right.items() if name != last} | {last: value}
    outcome = mixed_ehl(*start, *before, *(part for pair in given.items() for part in pair))
    told(outcome, last if last in outcome.err else value, word)
    assert list(tmp_path.iterdir()) == []


SHIPPED = ROOT / "data"
KINDS = {
    "a contact file": ROOT / "docs/examples/contact.toml",
    "an oil card": SHIPPED / "oils/75w90.toml",
    "a plan": SHIPPED / "plans/demo.toml",
    "a blank": SHIPPED / "blanks/iso23509_f4.toml",
    "a targets file": SHIPPED / "targets/fm_hypoid_13x42.toml",
    "a design": SHIPPED / "designs/fm_hypoid_13x42.toml",
    "the setup of a calibration": ROOT / "docs/examples/calibration.toml",
    "JSON": SHIPPED / "formulas/75w90.json",
    "a table": ROOT / "docs/examples/synthetic_traction.csv",
}
READERS = {
    "solve": "a contact file", "oil": "an oil card", "sweep": "a plan", "blank": "a blank",
    "settings": "a targets file", "gear": "a design",
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("command", READERS)
def test_file_of_another_kind_is_named(mixed_ehl: Cli, command: str, kind: str) -> None:
    if READERS[command] == kind or (command == "oil" and KINDS[kind].suffix != ".toml"):
        return
    outcome = mixed_ehl(command, KINDS[kind], *(["--estimate"] if command == "sweep" else []))
    told(outcome, KINDS[kind].name, f"It is {kind}", READERS[command])


def test_all_problems_of_a_file_at_once(mixed_ehl: Cli, tmp_path: Path) -> None:
    text = right_file("contact").replace("1.2 GPa", "120 GPa").replace("75w90", "75w91", 1).replace('"EP"', '"PE"')
    file = tmp_path / "contact.toml"
    file.write_text(text, encoding="utf-8")
    outcome = mixed_ehl("solve", file)
    told(outcome, "contact.pressure_hertz", "lubricant.oil", "surface.additive", "3 problems")
    with pytest.raises(ehl.InputError, match="3 problems") as caught:
        ehl.Contact.from_file(file)
    fields = [problem.field for problem in caught.value.problems]
    assert fields == ["contact.pressure_hertz", "lubricant.oil", "surface.additive"]
