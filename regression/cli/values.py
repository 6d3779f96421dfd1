"""Values typed on the command line of `mixed-ehl mu`: with their units, checked like those of a case file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np

from ehl import inputs
from ehl.fluid.oil import Oil, Temperature
from ehl.io.data import data_names
from ehl.io.errors import InputError
from ehl.io.units import ValueRange
from ehl.state import ContactState
from regression.data.dataset import columns, load_dataset
from regression.fitting.rows import usable_rows
from regression.formula import Formula
from regression.friction.conditions import conditions_of
from regression.friction.data_cloud import in_convex_hull
from regression.friction.models import FrictionModel

# variable -> option, and its unit with range; in the order of the options
POINT: dict[str, tuple[str, ValueRange]] = {
    name: (option, next(part for part in get_args(annotation) if isinstance(part, ValueRange)))
    for name, option, annotation in (
        ("pressure_hertz", "--pressure", inputs.Pressure),
        ("radius_equivalent", "--radius", inputs.Radius),
        ("speed_entrainment", "--speed", inputs.Speed),
        ("slide_to_roll", "--slide-to-roll", inputs.SlideToRoll),
        ("temperature_oil", "--temperature", Temperature),
        ("roughness_rms", "--roughness", inputs.Rms),
        ("speed_sliding_lengthwise", "--lengthwise", inputs.SlidingSpeed),
        ("correlation_length", "--correlation-length", inputs.Length),
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
    if isinstance(friction, Formula) and friction.formula.oil.name is not None:
        return friction.formula.oil.name
    if isinstance(friction, Formula) and friction.formula.oils:
        raise InputError(
            "--oil", None, "one of the formula's: " + ", ".join(str(o.name) for o in friction.formula.oils)
        )
    raise InputError("--oil", None, "one of " + ", ".join(data_names("oils")))


def with_options(friction: FrictionModel, boundary_friction: float | None, refuse: bool) -> FrictionModel:
    """A fitted formula with another boundary friction, or one that refuses points outside its data.

    Raises
    ------
    InputError
        Another kind of model was given either option, or the family does not take boundary friction as an input.
    """
    if boundary_friction is None and not refuse:
        return friction
    if not isinstance(friction, Formula):
        option = "--refuse" if boundary_friction is None else "--boundary-friction"
        raise InputError(option, friction.name, "a fitted formula: a formula file, or a shipped one")
    if boundary_friction is not None and friction.formula.form.design is not None:
        hint = "Its boundary friction is that of its data."
        raise InputError("--boundary-friction", boundary_friction, "a family that takes it as an input", hint)
    return replace(friction, boundary_friction=boundary_friction, refuse=refuse or friction.refuse)


def in_hull_of(friction: FrictionModel, runs: Sequence[Path], state: ContactState, oil: Oil) -> bool:
    """Whether a contact point lies in the convex hull of the cases a formula was fitted to, in ln of its variables.

    Raises
    ------
    InputError
        The model is no fitted formula with a cloud, or the runs are not those of its data.
    """
    if not isinstance(friction, Formula) or friction.formula.cloud is None:
        raise InputError("--hull", friction.name, "a formula file of schema 2, fitted with a cloud of cases")
    dataset = load_dataset(*runs)
    if dataset.data_hash != friction.formula.data.hash:
        given, allowed = ", ".join(map(str, runs)), f"all the data {friction.name} was fitted to"
        raise InputError("--hull", given, allowed, "These are other results.")
    frame, _ = usable_rows(dataset, corners=friction.formula.corners is None)
    cloud = friction.formula.cloud
    point = cloud.whitened({name: np.ravel(values) for name, values in conditions_of(state, oil).items()})
    return bool(in_convex_hull(point, cloud.whitened(columns(frame)))[0])
