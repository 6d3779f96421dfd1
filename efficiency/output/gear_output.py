"""What a gear result shows and writes: tables on the terminal, figures, one page, a workbook, CSV files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from efficiency.conditions.duty import DutyCycle
from efficiency.conditions.grid import Grid
from efficiency.geometry.misalignment import MisalignmentGrid
from efficiency.loss.compare import Comparison
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.notes import pair_notes
from ehl.common.errors import InputError
from regression.friction.published_registry import model_label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from efficiency.design.design import Design
    from efficiency.loss.heat_balance import HeatBalance
    from efficiency.output.machine_summary import Units
    from ehl.common.table import Table
    from ehl.uncertainty.result import InputUncertainty

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

    @classmethod
    def of(cls, files: Mapping[str, Any]) -> OutputFiles:
        """From names of the kinds of files to places."""
        for name in files:
            if name not in cls.__dataclass_fields__:
                raise InputError("file", name, "one of " + ", ".join(cls.__dataclass_fields__))
        return cls(**{name: None if place is None else Path(place) for name, place in files.items()})

    def __post_init__(self) -> None:
        for name, suffixes in _SUFFIXES.items():
            path: Path | None = getattr(self, name)
            if path is not None and path.suffix.lower() not in suffixes:
                raise InputError(name, str(path), f"a file name ending in {suffixes[0]}")

    def write_tables(self, tables: list[Table], title: str) -> None:
        """The workbook and the CSV files that are asked for."""
        from ehl.common.pages import write_csv, write_xlsx

        if self.xlsx is not None:
            write_xlsx(self.xlsx, tables, title)
        if self.csv is not None:
            write_csv(self.csv, tables)


@dataclass(frozen=True)
class GearOutput:
    """Draws, prints and writes the results of a design (`efficiency.loss.efficiency_result.Output`)."""

    design: Design

    def figures(self, result: Any) -> dict[str, Figure]:
        """Figures by their names, the most telling one first."""
        from efficiency.output import gear_report, geometry_report, plots_load, plots_map, plots_misalignment

        named: Iterable[tuple[Any, ...]]
        if isinstance(result, EfficiencyResult):
            named = gear_report.gear_figures(self.design, result)
        elif isinstance(result, Grid):
            named = plots_map.grid_figures(result)
        elif isinstance(result, Comparison):
            named = [("comparison", plots_load.plot_comparison(result))]
        elif isinstance(result, DutyCycle):
            named = [("duty", plots_map.duty_figure(result))]
        elif isinstance(result, MisalignmentGrid):
            named = plots_misalignment.misalignment_figures(self.design, result.studies)
        else:
            named = geometry_report.geometry_figures(result)
        return {name: figure for name, figure, *_ in named}

    def tables(self, result: Any, **parts: Any) -> list[Table]:
        """The tables a reader looks for first; `balance` and `uncertainty` of an efficiency with it."""
        from efficiency.output import geometry_tables, misalignment_table, notes, tables
        from ehl.common.notes import notes_table

        if isinstance(result, Grid):
            if tuple(result.axes) == ("torque", "speed", "temperature"):
                return [*tables.efficiency_grids(result), notes.grid_notes(result)]
            return [tables.map_table(result)]
        if isinstance(result, Comparison):
            found = notes.comparison_notes(result)
            return [tables.models_table(result), notes_table(found, len(result.results))]
        if isinstance(result, DutyCycle):
            return [tables.duty_table(result), notes.duty_notes(result)]
        if isinstance(result, EfficiencyResult):
            strength = [replace(table, notes=result.strength.notes) for table in tables.strength_tables(result)[:1]]
            told = notes_table(pair_notes(notes.result_notes(result)))
            added = _added(parts.get("balance"), parts.get("uncertainty"))
            return [tables.efficiency_table(result), told, *strength, *added]
        if isinstance(result, MisalignmentGrid):
            return [misalignment_table.misalignment_table(study) for study in result.studies]
        return geometry_tables.geometry_tables(result, parts.get("units", "metric"))

    def show(self, result: Any, **parts: Any) -> None:
        """Print the tables of a result."""
        for table in self.tables(result, **parts):
            table.print()

    def write(self, result: Any, units: Any, **files: Any) -> list[Path]:
        """Write files, see `efficiency.loss.efficiency_result.Presented.write`."""
        from efficiency.output import geometry_report, misalignment_table, plots_misalignment
        from ehl.common.pages import save_figures

        balance = files.pop("balance", None)
        files.pop("uncertainty", None)  # always written
        where = OutputFiles.of(files)
        if isinstance(result, EfficiencyResult):
            write_result(self.design, result, where, units, balance)
        elif isinstance(result, Grid):
            write_map(self.design, result, where, units)
        elif isinstance(result, Comparison):
            write_comparison(result, where)
        elif isinstance(result, DutyCycle):
            write_duty(result, where)
        elif isinstance(result, MisalignmentGrid):
            if where.csv is not None:
                misalignment_table.write_misalignment(where.csv, result)
            if where.plot is not None:
                save_figures(plots_misalignment.misalignment_figures(self.design, result.studies), where.plot)
        else:
            if where.plot is not None:
                save_figures(geometry_report.geometry_figures(result), where.plot)
            if where.report is not None:
                geometry_report.write_geometry_report(result, where.report, units)
        written = (where.plot, where.report, where.xlsx, where.csv)
        return [path for path in written if path is not None]


def write_result(
    design: Design,
    result: EfficiencyResult,
    files: OutputFiles,
    units: Units = "metric",
    balance: HeatBalance | None = None,
) -> None:
    """Figures, page and tables of one operating point."""
    from efficiency.output.gear_report import gear_figures, write_gear_report
    from efficiency.output.tables import operating_point, result_tables
    from ehl.common.pages import save_figures

    more = _added(balance)
    if files.plot is not None:
        save_figures(gear_figures(design, result), files.plot)
    if files.report is not None:
        write_gear_report(design, result, files.report, None, units, more)
    title = f"{operating_point(result)}, friction: {model_label(result.friction_model)}"
    files.write_tables([*result_tables(result), *more], title)


def _added(balance: HeatBalance | None, uncertainty: InputUncertainty | None = None) -> list[Table]:
    """Tables of what was computed with a result."""
    found = [] if balance is None else [balance.table()]
    return found if uncertainty is None else [*found, uncertainty.table()]


def write_map(design: Design, grid: Grid, files: OutputFiles, units: Units = "metric") -> None:
    """Figures, page and tables of a map; the page and the points are of the point next to the design's own."""
    from efficiency.output.gear_report import nearest_point, write_gear_report
    from efficiency.output.plots_map import grid_figures
    from efficiency.output.tables import map_tables
    from ehl.common.pages import save_figures

    result = nearest_point(design, grid)
    if files.plot is not None:
        save_figures(grid_figures(grid), files.plot)
    if files.report is not None:
        write_gear_report(design, result, files.report, grid, units)
    files.write_tables(
        map_tables(grid), f"{result.design}, {result.side}: map, friction: {model_label(result.friction_model)}"
    )


def write_comparison(comparison: Comparison, files: OutputFiles) -> None:
    """Figure, page and tables of a comparison."""
    from efficiency.output.comparison_report import write_comparison_report
    from efficiency.output.plots_load import plot_comparison
    from efficiency.output.tables import comparison_tables, operating_point
    from ehl.common.figures import save_figure

    if files.plot is not None:
        save_figure(plot_comparison(comparison), files.plot)
    if files.report is not None:
        write_comparison_report(comparison, files.report)
    files.write_tables(comparison_tables(comparison), f"{operating_point(comparison)}: friction models")


def write_duty(duty: DutyCycle, files: OutputFiles) -> None:
    """Tables of a duty cycle."""
    from efficiency.output.tables import duty_table, remarks_table

    if files.plot is not None or files.report is not None:
        raise InputError("write", "plot or report", "xlsx or csv for a duty cycle")
    title = f"{duty.design}: duty cycle, friction: {model_label(duty.friction_model)}"
    files.write_tables([duty_table(duty), remarks_table(duty.results)], title)
