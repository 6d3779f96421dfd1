"""What roughness does to friction, and how much of it is our assumption: waves, boundary film, spectrum, lay, finish.

    python validation/finish_sensitivity.py [waves|film|cutoff|lay|finishes|gears]

One contact of a truck hypoid pair (1.1 GPa, R 15 mm, 3 m/s, SR 0.3 across and 1.0 along the line, 80 degC, 75W90), both
surfaces equal, accuracy fast; `gears` is the loss of two shipped hypoids over the Rq of their flanks, and by published
formulas. Tables in docs/roughness.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from common import command_line, one_of

import efficiency
import ehl
from ehl.rough import RoughSurfaces, solve_transient
from ehl.surface.roughness import SelfAffine, generate_profile

RMS = (0.15e-6, 0.3e-6, 0.6e-6)
BASE = ehl.Contact(
    oil="75w90", temperature="80 degC", pressure_hertz="1.1 GPa", radius_equivalent="15 mm", speed_entrainment="3 m/s",
    slide_to_roll=0.3, speed_sliding_lengthwise="3 m/s", accuracy="fast",
)  # fmt: skip
GEARS = ("fh_hypoid_9x34", "fm_hypoid_13x42")
PUBLISHED = ("75w90", "xu_kahraman_2007", "schlenk_1994", "arana_2019", "benedict_kelley_1961")


def old_film(rms: float) -> float:
    """The boundary film of version 0.1: 2 nm and an eighth of the composite Rq, 5 to 100 nm."""
    return min(max(2e-9 + 0.125 * 2.0**0.5 * rms, 5e-9), 1e-7)


def row(name: str, **changes: object) -> None:
    """mu of the three Rq; a change may depend on Rq."""
    cells = []
    for rms in RMS:
        given = {key: value(rms) if callable(value) else value for key, value in changes.items()}
        result = BASE.replace(roughness_rms_1=rms, roughness_rms_2=rms, **given).solve()
        cells.append(f"{result.friction_coefficient:.4f} ({100.0 * result.friction_error:.0f} %)")
    print(f"{name:44s}" + "".join(f"{cell:>16s}" for cell in cells), flush=True)


def waves() -> None:
    """Correlation length over Rq."""
    row("standing defaults")
    row("lc 30 um, film of 0.1", correlation_length=30e-6, boundary_film=old_film)
    row("lc 30 um", correlation_length=30e-6)
    row("lc 50 Rq", correlation_length=lambda rms: 50.0 * rms)
    row("lc 200 Rq", correlation_length=lambda rms: 200.0 * rms)
    row("lc 30 um (Rq/0.3 um)^0.5", correlation_length=lambda rms: 30e-6 * (rms / 0.3e-6) ** 0.5)
    row("self-affine, lc 100 Rq", spectrum="self_affine")
    row("self-affine, lc 30 um", spectrum="self_affine", correlation_length=30e-6)


def film() -> None:
    """Boundary film, for one correlation length and for a self-affine profile."""
    for thickness in (10e-9, 30e-9, 60e-9, 150e-9):
        row(f"film {1e9 * thickness:.0f} nm", boundary_film=thickness)
    for additive in ehl.shipped("additives"):
        row(f"self-affine, additive {additive}", spectrum="self_affine", additive=additive)


def cutoff() -> None:
    """Self-affine profiles cut off at ever shorter waves, boundary film 30 nm: what more waves change."""
    problem = BASE.problem()
    length = max(32.0 * problem.line.half_width, 60.0 * 60e-6)
    for hurst in (0.8, 0.5):
        for shortest in (20e-6, 10e-6, 5e-6):
            cells = []
            for rms in RMS:
                spectrum = SelfAffine(100.0 * rms, hurst)
                unseen = spectrum.share_below(2.5e-6)
                kept = rms * ((1.0 - spectrum.share_below(shortest)) / (1.0 - unseen)) ** 0.5
                surfaces = RoughSurfaces(
                    *(
                        generate_profile(kept, 100.0 * rms, length, shortest / 4.0, seed, cutoff=shortest, hurst=hurst)
                        for seed in (3, 4)
                    )
                )
                result = solve_transient(
                    problem.line,
                    problem.lubricant,
                    surfaces,
                    accuracy="fast",
                    boundary_film=30e-9,
                    peklenik_number=1.0,
                    thermal=True,
                    materials=problem.bodies,
                    boundary_study=False,
                )
                cells.append(f"{result.friction_coefficient:.4f} ({result.nodes})")
            print(f"H {hurst:g}, cut off at {1e6 * shortest:2.0f} um" + "".join(f"{c:>16s}" for c in cells), flush=True)


def lay() -> None:
    """Peklenik number."""
    for gamma in (1.0 / 3.0, 1.0, 2.0, 3.0, 9.0):
        row(f"gamma {gamma:.2g}", peklenik_number=gamma)


def finishes() -> None:
    """Every finish and state at its own Rq, marks across the motion and at 24 deg to the contact line."""
    for name in ehl.shipped("finishes"):
        for state in ("new", "run_in"):
            cells = []
            for angle in ("0 deg", "24 deg"):
                contact = BASE.replace(finish=name, finish_state=state, lay_angle=angle)
                result, surface = contact.solve(), contact.surface
                cells.append(
                    f"gamma {surface.peklenik_number:.1f}: {result.friction_coefficient:.4f} "
                    f"({100.0 * result.friction_error:.0f} %)"
                )
            print(
                f"{name:14s} {state:7s} Rq {1e6 * surface.roughness_rms_1:.2f} um, lambda {result.film_ratio:.2f}  "
                + "   ".join(cells),
                flush=True,
            )


def gears() -> None:
    """Loss over the Rq of the flanks, waves growing with it: fitted formula and published ones."""
    for name in GEARS:
        mesh = efficiency.load(name).mesh()
        loaded = mesh.load()
        print(f"{name}: loss [W] at Rq 0.15, 0.3, 0.6 um of each flank")
        for friction in PUBLISHED:
            cells, losses = [], []
            for rms in RMS:
                result = loaded.efficiency(friction, roughness_rms_each=rms)
                lower, upper = (result.power_input * (1.0 - eta) for eta in (
                    result.efficiency_upper, result.efficiency_lower))  # fmt: skip
                losses.append(result.power_loss)
                cells.append(f"{result.power_loss:.1f} ({lower:.1f} to {upper:.1f})")
            growth = [after / before for before, after in pairwise(losses)]
            print(f"  {friction:22s}" + "".join(f"{c:>26s}" for c in cells), *(f"x{g:.2f}" for g in growth), flush=True)


PARTS = {part.__name__: part for part in (waves, film, cutoff, lay, finishes, gears)}


def main(argv: Sequence[str] | None = None) -> None:
    """Run the selected parts."""
    parser = command_line(__doc__)
    parser.add_argument("parts", nargs="*", type=one_of(PARTS))
    for part in parser.parse_args(argv).parts or PARTS:
        print(f"== {part}")
        PARTS[part]()


if __name__ == "__main__":
    main()
