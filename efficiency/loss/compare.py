"""Comparison of several friction models on the same loaded mesh, and with closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from efficiency.loss.closed_form import PitchGeometry, buckingham_type, coleman_type
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.efficiency_result import EfficiencyResult, LoadBalance, OperatingConditions
from efficiency.loss.kinematics import Operation
from efficiency.loss.power_loss import loss_by_region, loss_of
from efficiency.ltca.mesh_grids import LoadedGrids
from ehl.common.arrays import finite_or_none
from ehl.common.data import reason_text
from ehl.common.pages import Reportable, StatusOfReason
from ehl.fluid.oil import Oil
from regression.friction.models import COLEMAN_FRICTION, ConstantFriction, FrictionModel
from regression.friction.published_registry import PUBLISHED, model_label

if TYPE_CHECKING:
    import pandas

DEFAULT_MODELS = (
    *("constant:0.05", "xu_kahraman_2007", "benedict_kelley_1961", "schlenk_1994", "arana_2019"),
    *("ehl:smooth", "ehl"),
)
# references of the fitted constant in order of priority; then the first fitted formula, then the first model
REFERENCES = ("ehl:all", "ehl")


@dataclass(frozen=True)
class ComparisonRow:
    """One result of a comparison."""

    name: str  # friction model, or name of the closed form
    kind: Literal["mesh", "closed form"]  # load distribution and local friction, or one formula for the whole pair
    efficiency: float  # [-]
    # [-]; nan for a closed form
    efficiency_lower: float = math.nan
    efficiency_upper: float = math.nan
    efficiency_error: float = math.nan
    power_loss: float = math.nan  # [W]
    friction_coefficient_mean: float = math.nan  # [-]
    outside_range_share: float = 0.0  # share of the sliding power outside the stated range of the model [-]
    status: str = "converged"
    reason: str = ""
    seconds: float = 0.0  # run time of friction and loss; load and geometry are shared
    efficiency_with_rolling: float = math.nan  # [-]
    # share of the sliding loss by thirds of the gear flank, rows root, middle, tip, columns toe, middle, heel; empty
    # for a closed form
    loss_regions: tuple[tuple[float, ...], ...] = ()
    loss_factor: float = math.nan  # loss over that of the reference
    # of a duty cycle, if given: energy loss [J], over that of the first fitted formula, and least and largest such
    # ratio of its rows
    energy_loss: float = math.nan
    energy_factor: float = math.nan
    energy_factor_min: float = math.nan
    energy_factor_max: float = math.nan

    @property
    def label(self) -> str:
        """Name in figures and on pages."""
        return model_label(self.name) if self.kind == "mesh" else self.name


@dataclass(frozen=True, repr=False)
class Comparison(StatusOfReason, Reportable):
    """Efficiencies of one pair at one operating point."""

    presenter = "efficiency.output.comparison_report:comparison"

    design: str
    side: str
    conditions: OperatingConditions
    rows: tuple[ComparisonRow, ...]  # in the given order; closed forms last
    # results of the rows of kind "mesh", in their order; not in `to_dict`
    results: tuple[EfficiencyResult, ...] = field(repr=False, compare=False)
    reference: str = ""  # friction model with the same loss as the fitted constant; empty without a fitted constant

    @property
    def base(self) -> ComparisonRow | None:
        """Row to whose loss the others are compared: of `reference`, otherwise the first one with a result."""
        found = [row for row in self.rows if math.isfinite(row.power_loss)]
        return next((row for row in found if row.name == self.reference), next(iter(found), None))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of all results, each once."""
        return tuple(dict.fromkeys(note for result in self.results for note in result.notes))

    @property
    def reason(self) -> str:
        """Failed rows with their reasons."""
        return ", ".join(f"{row.label} ({reason_text(row.reason)})" for row in self.rows if row.status == "failed")

    def to_frame(self) -> pandas.DataFrame:
        """One row per result, SI units."""
        import pandas

        return pandas.DataFrame([asdict(row) for row in self.rows]).drop(columns="loss_regions")

    def __repr__(self) -> str:
        rows = ", ".join(f"{row.name} {row.efficiency:.5f}" for row in self.rows)
        return f"Comparison({self.design}, {self.side}, {self.conditions.torque:.6g} N m: {rows[:900]})"

    def to_dict(self) -> dict[str, Any]:
        """Content for JSON; not-a-number becomes None."""
        names = ("design", "side", "conditions", "status", "reference", "notes", "rows")
        return {name: finite_or_none(getattr(self, name)) for name in names}


