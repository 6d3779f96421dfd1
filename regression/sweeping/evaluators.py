"""Evaluation of one case of a sweep to a row of results; settings that are tried after a failure."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any, get_args

import numpy as np
from pydantic import BaseModel

from ehl.common.errors import ConvergenceError
from ehl.contact import Contact
from ehl.fluid.lubricant_inputs import OilLubricant
from ehl.inputs import Accuracy
from regression.data.row_format import OUTPUT_UNITS, SURFACE_UNITS
from regression.friction.conditions import UNITS, derive, lubricant_row
from regression.friction.published_registry import PUBLISHED

Outputs = Mapping[str, float | str]
Evaluator = Callable[[Contact], Outputs]

# reasons in the case itself or in the formula, which no other setting can change
FINAL_REASONS = frozenset({"too_hot", "shear_strength", "undefined"})
_ACCURACIES: tuple[str, ...] = get_args(Accuracy)


def case_numbers(case: Contact) -> dict[str, Any]:
    """Every input of a case that has a value, by its full name such as ``surface.seed``, as stored in journals."""
    return dict(_values(case, ""))


def _values(model: BaseModel, prefix: str) -> Iterator[tuple[str, Any]]:
    for name in type(model).model_fields:
        value = getattr(model, name)
        if isinstance(value, BaseModel):
            yield from _values(value, f"{prefix}{name}.")
        elif value is not None:
            yield prefix + name, value


def case_key(case: Contact, version: str) -> str:
    """Key of a case: digest of the version of the solver and of `case_numbers`."""
    return hashlib.sha256(repr((version, *case_numbers(case).items())).encode()).hexdigest()


def input_row(case: Contact) -> dict[str, float | str]:
    """Inputs of a case as stored in a dataset, and the name of its oil card."""
    contact = case.line_contact()
    lubricant = case.lubricant.lubricant()
    return {
        "pressure_hertz": contact.pressure_hertz,
        "radius_equivalent": contact.radius_equivalent,
        "effective_modulus": contact.effective_modulus,
        "speed_entrainment": contact.speed_entrainment,
        "slide_to_roll": contact.slide_to_roll,
        "speed_sliding_lengthwise": contact.speed_sliding_lengthwise,
        "temperature_oil": case.lubricant.temperature_oil,
        "roughness_rms_1": case.surface.roughness_rms_1,
        "roughness_rms_2": case.surface.roughness_rms_2,
        **{name: float(getattr(case.surface, name)) for name in SURFACE_UNITS},
        **lubricant_row(lubricant, contact.pressure_hertz),
        "oil": case.lubricant.oil if isinstance(case.lubricant, OilLubricant) else "",
    }


def solve_outputs(case: Contact) -> Outputs:
    """Results of the contact solver, with its status (converged, unsettled) and reason.

    Raises `ConvergenceError`: with the reason of the solver.
    """
    result = case.solve()
    if result.status == "failed":
        raise ConvergenceError(result.reason)
    values: dict[str, float | str] = {name: float(getattr(result, name, np.nan)) for name in OUTPUT_UNITS}
    if result.transient is not None:
        run = result.transient
        values |= {"boundary_film": run.boundary_film, "nodes": run.nodes, "steps": run.steps}
        values["travel"] = run.travel * case.line_contact().half_width
    skipped = "; ".join(dict.fromkeys(text.partition(":")[0] for text in result.skipped))
    return values | {"status": result.status, "reason": result.reason, "skipped": skipped}


def published_outputs(case: Contact, name: str) -> Outputs:
    """Friction by a published formula, for fast trials of plans and fits.

    Raises `ConvergenceError`: the formula has no positive value for this case.
    """
    columns = derive({key: np.array([value]) for key, value in input_row(case).items() if key in UNITS})
    base = "mineral"
    if isinstance(case.lubricant, OilLubricant):
        from ehl.fluid.oil import Oil

        base = Oil.load(case.lubricant.oil).base
    mu, _ = PUBLISHED[name].values(columns, base)
    if np.isnan(mu[0]):
        raise ConvergenceError("undefined")
    return {"friction_coefficient": float(mu[0]), "film_ratio": float(columns["film_ratio_formula"][0])}


def fallback_settings(case: Contact, step: int) -> tuple[Contact, str] | None:
    """The case with the settings after `step` failures, and the changes in words; None if no settings are left.

    Each step uses the next finer accuracy; the last step switches the shortcuts off.
    """
    if step == 0:
        return case, ""
    level = _ACCURACIES.index(case.model.accuracy)
    finer = min(level + step, len(_ACCURACIES) - 1)
    changes: dict[str, object] = {}
    if finer > level:
        # a friction tolerance would override the mesh of the accuracy
        changes |= {"accuracy": _ACCURACIES[finer], "friction_tolerance": None}
    beyond = step - (finer - level)
    if beyond == 1 and case.model.shortcuts != "off":
        changes["shortcuts"] = "off"
    elif beyond > 0:
        return None
    changed = " ".join(f"{name}={value}" for name, value in changes.items() if value is not None)
    return case.model_copy(update={"model": case.model.model_copy(update=changes)}), changed
