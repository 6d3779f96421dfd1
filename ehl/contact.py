"""`Contact`: one lubricated line contact with all its inputs, by keywords or from a file."""

from __future__ import annotations

import dataclasses
import difflib
import inspect
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self, TypedDict, Unpack, cast

from pydantic import ValidationError, model_validator

from ehl.common.errors import InputError
from ehl.common.validation import InputModel, input_error, read_toml
from ehl.fluid.lubricant_inputs import DirectLubricant, LubricantInput, OilLubricant
from ehl.fluid.pressure_viscosity import AlphaDefinition
from ehl.fluid.rheology import Limit, Rheology
from ehl.inputs import (
    EACH_RMS,
    MAX_PRESSURE_OVER_MODULUS,
    MAX_SLIDING,
    PRINTED,
    Accuracy,
    ContactInput,
    ContactProblem,
    ModelInput,
    SolidInput,
    SurfaceInput,
    Thermal,
)
from ehl.line_contact import LineContact
from ehl.material import Material, effective_modulus
from ehl.surface.finish import State

if TYPE_CHECKING:
    from ehl.result import ContactResult
    from ehl.uncertainty.result import InputUncertainty
    from ehl.uncertainty.spread import UncertaintyInput

Amount = float | str | None  # SI number or text with its unit; None takes an input away


class ContactKeywords(TypedDict, total=False):
    """Keywords of `Contact`: the keys of the input file without its tables, or whole tables."""

    radius_equivalent: Amount
    effective_modulus: Amount
    pressure_hertz: Amount
    load_per_length: Amount
    speed_entrainment: Amount
    slide_to_roll: Amount
    speed_sliding_lengthwise: Amount
    oil: str | None
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
    running_in: Literal["none", "plastic"] | None
    seed: int | None
    thermal: Thermal | None
    accuracy: Accuracy | None
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
        ("contact", ContactInput),
        ("lubricant", OilLubricant),
        ("lubricant", DirectLubricant),
        ("surface", SurfaceInput),
        ("model", ModelInput),
    )
    for name in model.model_fields
} | {
    "temperature": ("lubricant", "temperature_oil"),
    **{name: ("surface", name) for name in ("roughness_rms", *PRINTED)},
    "temperature_bulk_1": ("solid_1", "temperature_bulk"),
    "temperature_bulk_2": ("solid_2", "temperature_bulk"),
}

# for completion and help where types are not read
_SIGNATURE = inspect.Signature(
    [inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)]
    + [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY) for name in (*KEYWORDS, "solid_1", "solid_2")]
)


