"""What a gear command writes besides the terminal: figures, one page, a workbook, CSV files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ehl.io.errors import InputError

if TYPE_CHECKING:
    from efficiency.design.design import Design
    from efficiency.loss.compare import Comparison
    from efficiency.loss.duty_cycle import DutyCycle
    from efficiency.loss.heat_balance import HeatBalance
    from efficiency.loss.map import EfficiencyMap
    from efficiency.loss.result import EfficiencyResult
    from efficiency.loss.uncertainty import EfficiencyUncertainty
    from efficiency.output.machine_summary import Units
    from ehl.view.table import Table

_SUFFIXES = {"report": (".html", ".htm"), "xlsx": (".xlsx",)}


@dataclass(frozen=True)
class OutputFiles:
    """Where results go; None writes nothing.

    Parameters
    ----------
    plot : Path, optional
        Folder for figures, or the file of the one figure of a comparison.
    report : Path, optional
        HTML page.
    xlsx : Path, optional
        Workbook.
    csv : Path, optional
        Folder of CSV files.

    Raises
    ------
    InputError
        A suffix that does not belong to the kind of file.
    """

    plot: Path | None = None
    report: Path | None = None
    xlsx: Path | None = None
    csv: Path | None = None

    def __post_init__(self) -> None:
        for name, suffixes in _SUFFIXES.items():
            path: Path | None = getattr(self, name)
            if path is not None and path.suffix.lower() not in suffixes:
                raise InputError(f"--{name}", str(path), f"a file name ending in {suffixes[0]}")

    def write_tables(self, tables: list[Table], title: str) -> None:
        """The workbook and the CSV files that are asked for."""
        from ehl.view.table import write_csv, write_xlsx

        if self.xlsx is not None:
            write_xlsx(self.xlsx, tables, title)
        if self.csv is not None:
            write_csv(self.csv, tables)


@dataclass(frozen=True)
class Extras:
    """What else was asked for at an operating point."""

    balance: HeatBalance | None = None
    uncertainty: EfficiencyUncertainty | None = None

    def tables(self) -> list[Table]:
        """Tables of what there is."""
        from efficiency.output.tables import balance_table, uncertainty_table

        found = [] if self.balance is None else [balance_table(self.balance)]
        return found if self.uncertainty is None else [*found, uncertainty_table(self.uncertainty)]

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        found: dict[str, Any] = {}
        if self.balance is not None:
            parts = ("thermal_resistance", "heat", "rounds", "residual")
            found["heat_balance"] = {name: getattr(self.balance, name) for name in parts}
        if self.uncertainty is not None:
            found["uncertainty"] = self.uncertainty.to_dict()
        return found


def write_result(
    design: Design,
    result: EfficiencyResult,
    files: OutputFiles,
    units: Units = "metric",
    extras: Extras = Extras(),
) -> None:
    """Figures, page and tables of one operating point."""
    from efficiency.output.gear_report import save_gear_figures, write_gear_report
    from efficiency.output.tables import operating_point, result_tables

    if files.plot is not None:
        save_gear_figures(design, result, files.plot)
    if files.report is not None:
        write_gear_report(design, result, files.report, units=units, extras=extras)
    files.write_tables(
        [*result_tables(result), *extras.tables()], f"{operating_point(result)}, friction {result.friction_model}"
    )


def write_map(design: Design, grid: EfficiencyMap, files: OutputFiles, units: Units = "metric") -> None:
    """Figures, page and tables of a map; the page and the points are of the point next to the design's own."""
    from efficiency.output.gear_report import nearest_point, save_map_figures, write_gear_report
    from efficiency.output.tables import map_tables

    result = nearest_point(design, grid)
    if files.plot is not None:
        save_map_figures(grid, files.plot)
    if files.report is not None:
        write_gear_report(design, result, files.report, grid, units)
    files.write_tables(map_tables(grid), f"{result.design}, {result.side}: map, friction {result.friction_model}")


def write_comparison(comparison: Comparison, files: OutputFiles) -> None:
    """Figure, page and tables of a comparison."""
    from efficiency.output.comparison_report import write_comparison_report
    from efficiency.output.plots_load import plot_comparison
    from efficiency.output.tables import comparison_tables, operating_point
    from ehl.view.plots import save_figure

    if files.plot is not None:
        save_figure(plot_comparison(comparison), files.plot)
    if files.report is not None:
        write_comparison_report(comparison, files.report)
    files.write_tables(comparison_tables(comparison), f"{operating_point(comparison)}: friction models")


def write_duty(duty: DutyCycle, files: OutputFiles) -> None:
    """Tables of a duty cycle."""
    from efficiency.output.tables import duty_table, remarks_table

    title = f"{duty.design}: duty cycle, friction {duty.friction_model}"
    files.write_tables([duty_table(duty), remarks_table(duty.results)], title)
