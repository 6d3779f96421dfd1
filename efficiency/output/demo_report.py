"""The demonstration as one HTML page."""

from __future__ import annotations

import platform
from pathlib import Path
from typing import TYPE_CHECKING

from efficiency.output.flank_map import FlankMap
from efficiency.output.plots_flank import LOSS, contact_figure, field_figure
from efficiency.output.plots_geometry import contact_lines_figure, ease_off_figure
from efficiency.output.plots_load import (
    plot_comparison,
    plot_friction_and_loss,
    plot_load_sharing,
    plot_transmission_error,
)
from efficiency.output.tables import (
    COMPARISON_HEADER,
    RPM,
    comparison_rows,
    efficiency_rows,
    operating_point,
    percent,
)
from ehl import __version__
from ehl.view.html_report import Formula as FormulaBlock
from ehl.view.html_report import KeyFigures, Picture, Pictures, Section, Table, Text, number, write_report
from regression.view.plots import plot_friction, plot_parity

if TYPE_CHECKING:
    from efficiency.cli.demo import DemoResult
    from regression.friction.formula import FittedFormula

_BAND_UNITS = {
    "film_ratio": ("film ratio", 1.0, 0.0, ""),
    "slide_to_roll_total": ("|SR|", 1.0, 0.0, ""),
    "pressure_hertz": ("Hertz pressure", 1e-9, 0.0, " GPa"),
    "temperature_oil": ("oil temperature", 1.0, -273.15, " degC"),
}


def write_demo_report(result: DemoResult) -> Path:
    """Write `report.html` into the folder of the demonstration."""
    sections = [_summary(result), _contacts(result), _formulas(result), _gear(result), _comparison(result)]
    sections.append(_provenance(result))
    return write_report(
        result.folder / "report.html",
        "From lubricated contacts to gear efficiency",
        f"mixed-ehl {__version__}: {operating_point(result.comparison)}",
        sections,
        f"mixed-ehl {__version__}, Python {platform.python_version()}. Spin losses (churning, windage, bearings) are "
        "not part of any figure here.",
    )


def _summary(result: DemoResult) -> Section:
    best, gear = result.formulas[0], result.comparison.results[0]
    constant = next(row for row in result.comparison.rows if row.name.startswith("constant"))
    return Section(
        "",
        [
            KeyFigures(
                [
                    (f"{percent(gear.efficiency, 2)} %", f"mesh efficiency with the fitted formula ({best.family})"),
                    (f"{percent(constant.efficiency, 2)} %", "with a constant mu of 0.05"),
                    (f"{gear.power_loss:.0f} W", f"friction loss of {gear.power_input / 1e3:.1f} kW"),
                    (f"{100 * best.validation.mape:.1f} %", "mean error of the formula on held-out contacts"),
                    (f"{result.sweep_report.total - result.sweep_report.failed}", "contacts solved"),
                ]
            )
        ],
    )


def _contacts(result: DemoResult) -> Section:
    frame = result.dataset.converged
    report = result.sweep_report
    heated = int((~frame["skipped"].str.contains("heat")).sum())
    friction_error = frame["friction_error"]
    return Section(
        "1. Contacts",
        [
            Text(
                f"{report.total} line contacts drawn by a scrambled Sobol sequence over what the contact points of the "
                f"pair see, each solved as a smooth film with heat where an estimate says it matters ({heated} of "
                f"{len(frame)}), and mixed friction by load sharing. {report.failed} failed. The solver's own error of "
                f"mu is {100 * friction_error.median():.2g} % in the median and {100 * friction_error.max():.2g} % at "
                "worst; it covers the discretisation and the heat left out, not the load-sharing model or the oil data."
            ),
            Pictures(
                [
                    Picture(plot_friction(result.dataset), "Friction coefficient of every contact of the sweep."),
                    Picture(plot_parity(result.dataset, result.formulas), "Formula against computed friction (fit)."),
                ]
            ),
        ],
    )


