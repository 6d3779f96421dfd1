"""The gallery as a notebook: a kernel runs each example and shows its picture; tutorials show output below cells."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
pytest.importorskip("nbclient")
sys.path.insert(0, str(ROOT / "docs"))
from executed import PAGES, run_cells, with_outputs  # noqa: E402


def test_each_example_shows_a_picture_in_a_notebook(tmp_path: Path) -> None:
    outputs = run_cells([path.read_text(encoding="utf-8") for path in EXAMPLES], tmp_path)
    without = [
        path.stem
        for path, shown in zip(EXAMPLES, outputs, strict=True)
        if not any("image/png" in output.get("data", {}) for output in shown)
    ]
    assert without == []
    assert all(any(output.get("name") == "stdout" for output in shown) for shown in outputs)


def test_output_and_figure_stand_below_each_cell(tmp_path: Path) -> None:
    figure = "from matplotlib.pyplot import plot; plot([0])[0].figure.savefig('a.png')"
    text = f"Head\n\n```sh\necho one\npython -c {figure!r} --plot a.png\n```\n\n```sh\necho two\n```\nEnd\n"
    shown = with_outputs("tutorials/oil", text, tmp_path, tmp_path)
    places = [shown.index(part) for part in ("echo one", "\none\n", "![Figure", "echo two", "\ntwo\n", "End")]
    assert places == sorted(places)
    assert len(list(tmp_path.glob("tutorials_oil_*.png"))) == 1
    assert all((ROOT / "docs" / f"{page}.md").exists() for page in PAGES)
