"""Fit, calibration, study and optimisation killed with SIGKILL: outputs whole or as before, finished work kept."""

import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import regression
from ehl.fluid.oil import Oil

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"
# kills itself when the output gets its name, or at the second row of a journal; prints how many points were kept
CHILD = """
import os, signal, sys
from pathlib import Path
import regression
from ehl.common.journal import Journal

what, out, examples, killed = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]), sys.argv[4] == "killed"
replace, append, rows = os.replace, Journal.append, []

def replace_killed(draft, target):
    if Path(target).name == out.name:
        os.kill(os.getpid(), signal.SIGKILL)
    replace(draft, target)

def append_killed(journal, found):
    append(journal, found)
    rows.extend(found)
    if len(rows) >= 2:
        os.kill(os.getpid(), signal.SIGKILL)

if killed:
    os.replace, Journal.append = replace_killed, append_killed
reused = 0
if what == "fit":
    regression.fit("gear_fva3", "power_law").save(out)
elif what == "calibrate":
    found = regression.calibrate(
        examples / "synthetic_traction.csv", examples / "calibration.toml", parameters=["eyring_stress"],
        profile=False, jobs=1,
    )
    found.save_card(out, force=True)
elif what == "study":
    from efficiency.design.design import load_design
    from efficiency.studies.parameter_study import Levels, run_study

    levels = Levels((100.0, 250.0), (100.0,), (333.15,), (4e-7,), (5e-5,), (), (), ())
    reused = run_study([load_design("fm_spiral_bevel_14x39")], "constant:0.05", levels, store=out, grid=(4, 7)).reused
else:
    from efficiency.optimisation import check
    from efficiency.optimisation import optimise as search

    search.SEARCH_GRID, check.CHECK_GRID, search._FIRST = (4, 7), (4, 7), 2
    reused = search.optimise(
        "fh_spiral_bevel_12x37", {"lengthwise_crowning": "30:90 um"}, objectives=["power_loss"], misalignment={},
        friction="constant:0.05", evaluations=4, jobs=1, batch=1, check=0, store=out,
    ).reused
print(reused)
"""


@pytest.mark.parametrize("what", ["fit", "calibrate", "study", "optimise"])
def test_a_killed_command_leaves_whole_files_and_is_repeated(what: str, tmp_path: Path) -> None:
    out = tmp_path / {"fit": "formula.json", "calibrate": "card.toml"}.get(what, "points.jsonl")
    journal = what in ("study", "optimise")
    if not journal:
        out.write_text("before")
    shutil.copy(EXAMPLES / "calibration.toml", tmp_path)
    # a third of the rows
    rows = (EXAMPLES / "synthetic_traction.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "synthetic_traction.csv").write_text("".join(rows[:9]), encoding="utf-8")
    command = [sys.executable, "-c", CHILD, what, str(out), str(tmp_path)]
    assert subprocess.run([*command, "killed"], capture_output=True).returncode == -signal.SIGKILL
    if not journal:
        assert out.read_text() == "before"
    again = subprocess.run([*command, "again"], capture_output=True, text=True, check=True)
    if what == "fit":
        assert regression.friction_model(str(out)).name
    elif what == "calibrate":
        assert Oil.load(str(out)).at(353.15).viscosity_inlet > 0.0
    else:
        assert int(again.stdout.split()[-1]) >= 1
