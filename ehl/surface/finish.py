"""Surface finishes of flanks and additive classes of oils: typical values with ranges.

A range is the central 90 % interval of a log-normal variable, or of a normal one if it changes sign (skewness). Rq and
correlation length are independent variables with ranges of their own (docs/roughness.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import NormalDist
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import model_validator

from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.errors import InputError
from ehl.common.files import toml_text
from ehl.common.progress import counted
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, load_shipped, read_toml, validate

if TYPE_CHECKING:
    from ehl.surface.measured_surface import MeasuredSurface

State = Literal["new", "run_in"]
STATES: tuple[State, ...] = ("new", "run_in")
HALF_RANGE = NormalDist().inv_cdf(0.95)  # standard deviations from the middle to an end of a range

# without a named finish: lc over the Rq of one surface, the middle of 15 to 100 of measured profiles and of the limits
# by hardness and shakedown (docs/roughness.md), and its bounds [m]
LENGTH_PER_RMS = 40.0
SHORTEST_LENGTH, LONGEST_LENGTH = 8e-6, 150e-6
# power of Rq with which lc changes within one finish: RSm of 823 fine-turned parts, 70 to 130 um at Ra 0.39 to 0.99 um
# (docs/roughness.md)
LENGTH_POWER = 2.0 / 3.0
# RSm Rdq/Rq is at least 6, 8 to 9 for a Gaussian profile and 16 for a plateau; RSm/Sal of measured profiles is 3.3 to
# 5.6 (docs/roughness.md); both bounds have a margin (own choice)
SPACING_TIMES_SLOPE, SPACING_OVER_SAL = (6.0, 20.0), (2.5, 8.0)
UNNAMED = {"roughness_rms": 1.2, "correlation_length": 2.6, "peklenik_number": 3.0}
DEFAULT_ADDITIVE = "EP"
LEAST_PEKLENIK = 1.0 / 3.0  # smallest Peklenik number of a contact [-]
# of run-in flanks without a named finish [-], as in all run-in finishes of data/finishes
FLANK_SKEWNESS = -0.8


class Figure(InputModel):
    """A value with its range.

    value, low, high: SI; 90 % of the surfaces or oils of that name lie between `low` and `high`.
    source: source of the value; own estimates are marked as estimated.
    """

    value: float
    low: float
    high: float
    source: str = ""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low <= self.value <= self.high:
            raise InputError("value", self.value, f"{self.low:g} to {self.high:g}, its stated range")
        return self


_Length = Annotated[float, ValueRange("m", ge=1e-9, le=1e-2)]


class _LengthFigure(Figure):
    value: _Length
    low: _Length
    high: _Length


class _StateTable(InputModel):
    roughness_rms: _LengthFigure
    correlation_length: _LengthFigure
    skewness: Figure
    lay_ratio: Figure


class MeasuredParameters(InputModel):
    """Further values of a measured profile, SI units, as in `ehl.measured_surface`."""

    kurtosis: float
    rsm: float | None = None
    rdq: float
    correlation_length_along: float | None = None
    lay_angle: float | None = None
    cutoff_short: float
    cutoff_long: float
    frequency: tuple[float, ...] = ()
    spectral_density: tuple[float, ...] = ()


class _FinishFile(InputModel):
    name: str
    description: str
    measured: MeasuredParameters | None = None
    new: _StateTable | None = None
    run_in: _StateTable | None = None


@dataclass(frozen=True)
class Finish:
    """A finish of a flank in one state.

    Parameters
    ----------
    name : str
        Name of the finish.
    state : {"new", "run_in"}
        State of the flank.
    description : str
        Description in one sentence.
    roughness_rms, correlation_length : Figure
        Rq, and lc across the marks [m].
    skewness : Figure
        Skewness of the heights [-].
    lay_ratio : Figure
        Correlation length along the marks over that across them [-].
    measured : MeasuredParameters, optional
        Of a measured profile: Rku, RSm, Rdq, cut-offs, correlation length along the lay, power spectrum.
    """

    name: str
    state: State
    description: str
    roughness_rms: Figure
    correlation_length: Figure
    skewness: Figure
    lay_ratio: Figure
    measured: MeasuredParameters | None = None

    @classmethod
    def load(cls, name: str, state: str = "run_in") -> Finish:
        """A finish by name or from a file.

        Parameters
        ----------
        name : str
            One of `ehl.shipped("finishes")`, or the path of a .toml file.
        state : {"run_in", "new"}

        Raises
        ------
        InputError
            There is no such finish or state; the message lists the available ones.

        Examples
        --------
        >>> from ehl import Finish
        >>> Finish.load("ground", "new").roughness_rms.value
        5e-07
        """
        if state not in STATES:
            raise InputError("finish_state", state, " or ".join(STATES))
        if name.endswith(".toml"):
            file = validate(_FinishFile, read_toml(name, "finish"), name)
        else:
            file = load_shipped(_FinishFile, "finishes", name, "finish", "; or FILE.toml")
        table: _StateTable | None = getattr(file, state)
        if table is None:
            raise InputError("finish_state", state, f"a state of {name}: " + ", ".join(set(STATES) - {state}))
        figures = (table.roughness_rms, table.correlation_length, table.skewness, table.lay_ratio)
        return cls(file.name, state, file.description, *figures, file.measured)

    @classmethod
    def from_profile(cls, found: MeasuredSurface, state: State = "run_in") -> Finish:
        """The finish of a measured profile or map.

        A single profile does not show the lay: it is assumed isotropic, with a range up to 5. The other ranges are own
        estimates: 20 % of Rq, a factor of 1.25 of the correlation length, 0.3 of the skewness.

        Parameters
        ----------
        found : MeasuredSurface
            Result of `ehl.measured_surface`.
        state : {"run_in", "new"}
            State of the measured flank.

        Raises
        ------
        InputError
            The autocorrelation does not decrease to 1/e within the length of the profile.
        """
        across, along = found.correlation_length, found.correlation_length_along
        if not math.isfinite(across):
            raise InputError("profile", found.name, "heights whose autocorrelation falls to 1/e within the length")
        source = f"{Path(found.name).name}, {found.cutoff_short:.3g} m to {found.cutoff_long:.3g} m; range estimated"
        lay = Figure(value=1.0, low=1.0, high=5.0, source="not measurable by a single profile; range estimated")
        if math.isfinite(along):
            ratio = max(along / across, 1.0 / 3.0)
            lay = Figure(value=ratio, low=ratio / 1.5, high=ratio * 1.5, source=source)
        rms, skewness = found.roughness_rms, min(max(found.skewness, -2.7), 2.7)
        measured = {name: finite_or_none(getattr(found, name)) for name in MeasuredParameters.model_fields} | {
            name: tuple(getattr(found, name).tolist()) for name in ("frequency", "spectral_density")
        }
        return cls(
            Path(found.name).stem,
            state,
            f"measured, {counted(found.lines, 'line')} of {found.points} points",
            Figure(value=rms, low=rms / 1.2, high=rms * 1.2, source=source),
            Figure(value=across, low=across / 1.25, high=across * 1.25, source=source),
            Figure(value=skewness, low=skewness - 0.3, high=skewness + 0.3, source=source),
            lay,
            MeasuredParameters(**measured),
        )

    def to_toml(self) -> str:
        """TOML text of this finish, with its one state.

        Examples
        --------
        >>> import ehl
        >>> ehl.Finish.load("ground").to_toml().splitlines()[0]
        'name = "ground"'
        """
        figures = ("roughness_rms", "correlation_length", "skewness", "lay_ratio")
        content = {"name": self.name, "description": self.description}
        tables: dict[str, Any] = {self.state: {name: getattr(self, name).model_dump() for name in figures}}
        if self.measured is not None:
            tables["measured"] = self.measured.model_dump(exclude_none=True)
        return toml_text(content | tables)

    def length_at(self, rms: ArrayLike) -> FloatArray:
        """Correlation length across the marks of flanks with another Rq [m], in proportion to Rq^(2/3).

        rms: Rq [m]. Within 8 to 150 um.
        """
        ratio = np.asarray(rms, dtype=float) / self.roughness_rms.value
        length = self.correlation_length.value
        limits = min(SHORTEST_LENGTH, length), max(LONGEST_LENGTH, length)
        return np.asarray(np.clip(length * ratio**LENGTH_POWER, *limits))

    def with_rms(self, rms: float) -> Finish:
        """The finish with a measured Rq [m], with a range of 20 %, and its correlation length at it (`length_at`).

        Examples
        --------
        >>> import ehl
        >>> ehl.Finish.load("ground").with_rms(0.3e-6).roughness_rms.value
        3e-07
        """
        own, value = self.correlation_length, float(self.length_at(rms))
        low, high = (value * end / own.value for end in (own.low, own.high))
        length = Figure(value=value, low=low, high=high, source=own.source)
        return replace(self, roughness_rms=_given("roughness_rms", rms), correlation_length=length)


class Additive(InputModel):
    """Boundary film of an additive class.

    boundary_film: film thickness below which solids are in contact [m].
    boundary_friction: mu_b [-].
    """

    name: str
    description: str
    boundary_film: _LengthFigure
    boundary_friction: Figure

    @classmethod
    def load(cls, name: str) -> Additive:
        """A shipped additive class, one of `ehl.shipped("additives")`; `InputError` if there is none of the name."""
        return load_shipped(cls, "additives", name, "additive")


def default_correlation_length(rms_1: ArrayLike, rms_2: ArrayLike = 0.0) -> FloatArray:
    """lc of surfaces without a named finish: 40 Rq of one surface, within 8 to 150 um [m].

    Measured profiles have 16 to 20 Rq, smooth ones up to 200 Rq. With 40 Rq run-in flanks are below the shakedown limit
    of their summits (docs/roughness.md).

    rms_1, rms_2: Rq of both surfaces [m]; the root mean square of two rough ones is used.
    """
    first, second = np.asarray(rms_1, dtype=float), np.asarray(rms_2, dtype=float)
    rough = np.maximum((first > 0.0).astype(float) + (second > 0.0), 1.0)
    each = np.hypot(first, second) / np.sqrt(rough)
    return np.asarray(np.clip(LENGTH_PER_RMS * each, SHORTEST_LENGTH, LONGEST_LENGTH))


def printed_correlation_length(
    rms: float, *, rsm: float | None = None, rdq: float | None = None, sal: float | None = None
) -> float:
    """lc of one surface from profilometer parameters [m]: RSm/5, else Sal/1.25, else sqrt(2) Rq/(0.65 Rdq).

    The first is accurate to 25 % and hardly depends on the cut-offs. The last applies to a stylus filter of 2.5 um,
    with a factor of 0.5 to 0.8 for measured profiles (docs/roughness.md).

    rms: Rq [m].
    rsm: mean spacing of profile elements [m].
    rdq: RMS slope [-].
    sal: autocorrelation length of ISO 25178 (threshold 0.2) [m].
    Raises `InputError`: the parameters contradict one another.
    """
    if rsm is not None and rdq is not None:
        found, (low, high) = rsm * rdq / rms, SPACING_TIMES_SLOPE
        if not low <= found <= high:
            allowed = f"RSm Rdq/Rq of {low:g} to {high:g}"
            given = f"{rsm:.3g} m, rdq {rdq:.3g}, Rq {rms:.3g} m"
            raise InputError("rsm", given, allowed, f"It is {found:.3g}; check the units.")
    if rsm is not None and sal is not None and not SPACING_OVER_SAL[0] <= rsm / sal <= SPACING_OVER_SAL[1]:
        allowed = f"RSm/Sal of {SPACING_OVER_SAL[0]:g} to {SPACING_OVER_SAL[1]:g}"
        raise InputError("sal", f"{sal:.3g} m, rsm {rsm:.3g} m", allowed, f"It is {rsm / sal:.3g}; check the units.")
    if rsm is not None:
        return rsm / 5.0
    if sal is not None:
        return sal / 1.25
    assert rdq is not None
    return math.sqrt(2.0) * rms / (0.65 * rdq)


def lay_seen(correlation_length: float, lay_ratio: float, angle: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Correlation length along x and Peklenik number of marks at an angle to the contact line.

    The autocorrelation is an ellipse with the axes lc across the marks and r lc along them, so that

        1/l_x^2 = (cos^2 a + sin^2 a/r^2)/lc^2,   1/l_y^2 = (sin^2 a + cos^2 a/r^2)/lc^2,   gamma = l_y/l_x

    correlation_length: lc across the marks [m].
    lay_ratio: r, correlation length along the marks over that across them [-].
    angle: between marks and contact line [rad]; 0 for marks across the motion.
    Returns l_x [m] and gamma [-].
    """
    across, along = np.cos(np.asarray(angle)) ** 2, np.sin(np.asarray(angle)) ** 2
    x = across + along / lay_ratio**2
    y = along + across / lay_ratio**2
    return correlation_length / np.sqrt(x), np.sqrt(x / y)


