"""The main job, small and real: sweep -> fit -> gear -> compare -> one HTML report."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from efficiency.loss.compare import Comparison
from efficiency.pair import GearPair, Mesh
from ehl.io.data import data_path
from ehl.io.errors import ConvergenceError, InputError
from regression.data.dataset import Dataset, load_dataset
from regression.fitting.fit import fit_families
from regression.friction.formula import FittedFormula
from regression.plan.cost import available_jobs
from regression.plan.plan import Plan
from regression.sweeping.recorder import Progress
from regression.sweeping.sweep import SweepReport, sweep_shard

DESIGN = "fm_spiral_bevel_14x39"
CONSTANT = "constant:0.05"

Notify = Callable[[str, int, int], None]


@dataclass(frozen=True)
class DemoResult:
    """What the demonstration computed.

    Parameters
    ----------
    folder : Path
        Where it was written.
    sweep_report : SweepReport
        Of the contacts.
    dataset : Dataset
        Their results.
    formulas : tuple of Formula
        One per family, best cross-validated first.
    gear : Mesh
        Geometry of the pair.
    comparison : Comparison
        Friction models on the pair; the best formula first.
    seconds : dict
        Wall time of each step.
    """

    folder: Path
    sweep_report: SweepReport
    dataset: Dataset
    formulas: tuple[FittedFormula, ...]
    gear: Mesh
    comparison: Comparison
    seconds: dict[str, float]


def run_demo(
    folder: Path | str, jobs: int | None = None, notify: Notify = lambda step, done, total: None
) -> DemoResult:
    """Run all steps and write their files and the report into a folder.

    Parameters
    ----------
    folder : Path or str
        Made if there is none. Contacts already computed there are kept.
    jobs : int, optional
        Worker processes of the sweep; by default the cores there are.
    notify : callable
        Called with (step, done, total) as the work goes on.

    Raises
    ------
    InputError
        The folder cannot be written.
    ConvergenceError
        No formula could be fitted.
    """
    from efficiency.output.demo_report import write_demo_report

    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("--output", str(folder), "a folder that can be written", f"{error}.") from None
    seconds: dict[str, float] = {}
    clock = time.perf_counter()

    def lap(step: str) -> None:
        nonlocal clock
        now = time.perf_counter()
        seconds[step], clock = now - clock, now

    plan = Plan.from_file(data_path("plans", "demo.toml"))

    def report_case(progress: Progress) -> None:
        notify("contacts", progress.done, progress.total)

    report = sweep_shard(plan, folder / "run", jobs=jobs or available_jobs(), progress=report_case)
    dataset = load_dataset(folder / "run")
    lap("sweep")

    notify("formulas", 0, 1)
    formulas = tuple(fit_families(dataset).values())
    if not formulas:
        raise ConvergenceError("fit", "no family of formulas could be fitted to the contacts")
    paths = [folder / f"formula_{formula.family}.json" for formula in formulas]
    for formula, path in zip(formulas, paths, strict=True):
        formula.save(path)
    notify("formulas", 1, 1)
    lap("fit")

    notify("gear pair", 0, 1)
    gear = GearPair(DESIGN).mesh()
    models = [*map(str, paths), "ehl:load_sharing", CONSTANT, "xu_kahraman_2007"]
    comparison = gear.load().compare(models)
    notify("gear pair", 1, 1)
    lap("gear")

    result = DemoResult(folder, report, dataset, formulas, gear, comparison, seconds)
    (folder / "demo.json").write_text(json.dumps(demo_summary(result), indent=2) + "\n", encoding="utf-8")
    write_demo_report(result)
    return result


def demo_summary(result: DemoResult) -> dict[str, object]:
    """The figures of the demonstration, for other programs."""
    best = result.formulas[0]
    return {
        "sweep": {
            "cases": result.sweep_report.total,
            "failed": result.sweep_report.failed,
            "reasons": result.sweep_report.reasons,
        },
        "formula": {
            "family": best.family,
            "coefficients": best.coefficients,
            "validation": best.validation.model_dump(mode="json"),
        },
        "gear": result.comparison.results[0].to_dict(),
        "comparison": result.comparison.to_dict(),
        "seconds": result.seconds,
    }
