"""Registry of the published friction formulas: application at a contact point, range and certainty.

Formulas for discs use the local conditions directly. Formulas for a gear mesh are applied locally with the conversions
stated in `applied` (own choice).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from inspect import signature
from pathlib import PurePath
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.oil import Oil
from ehl.fluid.oil_family import OIL_FAMILIES
from regression.friction import published as p
from regression.friction.conditions import Array, Conditions, film_over_roughness, inlet_heating
from regression.friction.models import FrictionEstimate, FrictionFlag, FrictionModel

Mask = NDArray[np.bool_]
Certainty = Literal["published", "mixed", "unverified"]

RA_OVER_RQ = float(np.sqrt(2.0 / np.pi))  # Gaussian heights
RZ_OVER_RQ = 5.0  # typical of ground and lapped flanks (own choice)
PRESSURE_ANGLE = np.deg2rad(20.0)
ARANA_BOUNDARY_FRICTION = 0.065  # from FZG gears at 0.5 m/s, the validation of the load share by the authors
BOUNDARY_FRICTION = 0.10  # if the value of the authors is unknown (own choice)
SLIDING_FLOOR = 1e-3  # [m/s]
HARDNESS = 8e9  # of the shipped steel [Pa]; a contact state has none


@dataclass(frozen=True)
class PublishedFriction(FrictionModel):
    """One published formula as a local friction model."""

    name: str  # registry name, ``author_year``
    source: str  # authors, year, kind of data
    certainty: Certainty  # of the coefficients
    # friction coefficient from the local conditions and the base oil
    local: Callable[[Conditions, str], Array] = field(compare=False)
    # smallest and largest value of variables of `regression.friction.conditions.UNITS` in the original, SI units
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    range_certainty: str = "unverified"
    applied: str = ""  # additional assumptions at a contact point
    diverges: bool = False  # mu is infinite without sliding; it is evaluated with at least `SLIDING_FLOOR`

    @property
    def label(self) -> str:
        """Authors and year for figures: ``Xu & Kahraman 2007``."""
        if self.source.startswith("ISO"):
            return self.source.partition(",")[0]
        *authors, year = self.name.title().replace("Odonoghue", "O'Donoghue").split("_")
        return f"{' & '.join(authors)} {year}"

    @property
    def mark(self) -> str:
        """Suffix of the name in reports: " (M)" if a coefficient of the equation is unverified."""
        return "" if self.certainty == "published" else " (M)"

    @property
    def certainty_words(self) -> str:
        """Explanation of `mark`; empty if all coefficients were found."""
        if self.certainty == "published":
            return ""
        share = "in part " if self.certainty == "mixed" else ""
        return f"(M): the equation is {share}unverified, compare it with the publication"

    def references(self) -> set[str]:
        """The publication of the formula."""
        return {f"friction:{self.name}"}

    def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
        """Friction with a flag outside the range of the formula, without interval, which the authors do not state."""
        mu, outside = self.values(conditions, oil.base)
        flag = np.where(outside, FrictionFlag.OUTSIDE_RANGE, FrictionFlag.OK)
        flag = np.where(np.isnan(mu), FrictionFlag.UNDEFINED, flag)
        unknown = np.full_like(mu, np.nan)
        return FrictionEstimate(mu, unknown, unknown.copy(), flag.astype(np.int8))

    def values(self, conditions: Conditions, base: str) -> tuple[Array, Mask]:
        """Friction coefficient (nan without a positive value), and whether points are outside the range."""
        outside = np.zeros(np.shape(conditions["pressure_hertz"]), dtype=bool)
        for name, (low, high) in self.ranges.items():
            outside |= (conditions[name] < low) | (conditions[name] > high)
        table = dict(conditions)
        if self.diverges:
            outside |= table["speed_sliding"] < SLIDING_FLOOR
            table["speed_sliding"] = np.maximum(table["speed_sliding"], SLIDING_FLOOR)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            mu = self.local(table, base)
        return np.asarray(np.where(np.isfinite(mu) & (mu >= 0.0), mu, np.nan)), outside


def _mean_ra(c: Conditions) -> Array:
    return np.asarray(0.5 * RA_OVER_RQ * (c["roughness_rms_1"] + c["roughness_rms_2"]))


# arguments of formulas that follow from the local conditions and the base oil
_DERIVED: dict[str, Callable[[Conditions, str], Array | float]] = {
    "roughness_ra": lambda c, base: _mean_ra(c),
    "lubricant_factor": lambda c, base: p.lubricant_factor_niemann(base, c["speed_sum"]),
    "pinion_diameter": lambda c, base: 2.0 * c["radius_equivalent"] * (1.0 + 1.0 / 3.0) / np.sin(PRESSURE_ANGLE),
}


def _by_name(function: Callable[..., Array], c: Conditions, base: str) -> Array:
    """A formula at local conditions with the names of its arguments, or `_DERIVED` from them."""
    names = signature(function).parameters
    return function(**{name: _DERIVED[name](c, base) if name in _DERIVED else c[name] for name in names})


def _iso_tr_14179_1(c: Conditions, base: str) -> Array:
    # at the pitch point of a cylindrical pair 1/d1 + 1/d2 = sin(a)/(2 R), u_e = V sin(a), w_t = w' cos(a)
    sine, cosine = np.sin(PRESSURE_ANGLE), np.cos(PRESSURE_ANGLE)
    intensity = c["load_per_length"] * cosine * sine / (2.0 * c["radius_equivalent"])
    return p.iso_tr_14179_1(c["viscosity_kinematic"], intensity, c["speed_entrainment"] / sine)


def _arana_film(c: Conditions) -> Array:
    return inlet_heating(c) * c["film_formula"]


def _mix(share: Array, c: Conditions, base: str, boundary_friction: float = BOUNDARY_FRICTION) -> Array:
    """Boundary friction and the film friction of Arana et al., weighted by the asperity load share."""
    fluid = p.arana_2019_fluid(
        np.maximum(0.25 * np.pi * c["pressure_hertz"], 1.0),
        c["viscosity_mean_pressure"],
        c["pressure_viscosity"],
        c["speed_sliding"],
        _arana_film(c),
        OIL_FAMILIES[base].ratio,  # Lambda of the authors limits the mean friction and is no property of the oil
    )
    return np.asarray(share * boundary_friction + (1.0 - share) * fluid)


def _groups(c: Conditions) -> tuple[Array, Array, Array]:
    """U, W and G of Dowson & Higginson."""
    scale = c["effective_modulus"] * c["radius_equivalent"]
    speed, load = c["viscosity_inlet"] * c["speed_entrainment"] / scale, np.maximum(c["load_per_length"] / scale, 1e-12)
    return speed, load, c["pressure_viscosity_film"] * c["effective_modulus"]


def _arana(c: Conditions, base: str) -> Array:
    share = p.share_arana_2019(film_over_roughness(_arana_film(c), c["roughness_rms"]))
    return _mix(share, c, base, ARANA_BOUNDARY_FRICTION)


def _doleschel(c: Conditions, base: str) -> Array:
    return _mix(p.share_doleschel_2002(film_over_roughness(_arana_film(c), _mean_ra(c))), c, base)


def _matsumoto(c: Conditions, base: str) -> Array:
    minimum = c["radius_equivalent"] * p.pan_hamrock_1989_minimum(*_groups(c))
    heights = RZ_OVER_RQ * (c["roughness_rms_1"] + c["roughness_rms_2"])
    return _mix(p.share_matsumoto_2014(heights / minimum), c, base)


def _masjedi(c: Conditions, base: str) -> Array:
    rough, hardness = c["roughness_rms"] / c["radius_equivalent"], HARDNESS / c["effective_modulus"]
    share = p.share_masjedi_khonsari_2012(*_groups(c), rough, hardness)
    return _mix(share, c, base)


_LOCAL_LOAD = "a mesh mean with quantities at the pitch point, applied with local ones; Ra = 0.798 Rq, mean of both"
_FILM = "film of Moes (1992) with the inlet-heating factor of Gupta et al. (1992)"
_SHARE = _FILM + "; mu_b = 0.10 (this work)"

_ENTRIES = (
    PublishedFriction(
        "xu_kahraman_2007",
        "Xu, Kahraman, Anderson & Maddock 2007, J. Mech. Des. 129; regression of EHL results, 75W90",
        "published",
        partial(_by_name, p.xu_kahraman_2007),
        {
            "pressure_hertz": (0.5e9, 2.5e9),
            "radius_equivalent": (5e-3, 40e-3),
            "speed_entrainment": (1.0, 20.0),
            "slide_to_roll_total": (0.0, 1.0),
            "viscosity_inlet": (1e-3, 0.2),
        },
        "unverified; below the smallest viscosity the equation is meaningless",
        applied="|SR| is the length of the sliding vector over the entrainment speed",
    ),
    PublishedFriction(
        "benedict_kelley_1961",
        "Benedict & Kelley 1961, ASLE Trans. 4; disc tests, mineral oils",
        "mixed",
        partial(_by_name, p.benedict_kelley_1961),
        {"roughness_rms": (0.0, 30.0 * p.MICROINCH)},
        applied="roughness factor (unverified) with the composite Rq",
        diverges=True,
    ),
    PublishedFriction(
        "schlenk_1994",
        "Schlenk; Niemann, Hoehn & Michaelis; FZG gear tests",
        "published",
        partial(_by_name, p.schlenk_1994),
        {"load_per_length": (150e3, np.inf)},
        applied=_LOCAL_LOAD + "; XL of the standard (unverified) by base oil",
    ),
    PublishedFriction(
        "iso_tr_14179_1",
        "ISO/TR 14179-1, mesh coefficient of friction",
        "unverified",
        _iso_tr_14179_1,
        {"speed_entrainment": (2.0 * np.sin(PRESSURE_ANGLE), 25.0 * np.sin(PRESSURE_ANGLE))},
        "unverified: V of 2 to 25 m/s; K of 1.4 to 14 N/mm2 is not checked",
        applied="K and V from w', R and u_r at the pitch point of a pair with 20 deg pressure angle (this work)",
    ),
    PublishedFriction(
        "iso_tr_14179_2",
        "ISO/TR 14179-2, mesh coefficient of friction",
        "unverified",
        partial(_by_name, p.iso_tr_14179_2),
        {"load_per_length": (150e3, np.inf)},
        applied=_LOCAL_LOAD
        + "; d1 = 2 R (1 + 1/3)/sin 20 deg, a pair of ratio 3 (this work; ratio 1 gives 10 % less, a rack 7 % more)",
    ),
    PublishedFriction(
        "misharin_1958",
        "Misharin 1958; disc tests",
        "unverified",
        partial(_by_name, p.misharin_1958),
        {"pressure_hertz": (2500.0 * p.KGF_PER_CM2, np.inf), "slide_to_roll_total": (0.4, 1.3)},
        diverges=True,
    ),
    PublishedFriction(
        "drozdov_gavrikov_1967",
        "Drozdov & Gavrikov 1967; disc tests",
        "unverified",
        partial(_by_name, p.drozdov_gavrikov_1967),
        {
            "pressure_hertz": (4000.0 * p.KGF_PER_CM2, 20000.0 * p.KGF_PER_CM2),
            "viscosity_kinematic": (4e-6, 500e-6),
            "speed_sliding": (0.0, 15.0),
            "speed_sum": (3.0, 20.0),
        },
    ),
    PublishedFriction(
        "odonoghue_cameron_1966",
        "O'Donoghue & Cameron 1966; disc tests",
        "unverified",
        partial(_by_name, p.odonoghue_cameron_1966),
        applied="Ra = 0.798 Rq, mean of both; the unit of viscosity and the kind of rolling speed in the original are "
        "unknown, 2 and 11 % of mu",
        diverges=True,
    ),
    PublishedFriction(
        "arana_2019",
        "Arana, Larranaga & Ulacia 2019; load sharing 1 - erf(lambda), Eyring stress 2 Lam/alpha",
        "published",
        _arana,
        applied=_FILM + "; mu_b = 0.065 of the authors; alpha is the slope at ambient pressure instead of the authors' "
        "alpha* (film friction lower by up to 8 % for 75W90 and 13 % for 80W90)",
    ),
    PublishedFriction(
        "doleschel_2002",
        "Doleschel; load sharing (1 - lambda/2)^2, lambda on the mean Ra",
        "published",
        _doleschel,
        applied=_SHARE + "; film friction of Arana et al. instead of the measured reference values of the author",
    ),
    PublishedFriction(
        "matsumoto_morikawa_2014",
        "Matsumoto & Morikawa; load sharing 0.5 log10 D, D = (Rz1 + Rz2)/h_min",
        "published",
        _matsumoto,
        applied=_SHARE + "; film friction of Arana et al., h_min of Pan & Hamrock, Rz = 5 Rq (this work)",
    ),
    PublishedFriction(
        "masjedi_khonsari_2012",
        "Masjedi & Khonsari 2012, J. Tribol. 134; load share of rough line contacts, fit to a statistical model",
        "unverified",
        _masjedi,
        {"film_ratio_formula": (0.1, np.inf)},
        "estimated: the share exceeds 1 at lower values; the range of the original is unknown",
        applied="film friction of Arana et al. with the inlet-heating factor of Gupta et al. (1992); mu_b = 0.10 and "
        "hardness 8 GPa (this work)",
    ),
)

PUBLISHED: dict[str, PublishedFriction] = {entry.name: entry for entry in _ENTRIES}


def model_label(name: str) -> str:
    """Name of a friction model in pages and figures from its specification, e.g. "constant 0.05" ``constant:0.05``."""
    kind, _, rest = name.partition(":")
    if kind == "constant":
        value, comma, fitted = rest.partition(", fitted to ")
        return f"constant {float(value):.3g}" + (f"{comma}{model_label(fitted)}" if fitted else "")
    if kind == "ehl":
        return "solved contacts" + (f", {rest.replace('_', ' ').replace(':', ', ')}" if rest else "")
    if name in PUBLISHED:
        return PUBLISHED[name].label
    # formula_oil.json in any folder is "formula oil", formula.json is "formula"
    own = PurePath(name).name.removesuffix(".json").removeprefix("formula").lstrip("_")
    return f"formula {own}".rstrip()
