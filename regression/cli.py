"""Commands of the friction formula: `sweep` with `status` and `merge`, `fit`, `mu`, `calibrate`."""

from pathlib import Path
from typing import Annotated, Any

import typer
import typer.core

import ehl
import regression
from ehl import InputError
from ehl.common.console import (
    App,
    DaskOption,
    JobsOption,
    JsonOption,
    advanced,
    check_outputs,
    counted,
    given,
    names_of,
    pairs,
    print_json,
    print_result,
    print_text,
    reason_text,
    working,
)


def fit(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN", help="Folders or files of results, or shipped datasets.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FORMULA.json", help="The formula file.")],
    family: Annotated[str, typer.Option(help="best (by held-out error), network, or the name of one family.")] = "best",
    corners: Annotated[bool, typer.Option("--corners", help="Include the corner points of the plan.")] = False,
    paths: Annotated[Path | None, typer.Option(help="Run of contacts along gear meshes for validation.")] = None,
    noise: Annotated[
        Path | None,
        typer.Option(help="Run with several roughness profiles per point: noise floor, and errors of the means."),
    ] = None,
    oil: Annotated[
        str | None, advanced(help="The oil of the formula, if the data have several; all are used for training.")
    ] = None,
    nested: Annotated[
        bool, typer.Option("--nested", help="Cross-validate the choice of the family as well (minutes).")
    ] = False,
    plot: Annotated[Path | None, typer.Option(help="Write a figure of predicted over computed friction.")] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="FIT.html", help="Write an HTML page on data, formulas, errors and failures.")
    ] = None,
    jobs: Annotated[int | None, advanced(min=1, help="Worker processes; default: all processors.")] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print the content of the formula file.")] = False,
) -> None:
    """Fit a friction formula to the results of one or more sweeps, with its errors."""
    check_outputs({"output": output, "plot": plot, "report": report}, output=".json")
    with working("fit"):
        formula = regression.fit(
            runs, family, corners=corners, nested=nested, paths=paths, noise=noise, oil=oil, jobs=jobs
        )
    formula.save(output)
    formula.write(plot=plot, report=report)
    if json_output:
        typer.echo(formula.to_json(), nl=False)
        return
    formula.show()
    typer.echo(f"written: {output}")


def mu(
    model: Annotated[str, typer.Argument(metavar="FORMULA", help="Formula file, registry name, or constant:VALUE.")],
    pressure: Annotated[str, typer.Option(help='Maximum Hertz pressure, "1.2 GPa".')],
    radius: Annotated[str, typer.Option(help='Equivalent radius, "10 mm".')],
    speed: Annotated[str, typer.Option(help='Entrainment speed (u1 + u2)/2, "5 m/s".')],
    slide_to_roll: Annotated[str, typer.Option(help="Sliding across the contact line over entrainment speed.")],
    temperature: Annotated[str, typer.Option(help='Oil temperature at the inlet, "80 degC".')],
    roughness_rms: Annotated[
        str | None, typer.Option(help='Composite Rq of both surfaces, "0.4 um"; default: smooth.')
    ] = None,
    lengthwise: Annotated[str, typer.Option(help='Sliding along the contact line, "1 m/s".')] = "0 m/s",
    finish: Annotated[
        str | None, typer.Option(help="Finish of both surfaces, e.g. ground, for defaults of the roughness.")
    ] = None,
    correlation_length: Annotated[
        str | None, advanced(help='Correlation length of each surface, "50 um"; default: 40 Rq.')
    ] = None,
    peklenik_number: Annotated[
        str | None, advanced(help="Correlation length along the contact line over that across it; 1 is isotropic.")
    ] = None,
    oil: Annotated[str | None, typer.Option(help="Oil card; default: that of the formula.")] = None,
    boundary_friction: Annotated[
        float | None, advanced(help="Boundary friction mu_b; default: that of the formula.", min=0.0, max=1.0)
    ] = None,
    refuse: Annotated[bool, advanced("--refuse", help="Fail if the point is outside the data (exit code 2).")] = False,
    hull: Annotated[
        list[Path] | None, advanced(metavar="RUN", help="Data of the formula, for an exact test of their convex hull.")
    ] = None,
    json_output: JsonOption = False,
) -> None:
    """Evaluate a friction formula at one contact point."""
    friction = regression.friction_model(model)
    if isinstance(friction, regression.Formula):
        friction = friction.with_options(boundary_friction, refuse=refuse)
    elif boundary_friction is not None or refuse or hull:
        option = "hull" if hull else "refuse" if boundary_friction is None else "boundary_friction"
        raise InputError(option, friction.name, "a fitted formula: a formula file, or a shipped one")
    name = oil or friction.default_oil()
    point = given(
        {
            "pressure_hertz": pressure,
            "radius_equivalent": radius,
            "speed_entrainment": speed,
            "slide_to_roll": slide_to_roll,
            "temperature_oil": temperature,
            "speed_sliding_lengthwise": lengthwise,
            "roughness_rms": roughness_rms,
            "finish": finish,
            "correlation_length": correlation_length,
            "peklenik_number": peklenik_number,
        }
    )
    content: dict[str, Any] = friction.mu(oil=name, **point).to_dict()
    other = friction.oil_note(ehl.Oil.load(name)) if isinstance(friction, regression.Formula) else ""
    content |= {"friction_model": friction.name, "oil": name}
    if certainty := getattr(friction, "certainty", None):
        content["certainty"] = certainty
    if hull and isinstance(friction, regression.Formula):
        content["in_convex_hull"] = bool(friction.in_convex_hull(hull, oil=name, **point))
    spread = None if content["friction_coefficient"] is None else friction.uncertainty(oil=name, **point)
    if json_output:
        print_json(content | ({} if spread is None else {"uncertainty": spread.to_dict()}))
    else:
        _print_friction(content, friction.title)
        if spread is not None and spread.low < spread.high:
            stated = "; ".join((spread.headline(), *spread.notes))
            print_text(f"{100.0 * spread.level:.0f} % interval with inputs: mu = {stated}")
    outside = friction.range_note(oil=name, **point) if isinstance(friction, regression.Formula) else ""
    flagged = "" if content["flag"] == "ok" or other else reason_text(content["flag"])
    for note in filter(None, (outside or flagged, other)):
        typer.echo(f"note: {note}", err=True)
    if content["friction_coefficient"] is None:
        raise typer.Exit(1)