def with_lay_ratio(
    correlation_length: ArrayLike, peklenik_number: ArrayLike, lay_ratio: float, changed: float
) -> tuple[FloatArray, FloatArray]:
    """Texture of marks at the same angles with another lay ratio; l_x and gamma as returned by `lay_seen`.

    With c = cos^2 a, `lay_seen` gives c = (gamma^2 - 1/r^2)/((1 - 1/r^2) (1 + gamma^2)). For two surfaces with the same
    r, c is the mean with the weights (Rq/lc)^2 of their cos^2 a. Marks of an isotropic surface (r = 1) are taken to lie
    across the motion.

    correlation_length, peklenik_number: l_x [m] and gamma with the lay ratio r [-]. The limit of gamma, 1/3, is that of
        marks along the motion.
    lay_ratio, changed: r before and after [-].
    Returns l_x [m], and gamma of at least 1/3 [-].
    """
    gamma, r = np.asarray(peklenik_number, dtype=float), 1.0 / lay_ratio**2
    across = np.ones_like(gamma)
    if abs(1.0 - r) > 1e-9:
        across = np.where(gamma <= LEAST_PEKLENIK, 0.0, (gamma**2 - r) / ((1.0 - r) * (1.0 + gamma**2)))
    angle = np.arccos(np.sqrt(np.clip(across, 0.0, 1.0)))
    (before, _), (after, seen) = lay_seen(1.0, lay_ratio, angle), lay_seen(1.0, changed, angle)
    return np.asarray(correlation_length) * after / before, np.maximum(seen, LEAST_PEKLENIK)


