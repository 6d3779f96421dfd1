"""Parameters of a calibration: meaning, bounds, and the oil card with new values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ehl.common.errors import InputError
from ehl.common.units import KELVIN
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.fluid.oil_laws import GoldAlpha, ModulusAlpha, TabulatedAlpha
from ehl.fluid.rheology import RisingStress, stress_at
from ehl.fluid.viscosity import ModulusViscosity

GOLD_ANCHOR = 100.0 + KELVIN  # anchor temperature of a formula without measured value [K]
# default of the pressures between which a stress increases: those of the published 75W-90 law [Pa]
RISE_BETWEEN = (0.5e9, 3.5e9)
START_PRESSURE = 1e9  # pressure at which a stress law gives the start value of a constant stress [Pa]


@dataclass(frozen=True)
class CalibrationParameter:
    """One parameter, which is positive and fitted in its logarithm."""

    name: str  # of docs/nomenclature.md
    meaning: str  # for users
    # bounds, SI
    low: float
    high: float


_ALL = (
    CalibrationParameter("eyring_stress", "Eyring stress tau0, the same at all pressures", 2e5, 1e8),
    CalibrationParameter("stress_low", "lower level of the rising Eyring stress", 1e5, 1e8),
    CalibrationParameter("stress_slope", "slope of the rising Eyring stress with pressure", 1e-3, 0.3),
    CalibrationParameter("limiting_shear_coefficient", "limiting stress over pressure", 5e-3, 0.3),
    CalibrationParameter("pressure_viscosity", "pressure-viscosity coefficient", 3e-9, 4.5e-8),
    CalibrationParameter("boundary_film", "boundary film of the asperities", 5e-9, 1e-7),
    CalibrationParameter("boundary_friction", "friction of asperity contacts mu_b", 0.01, 0.5),
)
PARAMETERS: dict[str, CalibrationParameter] = {parameter.name: parameter for parameter in _ALL}
RISING = ("stress_low", "stress_slope")
EXCLUSIVE = {"eyring_stress": RISING}


def check_parameters(names: tuple[str, ...]) -> None:
    """Check that parameters exist and do not exclude each other."""
    if not names:
        raise InputError("parameters", "none", "at least one of " + ", ".join(PARAMETERS))
    for name in names:
        if name not in PARAMETERS:
            raise InputError("parameters", name, "one of " + ", ".join(PARAMETERS))
        if names.count(name) > 1:
            raise InputError("parameters", name, "each parameter once")
        for other in EXCLUSIVE.get(name, ()):
            if other in names:
                hint = "tau0 is either constant, or increases with pressure (stress_low, stress_slope)."
                raise InputError("parameters", f"{name}, {other}", "one law of the Eyring stress", hint)


def start_values(card: Oil, temperature: float, *, rising: bool) -> dict[str, float]:
    """Values of the oil parameters of a card at a temperature [K] for the selected stress law."""
    lubricant = card.at(temperature)
    values = {
        "limiting_shear_coefficient": lubricant.limiting_shear_coefficient,
        "pressure_viscosity": lubricant.pressure_viscosity,
    }
    if rising:
        law = _rising(card)
        return values | {"stress_low": law.stress_low, "stress_slope": law.stress_slope}
    return values | {"eyring_stress": float(stress_at(lubricant.eyring_stress, START_PRESSURE))}


def _rising(card: Oil) -> RisingStress:
    if card.eyring_stress_pressure is not None:
        return card.eyring_stress_pressure
    start, end = RISE_BETWEEN
    return RisingStress(stress_low=card.eyring_stress or 5e6, stress_slope=0.02, pressure_start=start, pressure_end=end)


def card_with(card: Oil, values: Mapping[str, float], temperature: float) -> Oil:
    """The card with the given parameter values; `pressure_viscosity` is that at `temperature` [K].

    alpha is scaled by one factor at all temperatures; for laws with constants ln(eta/eta0) is scaled.
    """
    changes: dict[str, object] = {}
    for name in ("eyring_stress", "limiting_shear_coefficient"):
        if name in values:
            changes[name] = values[name]
    if "limiting_shear_coefficient" in values and card.limiting_stress[0] > 0.0:
        changes["limiting_shear_ambient"] = card.limiting_stress[0]  # otherwise lost for that of the base oil
    if "stress_low" in values:
        law = _rising(card)
        changes["eyring_stress_pressure"] = law.model_copy(update={name: values[name] for name in RISING})
    if "pressure_viscosity" in values:
        changes |= _scaled_alpha(card, values["pressure_viscosity"] / float(card.alpha(temperature)), temperature)
    return card.model_copy(update=changes)


def _scaled_alpha(card: Oil, factor: float, temperature: float) -> dict[str, object]:
    """The slope at p = 0 times a factor at every temperature; laws with constants are scaled as a whole."""
    law = card.pressure_viscosity
    if factor == 1.0:
        return {}
    if isinstance(law, TabulatedAlpha):
        slopes = tuple(factor * float(card.alpha(at)) for at in law.temperature)
        return {"pressure_viscosity": law.model_copy(update={"value": slopes, **_as_slope(law)})}
    if isinstance(law, GoldAlpha):
        at = law.anchor_temperature if law.anchor_value is not None and law.anchor_temperature else GOLD_ANCHOR
        anchor = {"anchor_temperature": at, "anchor_value": factor * float(card.alpha(at))}
        return {"pressure_viscosity": law.model_copy(update={**anchor, **_as_slope(law)})}
    if isinstance(card.viscosity, ModulusViscosity) and law.anchor_value is None:
        constants = {name: getattr(card.viscosity, name) / factor for name in ("a1", "a2", "b1", "b2")}
        return {"viscosity": card.viscosity.model_copy(update=constants)}
    anchor = {"anchor_temperature": temperature, "anchor_value": factor * float(card.alpha(temperature))}
    return {"pressure_viscosity": ModulusAlpha(law="constants", alpha_definition="slope", **anchor)}


def _as_slope(law: TabulatedAlpha | GoldAlpha) -> dict[str, object]:
    """Definition "slope" if the card has a definition; the default is the slope."""
    return {} if law.alpha_definition is None else {"alpha_definition": "slope"}


def lubricant_of(card: Oil, temperature: float, *, rising: bool) -> Lubricant:
    """The lubricant of a card at a temperature [K]; `rising`: with an Eyring stress that increases with pressure."""
    lubricant = card.at(temperature)
    return replace(lubricant, eyring_stress=_rising(card)) if rising else lubricant
