"""The public interface of `regression`: one line for each step, the same errors, and the report of a fit."""

import html
import math
import re
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pages import read_page
from refusals import refuses
from small_plans import gear_plan, sweep_plan, swept

import regression
from ehl.common.data import reason_text
from ehl.common.pages import write_page
from ehl.common.sections import Text
from ehl.common.table import Table
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from regression.data.dataset import Dataset
from regression.data.result_files import read_run
from regression.fitting.fit import fit_formula
from regression.fitting.rows import fitted_rows
from regression.formula import Formula
from regression.friction.error_tables import ErrorInterval
from regression.friction.fitted import FittedFormula
from regression.friction.published_registry import PUBLISHED
from regression.plan.plan import Plan
from regression.sweeping.sweep import run_meta
from regression.view import plots
from regression.view.fit_report import fit_sections, formula_sections

XU = "xu_kahraman_2007"


def test_a_sweep_in_one_line_and_all_that_follows_from_it(tmp_path: Path) -> None:
    plan = regression.Plan.from_dict(sweep_plan("small"))
    handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    run = regression.sweep(plan, tmp_path / "run", formula=XU, jobs=1)
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == handlers
    assert run.status.complete
    assert (run.unanswered, run.reports[0].converged) == (0, 16)
    frame = run.to_frame(units=True)
    assert {"pressure_hertz [Pa]", "friction_coefficient", "key"} <= set(frame)
    # the stored plan is the plan
    assert run.plan.plan_hash == plan.plan_hash == read_run(run.path)[0]["plan_hash"]
    assert run.plan.to_frame().equals(plan.to_frame())
    again = regression.sweep(plan, tmp_path / "run", formula=XU, jobs=1)
    assert (again.reports[0].resumed, again.reports[0].converged) == (16, 0)
    assert regression.load_dataset(run).data_hash == regression.Run(tmp_path / "run").dataset().data_hash
    assert run.merge(tmp_path / "cases.csv") == run.merge(tmp_path / "cases.h5") == 16
    with refuses("target"):
        run.merge(tmp_path / "cases.txt")
    for result in (plan, run, run.status, run.dataset()):
        for name in ("page.html", "tables.xlsx", "first.csv", "all.json"):
            assert result.report(tmp_path / name).stat().st_size > 0
    half = regression.sweep(plan, tmp_path / "half", formula="benedict_kelley_1961", jobs=1, shard="1/2")
    assert (half.status.finished, half.status.complete) == (8, False)
    assert len(half.status.table().rows) == 1
    assert len(half.status.failed_table().rows) == len(half.status.failed)
    # a formula has no other settings: the failed cases are tried with it again, and fail again
    assert len(half.retry(jobs=1).status.failed) == len(half.status.failed)


def test_a_fit_has_its_data_and_a_file_needs_them(tmp_path: Path) -> None:
    run = regression.sweep(regression.Plan.from_dict(gear_plan("fit", {"size": 64})), tmp_path, formula=XU, jobs=1)
    fitted = regression.fit(run, "power_law")
    fitted.save(tmp_path / "fitted.json")
    loaded = regression.Formula.load(tmp_path / "fitted.json")
    assert dict(fitted.to_frame()[["term", "value"]].to_numpy().tolist()) == loaded.coefficients
    titles = [section.title for section in fitted.sections()]
    assert titles == [section.title for section in loaded.sections(dataset=run)]
    for axes in (fitted.plot(), loaded.plot(dataset=run)):
        drawn = sum(len(points.get_offsets()) for points in axes.collections)
        assert drawn + sum(len(line.get_xdata()) for line in axes.lines) >= fitted.data.used
    for field, use in (
        ("dataset", loaded.sections),
        ("dataset", loaded.plot),
        ("hull", lambda: loaded.in_convex_hull("gear_fva3_noise")),
        ("friction model", lambda: regression.friction_model("0,05")),
    ):
        with refuses(field):
            use()


@pytest.mark.parametrize("name", ["folder", "container", "merge", "fit"])
def test_a_name_of_several_lines_is_not_written_into_a_script(name: str, tmp_path: Path) -> None:
    """It would end the text for `sbatch`, and its other lines would run on the login node."""
    given = {"folder": str(tmp_path), name: f"{tmp_path}/x\nEOF\ntouch planted\n"}
    with refuses("slurm"):
        regression.slurm_script("demo", tasks=2, **given)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["demo", "gear", "gear_hot_noise", "gear_paths", "levels"])
def test_a_plan_is_read_back_from_what_files_store(name: str) -> None:
    levels = {"speed_entrainment": {"low": 2.0, "high": 8.0, "scale": "log", "levels": 3}}
    content = gear_plan("levels", {"size": 8}, **levels)
    plan = regression.Plan.from_dict(content) if name == "levels" else regression.Plan.from_file(name)
    back = regression.Plan.from_json(plan.model_dump_json())
    assert back.plan_hash == plan.plan_hash
    assert back.case_at(5).model_dump_json() == plan.case_at(5).model_dump_json()