def _formulas(result: DemoResult) -> Section:
    best = result.formulas[0]
    rows = [
        (
            formula.family,
            formula.form.title,
            str(len(formula.coefficients)),
            number(formula.validation.r2_log, 4),
            number(100 * formula.validation.mape, 3),
            number(100 * formula.validation.p95, 3),
            number(100 * formula.validation.largest, 3),
        )
        for formula in result.formulas
    ]
    header = ("family", "form", "terms", "R² of ln mu", "MAPE [%]", "95 % below [%]", "worst [%]")
    return Section(
        "2. Friction formula",
        [
            Text(
                "Each family is fitted to the same contacts and judged on cases it has not seen: whole cells of "
                "pressure and radius are held out in turn. The load-share family has an advantage here that a real "
                "contact would not give it: the contacts were computed with a load-sharing model of the same kind."
            ),
            Table(header, rows, "Errors on held-out contacts, best family first.", 0, 2),
            FormulaBlock(best.to_text()),
            _band_table(best),
        ],
    )


def _band_table(formula: FittedFormula) -> Table:
    rows = []
    for band in formula.bands:
        name, factor, shift, unit = _BAND_UNITS[band.variable]
        low, high = band.low * factor + shift, band.high * factor + shift
        rows.append(
            (
                f"{name} {low:.3g} to {high:.3g}{unit}",
                str(band.count),
                number(100 * band.mape, 3),
                number(100 * band.p95, 3),
                number(100 * band.bias, 3),
            )
        )
    header = ("region", "contacts", "MAPE [%]", "95 % below [%]", "bias [%]")
    return Table(header, rows, f"Held-out errors of {formula.family} by region.")


def _gear(result: DemoResult) -> Section:
    gear = result.comparison.results[0]
    pair = result.gear.pair
    cycle = tuple(load.position for load in gear.load.positions)
    flank = FlankMap.of(pair.flanks, gear)
    return Section(
        "3. Gear pair",
        [
            Text(
                f"{pair.teeth_pinion} x {pair.teeth_gear} spiral bevel pair, face-milled and generated: flanks from "
                "machine settings by the equation of meshing, ease-off against the conjugate pinion, loaded contact "
                f"at {gear.torque_pinion:.4g} N m and {gear.speed_pinion * RPM:.4g} rpm of the pinion."
            ),
            Pictures(
                [
                    Picture(ease_off_figure(pair), "Ease-off and unloaded contact path."),
                    Picture(contact_lines_figure(pair, cycle), "Potential contact lines over one mesh cycle."),
                    Picture(contact_figure(flank), "Contact pattern and Hertz pressure on the gear flank under load."),
                    Picture(field_figure(flank, LOSS), "Power loss per area of the gear flank, fitted formula."),
                    Picture(plot_load_sharing(gear), "Share of the torque one tooth pair carries."),
                    Picture(plot_transmission_error(gear), "Transmission error, unloaded and loaded."),
                    Picture(plot_friction_and_loss(gear), "Friction and loss over one mesh cycle, fitted formula."),
                ]
            ),
            Table(("quantity", "value", "unit"), efficiency_rows(gear), "With the fitted formula."),
        ],
    )


def _comparison(result: DemoResult) -> Section:
    return Section(
        "4. Against constant mu and other models",
        [
            Text(
                "The same loaded mesh with each friction model. 'ehl:load_sharing' solves contacts of the mesh, by the "
                "load-sharing model of the data, instead of using a formula, so its difference from the fitted formula "
                "is what the formula costs; 'ehl' would roll the rough surfaces through. Loads come from frictionless "
                "equilibrium. The closed forms take one constant mu for the whole pair."
            ),
            Table(COMPARISON_HEADER, comparison_rows(result.comparison), operating_point(result.comparison), 0),
            Picture(plot_comparison(result.comparison), "Power loss by friction model."),
        ],
    )


def _provenance(result: DemoResult) -> Section:
    best = result.formulas[0]
    rows = [
        ("data hash", best.data.hash[:16]),
        ("plan hash", best.data.plan_hash[:16]),
        ("solver", best.data.solver_version),
        *((f"time: {step}", f"{value:.1f} s") for step, value in result.seconds.items()),
    ]
    left_out = result.comparison.results[0].skipped
    return Section(
        "5. Provenance",
        [
            Table(("what", "value"), rows, text_columns=2),
            Text("Left out of the gear model: " + "; ".join(left_out) + "."),
            *(Text(f"Note on the pair: {note}.") for note in result.comparison.notes),
            Text("Files beside this page: run/ (contacts), formula_*.json (formulas), demo.json (all figures)."),
        ],
    )
