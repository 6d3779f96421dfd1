"""Measured traces and maps: reading with units, filters and cut-offs, parameters, lay, the command; worn peaks."""

import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusals import refuses
from samples import CONTACT, contact_case
from small_plans import sweep_plan

import ehl
from efficiency.design.design import load_design
from ehl.common.errors import InputError
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.rough.mixed import rough_surfaces, worn
from ehl.surface.finish import Finish
from ehl.surface.measured_surface import (
    gaussian_mean_line,
    joined_ends,
    load_profile,
    mean_spacing,
    measured_surface,
    prepared_profile,
    profile_points,
    rms_slope,
)
from ehl.surface.profile_file import read_heights, read_topography
from ehl.surface.roughness import generate_profile
from ehl.uncertainty.contact_design import uncertain_contact_inputs
from ehl.uncertainty.spread import DEFAULT
from regression.plan.plan import Plan
from regression.sweeping.evaluators import input_row

STEP = 2e-6
GIVEN: dict[str, Any] = CONTACT | {"oil": "75w90", "temperature": 353.15, "speed_entrainment": 1.0, "accuracy": "fast"}


def write(path: Path, lines: list[str]) -> Path:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def trace(folder: Path, heights: np.ndarray) -> Path:
    lines = (f"{2 * k},{1e6 * z:.6f}" for k, z in enumerate(heights))
    return write(folder / "trace.csv", ["x [um],z [um]", *lines])


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
    path = write(tmp_path / "map.txt", [*head, *("\t".join(f"{z:.6e}" for z in line) for line in heights)])
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
    for wrong in ("cutoff-long=0.0008", "cutoff-long=8 um", "cutoff-short=1 um", "unit-height=mm", "detrend=9"):
        assert mixed_ehl("profile", path, f"--{wrong}").code == 2


def test_what_is_printed_is_an_input(tmp_path: Path) -> None:
    """RSm/5, Sal/1.25 and sqrt(2) Rq/(0.65 Rdq) of one surface; of a known profile within the bounds stated."""
    by_slope, rough = 2.0**0.5 * 0.5e-6 / (0.65 * 0.05), GIVEN | {"roughness_rms_1": 0.5e-6}
    both = {"rsm": "80 um", "sal": "20 um"}
    for printed, length in (({"sal": "20 um"}, 16e-6), ({"rdq": 0.05}, by_slope), (both | {"rdq": 0.06}, 16e-6)):
        assert Contact(**rough, **printed).surface.correlation_length == pytest.approx(length, rel=1e-12)
    assert Contact(**rough, rsm="80 um").replace(rsm="60 um").surface.correlation_length == pytest.approx(12e-6)
    found = measured_surface(trace(tmp_path, generate_profile(0.5e-6, 20e-6, 6e-3, STEP, 4).heights))
    again = Contact(**rough, rsm=found.rsm, rdq=found.rdq).surface.correlation_length
    assert again == pytest.approx(found.correlation_length, rel=0.4)


@pytest.fixture
def flank(tmp_path: Path) -> Path:
    """4 mm of a Gaussian profile: Rq 0.4 um, lc 16 um."""
    return trace(tmp_path, generate_profile(0.4e-6, 16e-6, 4e-3, STEP, 3).heights)


def test_card_holds_what_was_measured(flank: Path, tmp_path: Path) -> None:
    measured = ehl.measured_surface(flank)
    card = tmp_path / "mine.toml"
    card.write_text(Finish.from_profile(measured).to_toml(), encoding="utf-8")
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
        ({"rsm": "80 um", "rdq": 0.4, "roughness_rms_1": 0.5e-6}, "rsm"),
        ({"rsm": "80 um", "sal": "80 um", "roughness_rms_1": 0.5e-6}, "sal"),
        ({"rsm": "80 um", "correlation_length": "10 um", "roughness_rms_1": 0.5e-6}, "correlation_length"),
        ({"rsm": "80 mm", "roughness_rms_1": 0.5e-6}, "rsm"),
        ({"rdq": 0.05, "roughness_rms_1": 0.0}, "rdq"),
        ({"running_in": "wear", "roughness_rms": "0.4 um"}, "running_in"),
        ({"running_in": "0 um", "roughness_rms": "0.4 um"}, "running_in"),
        ({"running_in": "-1 um", "roughness_rms": "0.4 um"}, "running_in"),
        ({"running_in": "0.3 um", "finish": "ground"}, "finish_state"),
        ({"running_in": "0.05 um", "roughness_rms": "0.4 um"}, "running_in"),
    ],
)
def test_printed_numbers_that_contradict_and_wear_are_refused(given: dict[str, Any], field: str) -> None:
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


