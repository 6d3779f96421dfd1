"""Objects in a notebook show tables and figures; tutorials show output below cells."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytest.importorskip("nbclient")
sys.path.insert(0, str(ROOT / "docs"))
from executed import PAGES, with_outputs  # noqa: E402


def test_output_and_figure_stand_below_each_cell(tmp_path: Path) -> None:
    figure = "from matplotlib.pyplot import plot; plot([0])[0].figure.savefig('a.png')"
    text = f"Head\n\n```sh\necho one\npython -c {figure!r} --plot a.png\n```\n\n```sh\necho two\n```\nEnd\n"
    shown = with_outputs("tutorials/oil", text, tmp_path, tmp_path)
    places = [shown.index(part) for part in ("echo one", "\none\n", "![Figure", "echo two", "\ntwo\n", "End")]
    assert places == sorted(places)
    assert len(list(tmp_path.glob("tutorials_oil_*.png"))) == 1
    assert all((ROOT / "docs" / f"{page}.md").exists() for page in PAGES)


def test_figures_of_later_cells_are_shown_and_objects_are_tables() -> None:
    import nbformat
    from nbclient import NotebookClient

    cells = [
        "import efficiency\npair = efficiency.load('fm_spiral_bevel_14x39')\npair", "mesh = pair.mesh()\nmesh",
        "loaded = mesh.load('200 N m')\nloaded", "efficiency.load('fzg_c14')", "axes = pair.plot_contact()",
        "pair.plot_contact()", "result = loaded.efficiency('constant:0.05')\nresult.plot()", "result.citation()",
    ]  # fmt: skip
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    NotebookClient(notebook, timeout=300).execute()
    shown = [[output.get("data", {}) for output in cell.outputs] for cell in notebook.cells]
    assert all(any("<table" in data.get("text/html", "") for data in cell) for cell in shown[:4])
    assert all(any("image/png" in data for data in cell) for cell in shown[4:7])
    assert any(data.get("text/plain", "").startswith("[1] ") for data in shown[7])
