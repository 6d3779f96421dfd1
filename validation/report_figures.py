"""Pictures of pages and of the comparison of friction models, as the documentation shows them.

``comparison`` and ``gear``: docs/reports.md; their PNG files contain the numbers that they show, for the test of these.
``optimise``: the search of docs/optimise.md, 160 points of the page's command; evaluations are kept in the folder of
results, and a stopped search resumes.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from common import OUT, command_line
from PIL import Image, PngImagePlugin

import efficiency

PAIR, TORQUE, SEARCHED = "fm_spiral_bevel_14x39_relieved", 200.0, "fm_hypoid_13x42_relieved"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
MODELS = ("75w90", "ehl", "constant:0.05", "xu_kahraman_2007")


def screenshot(page: Path, picture: Path, width: int = 1240, height: int = 900) -> None:
    """The first screen of a page, by a browser that is installed."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise SystemExit(f"no browser to draw {picture.name} with: one of {', '.join(BROWSERS)}")
    flags = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars")
    with tempfile.TemporaryDirectory() as profile:
        command = [browser, *flags, f"--user-data-dir={profile}", f"--window-size={width},{height}"]
        command += [f"--screenshot={picture.resolve()}", page.resolve().as_uri()]
        subprocess.run(command, check=True, capture_output=True, timeout=120)


def mark(picture: Path, numbers: dict[str, Any]) -> None:
    """Write numbers that a picture shows into its PNG file."""
    text = PngImagePlugin.PngInfo()
    text.add_text("Description", json.dumps(numbers))
    with Image.open(picture) as image:
        image.load()
        image.save(picture, pnginfo=text, optimize=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw one of them."""
    parser = command_line(__doc__)
    parser.add_argument("what", choices=("gear", "comparison", "optimise"))
    parser.add_argument("--out", type=Path, default=Path("docs/figures"))
    given = parser.parse_args(arguments)
    if given.what == "comparison":
        compared = efficiency.load(PAIR).compare(MODELS, torque=TORQUE)
        compared.write(plot=given.out / "comparison.png")
        mark(given.out / "comparison.png", {row.name: row.efficiency for row in compared.rows})
    elif given.what == "gear":
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "gear.html"
            result = efficiency.load(PAIR).at("75w90", torque=TORQUE)
            result.report(page)
            screenshot(page, given.out / "report_gear.png")
        shown = ("efficiency", "efficiency_error", "power_loss", "friction_coefficient_mean", "pressure_hertz_max")
        mark(given.out / "report_gear.png", {name: getattr(result, name) for name in shown})
    else:
        folder = OUT / "optimise"
        store = folder / "points.jsonl"
        found = efficiency.optimise(SEARCHED, ("ease_off", "blank"), evaluations=160, jobs=2, store=store)
        found.write(folder=folder)
        screenshot(folder / "optimise.html", given.out / "optimise_report.png")
        shutil.copy(folder / "trade.png", given.out / "optimise_trade.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
