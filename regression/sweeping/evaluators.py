"""What a sweep evaluates: one case in, one row of results out; and the settings tried after a failure."""

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

# the case itself is at fault, or the formula has no value there: no setting helps
FINAL_REASONS = frozenset({"too_hot", "shear_strength", "undefined"})
_ACCURACIES: tuple[str, ...] = get_args(Accuracy)


def case_numbers(case: Contact) -> dict[str, Any]:
    """Every input of a case that has a value, by its name, as ``surface.seed``; rows of journals hold them."""
    return dict(_values(case, ""))


def _values(model: BaseModel, prefix: str) -> Iterator[tuple[str, Any]]:
    for name in type(model).model_fields:
        value = getattr(model, name)
        if isinstance(value, BaseModel):
            yield from _values(value, f"{prefix}{name}.")
        elif value is not None:
            yield prefix + name, value


def case_key(case: Contact, version: str) -> str:
    """Key of a case: digest of the version of the solver and of `case_numbers`, the seed among them."""
    return hashlib.sha256(repr((version, *case_numbers(case).items())).encode()).hexdigest()


def input_row(case: Contact) -> dict[str, float | str]:
    """What the dataset stores of a case in addition to the results: its inputs, and the name of its oil card."""
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

    Raises `ConvergenceError`: with the solver's reason.
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
    """Friction by a formula of the registry: a sweep of milliseconds, to try a plan and to test the fit.

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
    """The case with the settings tried after so many failures, and what was changed; None where none is left.

    A finer mesh comes first, then the solution without shortcuts.

    case: as planned.
    step: 0 is the case itself; each further step takes the next accuracy, the last one switches the shortcuts off.
    """
    if step == 0:
        return case, ""
    level = _ACCURACIES.index(case.model.accuracy)
    finer = min(level + step, len(_ACCURACIES) - 1)
    changes: dict[str, object] = {}
    if finer > level:
        # a tolerance of its own would decide on the mesh in place of the accuracy
        changes |= {"accuracy": _ACCURACIES[finer], "friction_tolerance": None}
    beyond = step - (finer - level)
    if beyond == 1 and case.model.shortcuts != "off":
        changes["shortcuts"] = "off"
    elif beyond > 0:
        return None
    changed = " ".join(f"{name}={value}" for name, value in changes.items() if value is not None)
    return case.model_copy(update={"model": case.model.model_copy(update=changes)}), changed
