"""Pictures of pages and of the comparison of friction models, as the documentation shows them."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from common import command_line

import efficiency

PAIR = "fm_spiral_bevel_14x39"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
MODELS = ("75w90", "ehl", "constant:0.05", "xu_kahraman_2007")


def screenshot(page: Path, picture: Path, width: int = 1240, height: int = 900) -> None:
    """The first screen of a page, by a browser that is installed."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise SystemExit(f"no browser to draw {picture.name} with: one of {', '.join(BROWSERS)}")
    with tempfile.TemporaryDirectory() as profile:
        command = [
            browser,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            f"--user-data-dir={profile}",
        ]
        command += [f"--window-size={width},{height}", f"--screenshot={picture.resolve()}", page.resolve().as_uri()]
        subprocess.run(command, check=True, capture_output=True, timeout=120)


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw what is asked for."""
    parser = command_line(__doc__)
    parser.add_argument("what", choices=("gear", "comparison"))
    parser.add_argument("--out", type=Path, default=Path("docs/figures"))
    given = parser.parse_args(arguments)
    pair = efficiency.load(PAIR)
    if given.what == "comparison":
        pair.compare(MODELS).plot("comparison").savefig(given.out / "comparison.png", dpi=150)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "gear.html"
        pair.at("75w90").report(page)
        screenshot(page, given.out / "report_gear.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
