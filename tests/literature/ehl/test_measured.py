"""Shape of what was measured: order and ratios of oils, films of a ball on glass (benchmarks/measured.py --quick)."""

from __future__ import annotations

from pathlib import Path

import pytest
from measured import BALL_RADIUS, Row, hamrock_dowson_1977, main, markdown, measured, write

from ehl.fluid.lubricant import Lubricant


@pytest.fixture(scope="module")
def rows() -> dict[str, Row]:
    return {row.quantity: row for row in main(["--quick"])}


def test_oils_come_out_in_the_published_order(rows: dict[str, Row]) -> None:
    order = [row for name, row in rows.items() if name.endswith("at equal state")]
    assert len(order) == 4
    for row in order:
        assert row.computed_low > 0.9, row.quantity  # PAO and ester may be level


def test_synthetic_oils_are_well_below_mineral(rows: dict[str, Row]) -> None:
    ratios = [row.computed_low for name, row in rows.items() if name.endswith("roller thrust bearing")]
    assert len(ratios) == 3
    assert max(ratios) < 0.8


def test_film_on_glass_within_a_quarter(rows: dict[str, Row]) -> None:
    row = rows["central film, 40 degC"]
    assert abs(row.deviation) < 0.25


def test_friction_rises_with_slip_in_shape(rows: dict[str, Row]) -> None:
    row = rows["mu at 1 % over mu at 20 % slip, gear contact"]
    assert 0.2 < row.measured_low < 0.45
    # of a gear contact of a synthetic oil; the ball at 3.5 GPa is not reproduced, see the page
    assert 0.2 < row.computed_low < 0.45


def test_point_film_of_hamrock_and_dowson_by_hand() -> None:
    oil = Lubricant(viscosity_inlet=0.083, pressure_viscosity=20e-9, viscosity_law="barus")
    # as printed by the source of the measurements: 20 N, 0.1 m/s, steel on glass
    film = hamrock_dowson_1977(oil, 0.1, 20.0, BALL_RADIUS, 111.0e9)
    assert film == pytest.approx(93.9e-9, rel=0.02)


def test_every_measured_figure_names_source_licence_and_mark() -> None:
    for name in ("film_ball_on_disc", "bearing_oil_ratio", "superfinished_gears", "axle_efficiency"):
        entry = measured(name)
        assert entry["source"]
        assert entry["licence"]
        assert entry["mark"] in ("read", "abstract", "secondary", "memory")


def test_table_is_written_between_the_markers(rows: dict[str, Row], tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- measured: begin -->\nold\n<!-- measured: end -->\nafter\n")
    write(list(rows.values()), tmp_path, page)
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "old" not in text
    assert markdown(list(rows.values())) in text
    assert (tmp_path / "measured.csv").read_text().count("\n") == len(rows) + 1