def _given(name: str, value: float) -> Figure:
    factor = UNNAMED[name]
    return Figure(value=value, low=value / factor, high=value * factor, source="value of this contact; range estimated")


def surface_uncertainty(
    *,
    roughness_rms: float | None = None,
    correlation_length: float | None = None,
    peklenik_number: float | None = None,
    finish: str | None = None,
    finish_state: str = "run_in",
    additive: str = DEFAULT_ADDITIVE,
) -> dict[str, Figure]:
    """Roughness and boundary-film parameters of a surface with their ranges, for the uncertainty of friction.

    A named finish gives value and range of all parameters without a value. Given values have the ranges of `UNNAMED`;
    these are wide for correlation length and Peklenik number, which are rarely measured. Rq and correlation length are
    independent.

    roughness_rms, correlation_length: values of one surface [m].
    peklenik_number: value [-].
    finish, finish_state, additive: as in `Finish.load` and `Additive.load`.
    Returns `roughness_rms`, `correlation_length`, `peklenik_number`, `boundary_film`, `boundary_friction`.
    Raises `InputError`: there is no such finish, state or additive.
    """
    chemistry = Additive.load(additive)
    if finish is not None:
        named = Finish.load(finish, finish_state)
        named = named if roughness_rms is None else named.with_rms(roughness_rms)
        rms, length, lay = named.roughness_rms, named.correlation_length, named.lay_ratio
    else:
        rms = _given("roughness_rms", roughness_rms or 0.0)
        length = _given("correlation_length", float(default_correlation_length(rms.value)))
        lay = Figure(value=1.0, low=1.0, high=5.0, source="isotropic by default; range estimated")
    if correlation_length is not None:
        length = _given("correlation_length", correlation_length)
    if peklenik_number is not None:
        lay = _given("peklenik_number", peklenik_number)
    return {
        "roughness_rms": rms,
        "correlation_length": length,
        "peklenik_number": lay,
        "boundary_film": chemistry.boundary_film,
        "boundary_friction": chemistry.boundary_friction,
    }
