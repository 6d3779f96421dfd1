from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from ehl.io.errors import InputError
from ehl.view.html_report import Formula, KeyFigures, Picture, Pictures, Section, Text, number, write_report
from ehl.view.table import Table


def test_page_holds_everything_and_escapes(tmp_path: Path) -> None:
    figure = Figure()
    figure.add_subplot().plot([0, 1], [0, 1])
    picture = Picture(figure, "a line")
    page = write_report(
        tmp_path / "sub" / "page.html",
        "Title & more",
        "subtitle",
        [
            Section("One", [Text("a < b"), Formula("mu = 0.05"), KeyFigures([("99 %", "efficiency")])]),
            Section(
                "Two",
                [Table(["name", "value"], [["x", "1"], ["y", "2"]], "cap", highlight=1), picture, Pictures([picture])],
            ),
        ],
        "footer",
    ).read_text(encoding="utf-8")
    for part in ("Title &amp; more", "a &lt; b", "mu = 0.05", "99 %", "cap", 'class="highlight"', "a line", "footer"):
        assert part in page
    assert page.count("<svg") == 2
    assert "http://" not in page.replace("http://www.w3.org", "").replace("http://purl.org", "").replace(
        "http://creativecommons.org", ""
    )


def test_unwritable_page(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="writable"):
        write_report(tmp_path / "file" / "page.html", "", "", [])


def test_number() -> None:
    assert (number(0.0123456), number(float("nan"))) == ("0.01235", "–")
