"""Writes the fitted sums of exponentials of the elastic kernel, `ehl/rough/log_kernel.json`.

    python validation/log_kernel_table.py

The fit takes 0.2 to 0.4 s and is repeatable only to 1e-5 of a weight between processes. Rough histories near boundary
lubrication are chaotic and would differ by 1e-3 of mu, so that the program reads the fits it was tested with.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from common import command_line

import ehl.rough.exponential_sums
from ehl.rough._kernels.quasi_separable import MODES
from ehl.rough.accuracy import NODES_MAX
from ehl.rough.exponential_sums import fit_log_kernel, range_of
from ehl.rough.scaling import ELASTIC_MODES

OUT = Path(ehl.rough.exponential_sums.__file__).with_name("log_kernel.json")


def main(argv: Sequence[str] | None = None) -> None:
    """Fit every range a mesh may have, by modes."""
    command_line(__doc__).parse_args(argv)
    sizes = [64 << k for k in range(range_of(2 * NODES_MAX).bit_length() - 6)]
    table = {}
    for modes in (MODES, ELASTIC_MODES):
        for n in sizes:
            fit = fit_log_kernel(n, modes)
            table[f"{n} {modes}"] = {"weights": fit.weights.tolist(), "ratios": fit.ratios.tolist(), "error": fit.error}
            print(f"{n:6d} nodes, {modes:2d} modes: error {fit.error:.2g}")
    OUT.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