def compare_models(
    loaded: LoadedGrids,
    models: Sequence[FrictionModel],
    oil: Oil,
    operation: Operation,
    pitch: PitchGeometry,
    load_balance: LoadBalance,
) -> Comparison:
    """Efficiency of a loaded mesh with each friction model, with a fitted constant, and by closed forms.

    The fitted constant is the `friction_coefficient_mean` of the reference at this operating point. It gives the same
    loss as the reference without friction in the balance, and nearly the same with it. The closed forms
    use Coleman's constant 0.05 and the fitted one.

    loaded: geometry and load, the same for all models.
    operation: speed, oil temperature, roughness.
    pitch: pitch-point data of the pair.
    """
    results = [mesh_efficiency(loaded, model, oil, operation, load_balance) for model in models]
    names = [result.friction_model for result in results]
    reference = _reference(results)
    if reference is not None:
        fitted = ConstantFriction(reference.friction_coefficient_mean)
        results.append(mesh_efficiency(loaded, fitted, oil, operation, load_balance))
        names.append(f"{fitted.name}, fitted to {reference.friction_model}")
    rows = []
    for name, result in zip(names, results, strict=True):
        own = {f.name: getattr(result, f.name) for f in fields(ComparisonRow) if hasattr(result, f.name)}
        regions = tuple(tuple(map(float, row)) for row in loss_by_region(result))
        rows.append(ComparisonRow(name, "mesh", loss_regions=regions, **own))
    constants = [COLEMAN_FRICTION] + ([reference.friction_coefficient_mean] if reference is not None else [])
    for label, form in (("Coleman-type", coleman_type), ("Buckingham-type", buckingham_type)):
        for mu in constants:
            name = f"{label} (this work)" + ("" if mu == COLEMAN_FRICTION else f", mu {mu:.4g}")
            eta = form(pitch, mu, operation.driver)
            loss = loss_of(eta, loaded.fine.torque, operation.speed, operation.driver)
            rows.append(ComparisonRow(name, "closed form", eta, power_loss=loss, friction_coefficient_mean=mu))
    named = reference.friction_model if reference is not None else ""
    found = Comparison(loaded.mesh.design, loaded.mesh.side, results[0].conditions, tuple(rows), tuple(results), named)
    base = found.base.power_loss if found.base is not None else math.nan
    return replace(found, rows=tuple(replace(row, loss_factor=row.power_loss / base) for row in rows))


def over_duty(comparison: Comparison, cycle_of: Callable[[str], Any]) -> Comparison:
    """The comparison with the energies of a duty cycle, for all models but solved contacts.

    cycle_of: the duty cycle, `efficiency.conditions.duty.DutyCycle`, with a friction model by its name.
    """
    models = [result.friction_model for result in comparison.results]
    losses = {
        name: np.array([row.energy_loss for row in cycle_of(name).rows])
        for name in models
        if not name.startswith("ehl")
    }
    fitted = [name for name in losses if name not in PUBLISHED and not name.startswith("constant:")]
    base, rows = losses[next(iter(fitted or losses))], list(comparison.rows)
    for place, name in enumerate(models):
        if name in losses:
            ratios, total = losses[name] / base, float(losses[name].sum())
            rows[place] = replace(
                rows[place],
                energy_loss=total,
                energy_factor=total / float(base.sum()),
                energy_factor_min=float(ratios.min()),
                energy_factor_max=float(ratios.max()),
            )
    return replace(comparison, rows=tuple(rows))


def _reference(results: Sequence[EfficiencyResult]) -> EfficiencyResult | None:
    """Reference of the fitted constant; None if all models are constants or none has converged."""
    able = [
        result
        for result in results
        if result.status == "converged"
        and not result.friction_model.startswith("constant:")
        and math.isfinite(result.friction_coefficient_mean)
    ]
    named = [result for name in REFERENCES for result in able if result.friction_model == name]
    fitted = [result for result in able if result.friction_model not in PUBLISHED]
    return next(iter(named or fitted or able), None)
