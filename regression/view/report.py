"""What the command line shows of a fit and a friction value."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from regression.friction.formula import FittedFormula

# how the bands of each variable are shown: factor from SI, shift, unit
_SHOWN: dict[str, tuple[float, float, str]] = {
    "film_ratio": (1.0, 0.0, ""),
    "slide_to_roll_total": (1.0, 0.0, ""),
    "pressure_hertz": (1e-9, 0.0, "GPa"),
    "temperature_oil": (1.0, -273.15, "degC"),
}

_SHORT = {
    "film_ratio": "lambda",
    "slide_to_roll_total": "SR",
    "pressure_hertz": "p_h",
    "temperature_oil": "T",
}


def _compact(title: str, *names: str, space: int = 1) -> Table:
    """A table of numbers for 80 columns: the first column says where, the others stand close to each other."""
    table = Table(title=title, box=SIMPLE, padding=(0, 0, 0, space), pad_edge=False, title_justify="left")
    for name in names:
        table.add_column(name, justify="left" if name == names[0] else "right", no_wrap=name == names[0])
    return table


def _reasons(reasons: dict[str, int]) -> str:
    return ", ".join(f"{count} {reason}" for reason, count in sorted(reasons.items()))


def _per_cent(share: float | None) -> str:
    if share is None or not math.isfinite(share):
        return "-"
    return f"{100.0 * share:.1f}" if abs(share) < 0.9995 else f"{100.0 * share:.0f}"


def families_table(formulas: Sequence[FittedFormula], tried: Iterable[str]) -> None:
    """Held-out errors of all fitted families, best first, and which of those tried could not be fitted."""
    title = "errors of held-out cases in %, whole (p, R) cells left out at a time"
    table = _compact(title, "family", "terms", "R2 ln mu", "R2 mu", "MAPE", "95 %", "worst", "bias")
    for formula in formulas:
        v = formula.validation
        terms = str(len(formula.coefficients) - len(formula.dropped))
        relative = (_per_cent(x) for x in (v.mape, v.p95, v.largest, v.bias))
        table.add_row(formula.name, terms, f"{v.r2_log:.4f}", f"{v.r2:.4f}", *relative)
    console = Console()
    console.print(table)
    for name in sorted(set(tried) - {formula.family for formula in formulas}):
        console.print(f"{name} could not be fitted to these data; --family {name} says why", highlight=False)


def formula_report(formula: FittedFormula, spread: Sequence[tuple[float, float, float]] = ()) -> None:
    """Equation, coefficients, errors by region and the worst case.

    `spread` is that of the interval within each band, as of `regression.fitting.cross_validation.process_factors`.
    """
    console = Console()
    console.print(formula.to_text(), highlight=False, soft_wrap=True, markup=False)
    table = _compact(
        "held-out errors by region in % (ln mu: RMS, in: in the interval)",
        *("region", "cases", "R2", "ln mu", "MAPE", "95 %", "worst", "bias", "in", "noise"),
        space=0,
    )
    before = ""
    for band in formula.bands:
        if before and band.variable != before:
            table.add_section()
        before = band.variable
        factor, shift, unit = _SHOWN.get(band.variable, (1.0, 0.0, ""))
        low, high = (f"{factor * (x + shift):.3g}" for x in (band.low, band.high))
        region = f"{_SHORT.get(band.variable, band.variable)} {low} to {high} {unit}".strip()
        r2 = "-" if band.r2 is None else f"{band.r2:.3f}"
        figures = (band.rmse_log, band.mape, band.p95, band.largest, band.bias, band.coverage, band.noise)
        table.add_row(region, str(band.count), r2, *(_per_cent(x) for x in figures))
    console.print(table)
    console.print(_interval_table(formula, spread))
    worst = formula.validation.worst
    where = ", ".join(f"{name} {value:.4g}" for name, value in worst.conditions.items())
    console.print(
        f"worst case {worst.key[:12]}: {100.0 * worst.relative_error:+.1f} % at {where} (SI)",
        highlight=False,
        soft_wrap=True,
    )
    for checked, what in ((formula.corners, "corners of the box"), (formula.paths, "contacts along gear meshes")):
        if checked is not None:
            console.print(
                f"{checked.count} {what}, not fitted: MAPE {100.0 * checked.mape:.1f} %, "
                f"95 % {100.0 * checked.p95:.1f} %, worst {100.0 * checked.largest:.1f} %"
                + ("" if checked.coverage is None else f", {100.0 * checked.coverage:.0f} % within their interval")
                + ("" if checked.extrapolated is None else f", {100.0 * checked.extrapolated:.0f} % extrapolated"),
                highlight=False,
                soft_wrap=True,
            )
    if formula.noise is not None:
        noise = formula.noise
        console.print(
            f"noise floor: {noise.points} points, {noise.realisations:.3g} roughness realisations each: "
            f"one scatters by {100.0 * noise.single:.2g} %, their mean by {100.0 * noise.mean:.2g} %",
            highlight=False,
            soft_wrap=True,
        )
    if formula.nested is not None:
        console.print(
            f"choice of the family held out too: MAPE {100.0 * formula.nested.mape:.1f} %, "
            f"95 % {100.0 * formula.nested.p95:.1f} %",
            highlight=False,
        )
    data = formula.data
    console.print(
        f"{data.used} of {data.count} cases used, {formula.folds} folds, the solver's own error "
        f"{100.0 * formula.noise_floor:.2g} %, condition number {formula.condition_number:.3g}",
        highlight=False,
    )
    if data.excluded:
        console.print(f"left out: {_reasons(data.excluded)}", highlight=False)
    collinear = {term: value for term, value in formula.variance_inflation.items() if value > 10.0}
    if collinear:
        listed = ", ".join(f"{term} {value:.0f}" for term, value in collinear.items())
        console.print(f"collinear terms (variance inflation above 10): {listed}", highlight=False)


def _interval_table(formula: FittedFormula, spread: Sequence[tuple[float, float, float]]) -> Table:
    interval = formula.interval
    # of a process: what of them the cases have, as the deviation differs from case to case
    factors = ("median factor", "90 % of cases") if spread else ("deviations",) if interval.normalised else ("factor",)
    table = _compact(
        f"{100.0 * interval.level:.0f} % interval: mu over and times a factor; covered in %",
        *("film ratio", "held out", *factors, "covered", "two binomial errors"),
    )
    for i, band in enumerate(interval.bands):
        end = "up" if band.high is None else f"{band.high:g}"
        deviation = math.sqrt(interval.level * (1.0 - interval.level) / band.count)
        width = f"{band.log_width:.2f}" if interval.normalised else f"{math.exp(band.log_width):.3f}"
        shown: tuple[str, ...] = (width,)
        if spread:
            middle, low, high = spread[i]
            shown = (f"{middle:.3f}", f"{low:.3f} to {high:.3f}")
        table.add_row(
            f"{band.low:g} to {end}", str(band.count), *shown, _per_cent(band.coverage), _per_cent(2.0 * deviation)
        )
    return table
