"""Commands of the friction formula: `sweep`, `fit`, `mu`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
import typer.core


class SweepGroup(typer.core.TyperGroup):
    """`sweep PLAN.toml ...` means `sweep run PLAN.toml ...`; `sweep status` and `sweep merge` stay commands."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put the name of the default command before the plan."""
        if args and args[0] not in self.commands and args[0] not in ctx.help_option_names:
            args = ["run", *args]
        return super().parse_args(ctx, args)


sweep_app = typer.Typer(
    cls=SweepGroup,
    no_args_is_help=True,
    help="Compute the contacts of a plan: mixed-ehl sweep PLAN.toml -o RUN. The same command resumes. "
    "Its options: mixed-ehl sweep run --help.",
)


@sweep_app.command("run")
def sweep_run(
    plan: Annotated[
        str, typer.Argument(metavar="PLAN", help="Plan file, or a shipped plan: demo, gear_range, gear_range_75w90.")
    ],
    run: Annotated[Path, typer.Option("-o", "--output", metavar="RUN", help="Folder of the results.")],
    jobs: Annotated[int | None, typer.Option(help="Worker processes; all processors if not given.")] = None,
    shard: Annotated[str, typer.Option(help="i/n: only every n-th case, beginning with the i-th.")] = "1/1",
    time_cap: Annotated[str, typer.Option(help="Give a case up after this time.")] = "600 s",
    formula: Annotated[
        str | None, typer.Option("--with", help="Compute with a published formula, to try a plan in seconds.")
    ] = None,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="Compute failed cases on disk again.")] = False,
    slurm: Annotated[int | None, typer.Option(metavar="N", help="Print a Slurm job array of N tasks.")] = None,
) -> None:
    """Compute the cases of a plan that are not on disk yet (the default command)."""
    from functools import partial

    from ehl.errors import InputError
    from ehl.units import Quantity
    from regression.evaluators import SOLVER, published_outputs, solve_outputs
    from regression.plan import load_plan
    from regression.published_registry import PUBLISHED
    from regression.report import sweep_report
    from regression.slurm import array_script
    from regression.sweep import available_jobs, sweep

    content = load_plan(plan)
    if slurm is not None:
        typer.echo(array_script(plan, str(run), slurm), nl=False)
        return
    if formula is not None and formula not in PUBLISHED:
        raise InputError("--with", formula, "one of " + ", ".join(sorted(PUBLISHED)))
    try:
        with _progress_bar(content.name) as show:
            report = sweep(
                content,
                run,
                evaluate=partial(published_outputs, name=formula) if formula else solve_outputs,
                version=formula or SOLVER,
                jobs=available_jobs() if jobs is None else jobs,
                shard=_shard(shard),
                time_cap=Quantity("s", gt=0.0).check(time_cap, "--time-cap", bare=False),
                retry_failed=retry_failed,
                progress=show,
            )
    except KeyboardInterrupt:
        typer.echo("stopped; what is finished is on disk, the same command goes on", err=True)
        raise typer.Exit(1) from None
    sweep_report(report)
    if report.failed or report.unsettled:
        count = report.failed + report.unsettled
        typer.echo(f"not converged: {count} cases, recorded with their reasons", err=True)
        raise typer.Exit(1)


