"""Commands of the sweep: `sweep PLAN`, `sweep status`, `sweep merge`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
import typer.core

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from regression.plan.plan import Plan
    from regression.sweeping.executors import Executor


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
        str,
        typer.Argument(
            metavar="PLAN", help="Plan file, or a shipped plan: gear_default, gear_mesh, demo, gear_range..."
        ),
    ],
    run: Annotated[Path | None, typer.Option("-o", "--output", metavar="RUN", help="Folder of the results.")] = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change an entry: lubricant.oil=fva3.")
    ] = None,
    jobs: Annotated[int | None, typer.Option(help="Worker processes; all processors if not given.")] = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="A dask scheduler (tcp://..., file.json), or local:N.")
    ] = None,
    shard: Annotated[str, typer.Option(help="i/n: only every n-th case, beginning with the i-th.")] = "1/1",
    time_cap: Annotated[str, typer.Option(help="Give a case up after this time.")] = "600 s",
    retries: Annotated[int, typer.Option(help="Safer settings tried where the solver gives a case up.")] = 1,
    formula: Annotated[
        str | None, typer.Option("--with", help="Compute with a published formula, to try a plan in seconds.")
    ] = None,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="Compute failed cases on disk again.")] = False,
    adaptive: Annotated[
        bool, typer.Option("--adaptive", help="Add batches of cases by the plan's [adaptive].")
    ] = False,
    estimate: Annotated[bool, typer.Option("--estimate", help="Say what the plan costs, and compute nothing.")] = False,
    slurm: Annotated[int | None, typer.Option(metavar="N", help="Print a Slurm job array of N tasks.")] = None,
) -> None:
    """Compute the cases of a plan that are not on disk yet (the default command)."""
    from functools import partial

    from ehl.io.errors import InputError
    from ehl.io.units import ValueRange
    from regression.friction.published_registry import PUBLISHED
    from regression.plan.plan import load_plan
    from regression.sweeping.evaluators import SOLVER, published_outputs, solve_outputs
    from regression.sweeping.progress import show_progress
    from regression.sweeping.sweep import available_jobs, sweep
    from regression.view.report import estimate_report, sweep_report

    content = load_plan(plan, changes or ())
    if formula is not None and formula not in PUBLISHED:
        raise InputError("--with", formula, "one of " + ", ".join(sorted(PUBLISHED)))
    cap = ValueRange("s", gt=0.0).check(time_cap, "--time-cap", bare=False)
    workers = available_jobs() if jobs is None else jobs
    if estimate:
        estimate_report(content, workers)
        return
    if run is None:
        raise InputError("--output", None, "the folder of the results, -o RUN")
    if slurm is not None:
        from regression.sweeping.slurm import JOBS, array_script

        if adaptive or dask is not None or shard != "1/1":
            raise InputError("--slurm", slurm, "neither --adaptive, --dask nor --shard beside it")
        options = [part for change in changes or () for part in ("--set", change)]
        options += ["--with", formula] if formula else []
        options += ["--time-cap", time_cap, "--retries", str(retries), *(["--retry-failed"] if retry_failed else [])]
        typer.echo(array_script(plan, str(run), slurm, options, jobs or JOBS), nl=False)
        return
    conduct: dict[str, Any] = {
        "evaluate": partial(published_outputs, name=formula) if formula else solve_outputs,
        "version": formula or SOLVER,
        "jobs": workers,
        "time_cap": cap,
        "retries": retries,
        "retry_failed": retry_failed,
    }
    part = _shard(shard)
    try:
        with show_progress(content.name) as show, _executor(dask) as executor:
            conduct |= {"progress": show, "executor": executor}
            if adaptive:
                reports = _adaptive(content, run, part, conduct)
            else:
                reports = [sweep(content, run, shard=part, **conduct)]
    except KeyboardInterrupt:
        typer.echo("stopped; what is finished is on disk, the same command goes on", err=True)
        raise typer.Exit(1) from None
    for report in reports:
        sweep_report(report)
    count = sum(report.failed + report.unsettled for report in reports)
    if count:
        typer.echo(f"not converged: {count} cases, recorded with their reasons", err=True)
        raise typer.Exit(1)


def _executor(address: str | None) -> AbstractContextManager[Executor | None]:
    from contextlib import nullcontext

    if address is None:
        return nullcontext(None)
    from regression.sweeping.dask_workers import dask_executor

    return dask_executor(address)


def _adaptive(plan: Plan, run: Path, shard: tuple[int, int], conduct: dict[str, Any]) -> list[Any]:
    from ehl.io.errors import InputError
    from regression.sweeping.adaptive import Score, adaptive_sweep

    if shard != (1, 1):
        raise InputError("--shard", f"{shard[0]}/{shard[1]}", "no shards with --adaptive", "Use --jobs or --dask.")

    def notify(score: Score) -> None:
        error = f"{100.0 * score.weighted:.2g} % weighted, {100.0 * score.p95:.2g} % at 95 %"
        typer.echo(f"{score.cases} results: cross-validated error of mu {error}", err=True)

    report = adaptive_sweep(plan, run, notify=notify, **conduct)
    why = "the budget is spent" if report.ended == "budget" else "two more batches gained too little"
    typer.echo(f"{report.batches} batches added; ended because {why}")
    return list(report.sweeps)


@sweep_app.command("status")
def sweep_status(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder or file of results, or a shipped dataset.")],
    failed: Annotated[bool, typer.Option("--failed", help="List the failed cases too.")] = False,
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """How far a run is; also while it is being computed."""
    from regression.data.dataset import run_status
    from regression.data.datasets import results_path
    from regression.view.report import failed_table, status_table

    status = run_status(results_path(run))
    if json_output:
        from dataclasses import asdict

        from ehl.view.report import print_json

        shards = [{**asdict(shard), "path": str(shard.path)} for shard in status.shards]
        print_json({**asdict(status), "shards": shards, "complete": status.complete})
        return
    status_table(status)
    if failed:
        failed_table(status)


@sweep_app.command("merge")
def sweep_merge(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder or file of results, or a shipped dataset.")],
    target: Annotated[Path, typer.Option("-o", "--output", metavar="FILE", help="One file: .h5, or .csv as a table.")],
    compress: Annotated[bool, typer.Option("--compress", help="Compressed .h5, to keep and to pass on.")] = False,
) -> None:
    """Put all shards of a run into one file, sorted by case key."""
    from regression.data.dataset import export_table, load_dataset
    from regression.data.datasets import merge_compressed, results_path
    from regression.data.store import merge

    run = results_path(run)
    if target.suffix == ".csv":
        dataset = load_dataset(run)
        export_table(dataset, target)
        count = len(dataset.frame)
    else:
        count = merge_compressed(run, target) if compress else merge(run, target)
    typer.echo(f"{target}: {count} cases")


def _shard(text: str) -> tuple[int, int]:
    from ehl.io.errors import InputError

    number, slash, shards = text.partition("/")
    if not (slash and number.isdigit() and shards.isdigit() and 1 <= int(number) <= int(shards)):
        raise InputError("--shard", text, "i/n with 1 <= i <= n", "Write it as 2/8.")
    return int(number), int(shards)
