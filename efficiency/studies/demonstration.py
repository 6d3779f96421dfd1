"""A complete example: sweep, fit, gear pair, comparison, and one HTML report."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from efficiency.loss.compare import Comparison
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.output.comparison_report import comparison_notes
from efficiency.output.gear_report import SPIN, answer
from efficiency.output.tables import operating_point, percent
from efficiency.pair import GearPair
from ehl import __version__
from ehl.common.files import make_folder
from ehl.common.pages import Reportable
from ehl.common.progress import ProgressCallback, progress_to, report_progress
from ehl.common.runner import checked_jobs
from ehl.common.sections import Code, Folded, Head, KeyFigures, Medium, Notes, Row, Section, Text, picture
from ehl.common.table import Table
from ehl.common.threads import one_thread
from regression.data.dataset import Dataset
from regression.formula import fit
from regression.friction.fitted import FittedFormula
from regression.sweeping.run import Run, sweep
from regression.view.plots import plot_bands, plot_friction, plot_parity
from regression.view.tables import band_table, family_table


def demo_sections(result: DemoResult, medium: Medium) -> list[Section]:
    """Sections of the demonstration: gear pair, friction models, formulas, contacts, provenance."""
    if medium != "page":
        return result.comparison.sections(medium)
    _, *of_gear = result.gear.sections(medium)
    _, *of_models = result.comparison.sections(medium)
    return [_summary(result), *of_gear, *of_models, _formulas(result), _contacts(result), _provenance(result)]


def _summary(result: DemoResult) -> Section:
    best, gear = result.formulas[0], result.gear
    constant = next(row for row in result.comparison.rows if row.name.startswith("constant"))
    notes = Notes(comparison_notes(result.comparison), len(result.comparison.results))
    tiles = [
        (f"{percent(constant.efficiency, 2)} %", "with a constant friction coefficient of 0.05"),
        (f"{gear.power_loss:.0f} W", f"friction loss of {gear.power_input / 1e3:.1f} kW"),
        (f"{100 * best.validation.mape:.1f} %", f"mean error of the formula ({best.label}) on held-out contacts"),
        (f"{result.run.reports[0].total - result.run.unanswered}", "contacts solved"),
    ]
    point = operating_point(result.comparison)
    head = Head("From lubricated contacts to gear efficiency", f"mixed-ehl {__version__}: {point}", SPIN)
    return Section("", [head, answer(gear), KeyFigures(tiles), notes])


def _contacts(result: DemoResult) -> Section:
    frame = result.dataset.converged
    report = result.run.reports[0]
    heated = int((~frame["skipped"].str.contains("heat")).sum())
    friction_error = frame["friction_error"]
    text = (
        f"{report.total} line contacts, sampled by a scrambled Sobol sequence over the operating range of the contact "
        "points of the pair. Each contact is solved as a smooth film, with heat where an estimate predicts a relevant "
        f"effect ({heated} of {len(frame)}), and then transiently with both rough surfaces. {result.run.unanswered} "
        f"contacts failed. The numerical error of the friction coefficient is {100 * friction_error.median():.2g} % "
        f"(median) and at most {100 * friction_error.max():.2g} %. It comprises the discretisation and the neglected "
        "heat, but not the data of oil and surfaces."
    )
    figures = [
        picture("", "Friction of all contacts of the sweep.", plot_friction, result.dataset),
        picture("", "Friction: formula over computed.", plot_parity, result.dataset, result.formulas),
    ]
    return Section("Contacts", [Text(text), Row(figures)])


def _formulas(result: DemoResult) -> Section:
    best = result.formulas[0]
    text = (
        "Each family is fitted to the same contacts and assessed by cross-validation over cells of pressure and radius."
    )
    return Section(
        "Friction formula",
        [
            Text(text),
            family_table(result.formulas),
            picture("", "Held-out errors by band of each variable, with the number of cases.", plot_bands, best),
            Folded("Errors by region", [band_table(best)]),
            Folded(f"Equation and coefficients of {best.name}", [Code(best.to_text())]),
        ],
    )


def _provenance(result: DemoResult) -> Section:
    best = result.formulas[0]
    rows = [
        ("data hash", best.data.hash[:16]),
        ("plan hash", best.data.plan_hash[:16]),
        ("solver", best.data.solver_version),
        *((f"time: {step}", f"{value:.1f} s") for step, value in result.seconds.items()),
    ]
    neglected = Text(f"Effects that the gear model neglects: {'; '.join(result.gear.skipped)}.")
    files = Text("Files in the same folder: run/ (contacts), formula_*.json (formulas), demo.json (all figures).")
    return Section("Provenance", [Table(("item", "value"), rows), neglected, files])


DESIGN = "fm_spiral_bevel_14x39_relieved"
CONSTANT = "constant:0.05"


@dataclass(frozen=True)
class DemoResult(Reportable):
    """Results of the demonstration."""

    presenter = "efficiency.studies.demonstration:demo"

    folder: Path  # output folder
    run: Run  # run of the contacts
    dataset: Dataset  # results of the contacts
    formulas: tuple[FittedFormula, ...]  # one per family, best cross-validated first
    gear: EfficiencyResult  # the pair with the best formula
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
            "gear": self.gear.to_dict(),
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
        loaded = GearPair(DESIGN).mesh().load()
        models = [*map(str, paths), "ehl", CONSTANT, "xu_kahraman_2007"]
        comparison = loaded.compare(models)
        gear = loaded.efficiency(models[0])
        report_progress("gear pair", 1, 1)
        lap("gear")

    result = DemoResult(folder, run, dataset, formulas, gear, comparison, seconds)
    result.report(folder / "demo.json")
    result.report(folder / "report.html")
    return result
