"""Large runs: processor time and memory of merging, reading, asking the status of, and fitting so many rows.

    python benchmarks/sweep_scale.py [--rows 1000000] [--shards 16] [--family NAME] [--only STEP ...]

The rows are those of a shipped dataset again and again, each at conditions of its own (0.1 % apart), with 3 % of noise
on friction. Every step runs in a process of its own. Writes sweep_scale.csv.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from common import command_line

from regression.data.dataset import results_path
from regression.data.row_format import ROW, pack
from regression.data.store import ResultStore, read_run

BLOCK = 20_000
VARIED = ("pressure_hertz", "speed_entrainment", "slide_to_roll", "radius_equivalent")
STEPS = {
    "read": "from regression import load_dataset; load_dataset({run!r})",
    "status": "from regression import Run; Run({run!r}).status",
    "merge": "from regression import Run; Run({run!r}).merge({target!r})",
    "fit": "import regression; regression.fit({run!r}, family={family!r})",
}
MEASURED = """
import json, resource, time
clock = time.process_time()
{work}
print(json.dumps([time.process_time() - clock, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0]))
"""


def write_run(folder: Path, rows: int, shards: int) -> None:
    """A run of so many rows in shards."""
    meta, frame = read_run(results_path("gear_75w90"))
    shipped = pack([{str(name): value for name, value in row.items()} for row in frame.to_dict("records")])
    shared = {name: value for name, value in meta.items() if name not in ("schema", "writer")} | {"count": rows}
    rng = np.random.default_rng(1)
    folder.mkdir()
    for shard in range(shards):
        count = rows // shards + (shard < rows % shards)
        with ResultStore(folder / f"shard-{shard + 1:04d}-of-{shards:04d}.h5", shared) as store:
            for start in range(0, count, BLOCK):
                packed = np.asarray(shipped[rng.integers(0, len(shipped), min(BLOCK, count - start))], ROW)
                for name in VARIED:
                    packed[name] *= rng.normal(1.0, 1e-3, len(packed))
                packed["friction_coefficient"] *= rng.normal(1.0, 0.03, len(packed))
                packed["seed"] = rng.integers(1, 2**31, len(packed))
                packed["key"] = [rng.bytes(32).hex().encode() for _ in range(len(packed))]
                store.append_packed(packed)


def main(argv: Sequence[str] | None = None) -> None:
    """Write the run and take the steps."""
    parser = command_line(__doc__)
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--shards", type=int, default=16)
    parser.add_argument("--family", default="short", help="what is fitted")
    parser.add_argument("--only", nargs="+", choices=sorted(STEPS), default=list(STEPS))
    parser.add_argument("--csv", type=Path, default=Path("sweep_scale.csv"))
    options = parser.parse_args(argv)
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "run"
        write_run(run, options.rows, options.shards)
        size = sum(path.stat().st_size for path in run.iterdir()) / 1e6
        print(f"{options.rows} rows in {options.shards} files, {size:.0f} MB", flush=True)
        found = []
        for step in options.only:
            work = STEPS[step].format(run=str(run), target=str(Path(folder) / "all.h5"), family=options.family)
            command = [sys.executable, "-c", MEASURED.format(work=work)]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                print(f"{step}: {done.stderr[-2000:]}")
                continue
            seconds, memory = json.loads(done.stdout.splitlines()[-1])
            print(f"{step}: {seconds:.1f} s of processor time, at most {memory:.0f} MB", flush=True)
            found.append((step, options.rows, options.shards, f"{seconds:.4g}", f"{memory:.4g}"))
    with options.csv.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["step", "rows", "shards", "CPU [s]", "memory [MB]"])
        writer.writerows(found)


if __name__ == "__main__":
    main()
