"""Mutated files of every kind, read as the program reads them: no traceback, no hang, no impossible answer.

    python -m validation parse_campaign --count 2000 --out parsed.jsonl

Some thousand mutations of each kind of file (`tests/mutated_files.py`), in chunks; the same command resumes. A file of
quantities has about 60 texts, each of which counts as one input.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from common import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from mutated_files import Kind, kinds, run

CHUNK = 500


def inputs_of(name: str, kind: Kind) -> int:
    """Inputs of one file."""
    return sum(seed.count(b"\t") for seed in kind.seeds) // len(kind.seeds) if name == "quantities" else 1


def report(rows: Sequence[dict[str, Any]]) -> str:
    """Inputs and outcomes by kind, and each fault."""
    lines, total = [], 0
    for name in dict.fromkeys(row["kind"] for row in rows):
        own = [row for row in rows if row["kind"] == name]
        counts = sum((Counter(row["counts"]) for row in own), Counter[str]())
        total += (inputs := sum(row["inputs"] for row in own))
        lines.append(f"{name}: {inputs} inputs, files: {dict(counts)}")
    faults = [f"{row['kind']}: {fault}" for row in rows for fault in row["faults"]]
    return "\n".join([*lines, f"{total} inputs", *faults])


def main(argv: Sequence[str] | None = None) -> None:
    """Run the campaign from the command line."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=2000, help="files of each kind")
    parser.add_argument("--kind", action="append", help="only this kind; may be repeated")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, help="a line of JSON for each chunk; the same command resumes")
    options = parser.parse_args(argv)
    rows: list[dict[str, Any]] = []
    if options.out is not None and options.out.exists():
        rows = [json.loads(line) for line in options.out.read_text(encoding="utf-8").splitlines()]
    done = {(row["kind"], row["first"]) for row in rows}
    with tempfile.TemporaryDirectory() as name, np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        folder = Path(name)
        found = kinds(folder)
        for first in range(0, options.count, CHUNK):
            for of in options.kind or found:
                if (of, first) in done:
                    continue
                kind, clock = found[of], time.process_time()
                count = min(CHUNK, options.count - first)
                tally = run(kind, count, folder / f"input{kind.suffix}", f"{options.seed} {of} {first}")
                row = {"kind": of, "first": first, "inputs": count * inputs_of(of, kind)}
                seconds = round(time.process_time() - clock, 1)
                rows.append(row | {"counts": tally.counts, "faults": list(tally.faults), "seconds": seconds})
                if options.out is not None:
                    with options.out.open("a", encoding="utf-8") as file:
                        file.write(json.dumps(rows[-1]) + "\n")
    print(report(rows))


if __name__ == "__main__":
    main()
