"""`Contact`: one lubricated line contact with all its inputs, from keywords or a file."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self, TypedDict, Unpack

from pydantic import ValidationError, model_validator

from ehl import inputs as case_inputs
from ehl.common.errors import InputError, near
from ehl.common.validation import InputModel, input_error, read_toml
from ehl.fluid.lubricant import ASSUMED_CONDUCTIVITY
from ehl.fluid.lubricant_inputs import DirectLubricant, LubricantInput, OilLubricant
from ehl.fluid.oil import Oil
from ehl.fluid.pressure_viscosity import AlphaDefinition
from ehl.fluid.rheology import Limit, Rheology
from ehl.line_contact import LineContact, hertz_load
from ehl.material import Material, effective_modulus
from ehl.surface.finish import State

if TYPE_CHECKING:
    from ehl.result import ContactResult
    from ehl.uncertainty.result import InputUncertainty
    from ehl.uncertainty.spread import UncertaintyInput

Amount = float | str | None  # SI number or text with unit; None removes an input


class ContactKeywords(TypedDict, total=False):
    """Keywords of `Contact`: the keys of the input file without its tables, or whole tables."""

    radius_equivalent: Amount
    effective_modulus: Amount
    pressure_hertz: Amount
    load_per_length: Amount
    speed_entrainment: Amount
    slide_to_roll: Amount
    speed_sliding_lengthwise: Amount
    oil: str | Oil | Mapping[str, object] | None
    temperature: Amount
    temperature_oil: Amount
    viscosity_inlet: Amount
    pressure_viscosity: Amount
    alpha_definition: AlphaDefinition | None
    viscosity_law: Literal["roelands", "barus"] | None
    viscosity: Mapping[str, object] | None
    pressure_rise_factor: Amount
    pressure_valid: Amount
    density_law: Literal["incompressible", "dowson_higginson"] | None
    density_coefficients: Sequence[float] | None
    density_pressure: Mapping[str, object] | None
    temperature_viscosity: Amount
    density: Amount
    thermal_conductivity: Amount
    conductivity_pressure: str | Mapping[str, object] | None
    heat_capacity: Amount
    rheology: Rheology | None
    eyring_stress: Amount
    eyring_stress_law: Literal["constant", "pressure"] | None
    eyring_stress_pressure: Mapping[str, object] | None
    carreau_stress: Amount
    carreau_exponent: Amount
    limiting_shear: Limit | None
    limiting_shear_coefficient: Amount
    limiting_shear_ambient: Amount
    shear_modulus: Amount
    solid_1: str | Material | Mapping[str, object]
    solid_2: str | Material | Mapping[str, object]
    temperature_bulk_1: Amount
    temperature_bulk_2: Amount
    roughness_rms: Amount
    roughness_rms_1: Amount
    roughness_rms_2: Amount
    profile_1: str | None
    profile_2: str | None
    profile_unit_x: str | None
    profile_unit_height: str | None
    detrend: int | None
    cutoff_short: Amount
    cutoff_long: Amount
    finish: str | None
    finish_state: State | None
    additive: str | None
    spectrum: Literal["gaussian", "self_affine"] | None
    hurst_exponent: Amount
    correlation_length: Amount
    rsm: Amount
    rdq: Amount
    sal: Amount
    skewness: Amount
    kurtosis: Amount
    lay_angle: Amount
    peklenik_number: Amount
    boundary_film: Amount
    boundary_friction: Amount
    running_in: Amount
    seed: int | None
    thermal: case_inputs.Thermal | None
    accuracy: case_inputs.Accuracy | None
    friction_tolerance: Amount
    shortcuts: Literal["auto", "off"] | None
    contact: Mapping[str, object]
    lubricant: Mapping[str, object]
    surface: Mapping[str, object]
    model: Mapping[str, object]


# keyword -> (table, key) of the input file
KEYWORDS: dict[str, tuple[str, str]] = {
    name: (table, name)
    for table, model in (
        ("contact", case_inputs.ContactInput),
        ("lubricant", OilLubricant),
        ("lubricant", DirectLubricant),
        ("surface", case_inputs.SurfaceInput),
        ("model", case_inputs.ModelInput),
    )
    for name in model.model_fields
} | {
    "temperature": ("lubricant", "temperature_oil"),
    **{name: ("surface", name) for name in ("roughness_rms", *case_inputs.PRINTED)},
    "temperature_bulk_1": ("solid_1", "temperature_bulk"),
    "temperature_bulk_2": ("solid_2", "temperature_bulk"),
}

# for completion and help in tools that do not read the types
_SIGNATURE = inspect.Signature(
    [inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)]
    + [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY) for name in (*KEYWORDS, "solid_1", "solid_2")]
)


class Contact(InputModel):
    """One lubricated line contact: geometry, load, motion, oil, bodies, surfaces and models.

    Every quantity is an SI number or a string with its unit. The keywords are the keys of the input file of
    `mixed-ehl solve` without its tables, or whole tables (``surface={"seed": 3}``).

    Parameters
    ----------
    radius_equivalent : float or str
        Radius R of the equivalent cylinder on a plane [m].
    pressure_hertz, load_per_length : float or str
        Maximum Hertz pressure [Pa], or load per length [N/m]: exactly one of the two.
    speed_entrainment : float or str
        Mean of both surface velocities across the contact line [m/s].
    slide_to_roll : float
        Signed sliding across the line over `speed_entrainment` [-]; default: 0.
    speed_sliding_lengthwise : float or str
        Sliding along the contact line [m/s]; default: 0.
    effective_modulus : float or str
        E' with 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [Pa]; default: from both bodies.
    oil : str, Oil or dict
        Name of a shipped oil (`ehl.shipped("oils")`), path of an oil card, an `Oil` or the content of a card; requires
        `temperature`.
    temperature : float or str
        Oil temperature at the inlet [K], also `temperature_oil`.
    viscosity_inlet, pressure_viscosity : float or str
        Dynamic viscosity [Pa s] and pressure-viscosity coefficient [1/Pa] at the inlet, instead of `oil`. Optional
        with them: `viscosity_law`, `density_law`, `density_coefficients`, `temperature_viscosity` [1/K] and `density`
        [kg/m3].
    rheology : {"eyring", "newtonian", "carreau"}
        Shear law. Its parameters are `eyring_stress` [Pa], `eyring_stress_law`, `eyring_stress_pressure`,
        `carreau_stress` [Pa], `carreau_exponent`, `limiting_shear`, `limiting_shear_coefficient` and
        `limiting_shear_ambient` [Pa].
    thermal_conductivity, heat_capacity : float or str
        Thermal conductivity [W/(m K)] and specific heat capacity [J/(kg K)] of the oil.
    solid_1, solid_2 : str, Material or dict
        Name of a shipped material, a `Material`, or the keys of the table in the input file; default: steel.
    temperature_bulk_1, temperature_bulk_2 : float or str
        Bulk temperatures [K]; default: that of the oil.
    roughness_rms : float or str
        Composite Rq [m] of two equal surfaces; alternatively `roughness_rms_1` and `roughness_rms_2`.
    profile_1, profile_2 : str
        Files of measured profiles instead of Rq. A polynomial of the order `detrend` (default 2) is removed as form;
        wavelengths between `cutoff_short` and `cutoff_long` [m] are used. `profile_unit_x` and `profile_unit_height`
        are the units of files that do not state them.
    finish, finish_state : str
        Surface finish (`ehl.shipped("finishes")`) and its state, "run_in" (default) or "new". Default values of Rq,
        correlation length, skewness, kurtosis and lay follow from it.
    correlation_length, skewness, kurtosis, peklenik_number, seed : float, str or int
        Parameters of generated roughness; the default of the correlation length [m] is 40 Rq.
    rsm, rdq, sal : float or str
        Profilometer parameters of each surface instead of the correlation length: mean spacing [m], RMS slope [-] and
        autocorrelation length at 0.2 [m]. Several of them are checked for consistency.
    running_in : "none", float or str
        Rq of each surface after running-in [m]: the peaks of its profile are worn to plateaus, the valleys remain.
    spectrum, hurst_exponent : {"gaussian", "self_affine"}, float
        Spectrum with one correlation length, or self-affine roughness with a Hurst exponent.
    lay_angle : float or str
        Angle between the marks of the finish and the contact line [rad]; default: 0, marks across the motion.
    additive : {"EP", "base", "ZDDP"}
        Additive class of the oil, which gives the default boundary film and boundary friction.
    boundary_film : float or str
        Gap below which asperities are in contact [m]; default: from the additive.
    boundary_friction : float
        Friction coefficient of asperity contact [-]; default: from the additive.
    thermal : {"auto", "off", "on"}
        Heat balance.
    accuracy : {"standard", "fast", "reference"}
        Accuracy level; `friction_tolerance` [-] replaces its tolerance. With `shortcuts` = "off" no effect is neglected
        because of an estimate.

    Raises
    ------
    InputError
        The message states field, value and allowed range.

    Examples
    --------
    >>> import ehl
    >>> contact = ehl.Contact(
    ...     oil="75w90", temperature="90 degC", pressure_hertz="1.2 GPa", radius_equivalent="15 mm",
    ...     speed_entrainment="5 m/s", slide_to_roll=0.2,
    ... )
    >>> round(contact.line_contact().half_width * 1e6)
    318
    >>> contact.replace(slide_to_roll=0.1).contact.slide_to_roll
    0.1
    """

    contact: case_inputs.ContactInput
    lubricant: LubricantInput
    solid_1: case_inputs.SolidInput = case_inputs.SolidInput()
    solid_2: case_inputs.SolidInput = case_inputs.SolidInput()
    surface: case_inputs.SurfaceInput = case_inputs.SurfaceInput()
    model: case_inputs.ModelInput = case_inputs.ModelInput()

    def __init__(self, **values: Unpack[ContactKeywords]) -> None:
        tables, written = _tables(values, type(self).model_fields)
        if written:
            tables.setdefault("contact", {})
            if "lubricant" not in tables:
                raise InputError("oil", None, "an oil such as '75w90', or viscosity_inlet and pressure_viscosity")
        try:
            super().__init__(**tables)
        except ValidationError as error:

            def as_written(problem: InputError) -> InputError:
                field = written.get(problem.field, problem.field)
                table, _, key = field.partition(".")
                if written and key and table not in values:
                    field = key
                return InputError(field, problem.value, problem.allowed, problem.hint)

            raise input_error(error, type(self)).changed(as_written) from None

    __init__.__signature__ = _SIGNATURE  # type: ignore[attr-defined]

    @classmethod
    def from_file(cls, path: str | Path) -> Self:
        """The contact of an input file (TOML) of `mixed-ehl solve`; `InputError` as for `Contact`."""
        return cls(**read_toml(path, "contact"))

    def to_dict(self) -> dict[str, Any]:
        """The given inputs as tables of the input file in SI units, the keywords of an equal contact."""
        return self.model_dump(mode="json", exclude_unset=True)

    def replace(self, **changes: Unpack[ContactKeywords]) -> Self:
        """The same contact with some inputs changed (None removes one); `InputError` as for `Contact`."""
        tables, _ = _tables(changes, type(self).model_fields)
        content = self.model_dump(exclude_unset=True)
        for name, table in tables.items():
            merged = {**content.get(name, {}), **table}
            if set(case_inputs.PRINTED) & set(table):
                merged["correlation_length"] = None
            if "roughness_rms" in table:
                merged |= {each: None for each in case_inputs.EACH_RMS if each not in table}
            content[name] = {key: value for key, value in merged.items() if value is not None}
        return type(self)(**content)

    def solve(self, start: ContactResult | None = None) -> ContactResult:
        """Solve the contact; a failure to converge is a status of the result.

        Parameters
        ----------
        start : ContactResult, optional
            Result of a similar contact as the initial guess.

        Raises
        ------
        InputError
            A measured profile cannot be used.

        Examples
        --------
        >>> import ehl
        >>> contact = ehl.Contact(
        ...     viscosity_inlet=0.04, pressure_viscosity="18 1/GPa", pressure_hertz="1 GPa", radius_equivalent="10 mm",
        ...     speed_entrainment="5 m/s", slide_to_roll=0.2, thermal="off", accuracy="fast",
        ... )
        >>> contact.solve().status
        'converged'
        """
        from ehl.solve import solve_contact

        result = solve_contact(self.problem(), start)
        remarks = [
            note for note in self.lubricant.remarks() if (self.model.thermal, note) != ("off", ASSUMED_CONDUCTIVITY)
        ]
        if abs(ratio := self.contact.slide_to_roll) > 4.0:  # a value in per cent is likely
            remarks.append(f"slide-to-roll ratio {ratio:g}: surfaces in opposite directions; per cent as '{ratio:g} %'")
        return dataclasses.replace(result, notes=(*result.notes, *self.unused_inputs(), *remarks))

    def uncertainty(
        self, spreads: UncertaintyInput | None = None, level: float = 0.90, jobs: int | None = None
    ) -> InputUncertainty:
        """Interval of the friction coefficient by the uncertainty of the inputs, without the error of the solver.

        The contact is solved with each input at both ends of its interval and the same roughness (about twenty
        solutions).

        Parameters
        ----------
        spreads : UncertaintyInput, optional
            Standard deviations of the inputs; default: from oil card, finish and additives.
        level : float
            Coverage of the interval [-].
        jobs : int, optional
            Worker processes; default: one per core.

        Raises
        ------
        InputError
            The level is not between 0 and 1.
        """
        from ehl.uncertainty.contact_design import contact_uncertainty
        from ehl.uncertainty.spread import UncertaintyInput

        given, surface = spreads or UncertaintyInput(), self.surface
        texture = ("correlation_length", "peklenik_number")
        known = {name: getattr(surface, name) for name in texture if name in surface.model_fields_set}
        if surface.finish is not None:
            made = {"finish": surface.finish, "finish_state": surface.finish_state}
            own = [getattr(surface, name) for name in case_inputs.EACH_RMS if name in surface.model_fields_set]
            known["roughness_rms"] = next((rms for rms in own if rms > 0.0), None)
            given = given.of_surface(**made, **known, additive=surface.additive)
        else:
            given = given.of_surface(**known, roughness_rms=1e-6, additive=surface.additive)
        oil = Oil.load(self.lubricant.oil) if isinstance(self.lubricant, OilLubricant) else None
        return contact_uncertainty(self.problem(), _friction_of, given, oil, level, jobs)

    @property
    def effective_modulus(self) -> float:
        """Effective modulus E' [Pa], as given or from the two bodies."""
        given = self.contact.effective_modulus
        return effective_modulus(self.solid_1.body(), self.solid_2.body()) if given is None else given

    def line_contact(self) -> LineContact:
        """Geometry, load and motion, with Hertz pressure, half-width and surface speeds."""
        c, modulus = self.contact, self.effective_modulus
        load = c.load_per_length
        if c.pressure_hertz is not None:
            load = hertz_load(c.pressure_hertz, c.radius_equivalent, modulus)
        assert load is not None
        motion = (c.speed_entrainment, c.slide_to_roll, c.speed_sliding_lengthwise)
        return LineContact(c.radius_equivalent, modulus, load, *motion)

    def bulk_temperatures(self) -> tuple[float, float]:
        """Bulk temperatures of both bodies [K]; default: that of the oil."""
        oil = self.lubricant.temperature_oil
        return (self.solid_1.temperature_bulk or oil, self.solid_2.temperature_bulk or oil)

    def problem(self) -> case_inputs.ContactProblem:
        """The contact in the form of the solvers."""
        bodies = (self.solid_1.body(), self.solid_2.body())
        return case_inputs.ContactProblem(
            self.line_contact(), self.lubricant.lubricant(), self.surface, self.model, bodies, self.bulk_temperatures()
        )

    def unused_inputs(self) -> tuple[str, ...]:
        """One sentence for each given input that has no effect with the chosen models."""
        unused: list[tuple[str, str]] = []
        given, oil = self.surface.model_fields_set, self.lubricant
        unused += [(f"lubricant.{name}", why) for name, why in oil.unused_inputs()]
        if self.model.thermal == "off":
            for name, solid in (("solid_1", self.solid_1), ("solid_2", self.solid_2)):
                if solid.temperature_bulk is not None:
                    unused.append((f"{name}.temperature_bulk", "thermal is off"))
        if "hurst_exponent" in given and self.surface.spectrum == "gaussian":
            unused.append(("surface.hurst_exponent", "the spectrum is gaussian"))
        if "lay_angle" in given and self.surface.finish is None:
            unused.append(("surface.lay_angle", "it requires a finish"))
        worn, surface = self.surface.running_in, self.surface
        if worn != "none" and not surface.measured and worn >= max(surface.roughness_rms_1, surface.roughness_rms_2):
            unused.append(("surface.running_in", "Rq of both surfaces is not larger"))
        return tuple(f"{name} has no effect: {why}" for name, why in unused)

    def __repr__(self) -> str:
        return f"Contact({', '.join(f'{name}={value!r}' for name, value in self._given().items())})"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        from ehl.common.table import Table

        return Table.from_records([self._given()], title="Contact", vertical=True).html()

    def _given(self) -> dict[str, Any]:
        """Given inputs by keyword."""
        flat: dict[str, Any] = {}
        for table, content in self.to_dict().items():
            if table.startswith("solid_"):
                flat[table] = content
            else:
                flat |= content
        return flat

    @model_validator(mode="after")
    def _one_modulus(self) -> Self:
        elastic = {"youngs_modulus", "poisson_ratio", "material"}
        given = (self.solid_1.model_fields_set | self.solid_2.model_fields_set) & elastic
        if self.contact.effective_modulus is not None and given:
            allowed = "either effective_modulus or the elastic constants of [solid_1] and [solid_2]"
            raise InputError("contact.effective_modulus", self.contact.effective_modulus, allowed)
        return self

    @model_validator(mode="after")
    def _within_the_theory(self) -> Self:
        contact = self.line_contact()
        most = case_inputs.MAX_PRESSURE_OVER_MODULUS * contact.effective_modulus
        if contact.pressure_hertz > most:
            allowed = f"at most {most:.4g} Pa for this effective modulus"
            hint = "The half-width would exceed a quarter of the radius, beyond the assumption of half-spaces."
            raise InputError("contact.pressure_hertz", f"{contact.pressure_hertz:.4g} Pa", allowed, hint)
        if contact.speed_sliding > case_inputs.MAX_SLIDING:
            allowed = f"a sliding speed of at most {case_inputs.MAX_SLIDING:g} m/s"
            hint = f"It is {contact.speed_sliding:.4g} m/s."
            raise InputError("contact.slide_to_roll", self.contact.slide_to_roll, allowed, hint)
        return self


