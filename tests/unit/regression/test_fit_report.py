"""Report of a fit: its tables say what the formula file says, every axis has a name and a unit, nothing is left out."""

import html
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pages import read_page
from small_plans import gear_plan, swept

from ehl.common.data import reason_text
from ehl.common.errors import InputError
from ehl.common.pages import write_page
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from regression.data.dataset import Dataset
from regression.fitting.fit import fit_formula
from regression.fitting.rows import fitted_rows
from regression.friction.fitted import FittedFormula
from regression.friction.published_registry import PUBLISHED
from regression.plan.plan import Plan
from regression.sweeping.sweep import run_meta
from regression.view import plots
from regression.view.fit_report import fit_sections

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
    rows = {row[0]: row for row in cells(page) if row}
    best = formulas[0]
    assert rows[best.family][2] == f"{best.validation.r2_log:.4f}"
    assert rows["failed"][1:] == [reason_text("film_jump"), "2"]
    assert rows["friction error above 100 %"][1] == "3"
    assert rows["data"][1] == dataset.data_hash
    assert rows["solver"][1] == "arana_2019"
    for published in PUBLISHED.values():
        assert html.escape(published.label + published.mark) in rows
    # the data were made with this formula
    assert all(abs(float(text)) < 1e-9 for text in rows["Arana 2019"][1:4])
    for term, value in best.coefficients.items():
        assert float(rows[term][1]) == pytest.approx(value, rel=1e-8)
    assert page.count("<svg") >= 7
    assert "nan" not in seen.text.lower()
    assert f"{100.0 * best.validation.mape:.1f} %" in seen.sections[0]


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
    with pytest.raises(InputError, match="at most 48 letters"):
        run_meta(plan, "1")
