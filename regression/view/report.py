"""What the command line shows of a fit and a friction value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console

from regression.view.tables import band_table, interval_table, not_fitted, reason_text, value_text

if TYPE_CHECKING:
    from regression.friction.formula import FittedFormula


def formula_report(formula: FittedFormula, spread: Sequence[tuple[float, float, float]] = ()) -> None:
    """Equation, coefficients, errors by region and the worst case.

    `spread` is that of the interval within each band, as of `regression.fitting.cross_validation.process_factors`.
    """
    console = Console(markup=False)
    console.print(formula.to_text(), highlight=False, soft_wrap=True)
    band_table(formula).print()
    if formula.interval.bands:
        interval_table(formula, spread).print()
    else:  # too few cases for bands
        level, width = formula.interval.level, math.exp(formula.interval.log_width)
        console.print(
            f"interval of {100 * level:g} %: µ over and times {width:.3g}, at every film ratio", highlight=False
        )
    worst = formula.validation.worst
    where = ", ".join(value_text(name, value) for name, value in worst.conditions.items())
    console.print(
        f"worst case {worst.key[:12]}: {100.0 * worst.relative_error:+.1f} % at {where}",
        highlight=False,
        soft_wrap=True,
    )
    for what, checked in not_fitted(formula):
        console.print(
            f"{checked.count} {what}, not fitted: MAPE {100.0 * checked.mape:.1f} %, "
            f"95 % {100.0 * checked.p95:.1f} %, worst {100.0 * checked.largest:.1f} %, RMSE of mu {checked.rmse:.2g}"
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
        soft_wrap=True,
    )
    if data.excluded:
        console.print(f"left out: {reason_text(data.excluded)}", highlight=False)
    collinear = {term: value for term, value in formula.variance_inflation.items() if value > 10.0}
    if collinear:
        listed = ", ".join(f"{term} {value:.0f}" for term, value in collinear.items())
        console.print(f"collinear terms (variance inflation above 10): {listed}", highlight=False, soft_wrap=True)
