"""Sections of a fit: data, formulas, errors, failures; on the terminal only the best formula."""

import math
import platform
import time
from collections.abc import Iterable, Sequence
from functools import partial
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from ehl import __version__
from ehl.common.data import counted_reasons
from ehl.common.errors import InputError
from ehl.common.notes import Note
from ehl.common.progress import duration
from ehl.common.quantities import format_number, quantities
from ehl.common.sections import (
    Code,
    Folded,
    Head,
    Item,
    KeyFigures,
    MainResult,
    Medium,
    Notes,
    Picture,
    Row,
    Section,
    Text,
)
from ehl.common.table import Column, Table
from ehl.fluid.oil import Oil
from regression.data.dataset import Dataset, columns
from regression.fitting.cross_validation import interval_factors
from regression.fitting.rows import computed_friction, fitted_rows
from regression.fitting.sensitivity import formula_sensitivity
from regression.friction.conditions import Array
from regression.friction.fitted import FittedFormula
from regression.friction.models import COLEMAN_FRICTION
from regression.friction.published_registry import PUBLISHED
from regression.view import plots, tables

_OILS_SHOWN = 3
_WORST = 10
_LARGE = 0.3  # error above which a warning is shown
_FEW = 5  # smallest number of cases of a band in the warnings
# the conditions of single cases in tables, by their symbols
_CONDITIONS = {
    "pressure_hertz": "p_h",
    "radius_equivalent": "R",
    "speed_entrainment": "u_r",
    "slide_to_roll_total": "|SR|",
    "temperature_oil": "T",
    "roughness_rms": "Rq",
    "correlation_length": "l_c",
    "peklenik_number": "γ",
    "film_ratio_formula": "λ by formula",
}
_CONDITION_COLUMNS = [Column(name, label=label, digits=3) for name, label in _CONDITIONS.items()]
_LIBRARIES = ("numpy", "scipy", "scikit-learn", "pandas", "h5py", "numba")


def fit_sections(dataset: Dataset, formulas: Sequence[FittedFormula], tried: Iterable[str] = ()) -> list[Section]:
    """Sections of the page of a fit.

    dataset: data of the fit.
    formulas: fitted formulas, the best first.
    tried: families that were tried; those not among the formulas are reported as not fitted.
    """
    best = formulas[0]
    return [
        _summary(dataset, best),
        _errors(dataset, best),
        _range_and_cost(dataset, best),
        *(_curves(dataset, formulas, oil) for oil in dataset.oils[:_OILS_SHOWN]),
        _residuals(dataset, formulas),
        _sensitivity(dataset, best),
        _comparison(dataset, formulas, tried),
        _data(dataset),
        _failures(dataset, best),
        _formula(best),
        _provenance(dataset, formulas),
    ]


def formula_sections(
    formulas: Sequence[FittedFormula], tried: Iterable[str], dataset: Dataset | None, medium: Medium
) -> list[Section]:
    """Sections for the terminal (equation, errors by region, worst case) or for files (all tables)."""
    best = formulas[0]
    ranking = [tables.family_table(formulas, tried)] if len(formulas) > 1 or tried else []
    shown = [tables.band_table(best), tables.check_table(best), _interval(best, dataset)]
    if medium == "files":
        head = Head(f"Fit of a friction formula: {best.label}")
        return [Section("", [head, *ranking, *shown, tables.coefficient_table(best)])]
    notes = Notes(_notes(dataset, best))
    return [Section("", [*ranking, Code(best.to_text()), *shown, _answer(best), notes])]


def _interval(formula: FittedFormula, dataset: Dataset | None) -> Table | Text:
    """Interval by film ratio; of all cases together if they are too few for bands."""
    if formula.interval.bands:
        return tables.interval_table(formula, () if dataset is None else interval_factors(dataset, formula))
    level, width = formula.interval.level, formula.interval.log_width
    factor = (
        f"exp({width:.3g} s), s the deviation at the point" if formula.interval.normalised else f"{math.exp(width):.3g}"
    )
    return Text(f"interval of {100 * level:g} %: from µ/factor to µ·factor at every film ratio, factor {factor}")