def _print_friction(content: dict[str, Any], label: str) -> None:
    """Print one friction value."""
    value = content["friction_coefficient"]
    line = "mu = none" if value is None else f"mu = {value:.4f}"
    if content["friction_lower"] is not None:
        whose = ", 90 % interval of the formula" if content["friction_lower"] < content["friction_upper"] else ""
        line += f"  ({content['friction_lower']:.4f} to {content['friction_upper']:.4f}{whose})"
    if "in_convex_hull" in content:
        line += f"  {'inside' if content['in_convex_hull'] else 'outside'} the convex hull of its data"
    mark = "" if content.get("certainty", "published") == "published" else " (M: equation unverified, at least in part)"
    typer.echo(f"{line}  {label}{mark}, {content['oil']}")


def calibrate(
    measured: Annotated[Path, typer.Argument(metavar="MEASURED", help="Measured friction, CSV or XLSX.")],
    setup: Annotated[Path, typer.Option(metavar="SETUP.toml", help="Oil, parameters, specimens, common conditions.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="CARD.toml", help="Write the calibrated oil card.")
    ] = None,
    fit: Annotated[
        list[str] | None,
        typer.Option(
            "--fit", metavar="NAME", help="Fitted parameter; repeat for several; default: those of the setup."
        ),
    ] = None,
    oil: Annotated[str | None, typer.Option(help="Initial oil card; default: that of the setup.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Write measured and computed curves (PNG, SVG, PDF).")] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="CALIBRATION.html", help="HTML page on parameters, curves and residuals.")
    ] = None,
    jobs: JobsOption = None,
    profile: Annotated[
        bool | None, advanced("--profile/--no-profile", help="Profile-likelihood intervals; default: only if fast.")
    ] = None,
    force: Annotated[bool, advanced("--force", help="Write the card even if the model does not fit the data.")] = False,
    json_output: JsonOption = False,
) -> None:
    """Fit oil and surface parameters to measured traction or Stribeck curves, and write an oil card."""
    check_outputs({"output": output, "plot": plot, "report": report}, output=".toml")
    with working("calibration"):
        result = regression.calibrate(measured, setup, profile=profile, parameters=fit, oil=oil, jobs=jobs)
    try:  # files first, as standard output may be closed; the fit is shown even if it gives no card
        result.write(plot=plot, report=report)
        if output is not None:
            result.save_card(output, force=force)
    finally:
        print_result(result, json_output)
    if output is not None and not json_output:
        typer.echo(f"written: {output}. To use it:")
        for line in result.use_lines(output):
            typer.echo(f"  {line}")


class SweepGroup(typer.core.TyperGroup):
    """Command group with the default command `run`: `sweep PLAN.toml ...` is `sweep run PLAN.toml ...`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Insert the name of the default command before the plan."""
        if args and args[0] not in self.commands and args[0] not in ctx.help_option_names:
            args = ["run", *args]
        return super().parse_args(ctx, args)


