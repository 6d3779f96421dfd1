"""From a change in the page of `mixed-ehl app` to its answer, in a real browser; and the pictures of docs/app.md.

``python validation/app_response.py [--out FOLDER] [--count 12]`` starts the program and a Chromium, changes speed,
finish, torque and alignment in turns and prints the median and the largest time until efficiency or loss have changed,
next to the processor time of the same answer in Python (answer, both pictures of the tooth, notes). With --out the
pictures are written. An idle machine is needed.
"""

from __future__ import annotations

import os
import shutil
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from common import command_line

from efficiency.app.page import _drawn
from efficiency.app.scene import Bench, changed
from ehl.common.table import Table

PORT = 8659
# headline and details of the page; changes are so large that their rounded numbers differ
_ANSWER = "['.text-3xl', '.details'].map(part => document.querySelector(part).innerText).join()"
# label of the field in the page, field of the scene, two values to go between
CHANGES = (
    ("pinion speed", "speed", "2000", "4000"),
    ("Rq gear", "roughness_rms_gear", "0.3", "0.8"),
    ("pinion torque", "torque", "{}", "{}"),
    ("E offset", "E", "{}", "{}"),
)


def main(argv: Sequence[str] | None = None) -> int:
    """Measure, print, draw."""
    from playwright.sync_api import sync_playwright

    parser = command_line(__doc__)
    parser.add_argument("--out", type=Path, help="folder of the pictures")
    parser.add_argument("--count", type=int, default=12)
    options = parser.parse_args(argv)
    command = [sys.executable, "-c", "from efficiency.cli import main; main()", "app", "--no-browser"]
    server = subprocess.Popen([*command, "--port", str(PORT)], stderr=subprocess.PIPE, env=dict(os.environ), text=True)
    assert server.stderr is not None
    address = next(line for line in server.stderr if line.startswith("http://")).split()[0]
    while True:
        with socket.socket() as trial:
            if trial.connect_ex(("127.0.0.1", PORT)) == 0:
                break
        time.sleep(0.1)
    bench, rows = Bench(), []
    scene = bench.start()
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 1250})
        page.goto(address)
        page.wait_for_function("document.querySelector('.text-3xl').innerText.includes('%')", timeout=120_000)
        for number, (label, name, *pair) in enumerate(CHANGES):
            seen, alone = [], []
            for k in range(options.count):
                # torques and alignments that were not used before; the others alternate
                value = {"torque": f"{120 + 30 * k}", "E": f"{0.05 * (k + 1):.2f}"}.get(name, pair[k % 2])
                time.sleep(1.5)
                before = page.evaluate(_ANSWER)
                clock = time.perf_counter()
                page.get_by_label(label).fill(value)
                page.wait_for_function(f"was => {_ANSWER} != was", arg=before)
                seen.append(time.perf_counter() - clock)
                clock = time.process_time()
                scene = changed(scene, **{name: value})
                _drawn(bench.answer(scene))
                alone.append(time.process_time() - clock)
            rows.append((label, statistics.median(seen), max(seen), min(alone)))
            if options.out and number == 0:
                page.get_by_role("button", name="Efficiency map").click()
                page.get_by_role("button", name="Film and pressure").click()
                page.wait_for_function("document.body.innerText.includes('central film')", timeout=120_000)
                time.sleep(3.0)
                page.evaluate("window.scrollTo(0, 0)")
                page.screenshot(path=options.out / "app.png")
        if options.out:
            phone = browser.new_page(viewport={"width": 390, "height": 1100}, color_scheme="dark")
            phone.goto(address)
            phone.wait_for_function("document.querySelector('.text-3xl').innerText.includes('%')", timeout=120_000)
            time.sleep(3.0)
            phone.screenshot(path=options.out / "app_phone.png")
        browser.close()
    server.terminate()
    Table(("change", "in the browser, median [s]", "largest [s]", "processor time in Python, least [s]"), rows).print()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
