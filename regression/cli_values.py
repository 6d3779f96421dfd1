"""Values typed on the command line of `mixed-ehl mu`: with their units, checked like those of a case file."""

from __future__ import annotations

from typing import get_args

from ehl import inputs
from ehl._data import data_names
from ehl.errors import InputError
from ehl.oil import Temperature
from ehl.units import Quantity
from regression.friction_models import FormulaFriction, FrictionModel

# variable -> option, and its unit with range; in the order of the options
POINT: dict[str, tuple[str, Quantity]] = {
    name: (option, next(part for part in get_args(annotation) if isinstance(part, Quantity)))
    for name, option, annotation in (
        ("pressure_hertz", "--pressure", inputs.Pressure),
        ("radius_equivalent", "--radius", inputs.Radius),
        ("speed_entrainment", "--speed", inputs.Speed),
        ("slide_to_roll", "--slide-to-roll", inputs.SlideToRoll),
        ("temperature_oil", "--temperature", Temperature),
        ("roughness_rms", "--roughness", inputs.Rms),
        ("speed_sliding_lengthwise", "--lengthwise", inputs.SlidingSpeed),
    )
}


def check_point(texts: dict[str, str]) -> dict[str, float]:
    """SI numbers of one contact point.

    Raises
    ------
    InputError
        A value has no unit, the wrong one, or is out of range.
    """
    return {name: POINT[name][1].check(text, POINT[name][0], bare=False) for name, text in texts.items()}


def oil_of(friction: FrictionModel, given: str | None) -> str:
    """The oil to use: the one given, or the one the formula was fitted to.

    Raises
    ------
    InputError
        None was given and the model names none.
    """
    if given is not None:
        return given
    if isinstance(friction, FormulaFriction) and friction.formula.oil.name is not None:
        return friction.formula.oil.name
    raise InputError("--oil", None, "one of " + ", ".join(data_names("oils")))
