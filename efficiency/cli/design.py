"""Commands around a design: `blank`, `settings`, `correct`, `import`, `export`, `misalignment`, `study`, `plan`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import typer

import efficiency
import regression
from efficiency.cli.options import (
    OPERATION,
    OUTPUT,
    DesignArgument,
    JobsOption,
    JsonOption,
    LoadBalanceOption,
    OilOption,
    SideOption,
    SpeedOption,
    TemperatureOption,
    UnitsOption,
    load_balance_of,
    one_side,
    present,
    refuse,
    unit_system,
)
from ehl import InputError, shipped
from ehl.common.console import (
    ADVANCED,
    FORMULA,
    GEAR,
    App,
    fail_unless_converged,
    given,
    names_of,
    output_folder,
    print_json,
    working,
    write_text,
)

PAIRS = ("fh_hypoid_9x34", "fh_hypoid_9x34_offset_10")


def blank(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE", help="A blank file, or the name of a shipped one.", autocompletion=names_of("blanks")
        ),
    ],
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
) -> None:
    """Blank of a bevel or hypoid pair after ISO 23509: cones, depths, thicknesses, contact ratios, warnings."""
    pair = efficiency.blank(file)
    print_json(pair.to_dict()) if json_output else pair.show()


def settings(
    targets: Annotated[
        str,
        typer.Argument(
            metavar="TARGETS", help="A targets file, or the name of a shipped one.", autocompletion=names_of("targets")
        ),
    ],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write the design file here.")] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
) -> None:
    """Machine settings of both members from a blank, a cutter and contact targets: a complete design file.

    Exit code 1: a residual stays above 3 um rms, a cut tooth is pointed, or its working flank undercut; the design is
    written all the same.
    """
    result = efficiency.settings(targets)
    if output is not None:
        write_text(output, result.text)
    print_json(result.to_dict()) if json_output else result.show()
    if output is not None and not json_output:
        print(f"design: {output}")
    fail_unless_converged(result.status, "; ".join(result.warnings))


WHAT = "tooth, member, grid, summary"


def export(
    design: Annotated[
        str, typer.Argument(metavar="DESIGN|FORMULA", help="Design (file or name), or formula (file or name).")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for a design's files; file for a formula.")],
    what: Annotated[
        str,
        typer.Option(
            help="Comma-separated: tooth (STL of a space), member (STL), step (member, STEP), grid, "
            "ease_off, summary (CSV)."
        ),
    ] = WHAT,
    member: Annotated[str, typer.Option(help="pinion, gear or both.")] = "both",
    rows: Annotated[int, typer.Option(help="Points from root to tip.", rich_help_panel=ADVANCED)] = 15,
    columns: Annotated[int, typer.Option(help="Points from heel to toe.", rich_help_panel=ADVANCED)] = 31,
    margin: Annotated[
        float,
        typer.Option(
            help="Grids keep this share of face and depth off the edges, for inspection 0.05 to 0.1.",
            rich_help_panel=ADVANCED,
        ),
    ] = 0.0,
    rim: Annotated[
        str | None, typer.Option(help="Solids: rim below the root, such as '6 mm'.", rich_help_panel=ADVANCED)
    ] = None,
    bore: Annotated[
        str | None, typer.Option(help="Members: diameter of the bore, '0 mm' for none.", rich_help_panel=ADVANCED)
    ] = None,
    units: UnitsOption = "metric",
    language: Annotated[
        str | None,
        typer.Option(help="Formula: python, c, fortran, matlab; by the suffix if not given."),
    ] = None,
    oil: Annotated[str | None, typer.Option(help="Formula: oil card to write in, if fitted to several.")] = None,
    oil_arguments: Annotated[
        bool,
        typer.Option(
            "--oil-arguments",
            help="Formula: the oil's properties as arguments of the function.",
            rich_help_panel=ADVANCED,
        ),
    ] = False,
    guard: Annotated[
        bool,
        typer.Option(
            "--guard/--no-guard",
            help="Formula: flag points far from all cases of the fit (long).",
            rich_help_panel=ADVANCED,
        ),
    ] = True,
) -> None:
    """Write solids (STL), flank grids (CSV) and the machine summary (CSV) of a design, or a formula as code.

    A formula becomes one function with its range, interval and flag: .py, .c, .f90 or .m.
    """
    of_designs = {"rim": rim, "bore": bore, "member": member != "both" and member, "what": what != WHAT and what}
    if design in shipped("formulas") or Path(design).suffix == ".json":
        refuse("a formula", of_designs)
        formula = regression.Formula.load(design)
        formula.export(output, language, oil=oil, oil_arguments=oil_arguments, guard=guard)
        laws = "oil properties as arguments" if oil_arguments else oil or formula.default_oil()
        print(f"{output}: {formula.name}, {laws}")
        return
    refuse("a design", {"language": language, "oil": oil, "oil_arguments": oil_arguments})
    if member not in ("pinion", "gear", "both"):
        raise InputError("member", member, "pinion, gear or both")
    parts = [part.strip() for part in what.split(",") if part.strip()]
    if not parts:
        raise InputError("what", what, f"some of {WHAT}, ease_off, step")
    members: dict[str, tuple[Literal["pinion", "gear"], ...]] = {"pinion": ("pinion",), "gear": ("gear",)}
    written = efficiency.load(design).export(
        output,
        parts,
        members=members.get(member, ("pinion", "gear")),
        rows=rows,
        columns=columns,
        margin=margin,
        units=unit_system(units),
        **given({"rim": rim, "bore": bore}),
    )
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
    text, notes = efficiency.import_design(sheet, like)
    write_text(output, text)
    print(f"{output}: " + ("a design that can be computed" if like else "tables of a design file"))
    for note in notes:
        print(f"note     {note}")


def correct(
    design: DesignArgument,
    grids: Annotated[
        list[Path],
        typer.Argument(
            metavar="GRID...", help="Measured points of one or both flanks of a member (CSV), see `export`."
        ),
    ],
    uncertainty: Annotated[str, typer.Option(help="Standard uncertainty of one point along the normal.")] = "1 um",
    order: Annotated[
        int, typer.Option(help="1: settings for pressure and spiral angle; 2: for crowning and twist as well.")
    ] = 2,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the corrected machine tables here (TOML).")
    ] = None,
    json_output: JsonOption = False,
) -> None:
    """Machine corrections from measured flanks: what to change so that the next part comes out as designed."""
    result = efficiency.machine_corrections(design, grids, uncertainty, cast("Literal[1, 2]", order))
    if output is not None:
        write_text(output, result.text)
    print_json(result.to_dict()) if json_output else result.show()
    if output is not None and not json_output:
        print(f"corrected settings: {output}")


def misalignment(
    design: DesignArgument,
    e: Annotated[
        str | None, typer.Option("--E", help="Shift E along the offset: '-0.2, 0, 0.2 mm' or '-0.2:0.2:9 mm'.")
    ] = None,
    p: Annotated[str | None, typer.Option("--P", help="Shift P along the pinion axis, from apex to heel.")] = None,
    g: Annotated[str | None, typer.Option("--G", help="Shift G along the gear axis, from apex to heel.")] = None,
    shaft_angle_error: Annotated[str | None, typer.Option(help="Change of the shaft angle: '-4, 0, 4 arcmin'.")] = None,
    side: Annotated[
        str, typer.Option(help="Flanks in contact: drive, coast or both.", rich_help_panel=ADVANCED)
    ] = "drive",
    marking: Annotated[
        str | None, typer.Option(help="Thickness of the marking compound, default '6.35 um'.", rich_help_panel=ADVANCED)
    ] = None,
    torque: Annotated[
        str | None,
        typer.Option(help="Pinion torque: every state loaded as well, '250 N m'.", rich_help_panel=OPERATION),
    ] = None,
    friction: Annotated[
        str | None, typer.Option(help="Friction model as in `gear`; default: the formula shipped for the oil.")
    ] = None,
    speed: SpeedOption = None,
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    json_output: JsonOption = False,
    csv: Annotated[
        Path | None, typer.Option(help="Write all states as CSV (SI units).", rich_help_panel=ADVANCED)
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Folder for figures (PNG).", rich_help_panel=ADVANCED)] = None,
) -> None:
    """Misalignment study (V-H check): contact over a grid of E, P, G and shaft angle, added to those of the design.

    Without load; with ``--torque`` loaded transmission error, pressure, load at edges, loss and efficiency as well.

    Lists 'a, b, c unit' or ranges 'from:to:number unit'; the states are all combinations.
    """
    axes = given({"E": e, "P": p, "G": g, "shaft_angle_error": shaft_angle_error})
    conditions: dict[str, Any] = given({"speed": speed, "temperature": temperature, "oil": oil})
    with working("misalignment"):
        states = efficiency.load(design).misalignment(
            side=side,
            marking=marking,
            torque=torque,
            friction=friction,
            **conditions,
            **axes,
        )
    present(states, json_output, csv=csv, plot=plot)


def study(
    designs: Annotated[
        list[str] | None,
        typer.Argument(metavar="DESIGN...", help=f"Design files or names of shipped ones; default: {' '.join(PAIRS)}."),
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for page, tables and figures.", rich_help_panel=OUTPUT)
    ] = Path("mixed-ehl-study"),
    friction: Annotated[
        str | None, typer.Option(help="Friction model as in `gear`; default: the formula shipped for the oil.")
    ] = None,
    torque: Annotated[
        str | None,
        typer.Option(help="Pinion torques, '50, 100, 200 N m' or '50:250:5 N m'.", rich_help_panel=OPERATION),
    ] = None,
    speed: Annotated[str | None, typer.Option(help="Pinion speeds.", rich_help_panel=OPERATION)] = None,
    temperature: Annotated[str | None, typer.Option(help="Oil temperatures.", rich_help_panel=OPERATION)] = None,
    roughness_each: Annotated[
        str | None, typer.Option(help="Rq of each flank: '0.2, 0.4 um'.", rich_help_panel=OPERATION)
    ] = None,
    oil: OilOption = None,
    side: SideOption = "drive",
    e: Annotated[
        str | None,
        typer.Option("--E", help="Shift E along the offset: '-0.1, 0.1 mm'; '0 mm': none.", rich_help_panel=ADVANCED),
    ] = None,
    p: Annotated[
        str | None, typer.Option("--P", help="Shift P along the pinion axis.", rich_help_panel=ADVANCED)
    ] = None,
    g: Annotated[str | None, typer.Option("--G", help="Shift G along the gear axis.", rich_help_panel=ADVANCED)] = None,
    shaft_angle_error: Annotated[
        str | None,
        typer.Option(
            "--shaft-angle-error", help="Change of the shaft angle: '-4, 4 arcmin'.", rich_help_panel=ADVANCED
        ),
    ] = None,
    load_balance: LoadBalanceOption = None,
    strength: Annotated[
        bool,
        typer.Option(
            "--strength",
            help="Columns of grade, safety factors, integral temperature, specific film.",
            rich_help_panel=ADVANCED,
        ),
    ] = False,
    jobs: JobsOption = None,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Forget what an earlier run left in the folder.", rich_help_panel=ADVANCED)
    ] = False,
    json_output: JsonOption = False,
) -> None:
    """Parameter study: torque, speed, temperature, roughness, offset and misalignment against efficiency.

    All combinations of the operating parameters, misalignments one at a time. A study that was killed goes on.
    """
    values = {"torque": torque, "speed": speed, "temperature": temperature, "roughness_rms_each": roughness_each}
    values |= {"E": e, "P": p, "G": g, "shaft_angle_error": shaft_angle_error}
    store = output / "points.jsonl"
    if fresh and os.path.exists(store):
        store.unlink()
    chosen: dict[str, Any] = {"friction": friction, "oil": oil, "side": one_side(side), "jobs": jobs, "store": store}
    chosen |= {"strength": strength}
    chosen |= given({"load_balance": load_balance_of(load_balance)})
    kept = f"finished points are kept in {store}, the same command resumes"
    with output_folder(output), working("study", kept):
        result = efficiency.study(designs or PAIRS, **chosen, **given(values))
    written = result.write(folder=output)
    if json_output:
        print_json(result.to_dict())
    else:
        result.show()
        for path in written:
            print(path)
    fail_unless_converged(result.status, result.reason)


def plan(
    designs: Annotated[list[str], typer.Argument(metavar="DESIGN...", help="Design files, or names of shipped ones.")],
    duty: Annotated[
        Path, typer.Option(metavar="FILE", help="Duty cycle, CSV or XLSX: torque, speed, temperature, hours.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="PLAN.toml", help="The plan file.")],
    oil: Annotated[str | None, typer.Option(help="Oil card in place of the designs'.")] = None,
    size: Annotated[int, typer.Option(min=1, help="Cases of the plan, for each oil.")] = 1024,
    coverage: Annotated[float, typer.Option(help="Share of the lost work inside each range.")] = 0.98,
    model: Annotated[
        str, typer.Option(help="Model of the roughness: deterministic or load_sharing.")
    ] = "deterministic",
) -> None:
    """Write the plan of a sweep whose ranges are what the contact points of gear designs see in their duty.

    The ranges are quantiles weighted with the work lost at each point.
    """
    if model not in ("deterministic", "load_sharing"):
        raise InputError("model", model, "deterministic or load_sharing")
    if output.suffix != ".toml":
        raise InputError("output", str(output), "a file name ending in .toml")
    pairs = [efficiency.load(design) for design in designs]
    ranges = regression.operating_range([point for pair in pairs for point in pair.duty_points(duty, oil)], coverage)
    oils = tuple(dict.fromkeys([oil] if oil else [pair.design.operation.oil for pair in pairs]))
    words = f"{100.0 * coverage:g} % of the work lost by {', '.join(pair.name for pair in pairs)} over {duty.name}"
    text = ranges.plan_text(output.stem, oils, size=size, description=words, roughness=model)
    write_text(output, text)
    ranges.show()
    typer.echo(
        f"{output}: {regression.Plan.from_file(output).count} cases; for its cost: mixed-ehl sweep {output} --estimate"
    )


def register(app: App) -> None:
    """Add the commands to the application."""
    app.command(rich_help_panel=FORMULA)(plan)
    for command in (blank, settings, correct, export, misalignment, study):
        app.command(rich_help_panel=GEAR)(command)
    app.command("import", rich_help_panel=GEAR)(import_summary)
