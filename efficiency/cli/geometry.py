"""Commands of the geometry: what `gear --geometry` shows, `export`, `import`, `misalignment`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from efficiency.cli.options import DesignArgument, JsonOption, UnitsOption, value_list

if TYPE_CHECKING:
    from efficiency.contact.gear_flanks import Member
    from efficiency.design.design import Design

_WHAT = ("tooth", "member", "grid", "summary")
_MIN_POINTS, _MAX_POINTS = 5, 200
_MAX_STATES = 10_000


def show_geometry(
    design: Design,
    side: str,
    marking: str | None,
    json_output: bool,
    plot: Path | None,
    report: Path | None,
    units: str,
) -> None:
    """Compute and show geometry and unloaded contact; exit code 1 where a side could not be computed."""
    from threadpoolctl import threadpool_limits

    from efficiency.contact.pattern import MARKING
    from efficiency.geometry import MARKING_LIMITS, chosen_sides, pair_geometry
    from efficiency.output.geometry_tables import print_geometry
    from efficiency.output.machine_summary import chosen_units
    from ehl.view.report import print_json

    thickness = MARKING if marking is None else MARKING_LIMITS.check(marking, "--marking", bare=False)
    shown = chosen_units(units)
    # matrices are small: threads of the linear algebra would only wait for each other
    with threadpool_limits(1):
        geometry = pair_geometry(design, chosen_sides(side), thickness)
    if plot is not None:
        from efficiency.output.geometry_report import save_geometry_figures

        save_geometry_figures(geometry, plot)
    if report is not None:
        from efficiency.output.geometry_report import write_geometry_report

        write_geometry_report(geometry, report, shown)
    print_json(geometry.to_dict()) if json_output else print_geometry(geometry, shown)
    if geometry.failures:
        for name, reason in geometry.failures.items():
            typer.echo(f"{name}: {reason}", err=True)
        raise typer.Exit(1)


def export(
    design: Annotated[
        str, typer.Argument(metavar="DESIGN|FORMULA", help="Design (file or name), or formula (file or name).")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for a design's files; file for a formula.")],
    what: Annotated[
        str, typer.Option(help="Comma-separated: tooth (STL of a space), member (STL), grid (CSV), summary (CSV).")
    ] = "tooth, member, grid, summary",
    member: Annotated[str, typer.Option(help="pinion, gear or both.")] = "both",
    rows: Annotated[int, typer.Option(help="Points from root to tip.")] = 15,
    columns: Annotated[int, typer.Option(help="Points from heel to toe.")] = 31,
    margin: Annotated[
        float, typer.Option(help="Grids keep this share of face and depth off the edges, for inspection 0.05 to 0.1.")
    ] = 0.0,
    rim: Annotated[str | None, typer.Option(help="Solids: rim below the root, such as '6 mm'.")] = None,
    bore: Annotated[str | None, typer.Option(help="Members: diameter of the bore, '0 mm' for none.")] = None,
    units: UnitsOption = "metric",
    language: Annotated[
        str | None,
        typer.Option(help="Formula: python, c, fortran, matlab, latex, spreadsheet; by the suffix if not given."),
    ] = None,
    oil: Annotated[str | None, typer.Option(help="Formula: oil card to write in, if fitted to several.")] = None,
    oil_arguments: Annotated[
        bool, typer.Option("--oil-arguments", help="Formula: the oil's properties as arguments of the function.")
    ] = False,
) -> None:
    """Write solids (STL), flank grids (CSV) and the machine summary (CSV) of a design, or a formula as code.

    A formula becomes one function with its range, interval and flag: .py, .c, .f90, .m, .tex, .xlsx (live cells), .txt
    (formula for one cell).
    """
    from regression.formula import Formula, is_formula

    if is_formula(design):
        from regression.export.export import export_formula

        formula = Formula.load(design).formula
        program = export_formula(formula, output, language, oil=oil, oil_arguments=oil_arguments)
        print(f"{output}: {formula.name}, {program.oil or 'oil properties as arguments'}")
        return
    _export_design(design, output, what, member, rows, columns, margin, rim, bore, units)


def _export_design(
    design: str,
    output: Path,
    what: str,
    member: str,
    rows: int,
    columns: int,
    margin: float,
    rim: str | None,
    bore: str | None,
    units: str,
) -> None:
    from threadpoolctl import threadpool_limits

    from efficiency.design.design import load_design
    from efficiency.output.files import export_grids, export_member, export_summary, export_tooth_space
    from efficiency.output.machine_summary import chosen_units
    from ehl.io.errors import InputError
    from ehl.io.units import ValueRange

    wanted = [part.strip() for part in what.split(",") if part.strip()]
    for part in wanted:
        if part not in _WHAT:
            raise InputError("--what", part, "some of " + ", ".join(_WHAT))
    for name, count in (("--rows", rows), ("--columns", columns)):
        if not _MIN_POINTS <= count <= _MAX_POINTS:
            raise InputError(name, count, f"from {_MIN_POINTS} to {_MAX_POINTS}")
    if not 0.0 <= margin <= 0.3:
        raise InputError("--margin", margin, "from 0 to 0.3")
    length = ValueRange("m", ge=0.0, le=3.0)
    thickness = None if rim is None else length.check(rim, "--rim", bare=False)
    hole = None if bore is None else length.check(bore, "--bore", bare=False)
    shown, members = chosen_units(units), _members(member)
    written: list[str] = []
    with threadpool_limits(1):
        pair = load_design(design)
        for name in members:
            if "tooth" in wanted:
                written.append(export_tooth_space(pair, name, output, rows, columns, thickness))
            if "member" in wanted:
                written.append(export_member(pair, name, output, rows, columns, thickness, hole))
            if "grid" in wanted:
                written += export_grids(pair, name, output, rows, columns, margin)
        if "summary" in wanted:
            written += export_summary(pair, output, shown)
    for line in written:
        print(line)


def import_summary(
    sheet: Annotated[Path, typer.Argument(metavar="SHEET", help="Machine summary, one 'label, value' a line.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Design file to write (TOML).")],
    like: Annotated[
        str | None, typer.Option(help="Design that gives what a sheet does not: assembly, materials, operation.")
    ] = None,
) -> None:
    """Read a machine summary (inch or metric) into a design file."""
    from efficiency.output.design_import import design_from_sheet
    from ehl.io.errors import InputError

    text, notes = design_from_sheet(sheet, like)
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError("--output", str(output), "a writable file", f"{error}.") from None
    print(f"{output}: " + ("a design that can be computed" if like else "tables of a design file"))
    for note in notes:
        print(f"note     {note}")


def misalignment(
    design: DesignArgument,
    e: Annotated[
        str | None, typer.Option("--E", help="Along the offset: '-0.2, 0, 0.2 mm' or '-0.2:0.2:9 mm'.")
    ] = None,
    p: Annotated[str | None, typer.Option("--P", help="Along the pinion axis, from apex to heel.")] = None,
    g: Annotated[str | None, typer.Option("--G", help="Along the gear axis, from apex to heel.")] = None,
    alpha: Annotated[str | None, typer.Option("--alpha", help="Of the shaft angle: '-4, 0, 4 arcmin'.")] = None,
    side: Annotated[str, typer.Option(help="Flanks in contact: drive, coast or both.")] = "drive",
    marking: Annotated[str | None, typer.Option(help="Thickness of the marking compound, default '6.35 um'.")] = None,
    json_output: JsonOption = False,
    csv: Annotated[Path | None, typer.Option(help="Write all states as CSV (SI units).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Folder for figures (PNG).")] = None,
) -> None:
    """Misalignment study: unloaded contact over a grid of E, P, G and alpha, added to those of the design.

    Lists 'a, b, c unit' or ranges 'from:to:number unit'; the states are all combinations.
    """
    from threadpoolctl import threadpool_limits

    from efficiency.contact.pattern import MARKING
    from efficiency.design.design import Misalignment, load_design
    from efficiency.geometry import MARKING_LIMITS, chosen_sides
    from efficiency.misalignment import misalignment_study
    from efficiency.output.misalignment_table import print_study, write_study
    from ehl.io.errors import InputError
    from ehl.io.validation import value_range_of
    from ehl.view.report import print_json

    thickness = MARKING if marking is None else MARKING_LIMITS.check(marking, "--marking", bare=False)
    given = {"E": e, "P": p, "G": g, "alpha": alpha}
    values = {
        name: (0.0,) if text is None else value_list(f"--{name}", text, value_range_of(Misalignment, name))
        for name, text in given.items()
    }
    if all(text is None for text in given.values()):
        raise InputError("--E, --P, --G, --alpha", None, "at least one of them with its values")
    states = math.prod(len(part) for part in values.values())
    if states > _MAX_STATES:
        raise InputError("--E, --P, --G, --alpha", f"{states} states", f"at most {_MAX_STATES} combinations")
    offset, along_pinion, along_gear, shaft = values.values()
    with threadpool_limits(1):
        pair = load_design(design)
        studies = [
            misalignment_study(pair, E=offset, P=along_pinion, G=along_gear, alpha=shaft, side=part, marking=thickness)
            for part in chosen_sides(side)
        ]
    if csv is not None:
        write_study(csv, studies)
    if plot is not None:
        from efficiency.output.plots_misalignment import save_study_figures

        save_study_figures(pair, studies, plot)
    if json_output:
        print_json({"studies": [study.to_dict() for study in studies]})
    else:
        for study in studies:
            print_study(study)
    failed = sum(point.status == "failed" for study in studies for point in study.points)
    if failed:
        typer.echo(f"not converged: {failed} of {states * len(studies)} states", err=True)
        raise typer.Exit(1)


def _members(text: str) -> tuple[Member, ...]:
    from ehl.io.errors import InputError

    if text == "both":
        return ("pinion", "gear")
    if text == "pinion":
        return ("pinion",)
    if text == "gear":
        return ("gear",)
    raise InputError("--member", text, "pinion, gear or both")


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command()(export)
    app.command("import")(import_summary)
    app.command()(misalignment)