SPACING = 1e-6


def wave(length: float, n: int = 4000) -> np.ndarray:
    return np.sin(2.0 * np.pi * np.arange(n) * SPACING / length)


def rows(n: int = 100, template: str = "{x},{z}") -> list[str]:
    heights = [0.1 * math.sin(0.3 * i) for i in range(n)]
    return [template.format(x=0.001 * i, z=z, a=1e4 * z) for i, z in enumerate(heights)]


GERMAN = [line.replace(",", ";").replace(".", ",") for line in rows()]


@pytest.mark.parametrize(
    ("header", "lines", "encoding"),
    [
        ("x [mm], height [um]", rows(), "utf-8"),
        ("# stylus\n# x (mm); z (µm)", GERMAN, "utf-8-sig"),
        ("x[mm]\tz[um]", rows(template="{x}\t{z}"), "utf-16"),
        ("# x [mm]  z [µm]", [line.replace(";", "  ") for line in GERMAN], "latin-1"),
        ("Stylus,2.5 µm\nLength,0.1 mm\n\nLateral mm,Raw Micrometer,", rows(template="{x},{z},,"), "cp1252"),
        ("Weg/mm;Höhe/µm", GERMAN, "cp1252"),
        ("X_(mm) Z_(microns)\n100", rows(template="{x}, {z}"), "utf-8"),
        ("point\tx [mm]\tz [um]", [f"{k}\t" + line.replace(",", "\t") for k, line in enumerate(rows())], "utf-16-le"),
        ("spacing: 1 um, units: um", [line.split(",")[1] for line in rows()], "utf-8"),
        ("Sampling interval (mm): 0.001\nHeights in um", [line.split(",")[1] for line in rows()], "utf-8"),
        ("Height (µm),Distance (mm)", rows(template="{z},{x}"), "cp1252"),
        ("x [mm];P [µm];R [µm]", rows(template="{x};{z};0.1"), "latin-1"),
        ("mm µm\n100", rows(template="   {x:.7e},   {z:.16e}"), "utf-8"),
        ("x [mm],Height (Angstrom)", rows(template="{x},{a}"), "utf-8"),
        ('"x [mm]","z [um]"', [line.replace(".", ",") for line in rows(template='"{x:.3f}","{z:.16f}"')], "utf-8"),
        ("Datum;Zeit;x [mm];z [um]", rows(template="12.03.2024;10:00:01;{x};{z}"), "utf-8"),
        ("Messschrittweite: 1,0 um\nEinheit: um", [line.partition(";")[2] for line in GERMAN], "utf-8"),
        ("x [mm];z [um]", rows(template="{x};{z};;")[::-1], "utf-8"),  # falling positions
    ],
)
def test_columns_and_units_by_content(tmp_path, header, lines, encoding):
    path = tmp_path / "p.dat"
    path.write_bytes("\r\n".join([header, *lines, "", "end of data"]).encode(encoding))
    found = read_heights(path)
    assert_allclose(found.x, 1e-6 * np.arange(100), atol=1e-15)
    assert_allclose(found.heights, [1e-7 * np.sin(0.3 * np.arange(100))], atol=1e-18)
    assert found.notes == ()


