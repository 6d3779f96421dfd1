"""`Formula`: fit, evaluation, export and report of a friction formula; friction models by name."""

from __future__ import annotations

import json
import logging
import os
import re
from dataclasses import dataclass
from functools import cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray
from pydantic import PrivateAttr

from ehl.common.data import data_names, data_path
from ehl.common.errors import InputError, check_choice, same_name
from ehl.common.files import write_file
from ehl.common.pages import Reportable
from ehl.common.progress import duration, report_progress
from ehl.common.runner import checked_jobs
from ehl.common.sections import Medium, Section
from ehl.common.threads import one_thread
from ehl.common.units import ValueRange
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.friction.conditions import UNITS, PointConditions, conditions_of
from regression.friction.families import FAMILIES
from regression.friction.fitted import NETWORK, FittedFormula
from regression.friction.models import COLEMAN_FRICTION, ConstantFriction
from regression.friction.published_registry import PUBLISHED, PublishedFriction

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from regression.data.dataset import Dataset
    from regression.fitting.rows import Results

_LOG = logging.getLogger("mixed_ehl")
ANY_OIL = "gear"  # the shipped formula of all shipped oils, for oils without their own


@dataclass(frozen=True, eq=False)
class FitRecord:
    """Data of a fit for its report: families fitted to the same rows, best first, and the dataset."""

    candidates: tuple[FittedFormula, ...]
    tried: tuple[str, ...]
    dataset: Dataset


class Formula(FittedFormula, Reportable):
    """A fitted friction formula with its errors, range and origin: the content of a formula file.

    `regression.fit` fits a formula to results, `Formula.load` reads one.

    Examples
    --------
    >>> import regression
    >>> formula = regression.Formula.load("75w90")
    >>> point = {"pressure_hertz": "1.2 GPa", "radius_equivalent": "15 mm", "speed_entrainment": "5 m/s"}
    >>> formula.mu(**point, slide_to_roll=0.2, temperature="90 degC", roughness_rms="0.4 um")
    mu = 0.04677 (0.04459 to 0.04905), ok
    """

    _record: FitRecord | None = PrivateAttr(None)

    @classmethod
    def of(cls, fitted: FittedFormula, record: FitRecord) -> Formula:
        """A fitted formula with the data for its report."""
        formula = cls.model_construct(**{name: getattr(fitted, name) for name in cls.model_fields})
        formula._record = record
        return formula

    @property
    def candidates(self) -> tuple[FittedFormula, ...]:
        """All families fitted to the same rows, best first; only this formula if it was loaded from a file."""
        return (self,) if self._record is None else self._record.candidates

    def ranking(self) -> pd.DataFrame:
        """Held-out errors of all families fitted to the same rows, best first.

        One row per family: number of terms, R2 of ln mu and of mu, and the relative errors [-] `mape` (mean), `p95`
        (95 %), `largest` and `bias`.
        """
        from regression.view.tables import family_table

        return family_table(self.candidates).to_frame()

    def in_convex_hull(
        self,
        runs: Results,
        state: ContactState | None = None,
        *,
        oil: Oil | str | None = None,
        **conditions: Unpack[PointConditions],
    ) -> NDArray[np.bool_]:
        """Whether contact points, as in `mu`, lie in the convex hull of the fitted cases (logarithms).

        Parameters
        ----------
        runs : Dataset, str or path, or several of them
            The fitted data.

        Raises
        ------
        InputError
            The formula has no stored range of cases, or was fitted to other data.
        """
        from regression.data.dataset import columns
        from regression.fitting.rows import dataset_of, fitted_rows
        from regression.friction.data_cloud import in_convex_hull

        cloud = self.cloud
        if cloud is None:
            raise InputError("hull", self.name, "a formula fitted to data in which at least two variables vary")
        dataset = dataset_of(runs)
        if dataset.data_hash != self.data.hash:
            raise InputError("hull", str(runs), f"all fitted data of {self.name}", "These are other results.")
        state, card = self._points(state, oil, conditions)
        local = conditions_of(state, card)
        points = cloud.whitened({name: np.ravel(values) for name, values in local.items()})
        cases = cloud.whitened(columns(fitted_rows(dataset, self)))
        return in_convex_hull(points, cases).reshape(np.shape(state.pressure_hertz))

    def export(
        self,
        path: str | PathLike[str],
        language: str | None = None,
        *,
        oil: str | None = None,
        oil_arguments: bool = False,
        guard: bool = True,
    ) -> tuple[str, ...]:
        """Write the formula as Python, C, Fortran, MATLAB or FMU (FMI 2.0); returns the names of its arguments.

        Parameters
        ----------
        path : str or path
            File to write; its stem becomes the name of the function.
        language : {"python", "c", "fortran", "matlab", "fmu"}, optional
            Default: by the suffix of the file (.py, .c, .f90, .m, .fmu).
        oil : str, optional
            Oil card whose laws are written into the code; required for a formula of several oils.
        oil_arguments : bool
            Use the oil properties as arguments instead.
        guard : bool
            Flag points far from all fitted cases; this needs a loop over stored numbers.

        Raises
        ------
        InputError
            The language is unknown, the name is no identifier, or the file cannot be written.
        """
        from regression.export.export import identifier, writer_of
        from regression.export.program import program_of

        path = Path(path)
        text = writer_of(path, language)
        if oil is not None and oil_arguments:
            raise InputError("oil", oil, "no oil if its properties are arguments")
        name = identifier(path)
        program = program_of(self, oil=oil, oil_arguments=oil_arguments, guard=guard)
        write_file(path, text(program, name))
        return program.arguments

    def sections(self, medium: Medium = "page", dataset: Results | None = None) -> list[Section]:
        """Data, formulas, errors by region, curves, sensitivity and failures; the formula only for a terminal.

        Parameters
        ----------
        medium : {"page", "terminal", "files"}
        dataset : Dataset, str or path, or several of them, optional
            The fitted data; required for a page of a formula that was loaded from a file.

        Raises
        ------
        InputError
            The data are missing.
        """
        from regression.view.fit_report import fit_sections, formula_sections

        record = self._record if dataset is None and medium != "page" else self._fitted(dataset)
        if medium == "page" and record is not None:
            return fit_sections(record.dataset, record.candidates, record.tried)
        tried, data = ((), None) if record is None else (record.tried, record.dataset)
        return formula_sections(self.candidates, tried, data, medium)

    def _plot(self, ax: Axes | None, **options: Any) -> Axes:
        from regression.view.plots import plot_parity

        fitted = self._fitted(options.get("dataset"))
        return plot_parity(fitted.dataset, fitted.candidates, ax)

    def to_frame(self) -> pd.DataFrame:
        """One row per term: `term`, `value`, `standard_error`, `variance_inflation`, `dropped`."""
        import pandas as pd

        others = (self.standard_errors, self.variance_inflation, self.dropped)
        rows = [(term, self.coefficients[term], *(values.get(term) for values in others)) for term in self.form.terms]
        return pd.DataFrame(rows, columns=["term", "value", "standard_error", "variance_inflation", "dropped"])

    def __repr__(self) -> str:
        v, terms = self.validation, len(self.coefficients) - len(self.dropped)
        oils = ", ".join(str(identity.name) for identity in self.oils if identity.name) or "any oil"
        return (
            f"Formula {self.name}: {self.label} for {oils}, {terms} terms, "
            f"{self.data.used} contacts\nheld-out error of mu: mean {100.0 * v.mape:.1f} %, 95 % of the cases within "
            f"{100.0 * v.p95:.0f} %, worst {100.0 * v.largest:.0f} %"
        )

    __str__ = __repr__

    def _repr_html_(self) -> str:
        from regression.view.tables import coefficient_table, family_table

        ranking = [family_table(self.candidates)] if len(self.candidates) > 1 else []
        return "\n".join(table.html() for table in (*ranking, coefficient_table(self, repr(self))))

    def _fitted(self, dataset: Results | None) -> FitRecord:
        """Families and their fitted data."""
        if dataset is None:
            if self._record is None:
                hint = "A formula file does not contain its data."
                raise InputError("dataset", None, "the fitted results of the formula", hint)
            return self._record
        from regression.fitting.rows import dataset_of

        tried = () if self._record is None else self._record.tried
        return FitRecord(self.candidates, tried, dataset_of(dataset))


