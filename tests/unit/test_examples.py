"""Examples run: the gallery with the number each one ends with, cells of notebooks, tables of "Your files"."""

import re
import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from efficiency.conditions.duty import read_duty
from efficiency.cutting.summary import parse_summary
from efficiency.vehicle.loss_map import read_axle_losses
from regression.calibration.measurement import read_measurement

ROOT = Path(__file__).resolve().parents[2]
ANSWERS = {
    "plot_axle": 1226.23, "plot_blank": 39 / 14, "plot_constant_friction": 1.32390, "plot_contact_pattern": 12.2771,
    "plot_efficiency_map": 99.2953, "plot_film_and_pressure": 304.096, "plot_formula": 0.0456992,
    "plot_gear_efficiency": 99.2953, "plot_misalignment": 99.2299, "plot_oil_under_pressure": 11.2358,
    "plot_paper_contact": 0.0410145, "plot_paper_formula": 0.369669, "plot_paper_pair": 99.3403,
    "plot_rough_contact": 180.925, "plot_stribeck_curve": 1.89164,
}  # fmt: skip


def test_every_example_has_a_number() -> None:
    assert {path.stem for path in (ROOT / "examples").glob("*.py")} == set(ANSWERS)


@pytest.mark.parametrize("name", ANSWERS)
def test_example_gives_its_number(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = runpy.run_path(str(ROOT / "examples" / f"{name}.py"))
    assert plt.get_fignums()
    assert capsys.readouterr().out
    assert outcome["answer"] == pytest.approx(ANSWERS[name], rel=2e-3)


def test_output_and_figure_stand_below_each_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "docs")
    from executed import PAGES, with_outputs

    figure = "from matplotlib.pyplot import plot; plot([0])[0].figure.savefig('a.png')"
    text = f"Head\n\n```sh\necho one\npython -c {figure!r} --plot a.png\n```\n\n```sh\necho two\n```\nEnd\n"
    shown = with_outputs("tutorials/oil", text, tmp_path, tmp_path)
    places = [shown.index(part) for part in ("echo one", "\none\n", "![Figure", "echo two", "\ntwo\n", "End")]
    assert places == sorted(places)
    assert len(list(tmp_path.glob("tutorials_oil_*.png"))) == 1
    assert all((ROOT / "docs" / f"{page}.md").exists() for page in PAGES)


def test_figures_of_later_cells_are_shown_and_objects_are_tables() -> None:
    nbformat, client = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")

    cells = [
        "import efficiency\npair = efficiency.load('fm_spiral_bevel_14x39')\npair", "mesh = pair.mesh()\nmesh",
        "loaded = mesh.load('200 N m')\nloaded", "efficiency.load('fzg_c14')", "axes = pair.plot_contact()",
        "pair.plot_contact()", "result = loaded.efficiency('constant:0.05')\nresult.plot()", "result.citation()",
    ]  # fmt: skip
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    client.NotebookClient(notebook, timeout=300).execute()
    shown = [[output.get("data", {}) for output in cell.outputs] for cell in notebook.cells]
    assert all(any("<table" in data.get("text/html", "") for data in cell) for cell in shown[:4])
    assert all(any("image/png" in data for data in cell) for cell in shown[4:7])
    assert any(data.get("text/plain", "").startswith("[1] ") for data in shown[7])


# the examples of the page "Your files" are read as described there
PAGE = (ROOT / "docs" / "your_files.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```text\n(.*?)```", PAGE, flags=re.S)


def example(start: str, folder: Path, encoding: str = "utf-8") -> Path:
    """File of the example that begins so."""
    path = folder / "example.csv"
    path.write_bytes(next(text for text in EXAMPLES if text.startswith(start)).encode(encoding))
    return path


def test_examples_of_tables(tmp_path: Path) -> None:
    rig = read_measurement(example("MTM", tmp_path, "latin-1"), {"radius_equivalent": 0.0095})
    assert rig.friction == pytest.approx([0.0107])
    assert rig.columns["slide_to_roll"] == pytest.approx([0.01])
    first, second = read_duty(example("time", tmp_path, "utf-16"), tyre_radius=0.32, ratio=39 / 14)
    assert first.torque == pytest.approx(1114.3 * 14 / 39)
    assert second.speed == pytest.approx(37.5 / 3.6 / 0.32 * 39 / 14)
    assert read_axle_losses(example("Input Speed", tmp_path)).loss.tolist() == [[1.5], [2.5]]


def test_example_of_a_setting_sheet() -> None:
    found = parse_summary(next(text for text in EXAMPLES if text.startswith("units")), {"gear": "left"})
    machine = found.tables["gear"]["machine"]
    assert machine == {"process": "formate", "radial_setting": "116.573 mm", "cradle_angle": "-60.465 deg"}
    assert len(found.left_out) == 1