def test_given_units_win_over_the_header(tmp_path):
    found = read_heights(write(tmp_path / "p.csv", ["x [um], height [nm]", *rows()]), unit_x="mm", unit_height="um")
    assert (found.x[1], found.heights.max()) == pytest.approx((1e-6, 1e-7), rel=0.01)
    # uneven steps are resampled, with a note
    positions = np.cumsum(1e-3 * (1.0 + 0.3 * np.sin(np.arange(200))))
    lines = [f"{x:.9f},{2.0 * x:.9f}" for x in positions]
    found = read_heights(write(tmp_path / "p.csv", ["x [mm], z [mm]", *lines]))
    assert_allclose(found.heights[0], 2e-3 * positions[0] + 2.0 * found.x, rtol=1e-6)
    assert found.notes[0].startswith("resampled")


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (["x [mm], z [um]", *rows(50)], "at least 64 points"),
        (["x [mm], z [um]", *rows(99), "0.099,x9", "0.100,0.1"], "Line 101"),
        (["x [mm], z [um]", *rows(99), "0.050,0.1"], "point 100"),
        (["x [mm], z [um]", *rows(99), "9.0,0.1"], "oints are missing"),
        (["x [mm], z [kg]", *rows()], "unit_height"),
        (["x, z", *rows()], "length unit"),
        (["x [nm], z [um]", *rows()], "length of 0.1 mm to 100 mm"),
        (["x [mm]; z [um]", *GERMAN[:99], "0,099;1.500"], "Line 101"),
        (["a,b,c", *(f"{line},1" for line in rows())], "3 columns"),
        ([",".join(["1.5"] * 96)] * 96, "96 columns"),
        ([], "no lines of numbers"),
    ],
)
def test_what_is_refused_and_how(tmp_path, lines, says):
    with pytest.raises(InputError, match=says):
        read_heights(write(tmp_path / "p.csv", lines))


def test_gaps_and_spikes_are_interpolated_and_counted(tmp_path):
    truth = generate_profile(0.4e-6, 30e-6, 4e-3, SPACING, 4)
    lines = [f"{1e3 * x:.6f};{1e6 * z:.6f}" for x, z in zip(truth.x, truth.heights, strict=True)]
    for k, code in ((700, "Bad"), (701, "-9999"), (2500, "No Data"), (2600, "***")):
        lines[k] = lines[k].partition(";")[0] + f";{code}"
    lines[1200] = lines[1200].partition(";")[0] + ";35.0"
    found = read_heights(write(tmp_path / "p.csv", ["x [mm];z [um]", *lines])).cleaned()
    assert (found.missing, found.spikes, len(found.notes)) == (4, 1, 2)
    assert_allclose(found.heights[0], truth.heights, atol=5e-9)
    lines[1000:1200] = [line.partition(";")[0] + ";" for line in lines[1000:1200]]
    with refuses("profile"):
        read_heights(write(tmp_path / "p.csv", ["x [mm];z [um]", *lines])).cleaned()


@pytest.mark.parametrize(("of", "unit"), [(1e-6, "mm"), (1e-6, "nm"), (1e-9, "um"), (1e-6, "m")])
def test_heights_in_a_wrong_unit_are_refused(tmp_path, of, unit):
    profile = generate_profile(0.4e-6, 30e-6, 4e-3, SPACING, 4)
    lines = (f"{1e3 * x:.6f},{z / of:.6f}" for x, z in zip(profile.x, profile.heights, strict=True))
    with refuses("profile") as caught:
        profile_points(write(tmp_path / "p.csv", [f"x [mm], z [{unit}]", *lines]))
    assert {1e-6: "um", 1e-9: "nm"}[of] in caught.value.hint.split()[-1]


HEADS_OF_MAPS = {
    "gwyddion": "# Channel: Height\n# Width: 192 µm\n# Height: 60 µm\n# Value units: m",
    "german": "Breite: 0,192 mm\nHöhe: 0,06 mm\nEinheit der Werte: m",
    "keyence": '"XY calibration","2.000","um"\n"Output","Height"\n"Horizontal","96"\n"Unit","m"\n\n"Height"',
    "steps": "X pixel size [um],2\nY pixel size [um],2.0\nZ unit,m",
}


@pytest.mark.parametrize("kind", [*HEADS_OF_MAPS, "points", "points with holes"])
def test_a_map_of_text(tmp_path, kind):
    x = 2e-6 * np.arange(96)
    lines = np.array([generate_profile(0.2e-6, 12e-6, 192e-6, 2e-6, seed).heights for seed in range(30)])
    if kind in HEADS_OF_MAPS:
        text = [HEADS_OF_MAPS[kind], *("\t".join(f"{z:.5e}" for z in line) for line in lines)]
    else:
        points = ((a, k, z) for k, line in enumerate(lines) for a, z in zip(x, line, strict=True))
        text = ["x [um] y [um] z [um]", *(f"{1e6 * a:g} {2 * k} {1e6 * z:.6f}" for a, k, z in points)]
    if kind == "points with holes":
        del text[500::97]
    found = read_heights(write(tmp_path / "map.txt", text)).cleaned()
    assert found.missing == (len(range(500, 1 + lines.size, 97)) if kind == "points with holes" else 0)
    assert_allclose(found.heights, lines, atol=4e-8 if found.missing else 1e-11)
    assert (found.spacing, found.spacing_lines) == pytest.approx((2e-6, 2e-6))
    _, heights, notes = profile_points(tmp_path / "map.txt")
    assert np.std(heights) == pytest.approx(np.median(np.std(lines, axis=1)), rel=0.1)
    assert any("of 30 of a map" in note for note in notes)


