"""Heat balance, uncertainty and duty cycle of a gear run, for pages and files."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from efficiency.output.data_tables import DataTable, cell
from efficiency.output.tables import KELVIN, percent

if TYPE_CHECKING:
    from efficiency.loss.duty_cycle import DutyCycle
    from efficiency.loss.heat_balance import HeatBalance
    from efficiency.loss.uncertainty import EfficiencyUncertainty

DUTY_UNITS = {
    "torque_pinion": "N m",
    "speed_pinion": "rad/s",
    "temperature_oil": "K",
    "hours": "h",
    "energy_input": "J",
    "energy_output": "J",
    "energy_loss": "J",
    "energy_loss_rolling": "J",
}


def balance_rows(balance: HeatBalance) -> list[tuple[str, ...]]:
    """(quantity, pinion, gear) of a heat balance."""
    result = balance.result
    return [
        (
            "bulk temperature [degC]",
            f"{result.temperature_bulk_1 - KELVIN:.1f}",
            f"{result.temperature_bulk_2 - KELVIN:.1f}",
        ),
        ("friction heat into the teeth [W]", *(f"{heat:.1f}" for heat in balance.heat)),
        ("thermal resistance to the oil [K/W]", *(f"{value:.4g}" for value in balance.thermal_resistance)),
    ]


def balance_data(balance: HeatBalance) -> DataTable:
    """A heat balance in SI units."""
    result = balance.result
    rows = [
        ("temperature_bulk [K]", result.temperature_bulk_1, result.temperature_bulk_2),
        ("heat [W]", *balance.heat),
        ("thermal_resistance [K/W]", *balance.thermal_resistance),
    ]
    return DataTable("heat balance", ("quantity", "pinion", "gear"), rows)


def uncertainty_rows(uncertainty: EfficiencyUncertainty) -> list[tuple[str, ...]]:
    """(source, its standard deviation, that of the efficiency in points, share of the variance, note)."""
    return [
        (
            source.name,
            f"{source.sigma_input:.3g}" if source.sigma_input == source.sigma_input else "–",
            percent(source.sigma_efficiency, 4),
            percent(source.variance_share, 1),
            source.note,
        )
        for source in uncertainty.sources
    ]


def uncertainty_text(uncertainty: EfficiencyUncertainty) -> str:
    """Interval of the efficiency in words."""
    low, high = percent(uncertainty.efficiency_lower), percent(uncertainty.efficiency_upper)
    return (
        f"efficiency {percent(uncertainty.efficiency)} %, {100.0 * uncertainty.level:.0f} % interval {low} to {high} %"
    )


UNCERTAINTY_HEADER = ("source", "sigma, SI", "sigma of the efficiency [points]", "share of the variance [%]", "note")


def uncertainty_data(uncertainty: EfficiencyUncertainty) -> DataTable:
    """Sources of the uncertainty in SI units."""
    rows = [tuple(map(cell, asdict(source).values())) for source in uncertainty.sources]
    names = ("source", "sigma_input", "sigma_efficiency", "variance_share", "note")
    return DataTable("uncertainty", names, rows)


def duty_data(duty: DutyCycle) -> DataTable:
    """Rows of a duty cycle in SI units."""
    rows = [asdict(row) for row in duty.rows]
    return DataTable.of_columns("duty", {name: [row[name] for row in rows] for name in rows[0]}, DUTY_UNITS)
