"""Measured traces and maps: parameters, lay, cut-offs by the standard, the command; peaks worn to plateaus."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses
from samples import CONTACT, contact_case
from small_plans import sweep_plan

import ehl
from efficiency.design.design import load_design
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.rough.mixed import rough_surfaces, worn
from ehl.surface.finish import Finish
from ehl.surface.measured_surface import mean_spacing, measured_surface, rms_slope
from ehl.surface.roughness import generate_profile
from ehl.uncertainty.contact_design import uncertain_contact_inputs
from ehl.uncertainty.spread import DEFAULT
from regression.plan.plan import Plan
from regression.sweeping.evaluators import input_row

STEP = 2e-6


def trace(folder: Path, heights: np.ndarray) -> Path:
    path = folder / "trace.csv"
    lines = (f"{2 * k},{1e6 * z:.6f}" for k, z in enumerate(heights))
    path.write_text("x [um],z [um]\n" + "\n".join(lines), encoding="utf-8")
    return path


def surface(angle: float, across: float, along: float, size: int = 192) -> np.ndarray:
    """A random map whose autocorrelation is a Gaussian ellipse with its long axis at an angle to x."""
    k = 2.0 * np.pi * np.fft.fftfreq(size, STEP)
    ky, kx = np.meshgrid(k, k, indexing="ij")
    a = kx * math.cos(angle) + ky * math.sin(angle)
    b = -kx * math.sin(angle) + ky * math.cos(angle)
    noise = np.fft.fft2(np.random.default_rng(4).standard_normal((size, size)))
    heights = np.fft.ifft2(noise * np.exp(-((a * along) ** 2 + (b * across) ** 2) / 8.0)).real
    return np.asarray(0.3e-6 * heights / heights.std())


def passed(cutoff: float) -> float:
    """Share of Rq in waves shorter than a cut-off, of the autocorrelation exp(-(x/20 um)^2)."""
    return math.sqrt(1.0 - math.erf(math.pi * 20e-6 / cutoff))


def test_parameters_of_a_wave() -> None:
    x = STEP * np.arange(2000)
    wave = 0.5e-6 * np.sin(2.0 * np.pi * x / 80e-6 + 0.3)
    assert mean_spacing(wave, STEP) == pytest.approx(80e-6, rel=1e-3)
    assert rms_slope(wave, STEP) == pytest.approx(2.0 * np.pi * 0.5e-6 / 80e-6 / math.sqrt(2.0), rel=3e-3)
    assert math.isnan(mean_spacing(x, STEP))


def test_a_trace_with_form_and_spikes(tmp_path: Path) -> None:
    truth = generate_profile(0.5e-6, 20e-6, 6e-3, STEP, 4)
    heights = truth.heights - (truth.x - 3e-3) ** 2 / 40e-3
    heights[700] += 20e-6
    found = measured_surface(trace(tmp_path, heights), cutoff_short="4 um")
    assert (found.cutoff_long, found.spikes, found.missing) == (0.8e-3, 1, 0)
    assert found.roughness_rms == pytest.approx(truth.rms * passed(0.8e-3), rel=0.04)
    assert found.correlation_length == pytest.approx(truth.correlation_length, rel=0.15)
    # of exp(-(x/lc)^2): sqrt(2) Rq/lc
    assert found.rdq == pytest.approx(math.sqrt(2.0) * 0.5e-6 / 20e-6, rel=0.1)
    assert math.isnan(found.lay_angle)
    assert np.allclose(found.used + found.form, found.raw, atol=1.5e-6)


@pytest.mark.parametrize("angle", [0.0, 35.0, -60.0])
def test_the_lay_of_a_map(tmp_path: Path, angle: float) -> None:
    heights = surface(math.radians(angle), 8e-6, 40e-6)
    head = ["# Width: 384 um", "# Height: 384 um", "# Value units: m"]
    path = tmp_path / "map.txt"
    path.write_text("\n".join([*head, *("\t".join(f"{z:.6e}" for z in line) for line in heights)]), encoding="utf-8")
    found = measured_surface(path, cutoff_long="0.35 mm", cutoff_short="4 um")
    assert found.lines == 192
    assert math.remainder(found.lay_angle - math.radians(angle), math.pi) == pytest.approx(0.0, abs=0.05)
    assert found.correlation_length == pytest.approx(8e-6, rel=0.15)
    assert found.correlation_length_along == pytest.approx(40e-6, rel=0.35)
    assert found.roughness_rms == pytest.approx(0.3e-6, rel=0.15)
    ratio = found.correlation_length_along / found.correlation_length
    assert Finish.from_profile(found).lay_ratio.value == pytest.approx(ratio, rel=1e-12)


def test_the_command_shows_checks_and_draws(mixed_ehl: Callable[..., Any], tmp_path: Path) -> None:
    path = trace(tmp_path, generate_profile(0.05e-6, 20e-6, 4e-3, STEP, 4).heights)
    content = json.loads(mixed_ehl("profile", path, "--json", "--plot", tmp_path / "p.png").out)
    assert content["cutoff_long"] == 0.25e-3  # Ra of 0.02 to 0.1 um
    assert content["roughness_rms"] == pytest.approx(0.05e-6 * passed(0.25e-3), rel=0.1)
    assert (tmp_path / "p.png").stat().st_size > 1000
    for wrong in (("--cutoff-long", "8 um"), ("--cutoff-short", "1 um"), ("--unit-height", "mm"), ("--detrend", "9")):
        assert mixed_ehl("profile", path, *wrong).code == 2


PRINTED_OF: dict[str, Any] = CONTACT | {"oil": "75w90", "temperature": "90 degC", "roughness_rms_1": 0.5e-6}


def test_what_is_printed_is_an_input(tmp_path: Path) -> None:
    """RSm/5, Sal/1.25 and sqrt(2) Rq/(0.65 Rdq) of one surface; of a known profile within the bounds stated."""
    by_slope = 2.0**0.5 * 0.5e-6 / (0.65 * 0.05)
    both = {"rsm": "80 um", "sal": "20 um"}
    for printed, length in (({"sal": "20 um"}, 16e-6), ({"rdq": 0.05}, by_slope), (both | {"rdq": 0.06}, 16e-6)):
        assert Contact(**PRINTED_OF, **printed).surface.correlation_length == pytest.approx(length, rel=1e-12)
    assert Contact(**PRINTED_OF, rsm="80 um").replace(rsm="60 um").surface.correlation_length == pytest.approx(12e-6)
    found = measured_surface(trace(tmp_path, generate_profile(0.5e-6, 20e-6, 6e-3, STEP, 4).heights))
    again = Contact(**PRINTED_OF, rsm=found.rsm, rdq=found.rdq).surface.correlation_length
    assert again == pytest.approx(found.correlation_length, rel=0.4)


@pytest.mark.parametrize(
    ("printed", "field"),
    [
        ({"rsm": "80 um", "rdq": 0.4}, "rsm"),
        ({"rsm": "80 um", "sal": "80 um"}, "sal"),
        ({"rsm": "80 um", "correlation_length": "10 um"}, "correlation_length"),
        ({"rsm": "80 mm"}, "rsm"),
        ({"rdq": 0.05, "roughness_rms_1": 0.0}, "rdq"),
    ],
)
def test_printed_numbers_that_contradict_are_refused(printed: dict[str, Any], field: str) -> None:
    with refuses(field):
        Contact(**PRINTED_OF | printed)


@pytest.fixture
def flank(tmp_path: Path) -> Path:
    """4 mm of a Gaussian profile: Rq 0.4 um, lc 16 um."""
    return trace(tmp_path, generate_profile(0.4e-6, 16e-6, 4e-3, STEP, 3).heights)


def test_card_holds_what_was_measured(flank: Path, tmp_path: Path) -> None:
    measured = ehl.measured_surface(flank)
    card = tmp_path / "mine.toml"
    card.write_text(Finish.from_profile(flank).to_toml(), encoding="utf-8")
    finish = Finish.load(str(card))
    for name, true in (("roughness_rms", 0.4e-6), ("correlation_length", 16e-6)):
        figure = getattr(finish, name)
        assert figure.value == pytest.approx(getattr(measured, name), rel=1e-9)
        assert figure.low < true < figure.high
    assert (finish.lay_ratio.value, finish.lay_ratio.high) == (1.0, 5.0)
    assert finish.measured.rsm == measured.rsm
    power = np.trapezoid(finish.measured.spectral_density, finish.measured.frequency)
    assert power == pytest.approx(measured.roughness_rms**2, rel=0.15)
    for names in ((card, "new"), (tmp_path / "none.toml",)):
        with pytest.raises(ehl.InputError):
            Finish.load(*map(str, names))


def test_card_is_accepted_where_a_finish_is(flank, tmp_path, mixed_ehl, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert [mixed_ehl("new", "finish", flank, "-o", "mine.toml").code for _ in range(2)] == [0, 2]
    finish = Finish.load("mine.toml")
    content = sweep_plan("own")
    del content["variables"]["roughness_rms"]
    content["surface"] = {"finish": "mine.toml"}
    _, case = next(validate(Plan, content).cases())
    for contact in (case, contact_case(surface={"finish": "mine.toml"})):
        assert contact.surface.roughness_rms_1 == finish.roughness_rms.value
        assert contact.surface.correlation_length == pytest.approx(finish.correlation_length.value)
    design = load_design("fm_spiral_bevel_14x39").with_finish("mine.toml")
    assert design.pinion.roughness_rms == finish.roughness_rms.value
    assert design.gear.surface_finish() == finish


GIVEN: dict[str, Any] = CONTACT | {"oil": "75w90", "temperature": 353.15, "speed_entrainment": 1.0, "accuracy": "fast"}


@pytest.mark.fast
def test_wear_keeps_the_valleys_and_gives_the_measured_skewness() -> None:
    new = generate_profile(0.5e-6, 12e-6, 24e-3, 1e-6, 3)
    run_in = worn(new, 0.3e-6)
    assert run_in.rms == pytest.approx(0.3e-6, rel=1e-9)
    # of a half-worn Gaussian distribution; a disc that ran in from 0.5 to 0.3 um had -1.38
    assert -1.8 < run_in.skewness < -1.3
    removed = new.heights - run_in.heights
    removed -= removed.min()
    assert np.median(removed[new.heights < 0.0]) == pytest.approx(0.0, abs=1e-12)
    assert removed.max() > 0.5e-6
    assert worn(new, new.rms) is worn(new, 1e-5) is new
    assert worn(new, 0.1 * new.rms).rms == pytest.approx(0.1 * new.rms, rel=1e-6)
    assert ehl.Contact(**GIVEN, roughness_rms="0.4 um", running_in=None).surface.running_in == "none"
    assert any("running_in" in note for note in ehl.Contact(**GIVEN, running_in="0.3 um").unused_inputs())


@pytest.mark.fast
@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"running_in": "wear", "roughness_rms": "0.4 um"}, "running_in"),
        ({"running_in": "0 um", "roughness_rms": "0.4 um"}, "running_in"),
        ({"running_in": "-1 um", "roughness_rms": "0.4 um"}, "running_in"),
        ({"running_in": "0.3 um", "finish": "ground"}, "finish_state"),
        ({"running_in": "0.05 um", "roughness_rms": "0.4 um"}, "running_in"),
    ],
)
def test_refused(given: dict[str, Any], field: str) -> None:
    with refuses(field):
        ehl.Contact(**GIVEN, **given)


def test_run_in_flanks_have_less_friction_and_their_own_film_ratio() -> None:
    fresh = ehl.Contact(**GIVEN, finish="ground", finish_state="new")
    contact = fresh.replace(running_in="0.3 um")
    new, run_in = fresh.solve(), contact.solve()
    surfaces = rough_surfaces(contact.surface, contact.problem().line)
    assert surfaces.rms == pytest.approx(0.3e-6 * 2.0**0.5, rel=1e-6)
    assert run_in.friction_coefficient < new.friction_coefficient
    assert run_in.film_ratio > 1.4 * new.film_ratio
    assert any("worn" in note for note in run_in.notes)
    row = input_row(contact)
    assert row["roughness_rms_1"] == row["roughness_rms_2"] == 0.3e-6
    causes = uncertain_contact_inputs(contact.problem(), DEFAULT, None, run_in.film_ratio)
    assert {cause.name for cause in causes if cause.input == "roughness_rms"} == {"running_in"}
