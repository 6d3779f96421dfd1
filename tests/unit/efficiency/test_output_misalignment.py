"""Misalignment study on the command line, as table, CSV and figures."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import efficiency
from efficiency.contact.flank_pair import flank_pair
from efficiency.design.design import Design
from efficiency.geometry.misalignment import MisalignmentGrid, MisalignmentStudy, misalignment_study
from efficiency.output.misalignment_report import (
    map_figure,
    misalignment_table,
    section_contacts,
    section_figure,
    section_points,
)

PAIR = "fm_spiral_bevel_14x39"
Cli = Callable[..., Any]


@pytest.fixture(scope="module")
def study(design: Design) -> MisalignmentStudy:
    return misalignment_study(design, E=(-1e-4, 0.0, 1e-4), shaft_angle_error=(0.0, 5e-4))


def test_rows_show_what_varies(study: MisalignmentStudy) -> None:
    assert study.varied == ["E", "shaft_angle_error"]
    table = misalignment_table(study)
    rows = table.records()
    assert len(rows) == 6
    assert (rows[0]["E"], rows[0]["shaft_angle_error"]) == (-1e-4, 0.0)
    assert [row["peak_to_peak"] for row in rows] == [point.peak_to_peak for point in study.points]
    assert "shaft_angle_error [arcmin]" in table.html()
    assert f">{np.degrees(5e-4) * 60.0:.3f}<" in table.html()


def test_csv_holds_the_study(design: Design, study: MisalignmentStudy, tmp_path: Path) -> None:
    table = pd.read_csv(MisalignmentGrid(design, (study,)).report(tmp_path / "study.csv"))
    assert set(table["side"]) == {"drive"}
    np.testing.assert_allclose(table["peak_to_peak [rad]"], [point.peak_to_peak for point in study.points], rtol=1e-12)
    np.testing.assert_allclose(table["E [m]"], [point.E for point in study.points], rtol=1e-15)


def test_sections_pass_through_the_aligned_pair(study: MisalignmentStudy) -> None:
    values, points = section_points(study, "E")
    np.testing.assert_allclose(values, [-0.1, 0.0, 0.1], atol=1e-12)
    assert all(point.shaft_angle_error == 0.0 for point in points)
    assert [point.shaft_angle_error for point in section_points(study, "shaft_angle_error")[1]] == [0.0, 5e-4]


def test_figures_show_the_points(study: MisalignmentStudy, design: Design) -> None:
    figure = section_figure([study])
    line = figure.axes[0].get_lines()[0]
    expected = np.degrees([point.peak_to_peak for point in section_points(study, "E")[1]]) * 3600.0
    np.testing.assert_allclose(np.asarray(line.get_ydata(), dtype=float), expected)
    maps = map_figure(study)
    shown = np.asarray(maps.axes[0].collections[0].get_array()).reshape(2, 3)
    assert shown[0, 1] == pytest.approx(np.degrees(study.points[2].peak_to_peak) * 3600.0)


def test_patterns_of_a_section_are_those_of_the_study(study: MisalignmentStudy, design: Design) -> None:
    contacts = section_contacts(design, study, "E")
    assert [value for value, _, _ in contacts] == [-1e-4, 0.0, 1e-4]
    for (_, _, pattern), point in zip(contacts, section_points(study, "E")[1], strict=True):
        assert pattern.area_share == pytest.approx(point.pattern_area, rel=1e-9)
    aligned = flank_pair(design.flanks()).pattern(study.marking)
    # counted on samples of maps that differ a little in extent
    assert contacts[1][2].area_share == pytest.approx(aligned.area_share, abs=2e-3)


def test_study_on_the_command_line(mixed_ehl: Cli) -> None:
    outcome = mixed_ehl("misalignment", PAIR, "--G", "-0.05:0.05:3 mm", "--side", "coast", "--json")
    assert outcome.code == 0
    (study,) = json.loads(outcome.out)["studies"]
    assert study["side"] == "coast"
    assert study["G"] == pytest.approx([-5e-5, 0.0, 5e-5], abs=1e-18)
    assert len(study["points"]) == 3
    table = mixed_ehl("misalignment", PAIR, "--G", "0, 0.05 mm")
    for words in ("TE peak to peak", "[arcsec]", "2 states", "0.05000"):  # heads fold on narrow terminals
        assert words in table.out


def test_states_at_a_torque_are_those_of_the_loaded_pair(mixed_ehl: Cli, tmp_path: Path) -> None:
    """The V-H check under load: same numbers as the pair set up in that state, next to the unloaded ones."""
    options = ("--torque", "300 N m", "--friction", "constant:0.05", "--speed", "1500 rpm")
    outcome = mixed_ehl("misalignment", PAIR, "--E", "-0.1, 0.1 mm", *options, "--json", "--plot", tmp_path)
    assert outcome.code == 0
    (found,) = json.loads(outcome.out)["studies"]
    assert found["torque"] == 300.0
    pair = efficiency.load(PAIR)
    for point in found["points"]:
        result = pair.mesh("drive", E=point["E"]).load("300 N m").efficiency("constant:0.05", speed="1500 rpm")
        for name in ("efficiency", "pressure_hertz_max", "edge_load_share", "transmission_error_loaded", "power_loss"):
            assert point[name] == pytest.approx(result.value(name), rel=1e-9)
        assert 0.3 < point["transmission_error_loaded"] / point["peak_to_peak"] < 1.0
    # the offset moves the load along the face
    assert found["points"][0]["load_centre_u"] - found["points"][1]["load_centre_u"] > 1e-3
    assert (tmp_path / "misalignment_loaded.png").stat().st_size > 10_000
    table = mixed_ehl("misalignment", PAIR, "--E", "0.1 mm", *options).out
    assert "edges carry up to 12 %" in table


def test_conditions_without_a_torque_are_refused(mixed_ehl: Cli) -> None:
    outcome = mixed_ehl("misalignment", PAIR, "--E", "0.1 mm", "--speed", "1000 rpm")
    assert outcome.code == 2
    assert "no value without a torque" in outcome.err
    assert mixed_ehl("misalignment", PAIR, "--E", "0.1 mm", "--torque", "-5 N m").code == 2