def test_missing_and_binary_files_and_a_missing_extra(tmp_path, monkeypatch):
    (tmp_path / "b.csv").write_bytes(bytes(range(256)))
    for name in ("none.csv", "b.csv"):
        with refuses("profile"):
            read_heights(tmp_path / name)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    with refuses("profile"):
        load_profile(tmp_path / "scan.opd", cutoff_long=None, cutoff_short=10e-6)


@pytest.mark.parametrize(("ratio", "passes"), [(1.0, 0.5), (2.0, 2.0**-0.25), (0.5, 2.0**-4.0), (10.0, 2.0**-0.01)])
def test_gaussian_filter_transmission(ratio, passes):
    # ISO 16610-21: 2^-(cutoff/wavelength)^2
    cutoff = 200e-6 / ratio
    smooth = gaussian_mean_line(wave(200e-6), SPACING, cutoff)
    middle = slice(1000, 3000)
    assert np.std(smooth[middle]) / np.std(wave(200e-6)[middle]) == pytest.approx(passes, rel=2e-3)
    assert_allclose(gaussian_mean_line(np.full(300, 2.5), SPACING, cutoff), 2.5)


def test_joined_ends_are_periodic_and_keep_the_rms():
    heights = np.random.default_rng(3).standard_normal(20000)
    smooth = gaussian_mean_line(heights, 1.0, 40.0)
    joined = joined_ends(smooth, 4000)
    assert len(joined) == 16000
    assert abs(joined[0] - joined[-1]) < 3.0 * np.abs(np.diff(smooth)).max()
    assert np.std(joined[:4000]) == pytest.approx(np.std(smooth), rel=0.1)