sweep_app = App(
    cls=SweepGroup,
    no_args_is_help=True,
    help="Compute the contacts of a plan: mixed-ehl sweep PLAN.toml -o RUN. The same command resumes an interrupted "
    "sweep. See mixed-ehl sweep run --help for its options.",
)


@sweep_app.command("run")
def sweep_run(
    plan: Annotated[
        str,
        typer.Argument(
            metavar="PLAN", help="Plan file, or a shipped plan: gear, gear_mesh, demo", autocompletion=names_of("plans")
        ),
    ],
    run: Annotated[Path | None, typer.Option("-o", "--output", metavar="RUN", help="Folder of the results.")] = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change an entry: lubricant.oil=fva3.")
    ] = None,
    jobs: JobsOption = None,
    dask: DaskOption = None,
    shard: Annotated[str, advanced(help="i/n: only every n-th case, starting with the i-th.")] = "1/1",
    time_cap: Annotated[str, advanced(help="Time limit of a case.")] = "600 s",
    retries: Annotated[int, advanced(min=0, help="Number of fallback settings for a case without a solution.")] = 1,
    formula: Annotated[
        str | None, advanced("--with", help="Compute with a published formula, for a quick test of a plan.")
    ] = None,
    retry_failed: Annotated[bool, advanced("--retry-failed", help="Repeat the failed cases.")] = False,
    estimate: Annotated[bool, typer.Option("--estimate", help="Print the cost of the plan and stop.")] = False,
    slurm: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Print the script of a Slurm job array of N tasks.")
    ] = None,
    sbatch: Annotated[
        list[str] | None,
        advanced(metavar="NAME=VALUE", help="With --slurm: partition=short, account=..., mem=8G, time=08:00:00..."),
    ] = None,
    container: Annotated[str | None, advanced(metavar="IMAGE", help="With --slurm: apptainer image.")] = None,
    merge: Annotated[
        Path | None, advanced(metavar="FILE", help="With --slurm: a further job merges the results into this file.")
    ] = None,
    fit: Annotated[
        Path | None, advanced(metavar="FORMULA.json", help="With --slurm: the merge job also fits this formula.")
    ] = None,
) -> None:
    """Compute the cases of a plan that have no stored result (default command).

    The exit code is 0 if every case has a result, 1 if a case has none, and 130 after an interruption.
    """
    content = regression.Plan.from_file(plan, changes or ())
    if estimate:
        print_text(content.estimate(time_cap).to_text(jobs))
        return
    if run is None:
        raise InputError("output", None, "the folder of the results, -o RUN")
    options: dict[str, Any] = {"jobs": jobs, "formula": formula, "time_cap": time_cap, "retries": retries}
    options["retry_failed"] = retry_failed
    if slurm is not None:
        if dask is not None or shard != "1/1":
            raise InputError("slurm", slurm, "a job array without --dask and --shard")
        options |= {"sbatch": pairs("sbatch", sbatch), "container": container, "merge": merge, "fit": fit}
        typer.echo(regression.slurm_script(plan, run, slurm, changes=changes or (), **options), nl=False)
        return
    for name, value in (("sbatch", sbatch), ("container", container), ("merge", merge), ("fit", fit)):
        if value is not None:
            raise InputError(name, str(value), f"--{name} together with --slurm")
    options |= {"shard": shard, "dask": dask}
    with working(content.name, f"finished cases are kept in {run}; the same command resumes"):
        result = regression.sweep(content, run, **options)
    print_text("\n".join(report.to_text() for report in result.reports))
    if result.unanswered:
        cases = counted(result.unanswered, "case")
        typer.echo(f"{cases} without a result: `mixed-ehl sweep status {run} --failed` lists them", err=True)
        raise typer.Exit(1)


@sweep_app.command("status")
def sweep_status(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder or file of results, or a shipped dataset.")],
    failed: Annotated[bool, typer.Option("--failed", help="List the failed cases as well.")] = False,
    json_output: JsonOption = False,
) -> None:
    """Show the progress of a run, also while it is running."""
    status = regression.Run(run).status
    print_result(status, json_output)
    if failed and status.failed and not json_output:
        status.failed_table().print()


@sweep_app.command("merge")
def sweep_merge(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder or file of results, or a shipped dataset.")],
    target: Annotated[Path, typer.Option("-o", "--output", metavar="FILE", help="One file: .h5, or .csv as a table.")],
    compress: Annotated[bool, typer.Option("--compress", help="Compress the .h5 file.")] = False,
    complete: Annotated[bool, typer.Option("--complete", help="Fail if cases are missing in the run.")] = False,
) -> None:
    """Merge all shards of a run into one file, sorted by case key."""
    check_outputs({"target": target})
    count = regression.Run(run).merge(target, compress=compress, complete=complete)
    typer.echo(f"{target}: {counted(count, 'case')}")