def _percent(value: float) -> str:
    """A share in per cent with about two digits."""
    percent = 100.0 * value
    digits = 0 if abs(percent) >= 99.5 else 1 if abs(percent) >= 0.995 else 2
    return f"{percent:.{digits}f} %"


def _answer(best: FittedFormula) -> MainResult:
    """Held-out errors of a formula."""
    errors, worst = best.validation, best.validation.worst
    known = [
        (_percent(errors.p95), "95th percentile of the error"),
        (_percent(abs(errors.largest)), f"largest, case {worst.key[:8]} at {tables.conditions_text(worst.conditions)}"),
    ]
    if errors.coverage is not None:
        known.append((_percent(errors.coverage), f"of the cases inside their {100 * best.interval.level:g} % interval"))
    return MainResult(_percent(errors.mape), "mean error of the formula on held-out contacts", known)


def _summary(dataset: Dataset, best: FittedFormula) -> Section:
    errors = best.validation
    # a formula fitted to several datasets has more cases than the dataset of this page
    own = best.data.used <= len(dataset.frame)
    fitted = (f"{best.data.used} of {len(dataset.frame)}", "cases fitted")
    tiles = [
        (best.label, "formula with the smallest held-out error"),
        fitted if own else (f"{best.data.used}", f"cases fitted, of {dataset.plan_name} and other datasets"),
        (_percent(errors.bias), "mean deviation"),
        (f"{errors.r2_log:.4f}", "R² of ln µ"),
    ]
    if best.noise is not None:
        tiles.append((_percent(best.noise.single), "scatter between roughness realisations: the noise floor"))
    oils = ", ".join(dataset.oils) or "a lubricant without an oil card"
    footer = (
        "Errors are deviations from the results of the solver. They do not include the error of the solver against "
        "measurements."
    )
    head = Head("Fit of a friction formula", f"{dataset.plan_name}: {oils}", footer)
    return Section("", [head, _answer(best), KeyFigures(tiles), Notes(_notes(dataset, best))])


def _notes(dataset: Dataset | None, best: FittedFormula) -> list[Note]:
    """Notes on a formula and its data, warnings first."""
    level = best.interval.level
    warnings, others = list[str](), list[str]()
    if best.validation.p95 > _LARGE:
        warnings.append(f"5 % of the held-out contacts have errors above {_percent(best.validation.p95)}")
    many = [band for band in best.bands if band.count >= _FEW]
    worst = max(many, key=lambda band: band.p95, default=None)
    if worst is not None and worst.p95 > 2.0 * best.validation.p95:
        where = tables.region_text(worst.variable, worst.low, worst.high)
        warnings.append(f"largest errors at {where}: 5 % of the cases have errors above {_percent(worst.p95)}")
    narrow = [(band.coverage, band) for band in many if band.coverage is not None]
    share, band = min(narrow, key=lambda pair: pair[0], default=(1.0, None))
    if band is not None and share < level - 2.0 * math.sqrt(level * (1.0 - level) / band.count):
        where = tables.region_text(band.variable, band.low, band.high)
        held = f"it contains {_percent(share)} of {band.count} cases"
        warnings.append(f"the {100 * level:g} % interval is too narrow at {where}: {held}")
    for what, scores in tables.not_fitted(best):
        text = f"{scores.count} {what}, not fitted: mean error {_percent(scores.mape)}, 95 % {_percent(scores.p95)}"
        (warnings if scores.p95 > 2.0 * best.validation.p95 else others).append(text)
    if dataset is not None:
        cases, counts = len(dataset.frame), dataset.frame["status"].value_counts()
        if failed := int(counts.get("failed", 0)):
            warnings.append(f"{failed} of {cases} contacts have no result")
        if cases < dataset.planned:
            missing = f"{dataset.planned - cases} of the {dataset.planned} cases of the plan are missing"
            warnings.append(f"{missing}, because the sweep is running or was stopped: fit again when it is complete")
        if unsettled := int(counts.get("unsettled", 0)):
            others.append(f"the error of {unsettled} of {cases} contacts exceeds the tolerance")
    others.append(
        f"{best.data.used} of {best.data.count} cases fitted, {best.folds} folds; standard deviation of the numerical "
        f"error {_percent(best.noise_floor)}; condition number {best.condition_number:.3g}"
    )
    if best.data.excluded:
        others.append(f"excluded: {counted_reasons(best.data.excluded)}")
    if noise := best.noise:
        others.append(
            f"noise floor: scatter of one roughness realisation {_percent(noise.single)}, of the mean of "
            f"{noise.realisations:.3g} {_percent(noise.mean)}, at {noise.points} points"
        )
    if collinear := [f"{term} {value:.0f}" for term, value in best.variance_inflation.items() if value > 10.0]:
        others.append(f"collinear coefficients without a physical meaning (variance inflation): {', '.join(collinear)}")
    return [*(Note("warning", text) for text in warnings), *(Note("for information", text) for text in others)]


