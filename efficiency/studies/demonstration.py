"""A complete example: sweep, fit, gear pair, comparison, and one HTML report."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from efficiency.loss.compare import Comparison
from efficiency.mesh import Mesh
from efficiency.pair import GearPair
from ehl.common.files import make_folder
from ehl.common.pages import Reportable
from ehl.common.progress import ProgressCallback, progress_to, report_progress
from ehl.common.runner import checked_jobs
from ehl.common.threads import one_thread
from regression.data.dataset import Dataset
from regression.formula import fit
from regression.friction.fitted import FittedFormula
from regression.sweeping.run import Run, sweep

DESIGN = "fm_spiral_bevel_14x39_relieved"
CONSTANT = "constant:0.05"


@dataclass(frozen=True)
class DemoResult(Reportable):
    """Results of the demonstration."""

    presenter = "efficiency.studies.demonstration_report:demo"

    folder: Path  # output folder
    run: Run  # run of the contacts
    dataset: Dataset  # results of the contacts
    formulas: tuple[FittedFormula, ...]  # one per family, best cross-validated first
    gear: Mesh  # geometry of the pair
    comparison: Comparison  # friction models on the pair; the best formula first
    seconds: dict[str, float]  # wall time of each step [s]

    def to_dict(self) -> dict[str, Any]:
        """Results of all steps, for JSON."""
        best, report = self.formulas[0], self.run.reports[0]
        return {
            "sweep": {"cases": report.total, "failed": report.unanswered, "reasons": report.reasons_failed},
            "formula": {
                "family": best.family,
                "coefficients": best.coefficients,
                "validation": best.validation.model_dump(mode="json"),
            },
            "gear": self.comparison.results[0].to_dict(),
            "comparison": self.comparison.to_dict(),
            "seconds": self.seconds,
        }


@one_thread
def run_demo(folder: Path | str, jobs: int | None = None, progress: ProgressCallback | None = None) -> DemoResult:
    """Run all steps and write their files and the report to a folder.

    Parameters
    ----------
    folder : Path or str
        Output folder, created if necessary. Contacts computed there before are reused.
    jobs : int, optional
        Worker processes of the sweep; default: all available cores.
    progress : callable, optional
        Called with a `Progress` for contacts, formulas and gear pair.

    Returns
    -------
    DemoResult
        The run, its formulas and the comparison of the friction models.

    Raises
    ------
    InputError
        The folder cannot be written.
    ConvergenceError
        A nonlinear fit did not converge.

    Examples
    --------
    The computation takes about a minute:

    >>> import efficiency
    >>> efficiency.demo("mixed-ehl-demo")  # doctest: +SKIP
    """
    folder, jobs = Path(folder), checked_jobs(jobs)
    make_folder(folder, "folder")
    seconds: dict[str, float] = {}
    clock = time.perf_counter()

    def lap(step: str) -> None:
        nonlocal clock
        now = time.perf_counter()
        seconds[step], clock = now - clock, now

    run = sweep("demo", folder / "run", jobs=jobs, progress=progress)
    dataset = run.dataset()
    lap("sweep")

    with progress_to(progress):
        report_progress("formulas", 0, 1)
        formulas = fit(dataset).candidates
        paths = [folder / f"formula_{formula.label}.json" for formula in formulas]
        for formula, path in zip(formulas, paths, strict=True):
            formula.save(path)
        report_progress("formulas", 1, 1)
        lap("fit")

        report_progress("gear pair", 0, 1)
        gear = GearPair(DESIGN).mesh()
        models = [*map(str, paths), "ehl", CONSTANT, "xu_kahraman_2007"]
        comparison = gear.load().compare(models)
        report_progress("gear pair", 1, 1)
        lap("gear")

    result = DemoResult(folder, run, dataset, formulas, gear, comparison, seconds)
    result.report(folder / "demo.json")
    result.report(folder / "report.html")
    return result
