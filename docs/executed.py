"""Output below each cell of the tutorials, from a Jupyter kernel that runs the cells when the pages are built.

Cells are the `sh` or `python` blocks of `PAGES`. sphinx-gallery runs the examples of the gallery.
"""

from __future__ import annotations

import base64
import os
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

# page: the language of its cells
PAGES = {f"tutorials/{page}": "sh" for page in ("oil", "gear", "calibrate", "cluster", "better", "axle")}
PAGES |= {"tour": "python", "index": "python"}
_FIGURE = re.compile(r"--plot (\S+\.png)")
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")


def run_cells(cells: list[str], folder: Path) -> list[list[Any]]:
    """Outputs of each cell, run in one kernel with a working folder and lines of 80 characters."""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in cells])
    place = {"metadata": {"path": str(folder)}}
    client = NotebookClient(notebook, timeout=900, kernel_name="python3", resources=place, coalesce_streams=True)
    client.extra_arguments = ["--log-level=ERROR"]
    client.execute(env=os.environ | {"COLUMNS": "80"})
    return [cell.outputs for cell in notebook.cells]


def shown(outputs: list[Any], picture: str, folder: Path) -> str:
    """Outputs as Markdown: figures, written to `folder`, tables and texts without standard error."""
    parts = []
    for number, output in enumerate(outputs):
        data = output.get("data", {})
        if "image/png" in data:
            name = f"{picture}_{number}.png"
            (folder / name).write_bytes(base64.b64decode(data["image/png"]))
            parts.append(f"![Figure of the cell](/{folder.name}/{name})")
        elif "text/html" in data:
            parts.append("```{raw} html\n" + data["text/html"] + "\n```")
        elif text := data.get("text/plain") or (output.get("name") == "stdout" and output["text"]):
            parts.append("```{code-block} none\n:class: output\n\n" + _COLOUR.sub("", text).rstrip() + "\n```")
    return "\n\n".join(parts)


def with_outputs(page: str, text: str, folder: Path, pictures: Path) -> str:
    """The text of a page with the output of each cell below it, and the figure that a command writes."""
    language = PAGES[page]
    pieces = re.split(rf"^```{language}\n(.*?)^```\n", text, flags=re.S | re.M)
    cells = []
    for code in pieces[1::2]:
        cells.append(code if language == "python" else f"%%sh\n{code}")
        figure = _FIGURE.search(code)
        cells.append(f"from IPython.display import Image\nImage({figure[1]!r})" if figure else "")
    outputs = run_cells(cells, folder)
    for number, code in enumerate(pieces[1::2]):
        found = shown(outputs[2 * number] + outputs[2 * number + 1], f"{page.replace('/', '_')}_{number}", pictures)
        pieces[2 * number + 1] = f"```{language}\n{code}```\n\n{found}\n"
    return "".join(pieces)


def _read(app: Any, page: str, source: list[str]) -> None:
    """Run the cells of a page as it is read, unless the build leaves out the gallery."""
    if page not in PAGES or str(app.config.plot_gallery) in ("0", "False"):
        return
    docs = Path(app.srcdir)
    pictures = docs / "outputs"
    pictures.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in ("docs", "data"):
            (Path(folder) / name).symlink_to(docs.parent / name)
        for name in ("calibration.toml", "synthetic_traction.csv"):
            shutil.copy(docs / "examples" / name, folder)
        source[0] = with_outputs(page, source[0], Path(folder), pictures)


def setup(app: Any) -> dict[str, bool]:
    """Connect to the reading of pages."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": False}