def _range_and_cost(dataset: Dataset, best: FittedFormula) -> Section:
    ends = list(zip(("from", "to"), *best.ranges.values(), strict=True))
    ranges = Table(
        ("end", *best.ranges), ends, "Range of the formula; points outside are computed and flagged.", vertical=True
    )
    rest = plots.checked_rows(dataset)
    clock = time.perf_counter()
    plots.friction_of_rows(best, rest)
    each = (time.perf_counter() - clock) / max(len(rest), 1)
    cost = [
        ("CPU time of the solved contacts", duration(float(dataset.frame["seconds_cpu"].sum()))),
        ("time per value of the formula, in arrays", f"{format_number(1e6 * each, 1)} µs"),
        ("coefficients", str(len(best.coefficients) - len(best.dropped))),
    ]
    return Section("Range and cost", [Row([ranges, Table(("cost", "value"), cost, "Cost.")])])


def _data(dataset: Dataset) -> Section:
    frame = plots.checked_rows(dataset)
    counts = dataset.frame["status"].value_counts()
    said = ", ".join(f"{counts[name]} {name}" for name in counts.index)
    ends = ("minimum", "25 %", "median", "75 %", "maximum")
    columns = {name: frame[name].to_numpy(dtype=float) for name in plots.AXES}
    finite = {name: values[np.isfinite(values)] for name, values in columns.items() if np.isfinite(values).any()}
    quantiles = [np.quantile(values, (0.0, 0.25, 0.5, 0.75, 1.0)) for values in finite.values()]
    heads = [Column("quantile"), *(Column(name, digits=3) for name in finite)]
    return Section(
        "Data",
        [
            Text(
                f"{len(dataset.frame)} of {dataset.planned} cases of the plan '{dataset.plan_name}': {said}. "
                "A case is unsettled if an error estimate or the interval of its time mean exceeds the tolerance. "
                "It has a result with a stated error."
            ),
            Table(heads, list(zip(ends, *quantiles, strict=True)), vertical=True),
            Picture(partial(plots.plot_friction, dataset), "Computed friction over the film ratio of the solver."),
        ],
    )


def _comparison(dataset: Dataset, formulas: Sequence[FittedFormula], tried: Iterable[str]) -> Section:
    shares = (Column("inside", of="share", label="in its range"), Column("no value", of="share", label="no value"))
    heads = ("published formula", "mape", "p95", "bias", *shares)
    caption = "Published formulas for the same cases, not fitted. (M): constants partly or wholly unverified."
    return Section(
        "All formulas", [tables.family_table(formulas, tried), Table(heads, _published_rows(dataset), caption)]
    )


