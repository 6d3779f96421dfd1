"""`ContactResult`: results of one contact with status, errors and limits of the model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

from ehl.common.arrays import finite_or_none
from ehl.common.data import reason_text
from ehl.common.notes import group_notes
from ehl.common.pages import Reportable
from ehl.common.table import Table
from ehl.heat.traction import ThermalTraction
from ehl.inputs import ContactProblem
from ehl.rough import TransientResult
from ehl.rough.dry import DryContactResult
from ehl.smooth.solver import SteadyResult

if TYPE_CHECKING:
    from pandas import DataFrame

_NOT_SCALAR = ("skipped", "notes", "problem", "film", "isothermal", "heat", "transient", "dry")

_SHOWN = (
    *("friction_coefficient", "friction_fluid", "friction_asperity", "friction_error", "mesh_error"),
    *("statistical_error", "friction_boundary_half", "friction_boundary_double", "film_central", "film_min"),
    *("film_error", "film_ratio", "asperity_load_share", "roughness_load_share", "pressure_max"),
    *("rolling_traction", "temperature_film_max", "temperature_flash"),
)


@dataclass(frozen=True, repr=False)
class ContactResult(Reportable):
    """Results of one contact in SI units, with the names of docs/nomenclature.md.

    `Contact.solve` and `solve_path` return it. The main result is `friction_coefficient` with the relative error
    `friction_error`; `notes` are the relevant limits of the model. Pages and tables have the option `uncertainty`, the
    result of `Contact.uncertainty`.

    Parameters
    ----------
    status : str
        "converged"; "unsettled": usable, but an error that another input or setting may reduce exceeds four
        tolerances; "failed": there is no result and all numbers are nan.
    reason : str
        Cause of the status: empty when converged, else a reason of the solver or one of

        - "shear_strength": a film shear stress above 1 GPa; the shear law requires a limit
        - "mesh_budget" (unsettled): the largest mesh does not resolve the roughness, whose fine part is replaced by a
          subgrid film
        - "too_hot" (unsettled): film above 1000 K, where no law of the oil is valid, contributes more than half the
          tolerance to mu
        - "thermal_rounds" (unsettled): film and heat would change by more than the tolerance in further rounds
        - "mesh_error" (unsettled): the mesh error of mu is four times the tolerance or more
        - "beyond_laws" (unsettled): the error by limits of the model (notes), without that of marks along the motion,
          is four times the tolerance or more
        - "film_above_radius": a film above a tenth of the radius, beyond the validity of the Reynolds equation
        - "work_limit": a rough contact that would take far more work than its accuracy allows
    friction_coefficient, friction_fluid, friction_asperity : float
        mu = fluid + asperity part [-], without rolling traction.
    film_central, film_min : float
        h at x = 0 and the smallest h [m].
    pressure_max : float
        Maximum pressure [Pa].
    film_ratio : float
        lambda: smooth isothermal film_central over the composite Rq [-]; infinity for smooth surfaces.
    asperity_load_share : float
        Share of the load on asperity contact [-].
    roughness_load_share : float
        Share of the load above the macroscopic pressure [-].
    rolling_traction : float
        Traction of the pressure gradient over w' [-], not part of the friction.
    temperature_film_max, temperature_flash : float
        Largest temperature of the film (at which it has its effective viscosity) and of a surface [K]; the inlet
        temperature without heat balance.
    film_error, friction_error : float
        Relative error estimates [-] of discretisation, time mean (90 % interval), neglected effects, unresolved
        roughness, and the limits of the model in the notes.
    mesh_error, statistical_error : float
        The first two parts of `friction_error` [-].
    realisation_error : float
        Half width of the 90 % interval of mu over other realisations of the same surfaces, over mu [-]; not part of
        `friction_error`, which concerns the given surfaces.
    friction_boundary_half, friction_boundary_double : float
        mu at half and twice the boundary film [-]; nan with a small asperity load share or if not requested. With the
        reason "mesh_budget" mu without and with all of the fine roughness.
    skipped : tuple of str
        Neglected effects, each with the estimate that justifies it.
    notes : tuple of str
        Limits of the model that concern this case, and inputs without effect.
    iterations : int
        Newton iterations of all grids and paths.
    seconds : float
        Wall time [s].
    problem : ContactProblem
        Inputs.
    film, isothermal : SteadyResult
        Solution of the film, and the isothermal solution (for warm starts).
    heat : ThermalTraction
        Temperature profiles; None without heat balance.
    transient : TransientResult
        Transient solution with rough surfaces, or None.
    dry : DryContactResult
        Dry contact at one time if the film is negligible, or None.

    Examples
    --------
    >>> result = Contact(viscosity_inlet=0.02, pressure_viscosity=18e-9, pressure_hertz="0.8 GPa",
    ...                  radius_equivalent="15 mm", speed_entrainment="5 m/s", thermal="off").solve()
    >>> result.status, f"{1e9 * result.film_central:.0f} nm"
    ('converged', '577 nm')
    """

    presenter = "ehl.view.contact_report:contact"

    status: str
    reason: str
    friction_coefficient: float = math.nan
    friction_fluid: float = math.nan
    friction_asperity: float = math.nan
    film_central: float = math.nan
    film_min: float = math.nan
    pressure_max: float = math.nan
    film_ratio: float = math.nan
    asperity_load_share: float = math.nan
    roughness_load_share: float = math.nan
    rolling_traction: float = math.nan
    temperature_film_max: float = math.nan
    temperature_flash: float = math.nan
    film_error: float = math.nan
    friction_error: float = math.nan
    mesh_error: float = math.nan
    statistical_error: float = math.nan
    realisation_error: float = math.nan
    friction_boundary_half: float = math.nan
    friction_boundary_double: float = math.nan
    skipped: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    iterations: int = 0
    seconds: float = math.nan
    problem: ContactProblem | None = field(default=None, compare=False)
    film: SteadyResult | None = field(default=None, compare=False)
    isothermal: SteadyResult | None = field(default=None, compare=False)
    heat: ThermalTraction | None = field(default=None, compare=False)
    transient: TransientResult | None = field(default=None, compare=False)
    dry: DryContactResult | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        if self.status == "failed":
            return f"ContactResult(failed: {self.reason})"
        outcome = self.status if not self.reason else f"{self.status}: {self.reason}"
        return (
            f"ContactResult({outcome}, friction_coefficient={self.friction_coefficient:.5g} "
            f"± {100.0 * self.friction_error:.2g} %, film_central={self.film_central:.4g} m, "
            f"film_min={self.film_min:.4g} m, film_ratio={self.film_ratio:.3g}, "
            f"asperity_load_share={self.asperity_load_share:.3g}, pressure_max={self.pressure_max:.4g} Pa)"
        )

    @property
    def outcome(self) -> str:
        """Status and reason as text; for an unsettled contact with the error of its friction."""
        if self.status == "unsettled":
            return f"unsettled: {reason_text(self.reason)}; error of mu ±{100.0 * self.friction_error:.2g} %"
        return self.status if not self.reason else f"{self.status}: {reason_text(self.reason)}"

    def table(self) -> Table:
        """Results with units, neglected effects and notes, for terminal, page and files."""
        known = [name for name in _SHOWN if math.isfinite(getattr(self, name))]
        remarks = (f"{note.grade}: {note.text}" for note in group_notes(("", item) for item in self.notes))
        return Table(
            known,
            [[getattr(self, name) for name in known]] if known else [],
            title=f"line contact, {self.operating_point}".removesuffix(", "),
            notes=(self.outcome, *remarks, *(f"skipped: {item}" for item in self.skipped), self.cost),
            name="contact",
            vertical=True,
        )

    def to_dict(self) -> dict[str, Any]:
        """Scalar results in SI units for JSON; values that are not finite become None."""
        names = (item.name for item in fields(self) if item.name not in _NOT_SCALAR)
        values = {name: finite_or_none(getattr(self, name)) for name in names}
        sentences = [reason_text(self.reason), *self.notes] if self.reason else list(self.notes)
        return values | {"skipped": list(self.skipped), "notes": sentences}

    def to_frame(self) -> DataFrame:
        """One row of operating point and results in SI units."""
        return results_frame([self])

    def references(self) -> set[str]:
        """Line contact, laws of the lubricant, heat and roughness where they were solved."""
        if self.problem is None:
            return {"contact"}
        found = {"contact", *self.problem.lubricant.references()}
        found |= {"rough contact", "film formula"} if self.transient is not None else set()
        return found | ({"heat"} if self.heat is not None else set())

    @property
    def operating_point(self) -> str:
        """Pressure, radius, speed and slip as text; empty without inputs."""
        if self.problem is None:
            return ""
        line = self.problem.line
        return (
            f"p_h {line.pressure_hertz / 1e9:.3g} GPa, R {line.radius_equivalent * 1e3:.3g} mm, "
            f"u_r {line.speed_entrainment:.3g} m/s, SR {line.slide_to_roll:.3g}"
        )

    @property
    def cost(self) -> str:
        """Iterations and wall time as text."""
        seconds = f", {self.seconds:.3g} s" if math.isfinite(self.seconds) else ""
        return f"{self.iterations} Newton iterations{seconds}"


def results_frame(results: Sequence[ContactResult]) -> DataFrame:
    """One row per result with operating point and scalar results in SI units; missing values are nan."""
    import pandas as pd

    names = [item.name for item in fields(ContactResult) if item.name not in (*_NOT_SCALAR, "skipped", "notes")]
    rows = []
    for result in results:
        inputs = {} if result.problem is None else result.problem.to_dict()
        rows.append({**inputs, **{name: getattr(result, name) for name in names}})
    return pd.DataFrame(rows)
