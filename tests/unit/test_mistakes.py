"""Plausible mistakes for each command: exit code 2 with the field, and no traceback.

A mistake is a value in place of a right one: in the file the command reads, or in its options.
"""

import re
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from refusals import refused
from small_plans import POINT

import efficiency

ROOT = Path(__file__).resolve().parents[2]
PAIR = "fm_spiral_bevel_14x39"

# kind of the right file, command, and on each line: what stands in the file, what the user wrote, field of the message
FILES: dict[str, tuple[str, tuple[Any, ...], str]] = {
    "solve": ("contact", ("solve", "FILE"), """
        "1.2 GPa" | "1.2 Gpa s" | contact.pressure_hertz
        pressure_hertz | presure_hertz | contact.presure_hertz
        "90 degC" | "9000 degC" | lubricant.temperature_oil
        "steel" | "stel" | solid_1.material
        "0.3 um" | "3 mm" | surface.roughness_rms_1
        "EP" | "EPP" | surface.additive
        "standard" | "standart" | model.accuracy
        [surface] | [surfaces] | surfaces"""),
    "sweep": ("plan", ("sweep", "FILE", "--estimate"), """
        "2.0 GPa" | "20 GPa" | variables.pressure_hertz
        pressure_hertz | pressure_herz | variables.pressure_herz
        "75w90" | "75W140" | lubricant.oil
        "fast" | "quick" | model.accuracy"""),
    "settings": ("targets", ("settings", "FILE"), """
        teeth_pinion = 13 | teeth_pinion = 0 | blank.teeth_pinion
        teeth_pinion = 13 | teeth_pinion = 50 | blank.teeth_gear
        "170 mm" | "170" | blank.outer_pitch_diameter_gear
        "30 mm" | "-30 mm" | blank.face_width_gear
        "15 mm" | "-0.6 m" | blank.hypoid_offset
        method = 2 | method = 4 | blank.method
        "face_milling" | "face_hobbing" | blank.blade_groups
        "20 deg" | "80 deg" | blank.pressure_angle.drive
        "tilted_root" | "tilted" | blank.taper.type
        "0.2 mm" | "20 mm" | blank.backlash.value
        crowning_toe | crowning_toes | targets.drive.crowning_toes
        crowning_toe = | transmission_error = "2 mm" # | targets.drive.transmission_error
        gear = "generated" | gear = "cast" | cutting.gear
        "ground" | "grinded" | pinion.finish
        "220 N m" | "220 Nm/s" | operation.torque"""),
    "gear": ("design", ("gear", "FILE"), """
        "300 N m" | "300 N" | operation.torque
        "90 degC" | "-300 degC" | operation.temperature
        "75w90" | "75w80" | operation.oil
        "ground" | "groud" | pinion.finish
        "steel" | "Stahl" | pinion.material
        "90 deg" | "90" | assembly.shaft_angle
        [pinion.blank] | [pinion.blanks] | pinion.blanks"""),
    "calibrate": ("setup", ("calibrate", ROOT / "docs/examples/synthetic_traction.csv", "--setup", "FILE"), """
        "fva3" | "fva33" | oil
        "9.525 mm" | "9.525 s" | conditions.radius_equivalent
        "point" | "ball" | specimens.geometry
        "fast" | "fastest" | model.accuracy
        [model] | [models] | models"""),
    "oil": ("oil", ("oil", "FILE"), """
        base = "mineral" | base = "minerale" | base
        viscosity_kinematic_40 = | viscosity_kinematic_40 = "-220 cSt" # | viscosity_kinematic_40
        viscosity_kinematic_100 = | viscosity_kinematic_100 = 3e-4 # | viscosity_kinematic_100
        viscosity_kinematic_100 = | viscosity_kinematic_100 = 3e-7 # | viscosity_kinematic_100
        density_15 = | density_15 = 0.88 # | density_15
        [viscosity] | [viscosities] | viscosities"""),
    "import": ("sheet", ("import", "FILE", "-o", "never.toml", "--like", PAIR), """
        units, mm | units, cm | line 2
        units, mm | unit, mm | mean cone distance
        member, pinion | member, pinon | line 4
        teeth, 14 | teeth, 0 | teeth
        hand, left | hand, right | hand
        face width, 25.4 | face width, -25.4 | face_width
        pitch angle, 19.7468 | pitch angle, 197.468 | pitch_angle
        mean addendum, 4.836 | mean addendum, nan | mean addendum
        process, generated | process, generating | process
        radial setting | raidal setting | radial_setting
        ratio of roll, 2.98436034987 | ratio of roll, 0 | roll_ratio
        modified roll 2c, 0.0055 | modified roll 2c, 1e9 # | modified"""),
}  # fmt: skip
IN_FILES = [(command, line.split(" | ")) for command, (*_, text) in FILES.items() for line in text.strip().splitlines()]


