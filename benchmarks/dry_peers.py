"""The dry rough line contact of `work_precision.py`, solved by other programs where they are installed.

    python benchmarks/work_precision.py --parts dry --out FOLDER     writes the case
    OTHER/bin/python benchmarks/dry_peers.py tamaas --out FOLDER     in an environment that has tamaas, or slippy
    python benchmarks/work_precision.py --parts dry --out FOLDER     compares

tamaas: periodic line, conjugate gradients of Polonsky and Keer. slippy has no line elements, and its coefficients hold
for squares only: rows of squares 64 b long, summed; its bound-constrained conjugate gradients for a given approach, and
the approach that carries the load by Brent's method; the middle 16 b, outside of which nothing touches.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from common import OUT, command_line
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]

MIDDLE, ROW = 1024, 4096  # nodes of slippy's case, squares of a row


def by_tamaas(case: dict[str, Array]) -> tuple[Array, float]:
    """Pressure [Pa] and seconds."""
    tamaas = importlib.import_module("tamaas")
    x = case["x"]
    length = float(x[1] - x[0]) * x.size
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_1d, [length], [x.size])
    model.E, model.nu = float(case["modulus"]), 0.0
    solver = tamaas.PolonskyKeerRey(model, -case["shape_periodic"], 1e-12)
    begin = time.process_time()
    solver.solve(float(case["mean_pressure"]))
    return np.asarray(model.traction, dtype=float).ravel(), time.process_time() - begin


def by_slippy(case: dict[str, Array]) -> tuple[Array, float]:
    """Pressure [Pa] and seconds."""
    contact = importlib.import_module("slippy.contact")
    everything = case["x"].size
    inside = slice((everything - MIDDLE) // 2, (everything + MIDDLE) // 2)
    dx, shape = float(case["x"][1] - case["x"][0]), case["shape"][inside]
    mean = float(case["mean_pressure"]) * everything / MIDDLE
    # shear modulus of a body with E = modulus and nu = 0, over a rigid one
    squares = contact.elastic_influence_matrix("zz", (ROW, 2 * MIDDLE), (dx, dx), 0.5 * float(case["modulus"]), 0.0)
    response = squares.sum(axis=0, keepdims=True)
    begin = time.process_time()
    product = contact.plan_convolve(np.zeros((1, MIDDLE)), response, domain=np.ones((1, MIDDLE), dtype=bool))
    found = np.full(MIDDLE, mean)

    def carried(approach: float) -> float:
        nonlocal found
        found, _ = contact.bccg(product, approach - shape, 1e-12, 4000, found)
        return float(found.mean()) / mean - 1.0

    lift = float(np.asarray(product(found)).max())
    brentq(carried, 0.5 * lift, 2.0 * lift, rtol=1e-12)
    pressure = np.zeros(everything)
    pressure[inside] = found
    return pressure, time.process_time() - begin


PEERS = {"tamaas": by_tamaas, "slippy": by_slippy}


def main(argv: Sequence[str] | None = None) -> None:
    """Solve the case with one peer."""
    parser = command_line(__doc__)
    parser.add_argument("peer", choices=PEERS)
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args(argv)
    with np.load(options.out / "dry_case.npz") as case:
        pressure, seconds = PEERS[options.peer](dict(case))
    version = getattr(importlib.import_module(options.peer), "__version__", "")
    np.savez(options.out / f"dry_{options.peer}.npz", pressure=pressure, seconds=seconds)
    print(f"{options.peer} {version}: largest pressure {pressure.max() / 1e9:.4g} GPa, {seconds:.3g} s")


if __name__ == "__main__":
    main()
