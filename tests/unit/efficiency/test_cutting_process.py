"""The recipe "adding a cutting process" on a toy: an object and how the gear is cut are all it takes."""

import json
import subprocess
import sys
from pathlib import Path

TOY = """
import json, sys
from typing import Literal
from efficiency.cutting import process

class ToyCutter(process.FaceMillingCutter):
    type: Literal["toy"]

class Toy(process.FaceMilling):
    name = "toy"
    cutter = ToyCutter

process.PROCESSES["toy"] = Toy()

from efficiency.machine_settings import gear
gear.GEAR_CUTS["toy"] = gear.GEAR_CUTS["face_milling"]

import efficiency
from efficiency.cutting.summary import parse_summary

path = sys.argv[1]
text = efficiency.new_file("targets", process="toy", offset="0 mm", teeth_pinion=14, teeth_gear=39)
open(path, "w", encoding="utf-8").write(text)
result = efficiency.settings(path, transmission=False)
sheet = parse_summary("units, mm\\nmember, gear\\ncutter type, toy\\npoint radius, 76")
print(json.dumps({
    "status": result.status,
    "cutter": [result.design.pinion.concave.cutter.type, result.design.gear.convex.cutter.type],
    "flank": type(result.design.flank("gear", "concave")).__name__,
    "process": result.design.gear.concave.machine.process,
    "sheet": sheet.tables["gear"]["cutter"]["type"],
}))
"""


def test_a_toy_process_reaches_blank_settings_design_and_sheet(tmp_path: Path) -> None:
    # in a program of its own: the tables of input files are made from the registry at import
    run = [sys.executable, "-c", TOY, str(tmp_path / "toy.toml")]
    found = json.loads(subprocess.run(run, capture_output=True, text=True, check=True).stdout)
    assert found == {
        "status": "converged",
        "cutter": ["toy", "toy"],
        "flank": "CutFlank",
        "process": "generated",
        "sheet": "toy",
    }