class Contact(InputModel):
    """One lubricated line contact: geometry, load, motion, oil, bodies, surfaces and the models to use.

    Every quantity is an SI number or a string with its unit. The keywords are the keys of the input file of
    `mixed-ehl solve`, without its tables; whole tables are taken as well (``surface={"seed": 3}``).

    Parameters
    ----------
    radius_equivalent : float or str
        Radius R of the equivalent cylinder on a plane [m].
    pressure_hertz, load_per_length : float or str
        Maximum Hertz pressure [Pa], or load per length [N/m]: exactly one of the two.
    speed_entrainment : float or str
        Mean of both surface velocities across the contact line [m/s].
    slide_to_roll : float
        Signed sliding across the line over `speed_entrainment` [-]; 0 when not given.
    speed_sliding_lengthwise : float or str
        Sliding along the contact line [m/s]; 0 when not given.
    effective_modulus : float or str
        E' with 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [Pa]; from both bodies when not given.
    oil : str
        Name of a shipped oil (`ehl.shipped("oils")`) or path of an oil card; it needs `temperature`.
    temperature : float or str
        Oil temperature at the inlet [K], also `temperature_oil`.
    viscosity_inlet, pressure_viscosity : float or str
        Dynamic viscosity [Pa s] and pressure-viscosity coefficient [1/Pa] at the inlet, instead of `oil`. With them
        go `viscosity_law`, `density_law`, `density_coefficients`, `temperature_viscosity` [1/K] and `density` [kg/m3].
    rheology : {"eyring", "newtonian", "carreau"}
        Shear law. Its parameters are `eyring_stress` [Pa], `eyring_stress_law`, `eyring_stress_pressure`,
        `carreau_stress` [Pa], `carreau_exponent`, `limiting_shear`, `limiting_shear_coefficient` and
        `limiting_shear_ambient` [Pa].
    thermal_conductivity, heat_capacity : float or str
        Of the oil [W/(m K)], [J/(kg K)].
    solid_1, solid_2 : str, Material or dict
        Name of a shipped material, a `Material`, or the keys of the table in the input file; steel when not given.
    temperature_bulk_1, temperature_bulk_2 : float or str
        Bulk temperatures [K]; that of the oil when not given.
    roughness_rms : float or str
        Composite Rq [m], shared evenly by both surfaces; or, of each surface, `roughness_rms_1` and `roughness_rms_2`.
    profile_1, profile_2 : str
        Files of measured profiles instead, kept between `cutoff_short` and `cutoff_long` [m] after a polynomial of the
        order `detrend`, the form, was taken out (2). `profile_unit_x` and `profile_unit_height` give their units where
        the files have none.
    finish, finish_state : str
        How the surfaces were made (`ehl.shipped("finishes")`), and whether they are "run_in" (default) or "new"; gives
        Rq, correlation length, skewness, lay and a self-affine spectrum, each where it is not given.
    correlation_length, skewness, kurtosis, peklenik_number, seed : float, str or int
        Shape of generated roughness; the correlation length [m] is 40 Rq when not given.
    rsm, rdq, sal : float or str
        Of each surface as a profilometer prints them, in place of the correlation length: mean spacing [m], RMS slope
        [-], autocorrelation length to 0.2 [m]; several are checked against one another.
    running_in : {"none", "plastic"}
        Whether asperities that a dry contact presses beyond the hardness are flattened first (ours, not proven).
    spectrum, hurst_exponent : {"gaussian", "self_affine"}, float
        One correlation length, or waves of all lengths below it.
    lay_angle : float or str
        Between the marks of the finish and the contact line [rad]; 0 when not given, across the motion.
    additive : {"EP", "base", "ZDDP"}
        Additives of the oil: film and friction of the asperities where not given.
    boundary_film : float or str
        Gap at which asperities touch [m]; from additive and roughness when not given.
    boundary_friction : float
        Friction coefficient of asperity contact [-]; that of the additive when not given.
    thermal : {"auto", "off", "on"}
        Heat balance.
    accuracy : {"standard", "fast", "reference"}
        With `friction_tolerance` [-]; `shortcuts` = "off" leaves nothing out that an estimate finds small.

    Raises
    ------
    InputError
        Naming the field, its value and what is allowed.

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

    contact: ContactInput
    lubricant: LubricantInput
    solid_1: SolidInput = SolidInput()
    solid_2: SolidInput = SolidInput()
    surface: SurfaceInput = SurfaceInput()
    model: ModelInput = ModelInput()

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
        """The contact of an input file (TOML), as `mixed-ehl solve` reads it.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Contact

        Raises
        ------
        InputError
            The file cannot be read, or naming field, value and what is allowed.
        """
        return cls(**read_toml(path, "contact"))

    @classmethod
    def from_dict(cls, content: Mapping[str, object]) -> Self:
        """The contact of a dictionary of keywords or of tables as in the input file.

        Parameters
        ----------
        content : mapping

        Returns
        -------
        Contact

        Raises
        ------
        InputError
            Naming field, value and what is allowed.

        Examples
        --------
        >>> import ehl
        >>> contact = ehl.Contact.from_dict({
        ...     "contact": {"radius_equivalent": 0.01, "pressure_hertz": 1e9, "speed_entrainment": 5.0},
        ...     "lubricant": {"oil": "fva3", "temperature_oil": "80 degC"},
        ... })
        >>> contact == ehl.Contact.from_dict(contact.to_dict())
        True
        """
        return cls(**cast(ContactKeywords, content))

    def to_dict(self) -> dict[str, Any]:
        """The inputs that were given, as tables of the input file in SI units.

        Returns
        -------
        dict
        """
        return self.model_dump(mode="json", exclude_unset=True)

    def replace(self, **changes: Unpack[ContactKeywords]) -> Self:
        """The same contact with some inputs changed.

        Parameters
        ----------
        **changes
            Keywords as of `Contact`; None takes an input away.

        Returns
        -------
        Contact

        Raises
        ------
        InputError
            As `Contact`.
        """
        tables, _ = _tables(changes, type(self).model_fields)
        content = self.model_dump(exclude_unset=True)
        for name, table in tables.items():
            merged = {**content.get(name, {}), **table}
            if set(PRINTED) & set(table):
                merged["correlation_length"] = None
            if "roughness_rms" in table:
                merged |= {each: None for each in EACH_RMS if each not in table}
            content[name] = {key: value for key, value in merged.items() if value is not None}
        return type(self)(**content)

    def solve(self, start: ContactResult | None = None) -> ContactResult:
        """Solve the contact; a failure to converge is a status of the result.

        Parameters
        ----------
        start : ContactResult, optional
            Result of a similar contact, as a first guess.

        Returns
        -------
        ContactResult

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

        p = self.problem()
        result = solve_contact(p.line, p.lubricant, p.surface, p.model, p.bodies, p.temperature_bulk, start)
        return dataclasses.replace(result, notes=(*result.notes, *self.unused_inputs(), *self.lubricant.remarks()))

    def uncertainty(
        self, spreads: UncertaintyInput | None = None, level: float = 0.90, jobs: int | None = None
    ) -> InputUncertainty:
        """Interval of the friction coefficient by what is not known of the inputs; the solver's error is not in it.

        The contact is solved with each input at both ends of its own interval, with the same roughness: about twenty
        solutions.

        Parameters
        ----------
        spreads : UncertaintyInput, optional
            How well inputs are known; by default as oil card, finish and additives say.
        level : float
            Share of cases the interval is to hold [-].
        jobs : int, optional
            Worker processes; one per core if not given.

        Returns
        -------
        InputUncertainty

        Raises
        ------
        InputError
            The level is no share between 0 and 1.
        """
        from ehl.fluid.oil import Oil
        from ehl.uncertainty.contact_design import contact_uncertainty
        from ehl.uncertainty.spread import UncertaintyInput

        given, surface = spreads or UncertaintyInput(), self.surface
        if surface.finish is not None:
            made = {"finish": surface.finish, "finish_state": surface.finish_state}
            own = [rms for rms in (surface.roughness_rms_1, surface.roughness_rms_2) if rms > 0.0]
            given = given.of_surface(**made, roughness_rms=own[0] if own else None, additive=surface.additive)
        else:
            given = given.of_surface(roughness_rms=1e-6, additive=surface.additive)
        oil = Oil.load(self.lubricant.oil) if isinstance(self.lubricant, OilLubricant) else None
        return contact_uncertainty(self.problem(), _friction_of, given, oil, level, jobs)

    @property
    def effective_modulus(self) -> float:
        """Effective modulus E' [Pa], as given or from the two bodies."""
        given = self.contact.effective_modulus
        return effective_modulus(self.solid_1.body(), self.solid_2.body()) if given is None else given

    def line_contact(self) -> LineContact:
        """Geometry, load and motion, with Hertz pressure, half-width and surface speeds.

        Returns
        -------
        LineContact
        """
        c = self.contact
        motion = {
            "speed_entrainment": c.speed_entrainment,
            "slide_to_roll": c.slide_to_roll,
            "speed_sliding_lengthwise": c.speed_sliding_lengthwise,
        }
        if c.pressure_hertz is not None:
            return LineContact.from_pressure(
                radius_equivalent=c.radius_equivalent,
                effective_modulus=self.effective_modulus,
                pressure_hertz=c.pressure_hertz,
                **motion,
            )
        assert c.load_per_length is not None
        return LineContact(c.radius_equivalent, self.effective_modulus, c.load_per_length, **motion)

    def bulk_temperatures(self) -> tuple[float, float]:
        """Bulk temperatures of both bodies [K]; the oil's where none is given."""
        oil = self.lubricant.temperature_oil
        return (self.solid_1.temperature_bulk or oil, self.solid_2.temperature_bulk or oil)

    def problem(self) -> ContactProblem:
        """The contact as the solvers take it."""
        return ContactProblem(
            self.line_contact(),
            self.lubricant.lubricant(),
            self.surface,
            self.model,
            (self.solid_1.body(), self.solid_2.body()),
            self.bulk_temperatures(),
        )

    def unused_inputs(self) -> tuple[str, ...]:
        """One sentence for each given input that the chosen models do not use."""
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
            unused.append(("surface.lay_angle", "no finish is named"))
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
        elastic = {"E", "nu", "youngs_modulus", "poisson_ratio", "material"}
        given = (self.solid_1.model_fields_set | self.solid_2.model_fields_set) & elastic
        if self.contact.effective_modulus is not None and given:
            raise InputError(
                "contact.effective_modulus",
                self.contact.effective_modulus,
                "either effective_modulus or the elastic constants of [solid_1] and [solid_2]",
            )
        return self

    @model_validator(mode="after")
    def _within_the_theory(self) -> Self:
        contact = self.line_contact()
        if contact.pressure_hertz > MAX_PRESSURE_OVER_MODULUS * contact.effective_modulus:
            raise InputError(
                "contact.pressure_hertz",
                f"{contact.pressure_hertz:.4g} Pa",
                f"at most {MAX_PRESSURE_OVER_MODULUS * contact.effective_modulus:.4g} Pa for this effective modulus",
                "The contact would be wider than a quarter of its radius, and bodies are half-spaces here.",
            )
        if contact.speed_sliding > MAX_SLIDING:
            raise InputError(
                "contact.slide_to_roll",
                self.contact.slide_to_roll,
                f"a sliding speed of at most {MAX_SLIDING:g} m/s",
                f"It is {contact.speed_sliding:.4g} m/s.",
            )
        return self


