"""Output of oil cards: files, and properties over temperature and pressure as tables and plots."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ehl.common.data import data_rows
from ehl.common.errors import InputError
from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new
from ehl.common.files import toml_text, write_file
from ehl.common.quantities import axis_label, quantity, to_display
from ehl.common.sections import Head, Medium, Picture, Section
from ehl.common.table import Table
from ehl.common.units import KELVIN, ValueRange
from ehl.fluid.oil_laws import InputFactors
from ehl.fluid.pressure_viscosity import DEFINITIONS, alpha_of
from ehl.fluid.rheology import stress_at
from ehl.fluid.viscosity import TEMPERATURE_RANGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ehl.fluid.oil import Oil

TEMPERATURES = (40.0 + KELVIN, 100.0 + KELVIN)
PRESSURES = (0.0, 0.2e9, 0.4e9, 0.8e9, 1.2e9, 1.6e9)
_COLOURS = (BLUE, ORANGE, "#4b8b3b", "#8a4f9e")


def temperatures_of(given: str | Sequence[float | str] | None) -> tuple[float, ...]:
    """Temperatures [K] from a text such as "40, 100 degC", or from numbers and texts."""
    if given is None:
        return TEMPERATURES
    allowed = ValueRange("K", ge=TEMPERATURE_RANGE[0], le=TEMPERATURE_RANGE[1])
    if isinstance(given, str):
        return tuple(allowed.check_list(given, "temperatures"))
    return tuple(allowed.check(value, "temperatures") for value in given)


def figures_at(oil: Oil, temperature: float) -> dict[str, float | None]:
    """Properties of a card at a temperature [K] in SI units, with the Eyring stress at 1 GPa."""
    lubricant = oil.at(temperature)
    law, stress = lubricant.pressure_law, lubricant.eyring_stress
    return {
        "temperature_oil": temperature,
        "viscosity_kinematic": lubricant.viscosity_inlet / lubricant.density,
        **{name: getattr(lubricant, name) for name in ("viscosity_inlet", "temperature_viscosity", "density")},
        **{f"pressure_viscosity_{definition}": float(alpha_of(law, definition)) for definition in DEFINITIONS},
        "eyring_stress": float(stress_at(stress, 1e9)),
        **{name: getattr(lubricant, name) for name in _OWN},
    }


def sheet(oil: Oil, temperatures: Sequence[float]) -> dict[str, Any]:
    """All properties for JSON; ln(eta/eta0) has one row per temperature [K]."""
    pressure = np.array(PRESSURES)
    return {
        **{name: getattr(oil, name) for name in ("name", "description", "base")},
        "viscosity_law": oil.viscosity.law,
        "certainty": oil.certainty,
        "source": oil.source,
        "temperature_valid": list(oil.temperature_valid),
        "pressure_valid": oil.pressure_valid,
        "uncertainty": oil.uncertainty.model_dump(),
        "remarks": list(oil.remarks()),
        "states": [figures_at(oil, at) for at in temperatures],
        "pressures": list(PRESSURES),
        "log_viscosity_ratio": [oil.at(at).log_viscosity_ratio(pressure).tolist() for at in temperatures],
    }


@cache
def source_points() -> dict[str, list[tuple[float, float, float]]]:
    """Temperature [K], pressure [Pa] and viscosity [Pa s] by the law in the source of a card, for cards with one."""
    found: dict[str, list[tuple[float, float, float]]] = {}
    for row in data_rows("reference", "oil_points.csv"):
        celsius, gigapascal, viscosity = (float(value) for value in list(row.values())[1:])
        found.setdefault(row["card"], []).append((celsius + KELVIN, 1e9 * gigapascal, 1e-3 * viscosity))
    return found


def plot_oil(oil: Oil, temperatures: Sequence[float], ax: Axes | None = None) -> Axes:
    """Plot of eta over pressure; band: one standard deviation of ln(eta/eta0); points: source of the card."""
    axes = axes_or_new(ax, 7.0, 4.6)
    pressure = np.linspace(0.0, PRESSURES[-1], 161)
    shown = to_display("pressure", pressure)
    cards, known = [oil.varied(pressure_viscosity=n) for n in (-1.0, 0.0, 1.0)], source_points().get(oil.name, [])
    for number, at in enumerate(temperatures):
        colour = _COLOURS[number % len(_COLOURS)]
        low, middle, high = (to_display("viscosity_inlet", card.at(at).viscosity(pressure)) for card in cards)
        axes.fill_between(shown, low, high, color=colour, alpha=0.18, lw=0.0)
        axes.semilogy(shown, middle, color=colour, label=f"{at - KELVIN:.4g} °C")
        points = [(p, eta) for t, p, eta in known if abs(t - at) < 0.01]
        if points:
            place, eta = np.array(points).T
            place, eta = to_display("pressure", place), to_display("viscosity_inlet", eta)
            axes.plot(place, eta, "o", color=colour, ms=4, mfc="none")
    if known:
        axes.plot([], [], "o", color=GREY, ms=4, mfc="none", label="law of the source")
    if oil.pressure_valid is not None:
        axes.axvline(to_display("pressure", oil.pressure_valid), color=GREY, lw=0.8, ls="--")
        end, place = to_display("pressure", oil.pressure_valid), axes.get_xaxis_transform()
        axes.text(end, 0.02, " end of measured range", color=GREY, transform=place, fontsize=8)
    axes.set(xlabel=axis_label("pressure"), ylabel="viscosity [mPa s]", xlim=(0.0, shown[-1]))
    axes.set_title(f"{oil.name}: viscosity, band: one standard deviation of ln(eta/eta0)", fontsize=10)
    axes.legend(frameon=False)
    return axes


# properties of a lubricant that are shown as they are
_OWN = (
    "limiting_shear_ambient", "limiting_shear_coefficient", "shear_modulus", "thermal_conductivity", "heat_capacity"
)  # fmt: skip
_STATE = (
    *("viscosity_kinematic", "viscosity_inlet", "density"),
    *(f"pressure_viscosity_{name}" for name in DEFINITIONS),
    *("eyring_stress", *_OWN),
)


def oil_sections(card: Oil, temperatures: Sequence[float], medium: Medium) -> list[Section]:
    """Properties of a card with their uncertainty, and on a page its viscosity over pressure."""
    content = sheet(card, temperatures)
    heads = [quantity("temperature_oil").text(state["temperature_oil"]) for state in content["states"]]
    rows = [[head, *(state[name] for name in _STATE)] for head, state in zip(heads, content["states"], strict=True)]
    known = content["uncertainty"]
    low, high = content["temperature_valid"]
    reach = quantity("temperature_valid").span(low, high)
    if content["pressure_valid"] is not None:
        reach += f" and to {quantity('pressure_valid').text(content['pressure_valid'])}"
    name = ": ".join(filter(None, (card.name, card.description)))
    title = f"{name}; base {card.base}, law {content['viscosity_law']}, valid {reach}"
    columns = [quantity("pressure").text(pressure, 2) for pressure in content["pressures"]]
    over = [[head, *values] for head, values in zip(heads, content["log_viscosity_ratio"], strict=True)]
    spread = [[name, f"{100.0 * value:.3g} %"] for name, value in known.items() if name != "source"]
    remarks = [f"note: {text}" for text in content["remarks"]]
    remarks.append(f"Source: {card.source}")
    tables = [
        Table(["state", *_STATE], rows, title=title, vertical=True),
        Table(["ln(eta/eta0) at", *columns], over, title="increase of viscosity with pressure"),
        Table(["input", "one standard deviation"], spread, title="uncertainty", notes=[*remarks, known["source"]]),
    ]
    figure = Picture(partial(plot_oil, card, temperatures), "Viscosity over pressure.", "viscosity")
    return [Section("", [Head(card.name), *tables, *([figure] if medium == "page" else [])])]


def card_content(card: Oil) -> dict[str, Any]:
    """The values of a card in SI units."""
    same = {"factors"} if card.factors == InputFactors() else set[str]()
    return card.model_dump(exclude_none=True, exclude=same)


def card_text(card: Oil, head: str) -> str:
    """The card as TOML in SI units; `head` is a comment in the first line."""
    return f"# {head}; numbers in SI units.\n" + toml_text(card_content(card))


def write_card(card: Oil, path: Path, head: str) -> None:
    """Write the card and check that it can be read; `head` as in `card_text`.

    Raises `InputError`: the path does not end in .toml or cannot be written.
    """
    if path.suffix != ".toml":
        raise InputError("path", str(path), "a file name ending in .toml")
    write_file(path, card_text(card, head))
    type(card).load(str(path))
