"""The friction formula a user holds: fitted, loaded, used, exported, reported; friction models by name."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ehl.common.data import data_names, data_path
from ehl.common.errors import InputError
from ehl.common.pages import Reportable
from ehl.common.quantities import quantity
from ehl.common.sections import Medium, Section
from ehl.common.table import Column, Table
from ehl.common.units import ValueRange
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.friction.conditions import UNITS, Array, Conditions, conditions_of, contact_points
from regression.friction.families import FAMILIES, family_named
from regression.friction.formula import FittedFormula, load_formula
from regression.friction.models import (
    COLEMAN_FRICTION,
    ConstantFriction,
    FrictionEstimate,
    FrictionFlag,
    PointFriction,
    PublishedFriction,
    flags_of,
)
from regression.friction.oil_cards import card_hash, names_card
from regression.friction.published_registry import PUBLISHED

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from regression.data.dataset import Dataset

    Results = Dataset | str | PathLike[str] | Sequence[Dataset | str | PathLike[str]]


@dataclass(frozen=True, repr=False)
class Formula(Reportable, PointFriction):
    """A fitted friction formula: a friction model that knows its errors, its range and where it comes from.

    `regression.fit` makes one from results, `Formula.load` reads one.

    Parameters
    ----------
    formula : FittedFormula
        Equation, coefficients, errors, range: the content of the formula file.
    name : str
        What the user asked for.
    boundary_friction : float, optional
        Of the asperities [-], in place of the one of the data; only families that take it as an input notice.
    refuse : bool
        Refuse points outside the range or extrapolated points, in place of flagging them.
    candidates : tuple of FittedFormula
        All families fitted to the same rows, best first; only this one where it was loaded from a file.
    tried : tuple of str
        Families that `fit` tried; those not among the candidates could not be fitted.
    dataset : Dataset, optional
        What it was fitted to; None where it was loaded from a file.

    Examples
    --------
    >>> import regression
    >>> formula = regression.Formula.load("75w90")
    >>> point = {"pressure_hertz": "1.2 GPa", "radius_equivalent": "15 mm", "speed_entrainment": "5 m/s"}
    >>> formula.mu(**point, slide_to_roll=0.2, temperature="90 degC", roughness_rms="0.4 um")
    mu = 0.01858 (0.01516 to 0.02277), ok
    """

    formula: FittedFormula
    name: str
    boundary_friction: float | None = None
    refuse: bool = False
    candidates: tuple[FittedFormula, ...] = field(default=(), compare=False)
    tried: tuple[str, ...] = field(default=(), compare=False)
    dataset: Dataset | None = field(default=None, compare=False)

    @property
    def uses_texture(self) -> bool:
        """Whether mu depends on the lay of the roughness: the data must hold more than one Peklenik number."""
        return "peklenik_number" in self.formula.ranges

    @classmethod
    def load(
        cls, name: str | PathLike[str], *, boundary_friction: float | None = None, refuse: bool = False
    ) -> Formula:
        """A shipped formula, or the one of a formula file.

        Parameters
        ----------
        name : str or path
            One of ``ehl.shipped("formulas")``, or the path of a file.
        boundary_friction : float, optional
            Of the asperities [-], in place of the one of the data.
        refuse : bool
            Refuse points outside the range or extrapolated points, in place of flagging them.

        Returns
        -------
        Formula

        Raises
        ------
        InputError
            There is no such formula, the file is none, or the family does not take boundary friction as an input.

        Examples
        --------
        >>> from regression import Formula
        >>> Formula.load("75w90").formula.family
        'rough_share'
        """
        if str(name) in shipped_formulas():
            content, shown = load_formula(data_path("formulas", f"{name}.json")), str(name)
        else:
            path = Path(name)
            if path.suffix != ".json" and not os.path.isfile(path):
                raise InputError("friction model", str(name), friction_model_choices(), "Check the name or the path.")
            content, shown = load_formula(path), path.name
        return cls(content, shown).with_options(boundary_friction, refuse=refuse)

    def with_options(self, boundary_friction: float | None = None, *, refuse: bool = False) -> Formula:
        """The same formula with another boundary friction, or one that refuses what lies outside its data.

        Parameters
        ----------
        boundary_friction : float, optional
            Of the asperities [-].
        refuse : bool
            Refuse points outside the range or extrapolated points.

        Returns
        -------
        Formula

        Raises
        ------
        InputError
            The family does not take boundary friction as an input.
        """
        if boundary_friction is not None and self.formula.form.design is not None:
            hint = "Its boundary friction is that of its data."
            allowed = "a family that takes it as an input"
            raise InputError("boundary_friction", boundary_friction, allowed, hint)
        friction = self.boundary_friction if boundary_friction is None else boundary_friction
        return replace(self, boundary_friction=friction, refuse=refuse or self.refuse)

    def evaluate(self, state: ContactState, oil: Oil) -> FrictionEstimate:
        """Friction with the interval of the fit; outside its range and with another oil the largest error seen.

        Parameters
        ----------
        state : ContactState
            Contact points.
        oil : Oil
            Oil card.

        Returns
        -------
        FrictionEstimate

        Raises
        ------
        InputError
            With `refuse`: a point is outside the range or extrapolated.
        """
        return self.at_conditions(conditions_of(state, oil), oil)

    def at_conditions(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
        """`evaluate` where the conditions are known.

        Parameters
        ----------
        conditions : mapping
            `regression.friction.conditions.conditions_of` the contact points.
        oil : Oil
            Oil card.
        """
        value = self.formula.evaluate(conditions, self.boundary_friction)
        if self.refuse and np.any(value.outside | (value.extrapolation > 0)):
            raise self._refused(conditions, value.outside, value.extrapolation > 0)
        oil_flag = self._oil_flag(oil)
        flag = flags_of(oil_flag, value.extrapolation > 0, value.extrapolation > 1, value.outside, value.undefined)
        lower, upper = value.lower, value.upper
        if oil_flag == FrictionFlag.OTHER_OIL:
            width = self.formula.interval.largest
            lower, upper = np.minimum(lower, value.mu * np.exp(-width)), np.maximum(upper, value.mu * np.exp(width))
        return FrictionEstimate(value.mu, lower, upper, np.asarray(flag).astype(np.int8))

    def coefficient(self, state: ContactState, oil: Oil) -> Array:
        """Friction coefficients alone, without interval and flag, in less time than `evaluate` [-].

        Parameters
        ----------
        state : ContactState
            Contact points.
        oil : Oil
            Oil card.
        """
        return self.formula.coefficient(conditions_of(state, oil), self.boundary_friction)

    def default_oil(self) -> str:
        """Name of the oil it was fitted to.

        Raises
        ------
        InputError
            It was fitted to several oils, or to none of a name.
        """
        names = [str(identity.name) for identity in self.formula.oils if identity.name is not None]
        if len(names) == 1:
            return names[0]
        raise InputError("oil", None, "one of " + ", ".join(names or data_names("oils")))

    def ranking(self) -> pd.DataFrame:
        """Held-out errors of all families fitted to the same rows, best first.

        Returns
        -------
        pandas.DataFrame
            One row per family: number of terms, R2 of ln mu and of mu, and the relative errors [-] `mape` (mean),
            `p95` (95 %), `largest` and `bias`.
        """
        from regression.view.tables import family_table

        return family_table(self.candidates or (self.formula,)).to_frame()

    def in_convex_hull(
        self, runs: Results, state: ContactState | None = None, *, oil: Oil | str | None = None, **conditions: Any
    ) -> NDArray[np.bool_]:
        """Whether contact points lie in the convex hull of the fitted cases, in ln of their variables (exact).

        Parameters
        ----------
        runs : Dataset, str or path, or several of them
            The data the formula was fitted to.
        state : ContactState, optional
            Contact points; in their place the keywords of `mu`.
        oil : Oil or str, optional
            Oil card or its name; the one of the formula if not given.
        **conditions : float, str or array
            As of `mu`.

        Returns
        -------
        array of bool

        Raises
        ------
        InputError
            The formula was fitted without a cloud of cases, or to other data.
        """
        from regression.data.dataset import columns
        from regression.fitting.rows import fitted_rows
        from regression.friction.data_cloud import in_convex_hull

        cloud = self.formula.cloud
        if cloud is None:
            raise InputError("hull", self.name, "a formula file of schema 2, fitted with a cloud of cases")
        dataset = _dataset_of(runs)
        if dataset.data_hash != self.formula.data.hash:
            raise InputError("hull", str(runs), f"all the data {self.name} was fitted to", "These are other results.")
        state = contact_points(**conditions) if state is None else state
        name = self.default_oil() if oil is None else oil
        local = conditions_of(state, Oil.load(name) if isinstance(name, str) else name)
        points = cloud.whitened({name: np.ravel(values) for name, values in local.items()})
        cases = cloud.whitened(columns(fitted_rows(dataset, self.formula)))
        return in_convex_hull(points, cases).reshape(np.shape(state.pressure_hertz))

    def save(self, path: str | PathLike[str]) -> None:
        """Write the formula file (JSON).

        Parameters
        ----------
        path : str or path

        Raises
        ------
        InputError
            The file cannot be written.
        """
        self.formula.save(Path(path))

    def export(
        self,
        path: str | PathLike[str],
        language: str | None = None,
        *,
        oil: str | None = None,
        oil_arguments: bool = False,
        guard: bool = True,
    ) -> tuple[str, ...]:
        """Write the formula as program text: Python, C, Fortran, MATLAB, LaTeX, or a spreadsheet.

        Parameters
        ----------
        path : str or path
            File to write; its stem becomes the name of the function.
        language : {"python", "c", "fortran", "matlab", "latex", "spreadsheet"}, optional
            By the suffix of the file if not given: .py, .c, .f90, .m, .tex, .xlsx, .txt.
        oil : str, optional
            Oil card whose laws are written into the code; needed where the formula was fitted to several.
        oil_arguments : bool
            Take the oil's properties as arguments instead.
        guard : bool
            Flag points within the range that lie far from all cases of the fit: a loop over stored numbers, most of
            the text. LaTeX and spreadsheets never do.

        Returns
        -------
        tuple of str
            Names of the arguments of the function.

        Raises
        ------
        InputError
            The language is not known or cannot hold the formula, or the file cannot be written.
        """
        from regression.export.export import export_formula

        program = export_formula(self.formula, Path(path), language, oil=oil, oil_arguments=oil_arguments, guard=guard)
        return tuple(argument.name for argument in program.arguments)

    def sections(self, medium: Medium = "page", dataset: Results | None = None) -> list[Section]:
        """Data, all formulas, errors by region, curves, sensitivity, failures; on a terminal the formula alone.

        Parameters
        ----------
        medium : {"page", "terminal", "files"}
        dataset : Dataset, str or path, or several of them, optional
            The data it was fitted to; a page needs them where the formula was loaded from a file.

        Raises
        ------
        InputError
            The data are missing.
        """
        from regression.view.fit_report import fit_sections, formula_sections

        formulas = self.candidates or (self.formula,)
        if medium == "page":
            return fit_sections(self._data(dataset), formulas, self.tried)
        return formula_sections(formulas, self.tried, self.dataset if dataset is None else self._data(dataset), medium)

    def _plot(self, ax: Axes | None, dataset: Results | None = None) -> Axes:
        from regression.view.plots import plot_parity

        return plot_parity(self._data(dataset), self.candidates or (self.formula,), ax)

    def to_dict(self) -> dict[str, Any]:
        """The content of the formula file.

        Returns
        -------
        dict
            Numbers in SI units, by the names of docs/nomenclature.md.
        """
        return self.formula.to_dict()

    def to_frame(self) -> pd.DataFrame:
        """The coefficients.

        Returns
        -------
        pandas.DataFrame
            One row per term: `term`, `value`, `standard_error`, `variance_inflation`, and in `dropped` why it could not
            be fitted.
        """
        return self._coefficients().to_frame()

    def __repr__(self) -> str:
        v, f = self.formula.validation, self.formula
        oils = ", ".join(str(identity.name) for identity in f.oils if identity.name) or "any oil"
        return (
            f"Formula {self.name}: {f.name} for {oils}, {len(f.coefficients) - len(f.dropped)} terms, "
            f"{f.data.used} contacts\nheld-out error of mu: mean {100.0 * v.mape:.1f} %, 95 % of the cases within "
            f"{100.0 * v.p95:.0f} %, worst {100.0 * v.largest:.0f} %"
        )

    def _repr_html_(self) -> str:
        from regression.view.tables import family_table

        tables = [self._coefficients()]
        if len(self.candidates) > 1:
            tables.insert(0, family_table(self.candidates))
        return "\n".join(table.html() for table in tables)

    def _coefficients(self) -> Table:
        f = self.formula
        rows = [
            (t, f.coefficients[t], f.standard_errors.get(t), f.variance_inflation.get(t), f.dropped.get(t))
            for t in f.form.terms
        ]
        names = ("term", "value", "standard_error", "variance_inflation", "dropped")
        return Table([Column(name, label=name.replace("_", " ")) for name in names], rows, title=repr(self))

    def _data(self, dataset: Results | None) -> Dataset:
        if dataset is not None:
            return _dataset_of(dataset)
        if self.dataset is None:
            hint = "A formula file does not hold its data: name the run it was fitted to."
            raise InputError("dataset", None, "the results the formula was fitted to", hint)
        return self.dataset

    def range_note(self, state: ContactState | None = None, *, oil: Oil | str | None = None, **conditions: Any) -> str:
        """One sentence with every variable that lies outside the range of the data, its value and limit; else empty.

        Parameters
        ----------
        state : ContactState, optional
            One contact point; in its place the keywords of `mu`.
        oil : Oil or str, optional
            Oil card or its name; the one of the formula if not given.
        **conditions : float or str
            As of `mu`.
        """
        state = contact_points(**conditions) if state is None else state
        name = self.default_oil() if oil is None else oil
        local = conditions_of(state, Oil.load(name) if isinstance(name, str) else name)
        parts = []
        for variable, value, limit in self.formula.beyond(local):
            entry, side = quantity(variable), "at least" if value < limit else "at most"
            parts.append(f"{entry.label} {entry.text(value, 3)} ({side} {entry.text(limit, 3)})")
        return (
            f"outside the data of {self.name}: {', '.join(parts)}; the interval is wider by the distance"
            if parts
            else ""
        )

    def oil_note(self, oil: Oil) -> str:
        """One sentence where the formula was fitted to another oil or to another card of it; else empty.

        Parameters
        ----------
        oil : Oil
            Oil card the formula is used with.
        """
        flag = self._oil_flag(oil)
        if flag == FrictionFlag.OTHER_CARD:
            return f"the card of {oil.name} has other figures now than when the data of {self.name} were computed"
        if flag == FrictionFlag.OK:
            return ""
        names = ", ".join(str(identity.name or "a lubricant by numbers") for identity in self.formula.oils)
        return (
            f"friction model {self.name} was fitted to {names}, not to {oil.name}: its interval is at least its "
            f"largest error seen, and nothing says how far {oil.name} differs; fit a formula to it, or use ehl"
        )

    def _oil_flag(self, oil: Oil) -> FrictionFlag:
        if not self.formula.oils:
            return FrictionFlag.OK
        for identity in self.formula.oils:
            if names_card(identity.name, identity.card_hash, oil):
                same = identity.card_hash in (None, card_hash(oil))
                return FrictionFlag.OK if same else FrictionFlag.OTHER_CARD
        return FrictionFlag.OTHER_OIL

    def _refused(
        self, conditions: Conditions, outside: NDArray[np.bool_], extrapolated: NDArray[np.bool_]
    ) -> InputError:
        wrong = outside | extrapolated
        count = f"{int(np.sum(wrong))} of {wrong.size} points"
        for name, (low, high) in self.formula.ranges.items():
            there = np.ravel(conditions[name])[np.ravel(wrong)]
            if there.min() < low or there.max() > high:
                value = float(there.min() if there.min() < low else there.max())
                where = f"{low:.6g} to {high:.6g} {UNITS[name]}".strip()
                return InputError(name, value, where, f"{count} lie outside the data of {self.name}.")
        hint = f"Each variable is within its range, but no case of {self.name} has them together."
        return InputError("conditions", count, "points among the data", hint)


def fit(
    results: Results,
    family: str = "best",
    *,
    gaussian_process: bool = False,
    corners: bool = False,
    nested: bool = False,
    paths: Dataset | str | PathLike[str] | None = None,
    noise: Dataset | str | PathLike[str] | None = None,
) -> Formula:
    """Fit a friction formula to the results of one or more sweeps.

    Parameters
    ----------
    results : Run, Dataset, str or path, or several of them
        Results of a sweep, their folder or file, or the name of a shipped dataset.
    family : str
        A family of formulas (`short`, `rough_share`, `xu`, `power_law`, `regimes`, `load_share`), or ``"best"``: all
        of them, the one with the smallest held-out error of ln mu first.
    gaussian_process : bool
        Correct ln mu by a Gaussian process on what the family leaves.
    corners : bool
        Fit the corner points too, which a plan may have added.
    nested : bool
        Measure what the choice of the family itself costs (minutes); only with ``"best"``.
    paths : Dataset, str or path, optional
        Contacts along gear meshes: checked, not fitted.
    noise : Dataset, str or path, optional
        Points computed with several roughness profiles each, not fitted: the noise floor, and errors against the
        means over the profiles.

    Returns
    -------
    Formula
        With the ranking of all families attached.

    Raises
    ------
    InputError
        Too few usable cases, or there are no such results or no such family.
    ConvergenceError
        A nonlinear fit did not settle.

    Examples
    --------
    >>> import regression
    >>> formula = regression.fit("gear_fva3", "power_law")
    >>> formula.formula.family
    'power_law'
    """
    from regression.fitting.fit import fit_families, fit_formula

    if family != "best":
        family_named(family)
        if nested:
            raise InputError("nested", family, "family 'best'", "One family leaves no choice to hold out.")
    dataset = _dataset_of(results)
    options: dict[str, Any] = {
        "corners": corners,
        "gaussian_process": gaussian_process,
        "paths": None if paths is None else _dataset_of(paths),
        "noise": None if noise is None else _dataset_of(noise),
    }
    if family == "best":
        found = tuple(fit_families(dataset, nested=nested, **options).values())
    else:
        found = (fit_formula(dataset, family, **options),)
    tried = tuple(FAMILIES) if family == "best" else (family,)
    return Formula(found[0], found[0].name, candidates=found, tried=tried, dataset=dataset)


def _dataset_of(results: Results) -> Dataset:
    """Results as one dataset; several are joined. Errors as of `regression.load_dataset`."""
    from regression.data.dataset import Dataset, load_dataset

    return load_dataset(results) if isinstance(results, (Dataset, str, PathLike)) else load_dataset(*results)


def friction_model(spec: str) -> ConstantFriction | PublishedFriction | Formula:
    """The friction model a user names.

    Parameters
    ----------
    spec : str
        ``constant:0.05`` or ``coleman``, which is that one, a name of the registry (``xu_kahraman_2007``), a shipped
        formula, or the path of a formula file; ``strict:`` before the last two refuses points outside the data.

    Returns
    -------
    ConstantFriction, PublishedFriction or Formula
        With `mu` for single points and `evaluate` for contact states.

    Raises
    ------
    InputError
        Nothing of that name exists (the message lists what does), the constant is no number within 0 to 1, or the
        file is no formula.

    Examples
    --------
    >>> import regression
    >>> regression.friction_model("coleman").name
    'constant:0.05'
    """
    kind, colon, value = spec.partition(":")
    if spec == "coleman":
        return ConstantFriction(COLEMAN_FRICTION)
    if kind == "constant":
        try:
            return ConstantFriction(ValueRange("", ge=0.0, le=1.0).check(value, "friction model"))
        except InputError as error:
            raise InputError(
                "friction model", spec, f"constant:VALUE as in constant:0.05, {error.allowed}", error.hint
            ) from None
    if kind == "strict" and colon:
        return replace(Formula.load(value, refuse=True), name=spec)
    if spec in PUBLISHED:
        return PublishedFriction(PUBLISHED[spec])
    return Formula.load(spec)


def published() -> pd.DataFrame:
    """The published friction formulas that can be used by name.

    Returns
    -------
    pandas.DataFrame
        One row per formula: `name` (of `friction_model`), `source`, `certainty` of its digits ("found", "mixed",
        "from memory"), `range` in SI units, `range_certainty`, and how it is `applied` at a contact point.

    Examples
    --------
    >>> import regression
    >>> regression.published().name.iloc[0]
    'xu_kahraman_2007'
    """
    import pandas as pd

    return pd.DataFrame(
        [
            {
                "name": entry.name,
                "source": entry.source,
                "certainty": entry.certainty,
                "range": ", ".join(f"{n} {a:g} to {b:g} {UNITS[n]}".strip() for n, (a, b) in entry.ranges.items()),
                "range_certainty": entry.range_certainty,
                "applied": entry.applied,
            }
            for entry in PUBLISHED.values()
        ]
    )


def shipped_formulas(oil: str | None = None) -> tuple[str, ...]:
    """Names of the fitted formulas that come with the program: all, or those fitted to one oil."""
    names = data_names("formulas", ".json")
    if oil is None:
        return names
    return tuple(
        name for name in names if oil in {o.name for o in load_formula(data_path("formulas", f"{name}.json")).oils}
    )


def friction_model_choices() -> str:
    """What `friction_model` accepts, in words."""
    names = ", ".join((*sorted(PUBLISHED), *shipped_formulas()))
    coleman = f"coleman (constant:{COLEMAN_FRICTION:g})"
    return f"constant:VALUE, {coleman}, one of {names}, or the path of a formula file (.json)"
