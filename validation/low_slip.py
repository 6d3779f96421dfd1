"""Friction at small slip: the elastic part of the shear at 1 GPa, and a public traction curve at 3.5 GPa.

    python validation/low_slip.py [OUT]

The measured curve is that of a ball on a disc with an oil that is not named: its shape is compared, nothing is tuned.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from common import OUT, command_line

import ehl

SLIPS = np.geomspace(1e-3, 0.2, 13)
GEAR = {"temperature_oil": "80 degC", "pressure_hertz": "1 GPa", "radius_equivalent": "15 mm"}
# 3.5 GPa, 0.025 m/s, 40 degC: mu over SR as read in public traction files
MEASURED = {0.010: 0.017, 0.020: 0.040, 0.031: 0.049, 0.041: 0.052, 0.052: 0.053, 0.10: 0.054, 0.20: 0.055}
DISC = {
    "temperature_oil": "40 degC",
    "pressure_hertz": "3.5 GPa",
    "radius_equivalent": "10 mm",
    "speed_entrainment": "0.025 m/s",
}


def curve(slips: np.ndarray, **keys: object) -> np.ndarray:
    """mu over the slide-to-roll ratio."""
    contacts = (ehl.Contact(**keys, slide_to_roll=float(slip)) for slip in slips)
    return np.array([contact.solve().friction_coefficient for contact in contacts])


def main(argv: Sequence[str] | None = None) -> None:
    """Print both comparisons and draw them."""
    parser = command_line(__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=OUT)
    folder = parser.parse_args(argv).folder
    folder.mkdir(parents=True, exist_ok=True)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.2), layout="constrained")
    for colour, oil in (("tab:blue", "fva3"), ("tab:red", "75w90")):
        for modulus, style, name in ((None, "-", "G 0.3 GPa"), (3e6, "--", "G 3 MPa")):
            keys = {} if modulus is None else {"shear_modulus": modulus}
            mu = curve(SLIPS, oil=oil, speed_entrainment="5 m/s", **GEAR, **keys)
            left.plot(100.0 * SLIPS, mu, style, color=colour, label=f"{oil}, {name}")
            at = np.interp(np.log([1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.2]), np.log(SLIPS), mu)
            print(oil, name, "mu at 0.1 .2 .5 1 2 5 20 %:", np.round(at, 4), "1 % over 20 %:", round(at[3] / at[-1], 2))
    slips = np.array(list(MEASURED))
    measured = np.array(list(MEASURED.values()))
    right.plot(100.0 * slips, measured / measured[-1], "ko", label="measured, ball on disc, 3.5 GPa")
    for colour, oil in (("tab:blue", "fva3"), ("tab:red", "75w90")):
        for modulus, style in ((None, "-"), (0.2e6, "--")):
            keys = {} if modulus is None else {"shear_modulus": modulus}
            mu = curve(slips, oil=oil, **DISC, **keys)
            name = f"{oil}, G {(modulus or 0.3e9) / 1e6:.3g} MPa"
            right.plot(100.0 * slips, mu / mu[-1], style, color=colour, label=name)
            print(name, "mu:", np.round(mu, 4), "1 % over 20 %:", round(mu[0] / mu[-1], 2))
    left.set(xscale="log", xlabel="slide-to-roll ratio (%)", ylabel="friction coefficient (-)")
    left.set_title("1 GPa, 5 m/s, 80 °C, R 15 mm")
    right.set(xscale="log", xlabel="slide-to-roll ratio (%)", ylabel="friction coefficient over that at 20 % (-)")
    right.set_title("3.5 GPa, 0.025 m/s, 40 °C, line of R 10 mm", fontsize=10)
    for axes in (left, right):
        axes.set_ylim(bottom=0.0)
        axes.legend(fontsize=7)
        axes.grid(alpha=0.3)
    figure.savefig(folder / "low_slip.png", dpi=130)


if __name__ == "__main__":
    main()
