"""What the command line shows of a duty cycle, a heat balance and the uncertainty of an efficiency."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from efficiency.output.tables import KELVIN, RPM, percent

if TYPE_CHECKING:
    from efficiency.loss.duty_cycle import DutyCycle
    from efficiency.loss.heat_balance import HeatBalance
    from efficiency.loss.uncertainty import EfficiencyUncertainty

KWH = 3.6e6
DUTY_HEADER = ("flanks", "driver", "N m", "rpm", "degC", "hours", "efficiency [%]", "in [kWh]", "lost [kWh]")


def duty_rows(cycle: DutyCycle) -> list[tuple[str, ...]]:
    """Cells of the rows of a duty cycle, the total last."""
    rows = [
        (
            row.side,
            row.driver,
            f"{row.torque_pinion:.4g}",
            f"{row.speed_pinion * RPM:.4g}",
            f"{row.temperature_oil - KELVIN:.4g}",
            f"{row.hours:.4g}",
            percent(row.efficiency) if row.status == "converged" else row.reason,
            _energy(row.energy_input),
            _energy(row.energy_loss),
        )
        for row in cycle.rows
    ]
    energies = (cycle.total(name) for name in ("energy_input", "energy_loss"))
    hours = f"{cycle.total('hours'):.4g}"
    return [*rows, ("total", "", "", "", "", hours, percent(cycle.efficiency), *map(_energy, energies))]


def duty_table(cycle: DutyCycle) -> None:
    """Print a duty cycle."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    title = f"{cycle.design}, {cycle.oil}, friction {cycle.friction_model}"
    table = Table(title=title, box=box.SIMPLE, padding=(0, 1, 0, 0))
    for number, name in enumerate(DUTY_HEADER):
        table.add_column(name, justify="left" if number < 2 else "right")
    for row in duty_rows(cycle):
        table.add_row(*row)
    console = Console()
    console.print(table)
    rolling = _energy(cycle.total("energy_loss_rolling"))
    outside = sum(row.outside_range_share * row.energy_loss for row in cycle.rows) / cycle.total("energy_loss")
    console.print(
        f"efficiency of the cycle {percent(cycle.efficiency)} +- {percent(cycle.efficiency_error, 4)} % "
        f"(discretisation); rolling loss apart {rolling} kWh; {percent(outside, 1)} % of the loss outside the range of "
        "the friction model",
        highlight=False,
    )
    for note in cycle.notes:
        console.print(f"note     {note}", highlight=False)


def heat_lines(balance: HeatBalance) -> list[str]:
    """A heat balance in words."""
    result, (pinion, gear) = balance.result, balance.heat
    resistance_pinion, resistance_gear = balance.thermal_resistance
    return [
        f"bulk temperature of the pinion {result.temperature_bulk_1 - KELVIN:.1f} degC "
        f"({pinion:.4g} W through {resistance_pinion:.3g} K/W), of the gear "
        f"{result.temperature_bulk_2 - KELVIN:.1f} degC ({gear:.4g} W through {resistance_gear:.3g} K/W)",
        f"oil enters the contacts at {result.temperature_inlet - KELVIN:.1f} degC; {balance.rounds} rounds, "
        f"{balance.residual:.1g} K left",
    ]


def uncertainty_table(uncertainty: EfficiencyUncertainty) -> None:
    """Print where the uncertainty of an efficiency comes from."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    low, high = percent(uncertainty.efficiency_lower), percent(uncertainty.efficiency_upper)
    title = f"{100.0 * uncertainty.level:.3g} % interval of the efficiency: {low} to {high} %"
    table = Table(title=title, box=box.SIMPLE, padding=(0, 1, 0, 0))
    for name in ("source", "sigma [%]", "share of the variance [%]"):
        table.add_column(name, justify="left" if name == "source" else "right")
    table.add_column("", overflow="fold")
    for source in uncertainty.sources:
        table.add_row(source.name, percent(source.sigma_efficiency), percent(source.variance_share, 1), source.note)
    Console().print(table)


def _energy(joule: float) -> str:
    return f"{joule / KWH:.4g}" if math.isfinite(joule) else "–"
