"""`mixed-ehl oil` and what a card shows in a notebook."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from refusals import refuses
from samples import CONTACT

import ehl
from ehl.common.data import data_names, data_path
from ehl.common.units import KELVIN
from ehl.fluid.oil_sheet import source_points

Cli = Callable[..., Any]


def test_points_of_every_source_are_met_by_the_card() -> None:
    """Points computed from the printed constants, not by the card: 1 % in eta at every pressure and temperature."""
    cards = {row.split(",")[0] for row in data_path("reference", "oil_points.csv").read_text().splitlines()[4:]}
    assert cards <= set(data_names("oils"))
    assert len(cards) > 20
    for card in cards:
        oil = ehl.Oil.load(card)
        for temperature, pressure, viscosity in source_points(card):
            found = float(oil.at(temperature).viscosity(np.array(pressure)))
            assert found == pytest.approx(viscosity, rel=0.01), (card, temperature - KELVIN, pressure)


def test_a_card_in_a_notebook() -> None:
    """With the four coefficients of `test_four_coefficients_of_published_laws`."""
    oil = ehl.Oil.load("fva3")
    frame = oil.to_frame("40, 80, 100 degC")
    assert list(frame["temperature_oil"]) == [313.15, 353.15, 373.15]
    assert frame["viscosity_inlet"].is_monotonic_decreasing
    alphas = 1e9 * frame[[f"pressure_viscosity_{name}" for name in ("slope", "secant_200", "star", "film")]].to_numpy()
    np.testing.assert_allclose(alphas[[0, 2]], [[22.4, 20.8, 21.6, 21.8], [16.0, 14.4, 14.8, 15.1]], rtol=0.01)
    axes = oil.plot(Figure().add_subplot())
    np.testing.assert_allclose(axes.lines[0].get_ydata()[0], 1e3 * oil.at(313.15).viscosity_inlet)


@pytest.mark.parametrize("name", ["75w90", "squalane", "pao 97.5/13.3"])
def test_a_saved_card_is_the_same_oil(name: str, tmp_path: Path) -> None:
    oil = ehl.Oil.load(name)
    oil.save(tmp_path / "mine.toml")
    again = ehl.Oil.load(str(tmp_path / "mine.toml"))
    assert again == oil
    with refuses("path"):
        oil.save(tmp_path / "mine.txt")


def test_command_prints_a_card_its_figure_and_the_list(mixed_ehl: Cli, tmp_path: Path) -> None:
    assert mixed_ehl("oil", "75w90", "-T", "40, 100 degC", "--plot", tmp_path / "oil.png").code == 0
    assert (tmp_path / "oil.png").is_file()
    content = json.loads(mixed_ehl("oil", "fva3", "--json").out)
    assert content["states"][1]["pressure_viscosity_slope"] == pytest.approx(16.0e-9, rel=0.01)
    listed = json.loads(mixed_ehl("oil", "--json").out)["oils"]
    assert {row["oil"] for row in listed} == set(data_names("oils"))


def test_command_writes_a_generic_card_that_solves(mixed_ehl: Cli, tmp_path: Path) -> None:
    card = tmp_path / "my_oil.toml"
    outcome = mixed_ehl("oil", "--base", "ester", "--nu40", "97 cSt", "--nu100", "14 cSt", "-o", card)
    assert outcome.code == 0
    oil = ehl.Oil.load(str(card))
    assert (oil.name, oil.base) == ("my_oil", "ester")
    contact = {**CONTACT, "temperature_oil": "90 degC", "thermal": "off"}
    by_file, by_name = (ehl.Contact(oil=name, **contact).solve() for name in (str(card), "ester 97/14"))
    assert by_file.status == "converged"
    assert by_file.friction_coefficient == pytest.approx(by_name.friction_coefficient, rel=1e-9)


def test_a_card_must_thin_with_temperature(tmp_path: Path) -> None:
    text = data_path("oils", "minr.toml").read_text(encoding="utf-8")
    path = tmp_path / "bad.toml"
    for change in (("22.2 cSt", "320 cSt"), ("22.2 cSt", "0.3 cSt"), ('"mineral"', '"olive"')):
        path.write_text(text.replace(*change), encoding="utf-8")
        with pytest.raises(ehl.InputError):
            ehl.Oil.load(str(path))
