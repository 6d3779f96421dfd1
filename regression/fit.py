"""From a dataset to a formula: least squares on ln mu, its errors, and what they are worth.

dataset -> usable rows -> coefficients and their errors -> held-out errors by fold -> errors by region -> formula file
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ehl.errors import ConvergenceError, InputError, MixedEhlError
from regression import __version__
from regression.coefficients import fit_coefficients
from regression.conditions import UNITS, Array
from regression.dataset import Dataset, columns
from regression.families import FAMILIES, Family, family_named
from regression.formula import FORMULA_SCHEMA, DataIdentity, Formula, OilIdentity, Scores
from regression.scores import bands, computed_friction, interval_of, noise_floor, scores

FOLDS = 10
LARGEST_ERROR = 0.1  # a case whose own relative error is larger says too little about mu to be fitted
_CELLS = 4  # cells per axis of the (p, R) groups


def fit_formula(dataset: Dataset, family_name: str = "xu", *, corners: bool = False) -> Formula:
    """Fit one family of formulas to a dataset.

    The same data give bit-identical coefficients on one machine and build: rows are sorted by key and one thread
    computes.

    Parameters
    ----------
    dataset : Dataset
        As of `load_dataset`.
    family_name : str
        A name of `regression.families.FAMILIES`.
    corners : bool
        Fit the corner points too, which a plan may have added.

    Raises
    ------
    InputError
        Too few usable cases, more than one boundary friction, or no such family.
    ConvergenceError
        The nonlinear fit did not settle.
    """
    from threadpoolctl import threadpool_limits

    family = family_named(family_name)
    frame, excluded = usable_rows(dataset, corners=corners)
    boundary = np.unique(frame["boundary_friction"])
    if boundary.size > 1:
        raise InputError("boundary_friction", boundary.tolist(), "one value for all cases of a fit")
    if len(frame) < 2 * len(family.terms):
        reasons = ", ".join(f"{count} {reason}" for reason, count in excluded.items()) or "none excluded"
        needed = f"at least {2 * len(family.terms)} usable cases for family {family.name}"
        raise InputError("run", f"{len(frame)} usable cases", needed, f"Excluded: {reasons}.")
    mu_b = float(boundary[0])
    with threadpool_limits(1):
        fitted = fit_coefficients(family, frame, mu_b)
        held_out, folds = cross_validate(family, frame, mu_b)
    table = columns(frame)
    within = np.exp(family.log_mu(table, fitted.values, mu_b))
    error = np.abs(np.log(held_out / computed_friction(frame)))
    return Formula(
        schema_version=FORMULA_SCHEMA,
        writer=f"mixed-ehl {__version__}",
        family=family.name,
        equation=family.equation,
        coefficients=fitted.values,
        standard_errors=fitted.standard_errors,
        dropped=fitted.dropped,
        variance_inflation=fitted.variance_inflation,
        condition_number=fitted.condition_number,
        boundary_friction=mu_b,
        ranges={name: (float(frame[name].min()), float(frame[name].max())) for name in family.box},
        units={name: UNITS[name] for name in family.box},
        oil=OilIdentity(name=dataset.oil or None, card_hash=dataset.oil_hash or None),
        fit=scores(frame, within),
        validation=scores(frame, held_out),
        corners=None if corners else corner_scores(dataset, family, fitted.values, mu_b),
        folds=folds,
        bands=bands(frame, held_out),
        interval=interval_of(frame, error, fold_numbers(frame)),
        noise_floor=noise_floor(frame),
        data=DataIdentity(
            hash=dataset.data_hash,
            plan=dataset.plan_name,
            plan_hash=dataset.plan_hash,
            solver_version=dataset.solver_version,
            count=len(dataset.frame),
            used=len(frame),
            excluded=excluded,
        ),
    )


def fit_families(dataset: Dataset, *, corners: bool = False) -> dict[str, Formula]:
    """Every family fitted to the same rows, best first: smallest RMS of the held-out error of ln mu.

    A family that these data cannot fit is left out.

    Raises
    ------
    InputError, ConvergenceError
        As `fit_formula`, where no family can be fitted.
    """
    fitted: dict[str, Formula] = {}
    refused: dict[str, MixedEhlError] = {}
    for name in FAMILIES:
        try:
            fitted[name] = fit_formula(dataset, name, corners=corners)
        except (InputError, ConvergenceError) as error:
            refused[name] = error
    if not fitted:
        # the family that asks for the least says best what the data lack
        raise refused[min(refused, key=lambda name: len(FAMILIES[name].terms))]
    return dict(sorted(fitted.items(), key=lambda item: -item[1].validation.r2_log))


def usable_rows(dataset: Dataset, *, corners: bool) -> tuple[pd.DataFrame, dict[str, int]]:
    """Rows ln mu can be fitted to, and how many were left out for which reason."""
    frame = dataset.frame
    mu = frame["friction_coefficient"]
    reasons = pd.Series("", index=frame.index, dtype=object)
    reasons[frame["slide_to_roll_total"] <= 0.0] = "no sliding"
    reasons[~(mu > 0.0)] = "friction not positive"
    reasons[frame["friction_error"] > LARGEST_ERROR] = f"friction error above {100.0 * LARGEST_ERROR:.0f} %"
    if not corners:
        reasons[frame["origin"] == "corner"] = "corner kept for checking"
    failed = frame["status"] == "failed"
    reasons[failed] = "failed: " + frame.loc[failed, "reason"].astype(object)
    left_out = reasons[reasons != ""].value_counts().sort_index()
    excluded = {str(reason): int(count) for reason, count in left_out.items()}
    return frame[reasons == ""].reset_index(drop=True), excluded


def cell_groups(frame: pd.DataFrame) -> NDArray[np.int64]:
    """Group of every row: its cell of a 4 x 4 grid in pressure and radius (logarithm) over their ranges."""
    groups = np.zeros(len(frame), dtype=np.int64)
    for values in (frame["pressure_hertz"].to_numpy(), np.log(frame["radius_equivalent"].to_numpy())):
        low, width = values.min(), np.ptp(values)
        cell = (values - low) / width * _CELLS if width > 1e-9 * abs(low) else np.zeros(len(values))
        groups = groups * _CELLS + np.minimum(cell.astype(np.int64), _CELLS - 1)
    return groups


def fold_numbers(frame: pd.DataFrame) -> NDArray[np.int64]:
    """Fold of every row: whole (p, R) cells are held out together; fewer than two cells fall back to rows in turn."""
    from sklearn.model_selection import GroupKFold

    groups = cell_groups(frame)
    count = min(FOLDS, np.unique(groups).size)
    if count < 2:
        return np.arange(len(frame)) % min(FOLDS, len(frame))
    folds = np.zeros(len(frame), dtype=np.int64)
    for number, (_, held) in enumerate(GroupKFold(count).split(groups, groups=groups)):
        folds[held] = number
    return folds


def cross_validate(family: Family, frame: pd.DataFrame, boundary_friction: float) -> tuple[Array, int]:
    """Friction of every row by a formula fitted without its fold, and the number of folds."""
    folds = fold_numbers(frame)
    predicted = np.empty(len(frame))
    for number in np.unique(folds):
        held = folds == number
        fitted = fit_coefficients(family, frame[~held].reset_index(drop=True), boundary_friction)
        predicted[held] = np.exp(family.log_mu(columns(frame[held]), fitted.values, boundary_friction))
    return predicted, int(np.unique(folds).size)


def corner_scores(
    dataset: Dataset, family: Family, coefficients: Mapping[str, float], boundary_friction: float
) -> Scores | None:
    """Errors at the corners of the box, which were not fitted; None where the plan has none that can be used."""
    frame = dataset.frame
    usable = (frame["origin"] == "corner") & (frame["status"] != "failed") & (frame["friction_coefficient"] > 0.0)
    frame = frame[usable & (frame["slide_to_roll_total"] > 0.0)].reset_index(drop=True)
    if frame.empty:
        return None
    return scores(frame, np.exp(family.log_mu(columns(frame), coefficients, boundary_friction)))
