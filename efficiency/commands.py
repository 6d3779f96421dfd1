"""Commands of the gear pair: `gear`, `compare`, `demo`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from efficiency.contact.pair import Side
    from efficiency.design import Design
    from efficiency.run import Conditions

DesignArgument = Annotated[str, typer.Argument(metavar="DESIGN", help="A design file, or the name of a shipped one.")]
SideOption = Annotated[str, typer.Option(help="Flanks that carry the load: drive or coast.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")]
TorqueOption = Annotated[str | None, typer.Option(help="Pinion torque with its unit: '250 N m'.")]
SpeedOption = Annotated[str | None, typer.Option(help="Pinion speed with its unit: '1500 rpm'.")]
TemperatureOption = Annotated[str | None, typer.Option(help="Oil temperature with its unit: '80 degC'.")]
OilOption = Annotated[str | None, typer.Option(help="Oil card in place of the design's.")]


EOption = Annotated[str | None, typer.Option("--E", help="Misalignment along the offset: '0.1 mm'.")]
POption = Annotated[str | None, typer.Option("--P", help="Misalignment along the pinion axis, from apex to heel.")]
GOption = Annotated[str | None, typer.Option("--G", help="Misalignment along the gear axis, from apex to heel.")]
AlphaOption = Annotated[str | None, typer.Option("--alpha", help="Misalignment of the shaft angle: '2 arcmin'.")]
UnitsOption = Annotated[str, typer.Option(help="Units of tables: metric or inch.")]

Lists = tuple[list[float], list[float], list[float]]


def _side(side: str) -> Side:
    from ehl.errors import InputError

    if side == "drive":
        return "drive"
    if side == "coast":
        return "coast"
    raise InputError("--side", side, "drive or coast")


def _lists(torque: str | None, speed: str | None, temperature: str | None) -> Lists:
    from efficiency.design import OPERATION_LIMITS

    def check(text: str | None, name: str, option: str) -> list[float]:
        return [] if text is None else OPERATION_LIMITS[name].check_list(text, option)

    return (
        check(torque, "torque", "--torque"),
        check(speed, "speed", "--speed"),
        check(temperature, "temperature_oil", "--temperature"),
    )


def _conditions(lists: Lists, oil: str | None) -> Conditions:
    from efficiency.run import Conditions

    torque, speed, temperature = (values[0] if values else None for values in lists)
    return Conditions(torque, speed, temperature, oil)


def aligned_design(design: str, misalignment: dict[str, str | None]) -> Design:
    """A design with what the command line says of its misalignment."""
    from threadpoolctl import threadpool_limits

    from efficiency.design import Misalignment, load_design
    from ehl.expectation import quantity_of

    with threadpool_limits(1):
        loaded = load_design(design)
    given = {
        name: quantity_of(Misalignment, name).check(text, f"--{name}", bare=False)
        for name, text in misalignment.items()
        if text is not None
    }
    return loaded.with_misalignment(**loaded.assembly.misalignment.model_dump() | given) if given else loaded


def gear(
    design: DesignArgument,
    friction: Annotated[
        str, typer.Option(help="Formula file, constant:0.05, a published formula's name, ehl or ehl:smooth.")
    ] = "constant:0.05",
    torque: TorqueOption = None,
    speed: SpeedOption = None,
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    side: Annotated[
        str | None, typer.Option(help="Flanks in contact: drive (default under load), coast, or both (geometry only).")
    ] = None,
    e: EOption = None,
    p: POption = None,
    g: GOption = None,
    alpha: AlphaOption = None,
    json_output: JsonOption = False,
    plot: Annotated[Path | None, typer.Option(help="Folder for figures (PNG).")] = None,
    geometry: Annotated[
        bool, typer.Option("--geometry", help="Geometry and unloaded contact only: no load, no friction.")
    ] = False,
    report: Annotated[Path | None, typer.Option(help="With --geometry: write one HTML page.")] = None,
    marking: Annotated[
        str | None, typer.Option(help="With --geometry: thickness of the marking compound, default '6.35 um'.")
    ] = None,
    units: UnitsOption = "metric",
) -> None:
    """Efficiency of a gear pair: geometry, contact, load, friction, power loss.

    A comma-separated list of torques, speeds or temperatures ('100, 200, 300 N m') makes a map.
    """
    from threadpoolctl import threadpool_limits

    from efficiency.output.tables import efficiency_table, map_table, save_gear_figures, save_map_figure
    from efficiency.run import run_gear, run_map
    from ehl.errors import InputError
    from ehl.report import print_json

    misaligned = {"E": e, "P": p, "G": g, "alpha": alpha}
    if geometry:
        from efficiency.commands_geometry import show_geometry

        for name, value in (("torque", torque), ("speed", speed), ("temperature", temperature), ("oil", oil)):
            if value is not None:
                raise InputError(f"--{name}", value, "nothing beside --geometry, which takes no load and no oil")
        show_geometry(aligned_design(design, misaligned), side or "both", marking, json_output, plot, report, units)
        return
    for name, unused in (("report", report), ("marking", marking)):
        if unused is not None:
            raise InputError(f"--{name}", str(unused), "only together with --geometry")
    pair = aligned_design(design, misaligned)
    # matrices are small: threads of the linear algebra would only wait for each other
    lists = _lists(torque, speed, temperature)
    chosen = _side(side or "drive")
    if any(len(values) > 1 for values in lists):
        with threadpool_limits(1):
            grid = run_map(pair, friction, *lists, oil=oil, side=chosen)
        if plot is not None:
            save_map_figure(grid, plot)
        print_json(grid.to_dict()) if json_output else map_table(grid)
        status, reason = grid.status, grid.reason
    else:
        with threadpool_limits(1):
            result = run_gear(pair, friction, _conditions(lists, oil), side=chosen)
        if plot is not None:
            save_gear_figures(result, plot)
        print_json(result.to_dict()) if json_output else efficiency_table(result)
        status, reason = result.status, result.reason
    if status != "converged":
        typer.echo(f"not converged: {reason}", err=True)
        raise typer.Exit(1)


def compare(
    design: DesignArgument,
    friction: Annotated[
        list[str] | None, typer.Option(help="A friction model; repeat for several. Default: constants, published, ehl.")
    ] = None,
    torque: TorqueOption = None,
    speed: SpeedOption = None,
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    side: SideOption = "drive",
    json_output: JsonOption = False,
    plot: Annotated[Path | None, typer.Option(help="Write the figure (PNG, SVG, PDF).")] = None,
) -> None:
    """Compare friction models, constant mu and closed forms on one gear pair."""
    from threadpoolctl import threadpool_limits

    from efficiency.output.plots_load import plot_comparison
    from efficiency.output.tables import comparison_table
    from efficiency.run import run_compare
    from ehl.errors import InputError
    from ehl.plots import save_figure
    from ehl.report import print_json

    lists = _lists(torque, speed, temperature)
    for values, name in zip(lists, ("--torque", "--speed", "--temperature"), strict=True):
        if len(values) > 1:
            raise InputError(name, values, "one value; lists make a map with `mixed-ehl gear`")
    with threadpool_limits(1):
        comparison = run_compare(design, friction, _conditions(lists, oil), side=_side(side))
    if plot is not None:
        save_figure(plot_comparison(comparison), plot)
    print_json(comparison.to_dict()) if json_output else comparison_table(comparison)
    if comparison.status != "converged":
        failed = ", ".join(f"{row.name} ({row.reason})" for row in comparison.rows if row.status == "failed")
        typer.echo(f"not converged: {failed}", err=True)
        raise typer.Exit(1)


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")] = Path("mixed-ehl-demo"),
    jobs: Annotated[int | None, typer.Option(min=1, help="Worker processes; default: the cores there are.")] = None,
) -> None:
    """The main job, small and real: sweep, fit, gear, compare, one HTML report."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from efficiency.demo import run_demo
    from efficiency.output.tables import comparison_table
    from regression.sweep import available_jobs

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as bars:
        tasks = {name: bars.add_task(name, total=None) for name in ("contacts", "formulas", "gear pair")}

        def notify(step: str, done: int, total: int) -> None:
            bars.update(tasks[step], completed=done, total=total)

        result = run_demo(output, jobs or available_jobs(), notify)
    comparison_table(result.comparison)
    print(f"report: {output / 'report.html'}")
    if result.comparison.status != "converged":
        raise typer.Exit(1)


def register(app: typer.Typer) -> None:
    """Add the commands of this package to the application."""
    app.command()(gear)
    app.command()(compare)
    app.command()(demo)