@cache
def right_file(kind: str) -> str:
    if kind == "setup":
        return (ROOT / "docs/examples/calibration.toml").read_text(encoding="utf-8")
    if kind == "sheet":
        with tempfile.TemporaryDirectory() as folder:
            efficiency.load(PAIR).export(folder, ("summary",))
            return re.sub(", +", ", ", (Path(folder) / "setting_sheet.csv").read_text(encoding="utf-8"))
    return efficiency.new_file(kind)


@pytest.mark.parametrize(("command", "change"), IN_FILES, ids=lambda part: part if isinstance(part, str) else part[1])
def test_mistake_in_a_file(mixed_ehl: Any, tmp_path: Path, command: str, change: list[str]) -> None:
    kind, arguments, _ = FILES[command]
    right, wrong, field = (part.strip() for part in change)
    text = right_file(kind)
    assert right in text
    file = tmp_path / "file.toml"
    lines = text.splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if right in line and not line.startswith("#"))
    lines[at] = lines[at].replace(right, wrong, 1)
    file.write_text("".join(lines), encoding="utf-8")
    refused(mixed_ehl(*(file if part == "FILE" else part for part in arguments)), field)


@pytest.mark.parametrize("like", [(), ("--like", PAIR)])
@pytest.mark.parametrize("name", ["contact.toml", "synthetic_traction.csv"])
def test_other_files_are_not_imported(mixed_ehl: Any, tmp_path: Path, name: str, like: tuple[str, ...]) -> None:
    outcome = mixed_ehl("import", ROOT / "docs/examples" / name, "-o", tmp_path / "design.toml", *like)
    refused(outcome, "summary")
    assert list(tmp_path.iterdir()) == []


