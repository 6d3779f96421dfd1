"""`mixed-ehl oil` and what a card shows in a notebook."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from refusals import refuses

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


@pytest.mark.parametrize(
    ("card", "celsius", "alphas"),
    [
        # slope, secant at 0.2 GPa, alpha*, alpha_film [1/GPa] as gathered for the literature review of oils
        ("pao100", 40.0, (15.4, 14.0, 14.3, 14.6)),
        ("pao100", 100.0, (11.3, 10.2, 10.2, 10.5)),
        ("m100", 100.0, (16.3, 14.6, 15.1, 15.4)),
        ("fva3", 40.0, (22.4, 20.8, 21.6, 21.8)),
        ("fva3", 100.0, (16.0, 14.4, 14.8, 15.1)),
        ("80w90", 40.0, (25.5, 20.7, 22.7, 23.2)),
        ("80w90", 100.0, (17.9, 14.1, 15.1, 15.6)),
        ("t9", 100.0, (15.1, 13.0, 13.4, 13.7)),
        ("squalane", 40.0, (22.0, 16.0, 17.8, 18.6)),
    ],
)
def test_four_alphas_of_a_card(card: str, celsius: float, alphas: tuple[float, ...]) -> None:
    """Within 1 %: the table is printed to three digits."""
    row = ehl.Oil.load(card).to_frame([celsius + KELVIN]).iloc[0]
    for name, value in zip(("slope", "secant_200", "star", "film"), alphas, strict=True):
        assert 1e9 * row[f"pressure_viscosity_{name}"] == pytest.approx(value, rel=0.01)


def test_a_card_in_a_notebook(tmp_path: Path) -> None:
    oil = ehl.Oil.load("fva3")
    assert "<table" in oil._repr_html_()
    frame = oil.to_frame("40, 80, 100 degC")
    assert list(frame["temperature_oil"]) == [313.15, 353.15, 373.15]
    assert frame["viscosity_inlet"].is_monotonic_decreasing
    axes = oil.plot(Figure().add_subplot())
    assert len(axes.lines) == 2 * 2 + 2  # curve and points at two temperatures, key of the points, end of measurement
    np.testing.assert_allclose(axes.lines[0].get_ydata()[0], 1e3 * oil.at(313.15).viscosity_inlet)


@pytest.mark.parametrize("name", ["75w90", "80w90", "squalane", "pao 97.5/13.3"])
def test_a_saved_card_is_the_same_oil(name: str, tmp_path: Path) -> None:
    oil = ehl.Oil.load(name)
    oil.save(tmp_path / "mine.toml")
    again = ehl.Oil.load(str(tmp_path / "mine.toml"))
    assert again == oil
    with refuses("path"):
        oil.save(tmp_path / "mine.txt")


def test_command_prints_a_card(mixed_ehl: Cli, tmp_path: Path) -> None:
    outcome = mixed_ehl("oil", "75w90", "-T", "40, 100 degC", "--plot", tmp_path / "oil.png")
    assert outcome.code == 0
    for words in (
        "alpha, secant at 0.2 GPa",
        "10.83",
        "ln(eta/eta0)",
        "6.683",
        "pressure_viscosity",
        "10 %",
        "FVA 400",
    ):
        assert words in outcome.out
    assert (tmp_path / "oil.png").is_file()


def test_command_prints_json_and_the_list(mixed_ehl: Cli) -> None:
    content = json.loads(mixed_ehl("oil", "fva3", "--json").out)
    assert content["states"][1]["pressure_viscosity_slope"] == pytest.approx(16.0e-9, rel=0.01)
    assert content["uncertainty"]["pressure_viscosity"] == 0.08
    listed = json.loads(mixed_ehl("oil", "--json").out)["oils"]
    assert {row["oil"] for row in listed} == set(data_names("oils"))


def test_command_writes_a_generic_card_that_solves(mixed_ehl: Cli, tmp_path: Path) -> None:
    card = tmp_path / "my_oil.toml"
    outcome = mixed_ehl("oil", "--base", "ester", "--nu40", "97 cSt", "--nu100", "14 cSt", "-o", card)
    assert outcome.code == 0
    oil = ehl.Oil.load(str(card))
    assert (oil.name, oil.base) == ("my_oil", "ester")
    state = {"temperature_oil": "90 degC", "pressure_hertz": "1 GPa", "radius_equivalent": "15 mm"}
    state |= {"speed_entrainment": "5 m/s", "slide_to_roll": 0.1, "thermal": "off"}
    by_file, by_name = (ehl.Contact(oil=name, **state).solve() for name in (str(card), "ester 97/14"))
    assert by_file.status == "converged"
    assert by_file.friction_coefficient == pytest.approx(by_name.friction_coefficient, rel=1e-9)


@pytest.mark.parametrize(
    "arguments",
    [("no_such_oil",), ("--base", "pao"), ("--vg", "100"), ("75w90", "-T", "40"), ("75w90", "-T", "900 degC")],
)
def test_bad_input_of_the_command(mixed_ehl: Cli, arguments: tuple[str, ...]) -> None:
    assert mixed_ehl("oil", *arguments).code == 2


def test_a_card_must_thin_with_temperature(tmp_path: Path) -> None:
    text = data_path("oils", "minr.toml").read_text(encoding="utf-8")
    for change, words in (
        (("22.2 cSt", "320 cSt"), "exchanged"),
        (("22.2 cSt", "0.3 cSt"), "unit"),
        (('"mineral"', '"olive"'), "hydrocracked"),
    ):
        path = tmp_path / "bad.toml"
        path.write_text(text.replace(*change), encoding="utf-8")
        with pytest.raises(ehl.InputError, match=words):
            ehl.Oil.load(str(path))