def test_preparation_recovers_a_generated_profile():
    """Of a flank of 10 mm radius, mounted with a tilt, and of waviness where a long cut-off is given."""
    truth = generate_profile(0.4e-6, 30e-6, 8e-3, SPACING, 4)
    x = truth.x
    heights = truth.heights + 5e-6 + 2e-3 * x - (x - 3e-3) ** 2 / 20e-3
    heights = heights + 20e-9 * np.random.default_rng(0).standard_normal(len(x))
    profile = prepared_profile(x, heights, cutoff_long=None, cutoff_short=15e-6)
    assert profile.rms == pytest.approx(truth.rms, rel=0.08)
    assert profile.correlation_length == pytest.approx(truth.correlation_length, rel=0.1)
    assert (profile.cutoff, profile.spacing) == (15e-6, 3e-6)
    waves = 1e-6 * np.sin(2 * np.pi * x / 4e-3) + 0.1e-6 * np.sin(2 * np.pi * x / 50e-6)
    middle = prepared_profile(x, waves, cutoff_long=0.8e-3, cutoff_short=5e-6).heights
    middle = middle[len(middle) // 4 : -len(middle) // 4]
    assert np.std(middle) == pytest.approx(0.1e-6 / math.sqrt(2), rel=0.05)


@pytest.mark.parametrize(("field", "value"), [("cutoff_short", 1e-6), ("cutoff_short", 2e-3), ("cutoff_long", 11e-6)])
def test_cutoffs_out_of_range(field, value):
    given = {"cutoff_long": None, "cutoff_short": 10e-6} | {field: value}
    with refuses(field):
        prepared_profile(SPACING * np.arange(4000), wave(100e-6), **given)


def test_positions_with_too_few_digits_are_even(tmp_path):
    """As a stylus instrument prints steps of 0.156 um with one decimal."""
    heights = generate_profile(0.3e-6, 20e-6, 400e-6, 0.156e-6, 4).heights
    lines = (f"{0.156 * k:.1f},{1e6 * z:.6f},," for k, z in enumerate(heights))
    found = read_heights(write(tmp_path / "p.csv", ["Scan Data", "Lateral um,Raw Micrometer,", *lines]))
    assert (found.notes, found.spacing) == ((), pytest.approx(0.156e-6, rel=1e-4))
    assert_allclose(found.heights[0], heights, atol=1e-12)


@pytest.mark.parametrize("kind", ["gwy", "x3p", "matrix"])
def test_formats_written_by_surface_topography(tmp_path, kind):
    """Its own test files do not come with the package: it writes files of the same formats."""
    package = pytest.importorskip("SurfaceTopography", reason="extra roughness")
    heights = np.random.default_rng(1).normal(0.0, 0.3, (96, 80))
    topography = package.Topography(heights, (192.0, 160.0), unit="um")
    if not hasattr(topography, f"to_{kind}"):
        pytest.skip("a version of SurfaceTopography that does not write it")
    path = tmp_path / "map.dat"
    getattr(topography, f"to_{kind}")(str(path))
    found = read_heights(path)
    assert_allclose(found.heights, 1e-6 * heights.T, atol=1e-12)
    assert (found.spacing, found.spacing_lines) == pytest.approx((2e-6, 2e-6))
    assert (kind == "matrix") == (found.notes == ())


@pytest.mark.parametrize("kind", ["aISO-1.0", "aBCR-1.0", "gsf"])
def test_simple_formats_of_maps(tmp_path, kind):
    """Text after ISO 25178-71 with any number of heights a line, and the simple format of Gwyddion."""
    steps = np.random.default_rng(1).integers(-500, 500, (12, 96))
    path, heights = tmp_path / "map.txt", 1e-9 * steps
    if kind == "gsf":
        head = "Gwyddion Simple Field 1.0\nXRes = 96\nYRes = 12\nXReal = 192\nYReal = 24\nXYUnits = um\nZUnits = nm\n"
        path.write_bytes(head.encode() + b"\0" * (4 - len(head) % 4) + steps.astype("<f4").tobytes())
    else:
        head = "NumPoints = 96\nNumProfiles = 12\nXscale = 2e-6 ; um\nYscale = 2e-6\nZscale = 1e-9\n*\n"
        words = [*map(str, steps.ravel()[:-1]), "BAD"]
        lines = [" ".join(words[k : k + 7]) for k in range(0, len(words), 7)]
        path.write_text("\n".join([f"{kind}\nManufacID = test\n{head}", *lines, "*", "of a test"]))
        heights[-1, -1] = math.nan
    found = read_heights(path)
    assert_allclose(found.heights, heights, atol=1e-15)
    assert (found.spacing, found.spacing_lines) == pytest.approx((2e-6, 2e-6))
    path.write_bytes(path.read_bytes()[:150])
    with refuses("profile"):
        read_heights(path)


def test_profilometer_line_and_map(tmp_path, monkeypatch):
    path = tmp_path / "scan.opd"
    path.write_bytes(b"\0")
    line = np.sin(0.1 * np.arange(200))

    def provide(heights, unit="um"):
        topography = SimpleNamespace(dim=heights.ndim, unit=unit, physical_sizes=(float(len(heights)), 5.0))
        topography.heights = lambda: heights
        topography.positions_and_heights = lambda: (np.arange(len(heights), dtype=float), heights)
        module = SimpleNamespace(read_topography=lambda name: topography)
        monkeypatch.setitem(sys.modules, "SurfaceTopography", module)

    provide(line)
    found = read_heights(path)
    assert_allclose([found.spacing, found.heights[0, 10]], [1e-6, 1e-6 * line[10]])
    provide(np.stack([0.0 * line, line, 0.5 * line]).T)
    assert read_heights(path).spacing_lines == pytest.approx(5e-6 / 3.0)
    assert np.max(profile_points(path)[1]) == pytest.approx(0.5e-6, rel=0.01)
    # a text of another format is tried as well, whatever its name
    (tmp_path / "scan.csv").write_text("aBCR-1.0\n" + "12\n" * 70, encoding="utf-8")
    assert read_heights(tmp_path / "scan.csv").is_map
    provide(line, unit=None)
    with refuses("profile"):
        read_heights(path)
    assert read_heights(path, unit_height="um").spacing == pytest.approx(1e-6)
    provide(np.ma.masked_greater(line, 0.99))
    assert read_heights(path).cleaned().missing == np.sum(line > 0.99)
    with refuses("profile"):
        read_topography(tmp_path / "none.opd")
