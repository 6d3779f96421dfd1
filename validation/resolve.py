"""Datasets of a new engine: rows whose film hardly changes keep their values under the new key, the others are solved.

    python resolve.py prepare THRESHOLD   # journals of the kept rows
    python resolve.py solve JOBS          # sweeps; resumes
    python resolve.py merge               # datasets: solved rows, and old ones where a row is still missing
"""
import sys, os, json
from pathlib import Path
import numpy as np
sys.path.insert(0, "validation")
import shipped_formulas as s
import regression
from ehl.common.version import SOLVER
from ehl.common.journal import Journal
from regression.data import result_files as rf
from regression.sweeping import evaluators
from regression.sweeping.sweep import run_meta, SAME_RUN
from regression.data.dataset import load_dataset

OLD = SOLVER.replace("engine 10", "engine 9")
assert OLD != SOLVER
RUNS = Path("validation/out/engine10")

def plans():
    for oil in s.OILS:
        for kind in s.KINDS:
            seed = f"sampling.seed={100 * s.OILS.index(oil) + s.KINDS.index(kind) + 1}"
            changes = [f"lubricant.oil={oil}", seed]
            if kind == "_uncertain":
                changes.append(f"table.file=gear{kind}_{oil}.csv")
            if kind in s.PROFILES:
                changes.append(f"sampling.realisations={s.PROFILES[kind]}")
            yield oil, kind, regression.Plan.from_file(f"gear{kind}", changes)

def change(f):
    L = f.temperature_viscosity.abs() * f.viscosity_inlet * f.speed_entrainment**2 / f.thermal_conductivity
    est = 0.075 * L**0.8 * (1 + 0.8 * f.slide_to_roll_total.abs())
    return np.where(f.asperity_load_share > 0.9, 0.3 * est, est)

def prepare(threshold):
    total = todo = 0
    for oil, kind, plan in plans():
        name = f"gear_{oil}{kind}"
        meta, rows = rf.read_file(s.DATA / "datasets" / f"{name}.h5")
        frame = load_dataset(s.DATA / "datasets" / f"{name}.h5").frame
        est = dict(zip(frame["key"], change(frame)))
        table = {r["key"].decode(): r for r in rows}
        kept, missing = [], 0
        for i in range(len(plan.points)):
            case = plan.case_at(i)
            old, new = (evaluators.case_key(case, v) for v in (OLD, SOLVER))
            row = table.get(old)
            if row is None:
                missing += 1; continue
            if est.get(old, 1.0) < threshold or row["status"] == b"failed" and False:
                entry = {n: (row[n].decode() if isinstance(row[n], bytes) else row[n].item()) for n in rows.dtype.names if n != "checksum"}
                entry["key"] = new
                kept.append({n: v for n, v in entry.items() if v == v and v != ""})
        folder = RUNS / name
        folder.mkdir(parents=True, exist_ok=True)
        with Journal(folder / "shard-0001-of-0001.jsonl", run_meta(plan, SOLVER), SAME_RUN) as journal:
            journal.append([k for k in kept if k["key"] not in journal.rows])
        n = len({evaluators.case_key(plan.case_at(i), SOLVER) for i in range(len(plan.points))})
        print(name, n, "kept", len(kept), "missing", missing, flush=True)
        total += n; todo += n - len(kept)
    print(total, "to solve", todo)

def solve(jobs):
    for oil, kind, plan in plans():
        run = regression.sweep(plan, RUNS / f"gear_{oil}{kind}", jobs=jobs)
        print(repr(run), flush=True)

if __name__ == "__main__":
    what = sys.argv[1]
    if what == "prepare": prepare(float(sys.argv[2]))
    if what == "solve": solve(int(sys.argv[2]))