TRACTION, SETUP_FILE = (str(ROOT / "docs/examples" / name) for name in ("synthetic_traction.csv", "calibration.toml"))
# right options of a command, and mistakes: option=value, and for an argument the field of the message
OPTIONS: dict[str, tuple[tuple[Any, ...], dict[str, str], str]] = {
    "mu": (("mu", "75w90"), POINT, """
        --pressure=1.2 MN; --radius=15; --speed=5 rpm; --slide-to-roll=20 m; --temperature=90; --roughness-rms=0.4 mm;
        --lengthwise=5 m; --finish=grinded; --oil=fva33; --correlation-length=5 km; --peklenik-number=0;
        --boundary-friction=2; --hull=none.h5"""),
    "gear": (("gear", PAIR), {}, """
        --torque=300; --torque=300 rpm; --torque=nan N m; --speed=1500; --speed=1500 N m; --temperature=90;
        --temperature=900 degC; --oil=75w-91; --side=drives; --driver=pinon; --load-balance=friction;
        --friction=constant:2; --friction=75w91; --units=si; --E=0.1; --report=x.txt; --torque=0 N m;
        --torque=10, 20 N m; --speed=0 rpm; --side=both; --rating --side=coast; --rating --E=0.1 mm;
        --spectrum=duty.csv; --uncertainty --load-from=load.csv"""),
    "geometry": (("geometry", PAIR), {}, """
        --E=0.1; --shaft-angle-error=1 mm; --side=left; --marking=0 um; --torque=100 N m; --units=cubits"""),
    "map": (("map", PAIR), {}, "--torque=1:2 N m; --speed=1,5 rpm"),
    "oil": (("oil",), {"--base": "pao", "--nu40": "97.5 cSt", "--nu100": "13.3 cSt"}, """
        --base=poa; --nu40=97 mPa s; --nu100=130 cSt; --density=0.88 kg/m^3; --plot=x.xls"""),
    "new contact": (("new", "contact"), {}, """
        --pressure=100 GPa; --radius=15 s; --speed=-1 m/s; --slide-to-roll=much; --roughness=1 mm; --oil=75W140;
        --temperature=90; --output=x.csv"""),
    "new others": (("new",), {}, """
        oil --base=minral; oil --vg=221; plan --size=many; plan --oil=75w91; design --like=fm_bevel;
        design --torque=300 mm; targets --offset=5; targets --process=milling; targets --teeth-pinion=0;
        targets --finish=groud; duty --torque=300; duty --speed=0 rpm"""),
    "compare": (("compare", PAIR), {}, "--friction=xu_kahraman_2006; --side=both; --report=x.pdf"),
    "loss-map": (("loss-map", PAIR), {"--torque": "100, 200 N m", "--speed": "500 rpm"}, """
        --torque=100; --speed=500 N m; --drag=2; --model=x.csv; --load-share=150 %; --axle-losses=none.csv;
        --xlsx=x.csv; --torque=-1:1 N m; --load-share=60 %"""),
    "axle": (("axle", "truck_hypoid"), {}, """
        --temperature=balanced; --bearings=skv; --seals=lip; --churning=iso; --duty=no.csv; --test=triple;
        --model=x.csv; --model=x.vtlm; --tyre-radius=0.3 m; --duty duty.csv --test=single;
        --test single --temperature=balance"""),
    "misalignment": (("misalignment", PAIR), {"--E": "0, 0.1 mm"}, """
        --E=0.1; --P=1 deg; --shaft-angle-error=1 mm; --side=up; --G=0.1; --marking=6; --E=0, 5 mm;
        --speed=1000 rpm; --samples=-1; --samples=2 --accuracy-grade=12"""),
    # of the sizing, which is not requested
    "settings": (("settings", "fh_hypoid_9x34"), {}, "--torque=100 N m; --coast-torque=100 N m; --E=0.1 mm"),
    "axle-test": (("axle-test", PAIR), {}, """
        --application=singel; --torque-max=2500; --torque-max=100 N m; --revolutions-per-mile=1"""),
    "export": (("export", PAIR), {"--output": "out"}, """
        --what=tooths; --member=pinon; --rows=2; --columns=1; --margin=0.6; --rim=6; --bore=-1 mm; --bore=10 m;
        --units=si"""),
    "export formula": (("export", "75w90"), {"--output": "mu.py"}, """
        --language=pyton; --rows=3; --units=inch; --oil=75w91; --output=my-friction.c; --oil=fva3; --what=grid;
        --member=pinion; --language=c"""),
    "export unknown": (("export", "gear_fva3"), {}, "--output=mu.c | formula"),
    "correct": (("correct", PAIR, "none.csv"), {}, "--order=3; --uncertainty=1"),
    "plan": (("plan", PAIR), {"--duty": "duty.csv", "--output": "p.toml"}, """
        --duty=none.csv; --output=p.json; --oil=75w91; --size=0; --size=-1; --coverage=a"""),
    "study": (("study", PAIR), {}, """
        --jobs=0; --torque=50; --roughness-each=0.2; --E=0.1; --shaft-angle-error=4 mm; --P=10 m;
        eaxle_helical_23x75 --jobs=1 | design"""),
    "optimise": (("optimise", "fm_hypoid_13x42"), {}, """
        --vary=crowning; --objective=loss; --objective=pressure; --limit=presure_max; --flanks=drives; --evaluations=1;
        --batch=0; --check=-1; --seed=-1; --duty=none.csv; --oil=none; --E=0.05; --over=median; --jobs=0;
        --vary=hypoid_ofset; --limit=noise; --tolerance=bias; --dask=nowhere.json; --dask=local:x;
        --check-friction=75w90"""),
    "fit": (("fit", "gear_fva3_noise"), {"--output": "f.json"}, """
        --family=shrot; --output=f.toml; --paths=none; --noise=none; --plot=x.xls; --report=x.pdf;
        --noise=gear_75w90_noise; --paths=gear_75w90_paths; --output=.; --report=f.json"""),
    "fit names": (("fit", "--output", "f.json"), {}, f"""
        {ROOT}/data/plans/demo.toml=--corners | run; {ROOT}/data/oils/75w90.toml=--corners | run;
        {ROOT}/data/designs/fm_hypoid_13x42.toml=--corners | run; {ROOT}/data/formulas/75w90.json=--corners | run;
        {ROOT}/docs/examples/synthetic_traction.csv=--corners | run; 75w90=--corners | run;
        gear_fva3_nois=--corners | run"""),
    "sweep": (("sweep", "demo"), {"--output": "r"}, """
        --jobs=0; --jobs=-3; --shard=0/4; --shard=5/4; --shard=²/8; --time-cap=600; --time-cap=1e300 s; --retries=-1;
        --retries=many; --with=xu_kahraman_2006; --set=lubricant.oil; --slurm=0; --slurm=many; --dask=local:0;
        --merge=all.h5; --slurm 2 --sbatch=array=1-9; --slurm 2 --sbatch=partition;
        --slurm 2 --sbatch=comment=two words; --slurm 2 --sbatch=Part=short"""),
    "calibrate": (("calibrate", TRACTION), {"--setup": SETUP_FILE}, """
        --setup=none.toml; --output=x.csv; --plot=x.xls; --report=x.txt; --jobs=0; --fit=eyring_stres; --oil=fva33;
        --seed=-1"""),
    "demo": (("demo",), {}, """
        --jobs=0; --jobs=many; --output=/proc/x; --output=/dev/null; -o=; --jobs --output=results; --ouput=results;
        -j=2; --oil=fva3; --design=fm_hypoid_13x42; fm_hypoid_13x42=fva3"""),
    "app": (("app",), {}, f"""
        --port=80; --port=many; {ROOT}/data/oils/75w90.toml=--no-browser | file; --host=0.0.0.0; --friction=75w90;
        {ROOT}/data/formulas/75w90.json=--no-browser | file; {ROOT}/docs/examples=--no-browser | file;
        {ROOT}/docs/examples/synthetic_traction.csv=--no-browser | file; {ROOT}/README.md=--no-browser | file;
        none.toml=--no-browser | file; fm_hypoid_13x43=--no-browser | design; --browser=firefox | design;
        {ROOT}/data/targets/fm_hypoid_13x42.toml=--no-browser | file;
        fm_spiral_bevel_14x39 fm_hypoid_13x42=fva3"""),
    "names": ((), {}, f"""
        gear=fm_spiral_bevel_14x40 | design; gear=75w90 | design; gear=fm_spiral_bevel_14x39.toml | design;
        gear=mine.toml | file; blank=iso23509_f9 | blank; settings=fh_hypoid_9x35 | targets; solve=contact.toml | file;
        solve={ROOT}/docs | file; sweep=demos | file; oil=fva | oil; frobnicate=x; compare=demo | design;
        new=targts | kind"""),
}  # fmt: skip
IN_OPTIONS = [
    (command, *mistake.strip().split("=", 1))
    for command, (_, _, mistakes) in OPTIONS.items()
    for mistake in mistakes.split(";")
]