@one_thread
def fit(
    results: Results,
    family: str = "best",
    *,
    corners: bool = False,
    nested: bool = False,
    paths: Results | None = None,
    noise: Results | None = None,
    oil: str | None = None,
    jobs: int | None = None,
) -> Formula:
    """Fit a friction formula to the results of one or more sweeps.

    Parameters
    ----------
    results : Run, Dataset, str or path, or several of them
        Results of a sweep, their folder or file, or the name of a shipped dataset.
    family : str
        A family of formulas (`short`, `xu`, `power_law`, `regimes`); ``"network"``: `short` with neural networks for
        its parts; or ``"best"``: the one with the smallest mean held-out error of mu.
    corners : bool
        Include the corner points of the plan.
    nested : bool
        Include the choice of the family in the cross-validation (minutes); with ``"best"`` only.
    paths : Run, Dataset, str or path, or several of them, optional
        Contacts along gear meshes for validation.
    noise : Run, Dataset, str or path, or several of them, optional
        Points with several roughness profiles each for the noise floor and the errors of the means over the profiles;
        they are not fitted.
    oil : str, optional
        The oil of coefficients, errors, range and interval, if the data have several; networks are trained on the
        contacts of all and tuned to those of this oil. A further oil is best fitted together with the shipped datasets.
    jobs : int, optional
        Worker processes that train the networks, if that takes long; default: all processors.

    Returns
    -------
    Formula
        The formula, with the ranking of all families.

    Raises
    ------
    InputError
        There are too few usable cases, or no such results or family.
    ConvergenceError
        A nonlinear fit did not converge.

    Examples
    --------
    >>> import regression
    >>> formula = regression.fit("gear_fva3", "power_law")
    >>> formula.family
    'power_law'
    """
    from regression.fitting.fit import expected_seconds, fit_families, fit_formula
    from regression.fitting.rows import MAX_POINTS, dataset_of

    check_choice("family", family, ("best", NETWORK, *FAMILIES))
    if family != "best" and nested:
        raise InputError("nested", family, "family 'best'", "nested concerns the choice between families.")
    dataset, tried = dataset_of(results), (*FAMILIES, NETWORK) if family == "best" else (family,)
    seconds = expected_seconds(tried, min(len(dataset), MAX_POINTS))
    _LOG.info("fit of %d contacts: about %s of processor time", len(dataset), duration(seconds))
    checks: Any = {
        "paths": None if paths is None else dataset_of(paths),
        "noise": None if noise is None else dataset_of(noise),
        "oil": oil,
        "jobs": None if jobs is None else checked_jobs(jobs),
    }
    if family == "best":
        found = fit_families(dataset, corners=corners, nested=nested, **checks)
    else:
        report_progress("formulas", 0, 1, seconds)
        found = (fit_formula(dataset, family, corners=corners, **checks),)
    return Formula.of(found[0], FitRecord(found, tried, dataset))