def _published_rows(dataset: Dataset) -> list[tuple[object, ...]]:
    frame = plots.checked_rows(dataset)
    mu, table = computed_friction(frame), columns(frame)

    def row(name: str, value: Array, outside: NDArray[np.bool_]) -> tuple[object, ...]:
        defined = np.isfinite(value)
        relative = value[defined] / mu[defined] - 1.0
        if not relative.size:
            return (name, None, None, None, None, 1.0)
        errors = (np.mean(np.abs(relative)), np.quantile(np.abs(relative), 0.95), np.mean(relative))
        return (name, *errors, np.mean(~outside), np.mean(~defined))

    bases = np.array([Oil.load(name).base if name else "mineral" for name in frame["oil"]])
    rows = [row("constant 0.05 (Coleman)", np.full(mu.size, COLEMAN_FRICTION), np.zeros(mu.size, dtype=bool))]
    for published in PUBLISHED.values():
        value, outside = np.full(mu.size, np.nan), np.zeros(mu.size, dtype=bool)
        for base in np.unique(bases):
            here = bases == base
            value[here], outside[here] = published.values({name: v[here] for name, v in table.items()}, str(base))
        rows.append(row(published.label + published.mark, value, outside))
    return rows


def _errors(dataset: Dataset, best: FittedFormula) -> Section:
    caption = "Held-out errors by band of each variable, with the number of cases."
    shown = [tables.check_table(best), _interval(best, dataset)]
    return Section(
        "Errors by region",
        [Picture(partial(plots.plot_bands, best), caption), *shown, Folded("In numbers", [tables.band_table(best)])],
    )


def _residuals(dataset: Dataset, formulas: Sequence[FittedFormula]) -> Section:
    best = formulas[0]
    return Section(
        "Parity and residuals",
        [
            Text(
                "Held-out cases: friction by the same form fitted without the fold of the case, as in the tables of "
                "errors. Grey: best formula for cases excluded from the fit (corners, and results whose error exceeds "
                "mu)."
            ),
            Picture(
                partial(plots.plot_regimes, dataset, formulas),
                "Held-out friction by formula over computed friction, by film ratio. Dashed: deviation of 10 %. "
                "The best formula is on top. Points outside the frame are drawn at its edge.",
            ),
            Picture(
                partial(plots.plot_residuals, dataset, best),
                f"{best.label}: ratio of held-out to computed friction, over every variable. Line: running "
                "median; band: 5 to 95 %. Points outside the frame are drawn at its edge.",
            ),
        ],
    )


def _curves(dataset: Dataset, formulas: Sequence[FittedFormula], oil: str) -> Section:
    middle = plots.middle_conditions(dataset, oil)
    best = formulas[0]
    drawn = "Thick: fitted formulas, the best with its interval. Thin: published formulas, (M) unverified. "
    near = "Dots: computed cases whose other variables deviate by at most 22 % of their range from these conditions."
    blocks: list[Item] = [Text(f"Centre of the data, unless stated otherwise: {middle.description()}.")]
    if middle.ranges["roughness_rms"][0] > 0.0 and (
        plots.varies(middle, "roughness_rms") or plots.varies(middle, "speed_entrainment")
    ):
        caption = (
            "Stribeck curves from slow and rough to fast and smooth: speed and roughness run from 3 to 97 % of the "
            f"cases in opposite directions. {drawn}{near}"
        )
        blocks.append(Picture(partial(plots.plot_stribeck, middle, formulas), caption))
    blocks.append(Picture(partial(plots.plot_traction, middle, formulas), f"Traction curves. {drawn}{near}"))
    if plots.varies(middle, "pressure_hertz") and plots.varies(middle, "speed_entrainment"):
        caption = (
            f"{best.label}: friction over pressure and speed. Dots: computed cases near these conditions, in the same "
            "colours. Hatched: outside the range, or extrapolated."
        )
        blocks.append(Picture(partial(plots.plot_maps, middle, best), caption))
    return Section(f"Curves and maps, {oil}", blocks)


