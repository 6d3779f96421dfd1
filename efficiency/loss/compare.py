"""The same loaded mesh with several friction models, and the closed forms beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from efficiency.loss.closed_form import PitchGeometry, buckingham_type, coleman_type
from efficiency.loss.efficiency import LoadedGrids, solve_balanced
from efficiency.loss.efficiency_result import EfficiencyResult, LoadBalance
from efficiency.loss.kinematics import Operation
from efficiency.loss.power_loss import loss_by_region
from ehl.common.numbers import finite_or_none
from ehl.common.pages import Reportable
from ehl.fluid.oil import Oil
from regression.friction.models import ConstantFriction, FrictionModel
from regression.friction.published_registry import PUBLISHED, model_label

if TYPE_CHECKING:
    import pandas

COLEMAN_FRICTION = 0.05
# what the fitted constant is fitted to, best first; else the first fitted formula, else the first model
REFERENCES = ("ehl:all", "ehl")


@dataclass(frozen=True)
class ComparisonRow:
    """One way to the efficiency of the pair."""

    name: str  # friction model, or name of the closed form
    kind: Literal["mesh", "closed form"]  # load distribution and local friction, or one formula for the whole pair
    # [-]; nan where the way has none
    efficiency: float
    efficiency_lower: float
    efficiency_upper: float
    efficiency_error: float
    power_loss: float  # [W]
    friction_coefficient_mean: float  # [-]
    outside_range_share: float  # share of the sliding power outside the model's stated range [-]
    status: str
    reason: str
    seconds: float  # run time of friction and loss; load and geometry are shared
    efficiency_with_rolling: float  # [-]
    # share of the sliding loss by thirds of the gear flank, rows root, middle, tip, columns toe, middle, heel; empty
    # for a closed form
    loss_regions: tuple[tuple[float, ...], ...]

    @property
    def label(self) -> str:
        """What figures and pages call it."""
        return model_label(self.name) if self.kind == "mesh" else self.name


@dataclass(frozen=True, repr=False)
class Comparison(Reportable):
    """Efficiencies of one pair at one operating point."""

    presenter = "efficiency.output.comparison_report:comparison"

    design: str
    side: str
    oil: str
    # [N m], [rad/s], [K]
    torque: float
    speed: float
    temperature: float
    rows: tuple[ComparisonRow, ...]  # in the order asked for; closed forms last
    # of the rows of kind "mesh", in their order; not in `to_dict`
    results: tuple[EfficiencyResult, ...] = field(repr=False, compare=False)
    reference: str = ""  # friction model that the fitted constant has the same loss as; empty where none was fitted

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of all results, each once."""
        return tuple(dict.fromkeys(note for result in self.results for note in result.notes))

    @property
    def status(self) -> Literal["converged", "failed"]:
        """``failed`` if any row failed."""
        return "failed" if any(row.status == "failed" for row in self.rows) else "converged"

    @property
    def reason(self) -> str:
        """Which rows failed, and why."""
        return ", ".join(f"{row.label} ({row.reason})" for row in self.rows if row.status == "failed")

    def to_frame(self) -> pandas.DataFrame:
        """One row per way to the efficiency, SI units."""
        import pandas

        return pandas.DataFrame([asdict(row) for row in self.rows]).drop(columns="loss_regions")

    def __repr__(self) -> str:
        rows = ", ".join(f"{row.name} {row.efficiency:.5f}" for row in self.rows)
        return f"Comparison({self.design}, {self.side}, {self.torque:.6g} N m: {rows[:900]})"

    def _repr_html_(self) -> str:
        names = ["name", "efficiency", "efficiency_lower", "efficiency_upper", "power_loss", "outside_range_share"]
        return str(self.to_frame()[[*names, "status", "reason"]].to_html(index=False))

    def to_dict(self) -> dict[str, Any]:
        """For JSON; not-a-number becomes None."""
        names = ("design", "side", "oil", "torque", "speed", "temperature", "status", "reference")
        head = {name: getattr(self, name) for name in names}
        return head | {"notes": list(self.notes), "rows": finite_or_none(self.rows)}