def friction_model(spec: str) -> ConstantFriction | PublishedFriction | Formula:
    """A friction model by name.

    Parameters
    ----------
    spec : str
        ``constant:0.05``, which is also ``coleman``; a name of the registry (``xu_kahraman_2007``); a shipped formula;
        or the path of a formula file. The prefix ``strict:`` of the last two rejects points outside the data.

    Returns
    -------
    ConstantFriction, PublishedFriction or Formula
        Model with `mu` for single points and `evaluate` for contact states.

    Raises
    ------
    InputError
        There is no such model (the message lists the available ones), the constant is not within 0 to 1, or the file is
        no formula file.

    Examples
    --------
    >>> import regression
    >>> regression.friction_model("coleman").name
    'constant:0.05'
    """
    spec = same_name(str(spec), ("coleman", *PUBLISHED))
    kind, colon, value = spec.partition(":")
    kind = kind.casefold() if colon else kind
    if re.fullmatch(r"[\d.,]+", spec):
        hint = f"Did you mean 'constant:{spec.replace(',', '.')}'?"
        raise InputError("friction model", spec, friction_model_choices(), hint)
    if spec == "coleman":
        return ConstantFriction(COLEMAN_FRICTION)
    if kind == "constant":
        try:
            return ConstantFriction(ValueRange("", ge=0.0, le=1.0).check(value, "friction model"))
        except InputError as error:
            allowed = f"constant:VALUE as in constant:0.05, {error.allowed}"
            raise InputError("friction model", spec, allowed, error.hint) from None
    if kind == "strict" and colon:
        return _formula(value).with_options(refuse=True, name=spec)
    return PUBLISHED[spec] if spec in PUBLISHED else _formula(spec)


def _formula(name: str) -> Formula:
    try:
        return Formula.load(name)
    except InputError as error:
        if error.field != "formula" and (name.endswith(".json") or os.path.exists(name)):
            raise
        raise InputError("friction model", name, friction_model_choices(), error.hint) from None


def published() -> pd.DataFrame:
    """The published friction formulas that are available by name.

    Returns
    -------
    pandas.DataFrame
        One row per formula: `name` (for `friction_model`), `source`, `certainty` of its coefficients ("published",
        "mixed", "unverified"), `range` in SI units, `range_certainty`, and its application at a point (`applied`).

    Examples
    --------
    >>> import regression
    >>> regression.published().name.iloc[0]
    'xu_kahraman_2007'
    """
    import pandas as pd

    def spans(entry: PublishedFriction) -> str:
        return ", ".join(f"{n} {low:g} to {high:g} {UNITS[n]}".strip() for n, (low, high) in entry.ranges.items())

    rows = [
        (entry.name, entry.source, entry.certainty, spans(entry), entry.range_certainty, entry.applied)
        for entry in PUBLISHED.values()
    ]
    return pd.DataFrame(rows, columns=["name", "source", "certainty", "range", "range_certainty", "applied"])


def shipped_formulas(oil: str | None = None) -> tuple[str, ...]:
    """Names of the shipped fitted formulas: all, or those of one oil only."""
    names = data_names("formulas", ".json")
    return names if oil is None else tuple(name for name in names if _oils_of_formula(name) == {oil})


@cache
def _oils_of_formula(name: str) -> set[str]:
    """Names of the oils of a shipped formula."""
    content = json.loads(data_path("formulas", f"{name}.json").read_text(encoding="utf-8"))
    return {oil["name"] for oil in content["oils"]}


def friction_model_choices() -> str:
    """Description of the arguments of `friction_model`."""
    names = ", ".join((*sorted(PUBLISHED), *shipped_formulas()))
    coleman = f"coleman (constant:{COLEMAN_FRICTION:g})"
    return f"constant:VALUE, {coleman}, one of {names}, or the path of a formula file (.json)"
