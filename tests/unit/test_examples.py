"""The gallery of examples runs, with the number each one ends with."""

import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

ROOT = Path(__file__).resolve().parents[2]
ANSWERS = {
    "plot_axle": 1226.23, "plot_blank": 39 / 14, "plot_constant_friction": 1.29340, "plot_contact_pattern": 12.2771,
    "plot_efficiency_map": 99.2343, "plot_film_and_pressure": 302.987, "plot_formula": 0.0482211,
    "plot_gear_efficiency": 99.2343, "plot_misalignment": 99.2819, "plot_oil_under_pressure": 11.2358,
    "plot_paper_contact": 0.0410145, "plot_paper_formula": 0.362957, "plot_paper_pair": 99.3403,
    "plot_rough_contact": 180.925, "plot_stribeck_curve": 1.84344,
}  # fmt: skip


def test_every_example_has_a_number() -> None:
    assert {path.stem for path in (ROOT / "examples").glob("*.py")} == set(ANSWERS)


@pytest.mark.parametrize("name", ANSWERS)
def test_example_gives_its_number(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = runpy.run_path(str(ROOT / "examples" / f"{name}.py"))
    assert plt.get_fignums()
    assert capsys.readouterr().out
    assert outcome["answer"] == pytest.approx(ANSWERS[name], rel=2e-3)