@pytest.mark.parametrize(("command", "option", "mistake"), IN_OPTIONS)
def test_mistake_in_an_option(mixed_ehl, tmp_path, monkeypatch, command, option, mistake):
    monkeypatch.chdir(tmp_path)
    start, right, _ = OPTIONS[command]
    (*before, last), (value, _, field) = option.split(), mistake.partition(" | ")
    given = {name: text for name, text in right.items() if name != last} | {last: value}
    outcome = mixed_ehl(*start, *before, *(part for pair in given.items() for part in pair))
    refused(outcome, f"{field} =" if field else last)
    assert list(tmp_path.iterdir()) == []


# a file of each kind, and the command that reads it
KINDS = {
    "docs/examples/contact.toml": "solve", "data/oils/75w90.toml": "oil", "data/plans/demo.toml": "sweep",
    "data/blanks/iso23509_f4.toml": "blank", "data/targets/fm_hypoid_13x42.toml": "settings",
    "data/designs/fm_hypoid_13x42.toml": "gear", "docs/examples/calibration.toml": "", "data/formulas/75w90.json": "",
    "docs/examples/synthetic_traction.csv": "",
}  # fmt: skip


@pytest.mark.parametrize("command", [reader for reader in KINDS.values() if reader])
def test_file_of_another_kind_is_named(mixed_ehl: Any, command: str) -> None:
    for name, reader in KINDS.items():
        if reader != command and (command != "oil" or name.endswith(".toml")):
            file = ROOT / name
            refused(mixed_ehl(command, file, *(["--estimate"] if command == "sweep" else [])), "file =", file.name)


def test_all_problems_of_a_file_at_once(mixed_ehl: Any, tmp_path: Path) -> None:
    text = right_file("contact").replace("1.2 GPa", "120 GPa").replace("75w90", "75w91", 1).replace('"EP"', '"PE"')
    file = tmp_path / "contact.toml"
    file.write_text(text, encoding="utf-8")
    refused(mixed_ehl("solve", file), "contact.pressure_hertz", "lubricant.oil", "surface.additive")