def _friction_of(p: ContactProblem) -> tuple[float, float, float]:
    """Friction coefficient, its relative error and the film ratio of a problem."""
    from ehl.solve import solve_contact

    found = solve_contact(p.line, p.lubricant, p.surface, p.model, p.bodies, p.temperature_bulk)
    return found.friction_coefficient, found.friction_error, found.film_ratio


def _tables(values: Mapping[str, Any], names: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Keywords sorted into tables of the input file, and the keyword of each place that was given by one.

    Whole tables pass as they are, so that an error in one names its place in the file.
    """
    tables: dict[str, Any] = {}
    written: dict[str, str] = {}
    for name, value in values.items():
        if name in names:
            tables[name] = _solid(value) if name.startswith("solid_") else value
    for name, value in values.items():
        if name in names:
            continue
        if name not in KEYWORDS:
            close = difflib.get_close_matches(name, [*KEYWORDS, *names], n=3)
            known = f"Did you mean {' or '.join(close)}?" if close else ""
            raise InputError(name, value, "only the documented inputs of a contact", known)
        table, key = KEYWORDS[name]
        tables[table] = {**tables.get(table, {}), key: value}
        written[f"{table}.{key}"] = name
    return tables, written


def _solid(value: Any) -> Any:
    """Table of a body from the name of a material or a `Material`."""
    if isinstance(value, str):
        return {"material": value}
    if isinstance(value, Material):
        return value.model_dump(include=set(SolidInput.model_fields) - {"material"})
    return value
