"""The same loaded mesh with several friction models, and the closed forms beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from efficiency.loss.closed_form import PitchGeometry, buckingham_type, coleman_type
from efficiency.loss.efficiency import LoadedMesh, mesh_efficiency
from efficiency.loss.kinematics import Operation
from efficiency.loss.result import EfficiencyResult
from ehl.oil import Oil
from regression.friction_models import FrictionModel

COLEMAN_FRICTION = 0.05


@dataclass(frozen=True)
class ComparisonRow:
    """One way to the efficiency of the pair.

    Attributes
    ----------
    name : str
        Friction model, or name of the closed form.
    kind : {"mesh", "closed form"}
        Load distribution and local friction, or one formula for the whole pair.
    efficiency, efficiency_lower, efficiency_upper, efficiency_error : float
        [-]; nan where the way has none.
    power_loss : float
        [W].
    friction_coefficient_mean : float
        [-].
    outside_range_share : float
        Share of the sliding power outside the model's stated range [-].
    status, reason : str
    seconds : float
    """

    name: str
    kind: Literal["mesh", "closed form"]
    efficiency: float
    efficiency_lower: float
    efficiency_upper: float
    efficiency_error: float
    power_loss: float
    friction_coefficient_mean: float
    outside_range_share: float
    status: str
    reason: str
    seconds: float


@dataclass(frozen=True)
class Comparison:
    """Efficiencies of one pair at one operating point.

    Attributes
    ----------
    design, side, oil : str
    torque_pinion, speed_pinion, temperature_oil : float
        [N m], [rad/s], [K].
    rows : tuple of ComparisonRow
        In the order asked for; closed forms last.
    results : tuple of EfficiencyResult
        Of the rows of kind "mesh", in their order; not in `to_dict`.
    """

    design: str
    side: str
    oil: str
    torque_pinion: float
    speed_pinion: float
    temperature_oil: float
    rows: tuple[ComparisonRow, ...]
    results: tuple[EfficiencyResult, ...] = field(repr=False, compare=False)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of all results, each once."""
        return tuple(dict.fromkeys(note for result in self.results for note in result.notes))

    @property
    def status(self) -> Literal["converged", "failed"]:
        """``failed`` if any row failed."""
        return "failed" if any(row.status == "failed" for row in self.rows) else "converged"

    def to_dict(self) -> dict[str, Any]:
        """For JSON; not-a-number becomes None."""
        head = {
            name: getattr(self, name)
            for name in ("design", "side", "oil", "torque_pinion", "speed_pinion", "temperature_oil", "status")
        }
        return head | {"notes": list(self.notes), "rows": [_plain(asdict(row)) for row in self.rows]}


def compare_models(
    loaded: LoadedMesh,
    models: Sequence[FrictionModel],
    oil: Oil,
    operation: Operation,
    pitch: PitchGeometry | None = None,
) -> Comparison:
    """Efficiency of a loaded mesh with each friction model; closed forms with mu 0.05 where ``pitch`` is given.

    Parameters
    ----------
    loaded : LoadedMesh
        Geometry and load, the same for all models.
    models : sequence of FrictionModel
        Friction models.
    oil : Oil
        Oil card.
    operation : Operation
        Speed, oil temperature, roughness.
    pitch : PitchGeometry, optional
        Pitch-point data of the pair.
    """
    results = tuple(mesh_efficiency(loaded, model, oil, operation) for model in models)
    rows = [_mesh_row(result) for result in results]
    if pitch is not None:
        power = loaded.fine.torque_pinion * operation.speed_pinion
        rows.append(_closed_row("Coleman-type (our derivation)", coleman_type(pitch, COLEMAN_FRICTION), power))
        rows.append(_closed_row("Buckingham-type (our derivation)", buckingham_type(pitch, COLEMAN_FRICTION), power))
    return Comparison(
        loaded.mesh.design,
        loaded.mesh.side,
        oil.name,
        loaded.fine.torque_pinion,
        operation.speed_pinion,
        operation.temperature_oil,
        tuple(rows),
        results,
    )


def _mesh_row(result: EfficiencyResult) -> ComparisonRow:
    return ComparisonRow(
        name=result.friction_model,
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
    )


def _closed_row(name: str, efficiency: float, power: float) -> ComparisonRow:
    return ComparisonRow(
        name=name,
        kind="closed form",
        efficiency=efficiency,
        efficiency_lower=math.nan,
        efficiency_upper=math.nan,
        efficiency_error=math.nan,
        power_loss=(1.0 - efficiency) * power,
        friction_coefficient_mean=COLEMAN_FRICTION,
        outside_range_share=0.0,
        status="converged",
        reason="",
        seconds=0.0,
    )


def _plain(row: dict[str, Any]) -> dict[str, Any]:
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in row.items()}
