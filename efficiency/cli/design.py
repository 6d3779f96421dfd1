"""Commands around a design, from its blank and settings to studies, optimisation and the plan of a sweep."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import typer

import efficiency
import regression
from efficiency.cli import options as shared
from ehl import InputError, shipped
from ehl.common import console

PAIRS = ("fh_hypoid_9x34_relieved", "fh_hypoid_9x34_offset_10_relieved")


def blank(*, file: shared.BlankArgument, files: shared.ReportOptions) -> None:
    """Blank of a bevel or hypoid pair after ISO 23509: cones, depths, thicknesses, contact ratios, warnings.

    The files and the report contain the gear data for the drawings of both members.
    """
    shared.present(efficiency.blank(file), **files)


_SizingTorques: Any = shared.group(
    torque=shared.text_option("Pinion torque for --sized; default: that of the targets."),
    coast_torque=shared.text_option("The same on the coast side; default: that torque; '0 N m': none."),
)
_SizingBox: Any = shared.group(
    **{n: shared.text_option(f"Half width of {n} for --sized; default 0.05 mm.", name=f"--{n}") for n in "EPG"}
)


def settings(
    *,
    targets: shared.TargetsArgument,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Design file to write.")] = None,
    sized: Annotated[
        bool,
        typer.Option(
            "--sized",
            help="First size ease-off and edge relief for the torque: edges of both flanks carry below 0.5 % in a box "
            "of misalignments. The targets are written next to the design.",
        ),
    ] = False,
    torques: _SizingTorques,
    box: _SizingBox,
    json_output: shared.JsonOption = False,
) -> None:
    """Machine settings of both members from a blank, a cutter and contact targets: a complete design file.

    The exit code is 1 if a residual exceeds 3 um rms, a tooth is pointed, or a working flank is undercut. The design is
    written in all cases.
    """
    sizing = None
    console.check_outputs({"output": output})
    if sized:
        with console.working("load sizing", "nothing is kept"):
            sizing = efficiency.sized_for_load(targets, misalignment=box, **torques)
    else:
        shared.refuse("settings without --sized", torques | box)
    result = efficiency.settings(targets if sizing is None else sizing.targets)
    if output is not None:
        console.write_text(output, result.text)
        if sizing is not None:
            sizing.write_next_to(output)
    console.print_result(result, json_output)
    if sizing is not None and not json_output:
        console.print_text(f"sized: {sizing}")
    if output is not None and not json_output:
        print(f"design: {output}")
    console.fail_unless_converged(result.status, "; ".join(result.warnings))


_DesignFiles: Any = shared.group(
    what=shared.text_option(
        "Comma-separated: tooth (STL of a space), member (STL), step (members and pair, STEP), grid, ease_off, summary "
        "(CSV); default: tooth, member, grid, summary.",
        panel=None,
    ),
    member=shared.text_option("pinion, gear or both (default).", panel=None),
    rows=Annotated[int | None, console.advanced(help="Points from root to tip; default 15.")],
    columns=Annotated[int | None, console.advanced(help="Points from heel to toe; default 31.")],
    margin=Annotated[
        float | None, console.advanced(help="Grids: margin to the edges, share of face and depth; 0.05 for inspection.")
    ],
    rim=shared.text_option("Solids: rim below the root, such as '6 mm'."),
    bore=shared.text_option("Members: diameter of the bore, '0 mm' for none."),
    units=shared.UnitsOption,
)
_FormulaFile: Any = shared.group(
    language=shared.text_option("Formula: python, c, fortran, matlab, fmu; by the suffix if not given.", panel=None),
    oil=shared.text_option("Formula: oil of the written function, if fitted to several.", panel=None),
    oil_arguments=shared.switch("--oil-arguments", "Formula: the oil's properties as arguments of the function."),
    guard=shared.switch("--guard/--no-guard", "Formula: flag points far from all cases of the fit (long)."),
)


def export(
    *,
    design: Annotated[
        str, typer.Argument(metavar="DESIGN|FORMULA", help="Design (file or name), or formula (file or name).")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for a design's files; file for a formula.")],
    of_design: _DesignFiles,
    of_formula: _FormulaFile,
) -> None:
    """Write solids (STL), flank grids (CSV) and the machine summary (CSV) of a design, or a formula as code.

    A formula becomes one function with its range, interval and flag: .py, .c, .f90 or .m, or an FMU: .fmu.
    """
    # an unknown name with the file of a program is that of a formula
    other = design in shipped("designs") or Path(design).suffix == ".toml" or not output.suffix
    if design in shipped("formulas") or Path(design).suffix == ".json" or not other:
        shared.refuse("a formula", of_design)
        console.check_outputs({"output": output})
        formula = regression.Formula.load(design)
        formula.export(output, **of_formula)
        laws = of_formula.get("oil") or formula.default_oil()
        print(f"{output}: {formula.name}, {'oil properties as arguments' if 'oil_arguments' in of_formula else laws}")
        return
    shared.refuse("a design", of_formula)
    member = shared.one_of("member", of_design.pop("member", "both"), "pinion", "gear", "both")
    members: Any = ("pinion", "gear") if member == "both" else (member,)
    if "what" in of_design:
        text = of_design["what"]
        of_design["what"] = [part.strip() for part in text.split(",") if part.strip()]
        if not of_design["what"]:
            raise InputError("what", text, "some of tooth, member, grid, summary, ease_off, step")
    if "units" in of_design:
        of_design["units"] = shared.unit_system(of_design["units"])
    console.check_outputs({"output": output}, ["output"])
    written = efficiency.load(design).export(output, members=members, **of_design)
    for line in written:
        print(line)


def import_summary(
    sheet: Annotated[Path, typer.Argument(metavar="SHEET", help="Machine summary, one 'label, value' per line.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Design file to write (TOML).")],
    like: Annotated[
        str | None, typer.Option(help="Design for the data missing in the sheet: assembly, materials, operation.")
    ] = None,
) -> None:
    """Read a machine summary (inch or metric) into a design file."""
    console.check_outputs({"output": output})
    text, notes = efficiency.import_design(sheet, like)
    console.write_text(output, text)
    print(f"{output}: " + ("a design that can be computed" if like else "tables of a design file"))
    for note in notes:
        console.print_text(f"note     {note}")


def correct(
    design: shared.DesignArgument,
    grids: Annotated[
        list[Path],
        typer.Argument(metavar="GRID", help="Measured points of one or both flanks of a member (CSV), see `export`."),
    ],
    uncertainty: Annotated[str, typer.Option(help="Standard uncertainty of one point along the normal.")] = "1 um",
    order: Annotated[int, typer.Option(help="1: correct pressure and spiral angle; 2: also crowning and twist.")] = 2,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="File for the corrected machine tables (TOML).")
    ] = None,
    json_output: shared.JsonOption = False,
) -> None:
    """Machine corrections from measured flanks, so that the next part agrees with the design."""
    console.check_outputs({"output": output})
    result = efficiency.machine_corrections(design, grids, uncertainty, cast("Literal[1, 2]", order))
    if output is not None:
        console.write_text(output, result.text)
    console.print_result(result, json_output)
    if output is not None and not json_output:
        print(f"corrected settings: {output}")


_ShiftLists: Any = shared.misalignment_group(
    "Shift E along the offset: '-0.2, 0, 0.2 mm' or '-0.2:0.2:9 mm'.",
    "Shift P along the pinion axis, from apex to heel.",
    "Shift G along the gear axis, from apex to heel.",
    "Change of the shaft angle: '-4, 0, 4 arcmin'.",
    panel=None,
)
_StateOptions: Any = shared.group(
    side=shared.text_option("Flanks in contact: drive (default), coast or both."),
    marking=shared.MarkingOption,
    samples=Annotated[
        int | None,
        console.advanced(help="Tolerance analysis: number of random states; E, P, G, angle are standard deviations."),
    ],
    accuracy_grade=Annotated[
        int | None,
        console.advanced(help="ISO 1328-1 accuracy grade (1 to 11) of random flank deviations in each state."),
    ],
    friction=shared.text_option("Friction model as in mixed-ehl gear."),
)
_StateConditions: Any = shared.group(
    **{name: option for name, option in shared.CONDITIONS.items() if name not in ("side", "temperature", "oil")},
    temperature=shared.text_option("Oil temperature with its unit: '80 degC'."),
    oil=shared.text_option("Oil card; default: that of the design."),
    bulk=shared.BulkOption,
)


def misalignment(
    *,
    design: shared.DesignArgument,
    axes: _ShiftLists,
    more: _StateOptions,
    conditions: _StateConditions,
    files: shared.FolderOptions,
) -> None:
    """Misalignment study (V-H check): contact over a grid of E, P, G and shaft angle, added to those of the design.

    The contact is unloaded. With --torque, the loaded contact is computed as well: transmission error, pressure, edge
    load, loss and efficiency.

    Misalignments are lists 'a, b, c unit' or ranges 'from:to:number unit'. All combinations are computed.
    """
    with console.working("misalignment"):
        states = efficiency.load(design).misalignment(**axes, **more, **conditions)
    shared.present(states, **files)


_StudyLevels: Any = shared.group(
    torque=shared.text_option("Pinion torques, '50, 100, 200 N m' or '50:250:5 N m'.", console.OPERATION),
    speed=shared.text_option("Pinion speeds.", console.OPERATION),
    temperature=shared.text_option("Oil temperatures.", console.OPERATION),
    roughness_rms_each=shared.text_option("Rq of each flank: '0.2, 0.4 um'.", console.OPERATION, "--roughness-each"),
)
_StudyShifts: Any = shared.misalignment_group(
    "Shift E along the offset: '-0.1, 0.1 mm'; '0 mm': none.",
    "Shift P along the pinion axis.",
    "Shift G along the gear axis.",
    "Change of the shaft angle: '-4, 4 arcmin'.",
)
_StudyOptions: Any = shared.group(
    friction=shared.FrictionOption,
    oil=shared.OilOption,
    side=shared.SideOption,
    load_balance=shared.LoadBalanceOption,
    strength=shared.StrengthOption,
    jobs=console.JobsOption,
)


def study(
    *,
    designs: Annotated[
        list[str] | None,
        typer.Argument(metavar="DESIGN", help=f"Design files or names of shipped ones; default: {' '.join(PAIRS)}."),
    ] = None,
    output: Annotated[Path, shared.output_option("--output", "-o", help="Folder for page, tables and figures.")] = Path(
        "mixed-ehl-study"
    ),
    values: _StudyLevels,
    misalignment: _StudyShifts,
    more: _StudyOptions,
    fresh: shared.FreshOption = False,
    json_output: shared.JsonOption = False,
) -> None:
    """Parameter study: efficiency over torque, speed, temperature, roughness, offset and misalignment.

    Operating parameters are combined, misalignments are varied one at a time. The same command resumes an interrupted
    study.
    """
    store = shared.started_store(output, fresh)
    with console.output_folder(output), console.working("study", shared.kept("points", store, fresh)):
        result = efficiency.study(designs or PAIRS, store=store, **more, **values, **misalignment)
    shared.present_folder(result, json_output, output)


_SearchOptions: Any = shared.group(
    objectives=Annotated[
        list[str] | None,
        console.advanced(
            "--objective",
            help="Quantity to minimise, the most important first; default: power_loss, pressure_hertz_max, "
            "transmission_error_loaded.",
        ),
    ],
    duty=Annotated[
        Path | None,
        shared.operation(
            metavar="FILE",
            help="Duty cycle, CSV or XLSX: torque, speed, temperature, hours. Default: the targets' operating point.",
        ),
    ],
    friction=shared.text_option("Friction formula; default: the one shipped for the oil.", console.OPERATION),
    oil=shared.OilOption,
    over=shared.text_option(
        "Loss over the box of misalignments: mean (default) or worst; other quantities: always worst."
    ),
    flanks=shared.text_option("Flanks whose ease-off is varied: drive (default), coast or both."),
    evaluations=Annotated[int | None, console.advanced(help="Evaluations of the search; default 120.")],
    batch=Annotated[int | None, console.advanced(help="Parallel evaluations; default 4.")],
    check=Annotated[int | None, console.advanced(help="Points checked on the full mesh; default 4.")],
    solved=shared.text_option(
        "Check the gain of the best point with solved contacts: 'ehl' (minutes).", name="--check-friction"
    ),
    seed=Annotated[int | None, console.advanced(min=0, help="Seed of the random numbers; default 1.")],
    sized=shared.switch("--sized", "First size the start for its torque, as `settings --sized` does."),
    jobs=console.JobsOption,
    dask=console.DaskOption,
)
_SearchBox: Any = shared.misalignment_group(
    "Half width of E in the misalignment box; default '0.05 mm', '0 mm' for none.",
    "Half width of P; default '0.05 mm'.",
    "Half width of G; default none.",
    "Half width of the shaft angle; default none.",
)


def optimise(
    *,
    targets: shared.TargetsArgument,
    output: Annotated[
        Path, shared.output_option("--output", "-o", help="Folder for page, designs, tables and figures.")
    ] = Path("mixed-ehl-optimise"),
    vary: Annotated[
        list[str] | None,
        console.advanced(
            help="A variable, with bounds or without: 'lengthwise_crowning=20:120 um', 'bias', 'hypoid_offset'; repeat "
            "for several. 'ease_off' (the default) and 'blank' select the usual ones, without the offset."
        ),
    ] = None,
    limit: Annotated[
        list[str] | None,
        console.advanced(
            help="Quantity that may not exceed that of the start, or a value: 'pressure_hertz_max=1.4 GPa'; 'none' for "
            "none. Default: pressure, transmission error, edge load, root stresses, not above those of the start."
        ),
    ] = None,
    tolerance: Annotated[
        list[str] | None,
        console.advanced(help="Manufacturing error (half width): 'lengthwise_crowning=5 um'; repeat for several."),
    ] = None,
    misalignment: _SearchBox,
    more: _SearchOptions,
    fresh: shared.FreshOption = False,
    json_output: shared.JsonOption = False,
) -> None:
    """Search ease-off and blank of a pair for less loss within limits of pressure, transmission error, edges and roots.

    Writes the Pareto front, and each checked point as a design file for `gear`. The same command resumes an
    interrupted search. The exit code is 1 if no better point lies within the limits.
    """
    store = shared.started_store(output, fresh)
    box = {"E": "0.05 mm", "P": "0.05 mm"} | misalignment
    chosen: dict[str, Any] = {"limits": _limits(limit), "tolerance": console.pairs("tolerance", tolerance)}
    chosen |= {"misalignment": box, "store": store, **more}
    with console.output_folder(output), console.working("optimisation", shared.kept("evaluations", store, fresh)):
        result = efficiency.optimise(targets, _variables(vary), **chosen)
    shared.present_folder(result, json_output, output, "no better design")


def _parts(texts: list[str]) -> list[tuple[str, str, str]]:
    """Name, equals sign and value of each text ``NAME=VALUE`` or ``NAME``."""
    parts = [text.partition("=") for text in texts]
    return [(name.strip(), equals, value.strip()) for name, equals, value in parts]


def _variables(texts: list[str] | None) -> dict[str, Any] | None:
    return {name: bounds if equals else None for name, equals, bounds in _parts(texts)} if texts else None


def _limits(texts: list[str] | None) -> dict[str, Any] | None:
    if not texts:
        return None
    if "none" in texts:
        if len(texts) > 1:
            raise InputError("limit", "none", "not together with another limit")
        return {}
    return {name: value if equals else "start" for name, equals, value in _parts(texts)}


def plan(
    designs: Annotated[list[str], typer.Argument(metavar="DESIGN", help="Design files, or names of shipped ones.")],
    duty: Annotated[
        Path, typer.Option(metavar="FILE", help="Duty cycle, CSV or XLSX: torque, speed, temperature, hours.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="PLAN.toml", help="The plan file.")],
    oil: Annotated[str | None, typer.Option(help="Oil card; default: those of the designs.")] = None,
    size: Annotated[int, typer.Option(min=1, help="Cases of the plan, for each oil.")] = 1024,
    coverage: Annotated[float, typer.Option(help="Share of the friction work inside each range.")] = 0.98,
) -> None:
    """Write the plan of a sweep over the operating range of gear designs in a duty cycle.

    The ranges are quantiles weighted with the friction work of each contact point.
    """
    console.check_outputs({"output": output}, output=".toml")
    pairs = [efficiency.load(design) for design in designs]
    ranges = regression.operating_range([point for pair in pairs for point in pair.duty_points(duty, oil)], coverage)
    oils = tuple(dict.fromkeys([oil] if oil else [pair.design.operation.oil for pair in pairs]))
    words = f"{100.0 * coverage:g} % of the friction work of {', '.join(pair.name for pair in pairs)} over {duty.name}"
    text = ranges.plan_text(output.stem, oils, size=size, description=words)
    console.write_text(output, text)
    ranges.show()
    count, name = regression.Plan.from_file(output).count, shlex.quote(str(output))
    print(f"{output}: {count} cases\nnext: mixed-ehl sweep {name} --estimate")