def _formula(best: FittedFormula) -> Section:
    blocks: list[Item] = [Code(best.equation), tables.coefficient_table(best)]
    if network := best.network:
        known = quantities()
        inputs = ", ".join(known[name].label if name in known else name.replace("_", " ") for name in network.variables)
        text = f"X/(1 - X) and F/(1 - X)^1.5 times the exponential of {len(network.members)} networks of two layers of"
        blocks.insert(1, Text(f"{text} {network.units} units in the mean; inputs: {inputs}."))
    return Section("The formula", [Folded(f"Equation and coefficients of {best.label}", blocks)])


def _sensitivity(dataset: Dataset, best: FittedFormula) -> Section:
    if not dataset.oils:
        return Section("Sensitivity", [Text("Not computed: the lubricant has no oil card.")])
    try:
        found = [(oil, formula_sensitivity(best, Oil.load(oil))) for oil in dataset.oils[:_OILS_SHOWN]]
    except InputError as error:
        return Section("Sensitivity", [Text(f"Not computed: {error}")])
    return Section(
        "Sensitivity",
        [
            Text(
                f"Sobol indices of ln µ by {best.label} over the box of the data, {found[0][1].evaluations} "
                "evaluations each; the marks are 90 % intervals. The share of a variable depends on its range."
            ),
            Row([Picture(partial(plots.plot_sensitivity, indices), oil) for oil, indices in found]),
        ],
    )


def _failures(dataset: Dataset, best: FittedFormula) -> Section:
    frame = dataset.frame
    counted = frame.groupby(["status", "reason"]).size().reset_index(name="count").sort_values("count", ascending=False)
    rows = [(r["status"], r["reason"] or None, r["count"]) for r in counted.to_dict("records")]
    blocks: list[Item] = [Table(("status", "reason", "cases"), rows, "Status of the cases.")]
    if best.data.excluded:
        left_out = [(reason, str(count)) for reason, count in best.data.excluded.items()]
        blocks.append(Table(("excluded from the fit", "cases"), left_out))
    failed = frame[frame["status"] == "failed"].sort_values("key")
    if len(failed):
        records = failed.head(3 * _WORST).to_dict("records")
        shown = [(str(r["key"])[:8], str(r["reason"]), *(r[name] for name in _CONDITIONS)) for r in records]
        caption = f"Cases without a result: {len(shown)} of {len(failed)}."
        blocks.append(Table(["case", "reason", *_CONDITION_COLUMNS], shown, caption))
    rest = plots.checked_rows(dataset)
    deviation = plots.friction_of_rows(best, rest) / computed_friction(rest) - 1.0
    # fitted cases only: deviations of the others are mostly errors of the solver
    missed = np.where(rest["key"].isin(fitted_rows(dataset, best)["key"]), np.abs(deviation), -1.0)
    worst = np.argsort(-missed)[:_WORST]
    shown = [
        (str(r["key"])[:8], d, r["friction_coefficient"], r["friction_error"], *(r[name] for name in _CONDITIONS))
        for r, d in zip(rest.iloc[worst].to_dict("records"), deviation[worst], strict=True)
    ]
    header = ("case", Column("deviation", of="relative_error"), "friction_coefficient", "friction_error")
    caption = f"The fitted cases with the largest deviations of {best.label}, with the error stated by the solver."
    blocks.append(Table((*header, *_CONDITION_COLUMNS), shown, caption))
    return Section("Failed cases and largest deviations", blocks)


def _provenance(dataset: Dataset, formulas: Sequence[FittedFormula]) -> Section:
    best = formulas[0]
    rows = [
        ("data", dataset.data_hash),
        ("plan", f"{dataset.plan_name}, {dataset.plan_hash}"),
        ("solver", dataset.solver_version),
        *((f"oil card {identity.name}", identity.card_hash or "–") for identity in best.oils if identity.name),
        ("written by", best.writer),
        ("mixed-ehl", __version__),
        ("Python", platform.python_version()),
        *((library, version(library)) for library in _LIBRARIES),
    ]
    return Section("Versions and hashes", [Table(("item", "value"), rows)])
