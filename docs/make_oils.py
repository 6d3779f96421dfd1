"""Write docs/oil_cards: a page for every shipped oil, its laws drawn with the points of its source and its range.

python docs/make_oils.py
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

import ehl
from ehl.common.data import data_path
from ehl.fluid.oil_family import OIL_FAMILIES
from ehl.fluid.oil_sheet import PRESSURES, TEMPERATURES, plot_oil

FOLDER = Path(__file__).parent / "oil_cards"
CELSIUS = np.linspace(20.0, 150.0, 66)
COLOURS = ("#1f5a99", "#c8651b")
NAMES = {
    "viscosity_kinematic": ("nu [cSt]", 1e6), "viscosity_inlet": ("eta [mPa s]", 1e3), "density": ("rho [kg/m3]", 1.0),
    "pressure_viscosity_slope": ("alpha, slope [1/GPa]", 1e9), "pressure_viscosity_secant_200": ("secant [1/GPa]", 1e9),
    "pressure_viscosity_star": ("alpha* [1/GPa]", 1e9), "pressure_viscosity_film": ("alpha_film [1/GPa]", 1e9),
    "eyring_stress": ("tau0 at 1 GPa [MPa]", 1e-6), "limiting_shear_coefficient": ("limit over pressure", 1.0),
    "thermal_conductivity": ("k [W/(m K)]", 1.0), "heat_capacity": ("c [J/(kg K)]", 1.0),
}  # fmt: skip


def draw(oil: ehl.Oil, path: Path, traction: dict[str, Any]) -> None:
    """Four panels: viscosity over temperature and pressure, shear stresses and film conductivity over pressure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 7.6), layout="constrained")
    thin, thick, shear, heat = figure.subplots(2, 2).ravel()
    low, middle, high = (
        [1e6 * card.viscosity_kinematic(t + 273.15) for t in CELSIUS] for card in spread(oil, "viscosity")
    )
    thin.fill_between(CELSIUS, low, high, color=COLOURS[0], alpha=0.18, lw=0.0)
    thin.semilogy(CELSIUS, middle, color=COLOURS[0])
    thin.plot(
        [40.0, 100.0], [1e6 * oil.viscosity_kinematic_40, 1e6 * oil.viscosity_kinematic_100], "o", color=COLOURS[0]
    )
    for end in oil.temperature_valid:
        thin.axvline(end - 273.15, color="#8a8f98", lw=0.8, ls="--")
    thin.set(xlabel="temperature [°C]", ylabel="kinematic viscosity [cSt]", xlim=(CELSIUS[0], CELSIUS[-1]))
    thin.set_title("points: the card's two viscosities; dashed: range", fontsize=9)
    plot_oil(oil, TEMPERATURES, thick)
    thick.set_title("viscosity; band: one standard deviation", fontsize=9)
    pressure = np.linspace(0.0, PRESSURES[-1], 81)
    for kelvin, colour in zip(TEMPERATURES, COLOURS, strict=True):
        ends = [1e-6 * card.at(kelvin).shear_law.scale(pressure) for card in spread(oil, "eyring_stress")]
        shear.fill_between(1e-9 * pressure, ends[0], ends[2], color=colour, alpha=0.18, lw=0.0)
        shear.plot(1e-9 * pressure, ends[1], color=colour, label=f"tau0, {kelvin - 273.15:.0f} °C")
    limits = [
        1e-6 * card.at(TEMPERATURES[0]).shear_law.limiting_stress(pressure) for card in spread(oil, "limiting_shear")
    ]
    shear.fill_between(1e-9 * pressure, limits[0], limits[2], color="#4b8b3b", alpha=0.18, lw=0.0)
    shear.plot(1e-9 * pressure, limits[1], color="#4b8b3b", label="limiting stress")
    if oil.name in traction:
        mean = 1.5 * np.pi / 4.0
        shear.plot([mean], [1e3 * mean * traction[oil.name]], "ks", ms=5, label="measured mean, ball bearing")
    shear.set(xlabel="pressure [GPa]", ylabel="shear stress [MPa]", xlim=(0.0, 1e-9 * pressure[-1]), ylim=(0.0, None))
    shear.legend(frameon=False, fontsize=8)
    law = oil.at(TEMPERATURES[0])
    heat.plot(1e-9 * pressure, law.film_conductivity(pressure, law.thermal_conductivity), color=COLOURS[0])
    heat.axvline(1.1, color="#8a8f98", lw=0.8, ls="--")
    heat.set(
        xlabel="pressure [GPa]", ylabel="conductivity [W/(m K)]", xlim=(0.0, 1e-9 * pressure[-1]), ylim=(0.0, None)
    )
    heat.set_title("dashed: measured up to here (of a PAO and a paraffinic oil)", fontsize=9)
    figure.savefig(path, dpi=90)