def compare_models(
    loaded: LoadedGrids,
    models: Sequence[FrictionModel],
    oil: Oil,
    operation: Operation,
    pitch: PitchGeometry | None = None,
    load_balance: LoadBalance = "frictional",
) -> Comparison:
    """Efficiency of a loaded mesh with each friction model, a constant fitted to the best of them, and closed forms.

    The fitted constant is the `friction_coefficient_mean` of the reference at this operating point: without friction in
    the balance it has the same loss, with it nearly so. What a constant misses shows along the mesh and at other
    operating points. The closed forms, given where ``pitch`` is, take Coleman's constant 0.05 and the fitted one.

    loaded: geometry and load, the same for all models.
    models: friction models.
    operation: speed, oil temperature, roughness.
    pitch: pitch-point data of the pair.
    """
    results = [solve_balanced(loaded, model, oil, operation, load_balance) for model in models]
    names = [result.friction_model for result in results]
    reference = _reference(results)
    if reference is not None:
        fitted = ConstantFriction(reference.friction_coefficient_mean)
        results.append(solve_balanced(loaded, fitted, oil, operation, load_balance))
        names.append(f"{fitted.name}, fitted to {reference.friction_model}")
    rows = [_mesh_row(name, result) for name, result in zip(names, results, strict=True)]
    if pitch is not None:
        power = loaded.fine.torque * operation.speed
        constants = [COLEMAN_FRICTION] + ([reference.friction_coefficient_mean] if reference is not None else [])
        for label, form in (("Coleman-type", coleman_type), ("Buckingham-type", buckingham_type)):
            for mu in constants:
                name = f"{label} (our derivation)" + ("" if mu == COLEMAN_FRICTION else f", mu {mu:.4g}")
                rows.append(_closed_row(name, mu, form(pitch, mu, operation.driver), operation, power))
    return Comparison(
        loaded.mesh.design,
        loaded.mesh.side,
        oil.name,
        loaded.fine.torque,
        operation.speed,
        operation.temperature,
        tuple(rows),
        tuple(results),
        reference.friction_model if reference is not None else "",
    )


def _reference(results: Sequence[EfficiencyResult]) -> EfficiencyResult | None:
    """What a constant is fitted to; None where nothing but constants was asked for, or nothing converged."""
    able = [
        result
        for result in results
        if result.status == "converged"
        and not result.friction_model.startswith("constant:")
        and math.isfinite(result.friction_coefficient_mean)
    ]
    for name in REFERENCES:
        for result in able:
            if result.friction_model == name:
                return result
    fitted = [result for result in able if result.friction_model not in PUBLISHED]
    return next(iter(fitted or able), None)


def _mesh_row(name: str, result: EfficiencyResult) -> ComparisonRow:
    return ComparisonRow(
        name=name,
        kind="mesh",
        efficiency=result.efficiency,
        efficiency_lower=result.efficiency_lower,
        efficiency_upper=result.efficiency_upper,
        efficiency_error=result.efficiency_error,
        power_loss=result.power_loss,
        friction_coefficient_mean=result.friction_coefficient_mean,
        outside_range_share=result.outside_range_share,
        status=result.status,
        reason=result.reason,
        seconds=result.seconds,
        efficiency_with_rolling=result.efficiency_with_rolling,
        loss_regions=tuple(tuple(map(float, row)) for row in loss_by_region(result)),
    )


def _closed_row(name: str, mu: float, efficiency: float, operation: Operation, power: float) -> ComparisonRow:
    loss = (1.0 - efficiency) * (power if operation.driver == "pinion" else power / efficiency)
    return ComparisonRow(
        name=name,
        kind="closed form",
        efficiency=efficiency,
        efficiency_lower=math.nan,
        efficiency_upper=math.nan,
        efficiency_error=math.nan,
        power_loss=loss,
        friction_coefficient_mean=mu,
        outside_range_share=0.0,
        status="converged",
        reason="",
        seconds=0.0,
        efficiency_with_rolling=math.nan,
        loss_regions=(),
    )