PLAN = gear_plan(
    "report", {"size": 64, "corners": True}, roughness_rms={"low": "0.1 um", "high": "0.6 um", "scale": "log"}
)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Two cases fail and three are too uncertain to be fitted."""
    whole = swept(tmp_path_factory.mktemp("report"), PLAN)
    frame = whole.frame.copy()
    rows = np.flatnonzero(frame["origin"] == "sobol")[:5]
    frame.loc[rows[:2], ["status", "reason"]] = ["failed", "film_jump"]
    frame.loc[rows[2:], ["status", "reason", "friction_error"]] = ["unsettled", "statistical_interval", 1.3]
    return replace(whole, frame=frame)


@pytest.fixture(scope="module")
def formulas(dataset: Dataset) -> list[FittedFormula]:
    return [fit_formula(dataset, name) for name in ("short", "power_law")]


def cells(page: str) -> list[list[str]]:
    rows = re.findall(r"<tr[^>]*>(.*?)</tr>", page.replace("\N{NO-BREAK SPACE}", " "), flags=re.DOTALL)
    return [[re.sub(r"<[^>]+>", "", cell).strip() for cell in re.findall(r"<t[dh][^>]*>.*?</t[dh]>", r)] for r in rows]


@pytest.mark.usefixtures("svg_figures")
def test_page(dataset: Dataset, formulas: list[FittedFormula], tmp_path: Path) -> None:
    path = write_page(tmp_path / "fit.html", fit_sections(dataset, formulas, ["xu", "not_there"]))
    page, seen = path.read_text(encoding="utf-8"), read_page(path)
    rows = {html.unescape(row[0]): row for row in cells(page) if row}
    best = formulas[0]
    assert rows[best.family][2] == f"{best.validation.r2_log:.4f}"
    assert rows["failed"][1:] == [reason_text("film_jump"), "2"]
    assert rows["friction error above 100 %"][1] == "3"
    assert rows["data"][1] == dataset.data_hash
    assert rows["solver"][1] == "arana_2019"
    for published in PUBLISHED.values():
        assert published.label + published.mark in rows
    # the data were made with this formula
    assert all(abs(float(text)) < 1e-9 for text in rows["Arana 2019"][1:4])
    for term, value in best.coefficients.items():
        assert float(rows[term][1]) == pytest.approx(value, rel=1e-8)
    assert page.count("<svg") >= 7
    assert "nan" not in seen.text.lower()
    assert f"{100.0 * best.validation.mape:.1f} %" in seen.sections[0]


def test_interval_of_few_cases_is_a_factor_at_the_point() -> None:
    """Widths of networks are multiples of the deviation at a point; without bands there is no table."""
    fitted = Formula.load("75w90")
    few = fitted.model_copy(update={"interval": fitted.interval.model_copy(update={"bands": ()})})
    width = few.interval.log_width
    plain = ErrorInterval(level=0.9, log_width=0.1, largest=0.2)
    for interval, factor in ((few.interval, f"exp({width:.3g} s)"), (plain, f"{math.exp(0.1):.3g}")):
        formula = few.model_copy(update={"interval": interval})
        (section,) = formula_sections([formula], (), None, "terminal")
        assert factor in " ".join(part.text for part in section.items if isinstance(part, Text))
        assert not any("interval" in part.title for part in section.items if isinstance(part, Table))


@pytest.mark.usefixtures("svg_figures")
def test_smooth_contacts_at_one_pressure(tmp_path: Path) -> None:
    smooth = {**PLAN["variables"], "pressure_hertz": "1 GPa"}
    del smooth["roughness_rms"]
    dataset = swept(tmp_path / "run", {**PLAN, "sampling": {"size": 32}, "variables": smooth})
    write_page(tmp_path / "fit.html", fit_sections(dataset, [fit_formula(dataset, "power_law")]))
    assert (tmp_path / "fit.html").read_text("utf-8").count("<svg") < 7


def test_an_oil_named_by_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    card = Path("vg220.toml")
    Oil.generic("mineral", iso_vg=220, name="our VG 220").save(card)
    content = {**gear_plan("own", {"size": 32}), "lubricant": {"oil": str(card)}}
    dataset = swept(tmp_path / "run", content)
    formula = fit_formula(dataset, "power_law")
    middle = plots.middle_conditions(dataset, str(card))
    assert len(middle.near(*middle.held)[0]) == len(fitted_rows(dataset))
    # the formula knows its own oil, by whatever path it is read, and names any other
    assert formula.oil_note(Oil.load(str(card))) == ""
    copy = card.rename("moved.toml")
    assert formula.oil_note(Oil.load(str(copy))) == ""
    assert formula.oil_note(Oil.load("fva3"))


@pytest.mark.parametrize("name", ["folder/" * 8 + "oil.toml", "öl.toml", "a, b.toml"])
def test_a_name_that_rows_cannot_hold_is_refused(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).parent.mkdir(parents=True, exist_ok=True)
    Oil.load("fva3").save(name)
    plan = validate(Plan, {**gear_plan("own", {"size": 32}), "lubricant": {"oil": name}})
    with refuses("lubricant.oil"):
        run_meta(plan, "1")