def spread(oil: ehl.Oil, name: str) -> tuple[ehl.Oil, ehl.Oil, ehl.Oil]:
    """The card with one input one standard deviation below, as it is, and above."""
    return oil.varied(**{name: -1.0}), oil, oil.varied(**{name: 1.0})


def page(oil: ehl.Oil) -> str:
    """Text of the page of an oil."""
    sheet, known = oil.to_dict("40, 80, 100 degC"), oil.uncertainty
    family = OIL_FAMILIES[oil.base]
    lines = [
        "---",
        "orphan: true",
        "---",
        "",
        f"# {oil.name}",
        "",
        f"{oil.description}.",
        "",
        f"![Laws of {oil.name}]({oil.name}.png)",
        "",
    ]
    lines += ["| | 40 °C | 80 °C | 100 °C |", "|---|---|---|---|"]
    for name, (label, factor) in NAMES.items():
        lines.append(f"| {label} | " + " | ".join(f"{factor * state[name]:.4g}" for state in sheet["states"]) + " |")
    own = oil.eyring_stress is not None or oil.limiting_shear_coefficient is not None
    valid = f"{1e-9 * oil.pressure_valid:.3g} GPa" if oil.pressure_valid else "not stated"
    low, high = (end - 273.15 for end in oil.temperature_valid)
    lines += [
        "",
        f"- **Base**: {oil.base}; viscosity law `{oil.viscosity.law}`.",
        f"- **Range**: {low:.0f} to {high:.0f} °C; pressure measured up to {valid}.",
        f"- **Shear**: {'figures of the card' if own else 'of its base oil'}; limit of the base oil "
        f"{family.limit_slope:g}, published {family.limit_range[0]:g} to {family.limit_range[1]:g} ({family.source}).",
        f"- **One standard deviation**: ln(eta/eta0) {100 * known.pressure_viscosity:.0f} %, eta0 "
        f"{100 * known.viscosity:.0f} %, tau0 {100 * known.eyring_stress:.0f} %, "
        f"limit {100 * known.limiting_shear:.0f} %, conductivity "
        f"{100 * known.thermal_conductivity:.0f} % ({known.source}).",
        *(f"- **Assumed**: {remark}." for remark in oil.remarks()),
        f"- **Source**: {oil.source}",
        "",
    ]  # fmt: skip
    return "\n".join(lines)


def write() -> None:
    """Write pages and figures whose cards have changed."""
    FOLDER.mkdir(exist_ok=True)
    with data_path("reference/measured", "ranges.toml").open("rb") as file:
        traction = tomllib.load(file)["ball_bearing_traction"]
    names = ehl.shipped("oils")
    rows = [
        "---",
        "orphan: true",
        "---",
        "",
        "# Oil cards",
        "",
        "Made from the cards by `python docs/make_oils.py`.",
        "",
    ]
    rows += ["| card | oil | base |", "|---|---|---|"]
    for name in names:
        oil = ehl.Oil.load(name)
        text, target = page(oil), FOLDER / f"{name}.md"
        figure = FOLDER / f"{name}.png"
        if not figure.exists() or not target.exists() or target.read_text(encoding="utf-8") != text:
            draw(oil, figure, traction)
            target.write_text(text, encoding="utf-8")
        rows.append(f"| [{name}]({name}.md) | {oil.description} | {oil.base} |")
    (FOLDER / "index.md").write_text("\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write()