def _friction_of(p: case_inputs.ContactProblem) -> tuple[float, float, float]:
    """Friction coefficient, its relative error and the film ratio of a problem."""
    from ehl.solve import solve_contact

    found = solve_contact(p)
    return found.friction_coefficient, found.friction_error, found.film_ratio


def _tables(values: Mapping[str, Any], names: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Keywords sorted into tables of the input file, and the keyword of each entry that was given by one.

    Whole tables are not changed, so that an error in a table refers to its key in the file.
    """
    whole = {name: value for name, value in values.items() if name in names}
    tables = {name: _solid(value) if name.startswith("solid_") else value for name, value in whole.items()}
    written: dict[str, str] = {}
    for name, value in values.items():
        if name in names:
            continue
        if name not in KEYWORDS:
            raise InputError(name, value, "only the documented inputs of a contact", near(name, [*KEYWORDS, *names]))
        table, key = KEYWORDS[name]
        if (other := written.get(f"{table}.{key}")) is not None:
            raise InputError(name, value, f"not together with {other}")
        tables[table] = {**tables.get(table, {}), key: str(value) if isinstance(value, Path) else value}
        written[f"{table}.{key}"] = name
    return tables, written


def _solid(value: Any) -> Any:
    """Table of a body from the name of a material, or from a `Material`."""
    if isinstance(value, str):
        return {"material": value}
    if isinstance(value, Material):
        return value.model_dump(include=set(case_inputs.SolidInput.model_fields) - {"material"})
    return value
