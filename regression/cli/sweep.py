"""Commands of the sweep: `sweep PLAN`, `sweep status`, `sweep merge`."""

from pathlib import Path
from typing import Annotated, Any

import typer
import typer.core

import regression
from ehl import InputError
from ehl.common.console import App, JsonOption, advanced, names_of, pairs, print_json, print_text, working


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
    "sweep. For its options see mixed-ehl sweep run --help.",
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
    jobs: Annotated[int | None, typer.Option(help="Worker processes; default: all processors.")] = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="A dask scheduler (tcp://..., file.json), or local:N.")
    ] = None,
    shard: Annotated[str, advanced(help="i/n: every n-th case only, starting with the i-th.")] = "1/1",
    time_cap: Annotated[str, advanced(help="Time limit of a case.")] = "600 s",
    retries: Annotated[int, advanced(help="Number of fallback settings for a case without a solution.")] = 1,
    formula: Annotated[
        str | None, advanced("--with", help="Compute with a published formula, for a quick test of a plan.")
    ] = None,
    retry_failed: Annotated[bool, advanced("--retry-failed", help="Repeat failed cases on disk.")] = False,
    estimate: Annotated[bool, typer.Option("--estimate", help="Print the cost of the plan and stop.")] = False,
    slurm: Annotated[
        int | None, typer.Option(metavar="N", help="Print the script of a Slurm job array of N tasks.")
    ] = None,
    sbatch: Annotated[
        list[str] | None,
        advanced(metavar="NAME=VALUE", help="With --slurm: partition=short, account=..., mem=8G, time=08:00:00..."),
    ] = None,
    container: Annotated[
        str | None, advanced(metavar="IMAGE", help="With --slurm: run in this image with apptainer.")
    ] = None,
    merge: Annotated[
        Path | None, advanced(metavar="FILE", help="With --slurm: a job after the array merges into this file.")
    ] = None,
    fit: Annotated[
        Path | None, advanced(metavar="FORMULA.json", help="With --slurm: this job also fits this formula.")
    ] = None,
) -> None:
    """Compute the cases of a plan that are not on disk yet (the default command).

    The exit code is 0 if every case has a result with its error, 1 if a case has none, and 130 after an interruption.
    """
    content = regression.Plan.from_file(plan, changes or ())
    if estimate:
        print_text(content.estimate().to_text(jobs))
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
    print_text(result.to_text())
    if result.unanswered:
        cases = "1 case has" if result.unanswered == 1 else f"{result.unanswered} cases have"
        typer.echo(f"{cases} no result: `mixed-ehl sweep status {run} --failed` lists them", err=True)
        raise typer.Exit(1)


@sweep_app.command("status")
def sweep_status(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder or file of results, or a shipped dataset.")],
    failed: Annotated[bool, typer.Option("--failed", help="List the failed cases as well.")] = False,
    json_output: JsonOption = False,
) -> None:
    """Show the progress of a run, which may still be in progress."""
    status = regression.Run(run).status
    if json_output:
        print_json(status.to_dict())
        return
    status.show()
    if failed and status.failed:
        status.failed_table().print()


@sweep_app.command("merge")
def sweep_merge(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder or file of results, or a shipped dataset.")],
    target: Annotated[Path, typer.Option("-o", "--output", metavar="FILE", help="One file: .h5, or .csv as a table.")],
    compress: Annotated[bool, typer.Option("--compress", help="Compress the .h5 file.")] = False,
    complete: Annotated[bool, typer.Option("--complete", help="Reject a run with missing cases.")] = False,
) -> None:
    """Merge all shards of a run into one file, sorted by case key."""
    count = regression.Run(run).merge(target, compress=compress, complete=complete)
    typer.echo(f"{target}: {count} cases")
