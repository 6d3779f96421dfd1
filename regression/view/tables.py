"""Tables of fitted formulas, for terminal, pages and notebooks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from ehl.common.table import Column, Table

if TYPE_CHECKING:
    from regression.friction.error_tables import Band, Scores
    from regression.friction.fitted import FittedFormula

_ERRORS = ("mape", "p95", "largest", "bias")


def family_table(formulas: Sequence[FittedFormula], tried: Iterable[str] = ()) -> Table:
    """Held-out errors of fitted families in the given order; notes on families that could not be fitted."""
    rows = []
    for formula in formulas:
        v = formula.validation
        terms = len(formula.coefficients) - len(formula.dropped)
        rows.append((formula.label, terms, v.r2_log, v.r2, *(getattr(v, name) for name in _ERRORS)))
    columns = ("family", "terms", Column("r2_log", label="R² ln µ"), Column("r2", label="R² µ"), *_ERRORS)
    title = "Fitted formulas: errors of held-out cases, folds of whole (p, R) cells"
    missing = sorted(set(tried) - {formula.label for formula in formulas})
    notes = [f"{name} could not be fitted to these data; --family {name} shows the reason" for name in missing]
    return Table(columns, rows, title=title, notes=notes, highlight=0)


def band_table(formula: FittedFormula) -> Table:
    """Held-out errors by band of each variable."""
    rows = [
        (
            region_text(band.variable, band.low, band.high),
            *(getattr(band, name) for name in ("count", "r2", "rmse_log", *_ERRORS, "coverage", "noise")),
        )
        for band in formula.bands
    ]
    columns = (
        "region",
        Column("count", label="cases"),
        Column("r2", label="R² µ"),
        Column("rmse_log", of="share", label="RMS of ln µ"),
        *_ERRORS,
        Column("coverage", of="share", label="covered"),
        Column("noise", of="share", label="noise floor"),
    )
    note = (
        "Noise floor: scatter of one roughness realisation about the mean of several, at points with several "
        "realisations. Covered: share of the cases inside the interval of single profiles."
    )
    return Table(columns, rows, title=f"{formula.label}: errors of held-out cases by region", notes=(note,))


def not_fitted(formula: FittedFormula) -> tuple[tuple[str, Scores], ...]:
    """Groups of cases that were not fitted, and the errors of a formula there."""
    found = (
        ("corners of the box", formula.corners),
        ("contacts along gear meshes", formula.paths),
        ("points with the mean over several profiles", formula.unseen),
    )
    return tuple((what, scores) for what, scores in found if scores is not None)


def check_table(formula: FittedFormula) -> Table:
    """Errors of a formula on fitted cases, held-out cases and cases outside the fit."""
    checked: tuple[tuple[str, Scores | Band | None], ...] = (
        ("fitted cases", formula.fit),
        ("held-out cells", formula.validation),
        ("held-out cells, with choice of the family", formula.nested),
        *not_fitted(formula),
        *((f"  {region_text(b.variable, b.low, b.high)}", b) for b in formula.unseen_bands),
    )
    columns = (
        "checked on",
        Column("count", label="cases"),
        *_ERRORS[:3],
        Column("rmse", label="RMSE of µ"),
        Column("coverage", of="share", label="covered"),
        Column("extrapolated", of="share", label="extrapolated"),
    )
    rows = [
        (what, s.count, s.mape, s.p95, s.largest, s.rmse, s.coverage, getattr(s, "extrapolated", None))
        for what, s in checked
        if s is not None
    ]
    return Table(columns, rows, title="The same formula on other cases")


def interval_table(formula: FittedFormula, spread: Sequence[tuple[float, float, float]]) -> Table:
    """Interval of mu by film ratio.

    spread: result of `regression.fitting.cross_validation.interval_factors` for networks, whose deviation differs from
        case to case; empty for other forms.
    """
    interval = formula.interval
    level = interval.level
    rows = []
    for i, band in enumerate(interval.bands):
        error = 2.0 * math.sqrt(level * (1.0 - level) / band.count)
        factors = (band.log_width, *spread[i]) if spread else (band.log_width, math.exp(band.log_width), None, None)
        rows.append((band.low, band.high, band.count, *factors, band.coverage, error))
    keep = [True, True, True, interval.normalised, True, bool(spread), bool(spread), True, True]
    columns: tuple[Column | str, ...] = (
        Column("low", of="film_ratio", label="film ratio from"),
        Column("high", of="film_ratio", label="to"),
        Column("count", label="cases"),
        Column("log_width", label="deviations"),
        Column("factor", label="factor, median" if spread else "factor"),
        Column("factor_low", label="factor, 5 % of cases"),
        Column("factor_high", label="factor, 95 % of cases"),
        Column("coverage", of="share", label="covered"),
        Column("coverage_error", of="share", label="two binomial standard errors"),
    )
    notes = ["factor = exp(w s) with w from column deviations and s the deviation at the point"] if spread else []
    if interval.of_means != 1.0:
        notes.append(
            f"for the mean over roughness profiles, {interval.of_means:.2g} times the widths that cover single "
            "profiles; covered: single profiles by the latter"
        )
    return Table(
        [column for column, kept in zip(columns, keep, strict=True) if kept],
        [[value for value, kept in zip(row, keep, strict=True) if kept] for row in rows],
        title=f"{formula.label}: interval of {100 * level:g} % by film ratio, from µ/factor to µ·factor",
        notes=tuple(notes),
    )


def conditions_text(values: Mapping[str, float], digits: int = 3) -> str:
    """The conditions of a case as text, in display units."""
    known = {name: Column(name).quantity for name in values}
    return ", ".join(f"{known[name].label} {known[name].text(value, digits)}" for name, value in values.items())


def region_text(variable: str, low: float, high: float) -> str:
    """A band of a variable as text."""
    entry = Column(variable).quantity
    return f"{entry.label} {entry.span(low, high)}"


def coefficient_table(formula: FittedFormula, title: str = "") -> Table:
    """Coefficients of a formula with standard errors and collinearity."""
    rows = []
    for term in formula.form.terms:
        value, error = formula.coefficients[term], formula.standard_errors.get(term)
        inflation = formula.variance_inflation.get(term)
        relative = None if error is None or not value else error / abs(value)
        remark = formula.dropped.get(term, "collinear" if inflation is not None and inflation > 10.0 else "")
        rows.append((term, value, error, relative, inflation, remark))
    columns = (
        "coefficient",
        Column("number", label="value", digits=9),
        Column("standard_error", digits=3),
        Column("relative error", of="relative_error"),
        Column("variance_inflation", digits=3),
        "remark",
    )
    note = (
        f"Collinearity: condition number {formula.condition_number:.3g}. With a variance inflation above 10 only "
        "combinations of coefficients are determined."
    )
    return Table(columns, rows, title=title, notes=(note,), name="coefficients")
