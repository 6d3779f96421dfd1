"""What lay, film ratio and the cut-off of a measured profile do to friction (docs/roughness.md).

    python validation/roughness_effects.py [smooth|lay|cutoff]

smooth: rough over smooth friction at film ratios from 0.5 to 3.5, by the limiting stress of the card and a higher one.
lay: marks along over marks across the motion. cutoff: self-affine profiles given as measured ones, at ever shorter
cut-offs. Film ratio: central film of the smooth contact over the composite Rq. Accuracy "standard".
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from common import OUT, command_line, one_of, write_rows

import ehl
from ehl.surface.roughness import generate_profile

Rows = list[dict[str, Any]]
BASE = ehl.Contact(
    oil="minr", temperature="80 degC", pressure_hertz="1 GPa", radius_equivalent="10 mm", speed_entrainment="2 m/s",
    slide_to_roll=0.5,
)  # fmt: skip
HIGH_LIMIT = 0.1  # limiting shear coefficient above all measured ones
SHORTEST = 8e-6  # least correlation length [m]
MEDIAN = ehl.Contact(
    oil="75w90", temperature="90 degC", pressure_hertz="1.1 GPa", radius_equivalent="18.5 mm",
    speed_entrainment="1.79 m/s", slide_to_roll=0.44,
)  # fmt: skip


def rough(
    contact: ehl.Contact, film_ratio: float, film: float, seeds: Sequence[int] = (1, 2), **more: Any
) -> tuple[float, ...]:
    """Mean friction and asperity load share of two profiles; Rq from the film ratio, lc 40 Rq of one surface."""
    rq = film / film_ratio
    given = {"correlation_length": max(40.0 * rq / 2.0**0.5, SHORTEST)} | more
    found = [contact.replace(roughness_rms=rq, seed=seed, **given).solve() for seed in seeds]
    means = ("friction_coefficient", "asperity_load_share")
    return tuple(float(np.mean([getattr(result, name) for result in found])) for name in means)


def over_smooth(
    oils: Sequence[str] = ("minr", "paor", "pagd"), limits: Sequence[float | None] = (None, HIGH_LIMIT)
) -> Rows:
    """Rough over smooth friction, isotropic roughness; a limit of None is that of the card."""
    rows = []
    for oil, limit in product(oils, limits):
        contact = BASE.replace(oil=oil, **({} if limit is None else {"limiting_shear_coefficient": limit}))
        smooth = contact.solve()
        for film_ratio in (0.5, 1.0, 2.0, 3.5):
            mu, share = rough(contact, film_ratio, smooth.film_central)
            ratio, name = mu / smooth.friction_coefficient, limit or "of the card"
            rows.append({"oil": oil, "limit": name, "film_ratio": film_ratio, "over_smooth": ratio, "share": share})
    return rows


def lay(oils: Sequence[str] = ("fva3", "75w90")) -> Rows:
    """Friction with marks along the motion (gamma 0.35) over that with marks across it (gamma 5)."""
    rows = []
    for oil, (film_ratio, speed) in product(oils, ((0.5, 1.0), (1.3, 4.0), (3.1, 12.0))):
        contact = BASE.replace(oil=oil, radius_equivalent=15e-3, slide_to_roll=0.2, speed_entrainment=speed)
        film = contact.solve().film_central
        across = max(40.0 * film / film_ratio / 2.0**0.5, SHORTEST)
        lengths = {0.35: across / 0.35, 5.0: across}  # along the motion
        along, transverse = (
            rough(contact, film_ratio, film, peklenik_number=gamma, correlation_length=length)[0]
            for gamma, length in lengths.items()
        )
        rows.append({"oil": oil, "film_ratio": film_ratio, "along": along, "across": transverse})
    return rows


def cutoff(gammas: Sequence[float] = (1.0, 2.0, 5.0), pairs: int = 3) -> Rows:
    """mu of profiles (H 0.85, lc 16 um, Rq 0.3 um, waves down to 2.5 um) by the cut-off of their evaluation."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(2 * pairs):
            profile = generate_profile(0.3e-6, 16e-6, 8e-3, 0.5e-6, 100 + number, cutoff=2.5e-6, hurst=0.85)
            points = np.column_stack([profile.x, profile.heights]) * 1e6
            np.savetxt(Path(folder) / f"{number}.csv", points, "%.6f", ", ", header="x [um], height [um]", comments="")
        for gamma, cut in product(gammas, (20.0, 10.0, 5.0, 3.0)):
            found = []
            for number in range(0, 2 * pairs, 2):
                files = {f"profile_{k + 1}": str(Path(folder) / f"{number + k}.csv") for k in range(2)}
                contact = MEDIAN.replace(peklenik_number=gamma, cutoff_short=1e-6 * cut, **files)
                found.append(contact.solve().friction_coefficient)
            rows.append({"peklenik_number": gamma, "cutoff_um": cut, "mu": float(np.mean(found))})
    return rows


PARTS = {"smooth": over_smooth, "lay": lay, "cutoff": cutoff}


def main(argv: Sequence[str] | None = None) -> None:
    """Run the selected parts."""
    parser = command_line(__doc__)
    parser.add_argument("parts", nargs="*", type=one_of(PARTS))
    for part in parser.parse_args(argv).parts or PARTS:
        rows = PARTS[part]()
        write_rows(OUT / f"roughness_{part}.csv", rows)
        print(pd.DataFrame(rows).to_string(index=False, float_format="%.3g"))


if __name__ == "__main__":
    main()