@sweep_app.command("status")
def sweep_status(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of the results.")],
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """How far a run is; also while it is being computed."""
    from regression.dataset import run_status
    from regression.report import status_table

    status = run_status(run)
    if json_output:
        from dataclasses import asdict

        from ehl.report import print_json

        shards = [{**asdict(shard), "path": str(shard.path)} for shard in status.shards]
        print_json({**asdict(status), "shards": shards, "complete": status.complete})
    else:
        status_table(status)


@sweep_app.command("merge")
def sweep_merge(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of the results.")],
    target: Annotated[Path, typer.Option("-o", "--output", metavar="FILE", help="One file: .h5, or .csv as a table.")],
) -> None:
    """Put all shards of a run into one file, sorted by case key."""
    from regression.dataset import export_table, load_dataset
    from regression.store import merge

    if target.suffix == ".csv":
        dataset = load_dataset(run)
        export_table(dataset, target)
        count = len(dataset.frame)
    else:
        count = merge(run, target)
    typer.echo(f"{target}: {count} cases")


def fit(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder or file of results.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FORMULA.json", help="The formula file.")],
    family: Annotated[str, typer.Option(help="best (by held-out error), xu, power_law or load_share.")] = "best",
    corners: Annotated[bool, typer.Option("--corners", help="Fit the corner points of the plan too.")] = False,
    plot: Annotated[Path | None, typer.Option(help="Write a figure of fitted over computed friction.")] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print the formula file's content.")] = False,
) -> None:
    """Fit a friction formula to the results of a sweep, and say what it is worth."""
    from regression.dataset import load_dataset
    from regression.families import FAMILIES
    from regression.fit import fit_families, fit_formula
    from regression.report import families_table, formula_report

    dataset = load_dataset(run)
    if family == "best":
        formulas = list(fit_families(dataset, corners=corners).values())
    else:
        formulas = [fit_formula(dataset, family, corners=corners)]
    formulas[0].save(output)
    if plot is not None:
        from ehl.plots import save_figure
        from regression.plots import plot_parity

        save_figure(plot_parity(dataset, formulas), plot)
    if json_output:
        typer.echo(formulas[0].to_json(), nl=False)
        return
    families_table(formulas, FAMILIES if family == "best" else [family])
    formula_report(formulas[0])
    typer.echo(f"written: {output}")


def mu(
    model: Annotated[str, typer.Argument(metavar="FORMULA", help="Formula file, registry name, or constant:VALUE.")],
    pressure: Annotated[str, typer.Option(help='Maximum Hertz pressure, "1.2 GPa".')],
    radius: Annotated[str, typer.Option(help='Equivalent radius, "10 mm".')],
    speed: Annotated[str, typer.Option(help='Entrainment speed (u1 + u2)/2, "5 m/s".')],
    slide_to_roll: Annotated[str, typer.Option(help="Sliding across the contact line over entrainment speed.")],
    temperature: Annotated[str, typer.Option(help='Oil temperature at the inlet, "80 degC".')],
    roughness: Annotated[str, typer.Option(help='Composite Rq of both surfaces, "0.4 um".')] = "0 um",
    lengthwise: Annotated[str, typer.Option(help='Sliding along the contact line, "1 m/s".')] = "0 m/s",
    oil: Annotated[str | None, typer.Option(help="Oil card; the formula's own if not given.")] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
) -> None:
    """Evaluate a friction formula at one contact point."""
    from ehl.material import effective_modulus, load_material
    from ehl.oil import Oil
    from ehl.report import print_json
    from ehl.state import ContactState
    from regression.cli_values import POINT, check_point, oil_of
    from regression.friction_models import friction_model
    from regression.report import friction_content, friction_line

    friction = friction_model(model)
    given = (pressure, radius, speed, slide_to_roll, temperature, roughness, lengthwise)
    values = check_point(dict(zip(POINT, given, strict=True)))
    composite = values.pop("roughness_rms") / 2.0**0.5
    steel = load_material("steel")
    name = oil_of(friction, oil)
    state = ContactState.of(
        **values,
        effective_modulus=effective_modulus(steel, steel),
        roughness_rms_1=composite,
        roughness_rms_2=composite,
    )
    content = friction_content(friction.name, name, friction.evaluate(state, Oil.load(name)))
    if json_output:
        print_json(content)
    else:
        friction_line(content)
    if content["flag"] != "ok":
        typer.echo(f"note: {content['flag'].replace('_', ' ')}", err=True)
    if content["friction_coefficient"] is None:
        raise typer.Exit(1)


def _shard(text: str) -> tuple[int, int]:
    from ehl.errors import InputError

    number, slash, shards = text.partition("/")
    if not (slash and number.isdigit() and shards.isdigit() and 1 <= int(number) <= int(shards)):
        raise InputError("--shard", text, "i/n with 1 <= i <= n", "Write it as 2/8.")
    return int(number), int(shards)


def _progress_bar(name: str) -> Any:
    """A context that gives a function showing the progress of a sweep."""
    from regression.progress import progress_bar

    return progress_bar(name)


def register(app: typer.Typer) -> None:
    """Add the commands of this package to the application."""
    app.add_typer(sweep_app, name="sweep")
    app.command()(fit)
    app.command()(mu)
