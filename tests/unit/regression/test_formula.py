"""Formula files: round trip, ranges, intervals, refused files, and formulas that are shipped."""

import json
import math
import runpy
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contacts import gear_state as state
from refusals import refuses
from small_plans import point_options

from ehl.common.errors import InputError
from ehl.contact import Contact
from ehl.fluid.oil import Oil
from ehl.surface.finish import Finish
from ehl.uncertainty.spread import FILM_TO_SHARE, UncertaintyInput
from regression.data.dataset import columns, load_dataset
from regression.formula import Formula, friction_model
from regression.friction.conditions import conditions_of, contact_points
from regression.friction.families import FAMILIES
from regression.friction.fitted import FORMULA_SCHEMA
from regression.friction.models import FrictionFlag
from regression.friction.published import XU_COEFFICIENTS
from regression.friction.uncertainty import friction_changes

XU: dict[str, Any] = Formula.load("fva3_short").model_dump(mode="json", by_alias=True) | {
    "family": "xu",
    "equation": FAMILIES["xu"].equation,
    "coefficients": dict(zip(FAMILIES["xu"].terms, XU_COEFFICIENTS, strict=True)),
    "ranges": {"pressure_hertz": [0.5e9, 2e9], "slide_to_roll_total": [0.02, 1.2], "speed_entrainment": [1.0, 15.0]},
    "units": {"pressure_hertz": "Pa"},
    "oils": [{"name": "fva3", "card_hash": None}],
    "interval": {"level": 0.9, "log_width": 0.1, "largest": 0.25},
    "network": None,
    "cloud": None,
}
FORMULA = Formula.model_validate(XU)
BAND = {"count": 20, "log_width": 0.1}
OIL = Oil.load("fva3")
HOT: dict[str, Any] = {"pressure_hertz": "1 GPa", "radius_equivalent": "15 mm", "speed_entrainment": "2 m/s"}
HOT |= {"slide_to_roll": 0.4, "temperature_oil": "100 degC", "roughness_rms": "0.4 um"}


def test_file_round_trip_is_exact(tmp_path: Path) -> None:
    path = tmp_path / "formula.json"
    FORMULA.save(path)
    assert Formula.load(path).to_dict() == FORMULA.to_dict()
    assert Formula.load(path).to_json() == path.read_text()
    assert friction_model(str(path)).name == "formula.json"
    # order and layout are no edit
    path.write_text(json.dumps(dict(reversed(FORMULA.to_dict().items())), indent=7))
    assert Formula.load(path).to_dict() == FORMULA.to_dict()
    for use in (Formula.load, FORMULA.save):
        with pytest.raises(InputError):
            use(tmp_path)


def test_points_outside_are_flagged_and_get_the_widest_error() -> None:
    points = state(pressure_hertz=np.array([0.5e9, 0.4e9, 2e9 * (1 + 1e-9)]))
    estimate = FORMULA.mu(points, oil=OIL)
    assert estimate.flag.tolist() == [FrictionFlag.OK, FrictionFlag.OUTSIDE_RANGE, FrictionFlag.OK]
    assert estimate.upper[1] / estimate.mu[1] == pytest.approx(np.exp(0.25), rel=1e-12)
    other = FORMULA.mu(points, oil="75w90")
    assert other.upper[0] / other.mu[0] == pytest.approx(np.exp(0.25), rel=1e-12)
    assert other.flag.tolist() == [FrictionFlag.OTHER_OIL, FrictionFlag.OUTSIDE_RANGE, FrictionFlag.OTHER_OIL]


def test_friction_falls_to_zero_with_a_continuous_slope_below_the_least_sliding() -> None:
    """Proportional to sliding near zero, rising up to the least sliding of the data, and without a bend there."""
    least, step = 0.02, 1e-4
    part = np.array([0.0, 1e-6, 2e-6, 0.25, 0.5, 1.0 - step, 1.0, 1.0 + step])
    value = FORMULA.evaluate(conditions_of(state(slide_to_roll=part * least), OIL))
    assert value.mu[0] == 0.0
    assert value.mu[2] == pytest.approx(2.0 * value.mu[1], rel=1e-5)
    assert (np.diff(value.mu[:7]) > 0.0).all()
    before, after = np.diff(value.mu[5:]) / step
    assert before == pytest.approx(after, abs=1e-3 * value.mu[6])
    assert (value.flag[[3, 4, 6, 7]] == FrictionFlag.OUTSIDE_RANGE).tolist() == [True, True, False, False]


def test_ranges_that_begin_or_end_at_zero() -> None:
    """Data with pure rolling or smooth surfaces: friction has no smallest sliding, and any roughness is outside."""
    ranges = XU["ranges"] | {"slide_to_roll_total": [0.0, 1.2], "roughness_rms": [0.0, 0.0]}
    formula = Formula.model_validate(XU | {"ranges": ranges})
    points = conditions_of(state(slide_to_roll=np.array([1e-4, 0.3, 2.4])), OIL)
    value = formula.evaluate(points)
    np.testing.assert_allclose(value.mu, np.exp(formula.form.log_mu(points, formula.coefficients, 0.1)), rtol=1e-12)
    assert (value.flag == FrictionFlag.OUTSIDE_RANGE).all()
    # beyond a range that ends at zero there is no factor; twice the largest sliding is one
    np.testing.assert_allclose(formula.excess(points), [0.0, 0.0, np.log(2.0)], rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"schema": FORMULA_SCHEMA + 1, "writer": "mixed-ehl 9"}, "schema"),
        ({"schema": FORMULA_SCHEMA - 1}, "schema"),
        ({"family": "spline"}, "family"),
        ({"coefficients": {"b1": 1.0}}, "coefficients.b2"),
        ({"coefficients": XU["coefficients"] | {"b10": 1.0}}, "coefficients.b10"),
        ({"ranges": {"nonsense": [0, 1]}}, "ranges.nonsense"),
        ({"ranges": {"pressure_hertz": [2e9, 5e8]}}, "ranges.pressure_hertz"),
        ({"boundary_friction": -3}, "boundary_friction"),
        ({"units": {"pressure_hertz": "GPa"}}, "units.pressure_hertz"),
        ({"units": {"pressure": "Pa"}}, "units.pressure"),
        ({"equation": "mu = 42"}, "equation"),
        ({"comment": "mine"}, "comment"),
        ({"interval": XU["interval"] | {"level": 1.5}}, "interval.level"),
        ({"interval": XU["interval"] | {"bands": [BAND | {"low": 1, "high": 0.5}]}}, "interval.bands.0.high"),
        ({"interval": XU["interval"] | {"normalised": True}}, "interval.normalised"),
        ({"network": Formula.load("75w90").to_dict()["network"]}, "network"),
        ({}, "interval"),
        ("", ""),
        ("[1, 2]", ""),
        (FORMULA.to_json()[:500], ""),
    ],
)
def test_files_that_are_no_formula(tmp_path: Path, change: Any, field: str) -> None:
    path = tmp_path / "formula.json"
    content = {**XU, **change} if isinstance(change, dict) else change
    if change == {}:
        del content["interval"]
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    with refuses(f"formula.json.{field}" if field else "formula file"):
        Formula.load(path)


EDITED = {"coefficients": {"strain": 0.9}, "interval": {"largest": 0.01}, "boundary_friction": 0.12}


@pytest.mark.parametrize(("name", "value"), EDITED.items())
def test_an_edited_number_is_refused(tmp_path: Path, mixed_ehl: Any, name: str, value: Any) -> None:
    content, path = json.loads(Formula.load("fva3_short").to_json()), tmp_path / "edited.json"
    content[name] = content[name] | value if isinstance(value, dict) else value
    path.write_text(json.dumps(content))
    with refuses("edited.json.checksum"):
        Formula.load(path)
    assert mixed_ehl("mu", path, *point_options()).code == 2


def test_interval_follows_the_band_of_the_film_ratio() -> None:
    bands = [BAND | {"low": 0.0, "high": 0.5, "log_width": 0.02}, BAND | {"low": 2.0, "high": None, "log_width": 0.2}]
    formula = Formula.model_validate(XU | {"interval": XU["interval"] | {"bands": bands}})
    table = conditions_of(state(slide_to_roll=np.full(4, 0.5)), OIL)
    table["film_ratio_formula"] = np.array([0.1, 0.5, 1.999, np.inf])
    value = formula.evaluate(table)
    np.testing.assert_allclose(np.log(value.upper / value.mu), [0.02, 0.1, 0.1, 0.2], rtol=1e-9)
    np.testing.assert_allclose(value.upper / value.mu, value.mu / value.lower, rtol=1e-12)


def test_film_ratio_of_a_smooth_contact_is_that_of_the_least_roughness() -> None:
    """Also where all contacts of the data are smooth, and unchanged where the roughness is within the range."""
    table = conditions_of(state(roughness_rms_1=np.array([0.0, 0.02e-6]), roughness_rms_2=np.zeros(2)), OIL)
    for low in (0.0, 0.01e-6):
        moved = Formula.model_validate(XU | {"ranges": {"roughness_rms": [low, 1e-6]}}).with_roughness_in_range(table)
        expected = table["film_formula"] / np.array([max(low, 1e-300), 0.02e-6])
        np.testing.assert_allclose(moved["film_ratio_formula"], expected, rtol=1e-12)


def test_smooth_contacts_are_within_the_range_and_what_is_outside_is_named() -> None:
    model = friction_model("75w90")
    point: dict[str, Any] = HOT | {"temperature_oil": "80 degC", "slide_to_roll": 0.3, "roughness_rms": "0 um"}
    random, errors, inside = np.random.default_rng(3).random((40, 4)), [], []
    for pressure, speed, slip, hot in random:
        at = {
            "pressure_hertz": f"{0.4 + pressure} GPa", "speed_entrainment": f"{25.0**speed} m/s",
            "slide_to_roll": 0.02 * 40.0**slip, "radius_equivalent": "15 mm",
        }  # fmt: skip
        known = Contact(oil="75w90", temperature=f"{40 + 60 * hot} degC", **at).solve()
        light = at | {"temperature_oil": f"{40 + 60 * hot} degC", "roughness_rms": "0 um"}
        smooth = model.mu(**light)
        assert smooth.flag < FrictionFlag.OUTSIDE_RANGE
        assert model.range_note(**light) == ""
        if known.film_central > 120e-9:  # thinner films are those of the least roughness of the data, 0.03 um
            errors.append(abs(float(smooth.mu) / known.friction_coefficient - 1.0))
            inside.append(smooth.lower < known.friction_coefficient < smooth.upper)
    assert len(errors) > 25
    assert np.mean(errors) < 0.06
    assert np.mean(inside) > 0.75
    far = point | {"pressure_hertz": "3 GPa", "speed_entrainment": "0.02 m/s", "roughness_rms": "4 um"}
    for quantity in ("Hertz pressure 3 GPa (at most 2.5 GPa)", "entrainment speed", "composite Rq"):
        assert quantity in model.range_note(**far)
    assert model.mu(**far).flag == FrictionFlag.OUTSIDE_RANGE


@pytest.mark.parametrize("name", ["75w90", "fva3_short"])
def test_marks_across_the_motion_rub_less_than_marks_along_it(name: str) -> None:
    model = friction_model(name)
    assert model.uses_texture
    low, high = model.ranges["peklenik_number"]
    assert 0.35 <= low < 0.36 < 8.9 < high <= 9.0  # 0.35 to 9 in the plan
    mu = [float(model.mu(**HOT, peklenik_number=gamma).mu) for gamma in (0.4, 1.0, 3.0, 8.0)]
    assert mu == sorted(mu, reverse=True)
    assert mu[0] > 1.2 * mu[-1]
    assert float(model.mu(**HOT).mu) == mu[1]  # isotropic by default
    assert "Peklenik number 20" in model.range_note(**HOT, peklenik_number=20.0)


def test_points_never_fitted_are_met_as_their_table_says() -> None:
    """The errors `unseen` are those against the means over the profiles of the points of `--noise`."""
    model = friction_model("75w90")
    frame = load_dataset("gear_75w90_noise", "gear_75w90_hot_noise").frame
    frame, ratio = frame[frame["friction_error"] <= 1.0], ["film_ratio_formula"]
    assert 123 <= model.unseen.count == len(frame.drop_duplicates(ratio)) <= 128
    counts, _ = np.histogram(frame.drop_duplicates(ratio)["film_ratio"], [0.0, 0.5, 1.0, 2.0, np.inf])
    assert [band.count for band in model.unseen_bands] == counts.tolist()
    # contacts along gear meshes too are means over their profiles
    paths, point = load_dataset("gear_75w90_paths").frame, ["pressure_hertz", "speed_entrainment", "slide_to_roll"]
    assert (model.paths.count, len(paths)) == (200, 800)
    for rows, by, stated in ((frame, ratio, model.unseen), (paths, point, model.paths)):
        means = rows.groupby(by, sort=False)["friction_coefficient"].mean()
        error = np.abs(model.evaluate(columns(rows.drop_duplicates(by))).mu / means.to_numpy() - 1.0)
        assert stated.mape == pytest.approx(error.mean(), rel=1e-3)


def test_what_a_formula_of_a_file_has_and_lacks() -> None:
    model = FORMULA
    assert len(model.ranking()) == 1
    for field, use in (
        ("hull", lambda: model.in_convex_hull("gear_fva3")),
        ("boundary_friction", lambda: model.with_options(boundary_friction=0.1)),
        ("oil", lambda: friction_model("gear").default_oil()),  # type: ignore[union-attr]
    ):
        with refuses(field):
            use()
    assert model.oil_note(Oil.load("75w90"))
    assert model.oil_note(Oil.load("fva3")) == ""
    shipped = friction_model("fva3")
    other = Oil.load("fva3").model_copy(update={"heat_capacity": 2345.0})
    assert shipped.oil_flag(other) == FrictionFlag.OTHER_CARD
    assert shipped.oil_flag(Oil.load("fva3").model_copy(update={"description": "the same"})) == FrictionFlag.OK
    assert shipped.oil_note(other)
    assert len(shipped.to_text()) > len(shipped.equation)
    assert Formula.load("gear").oil_note(Oil.load("minr"))
    thin: Any = {"pressure_hertz": "0.16 GPa", "radius_equivalent": "3.2 mm", "speed_entrainment": "0.05 m/s"}
    thin |= {"roughness_rms": "0.04 um", "correlation_length": "100 um", "temperature": "30 degC"}
    with refuses("conditions"):  # each in its range
        shipped.with_options(refuse=True).mu(**thin, slide_to_roll=0.05)


@pytest.mark.fast
def test_a_finish_gives_the_roughness_of_a_contact(mixed_ehl: Any) -> None:
    formula = Formula.load("75w90")
    point = {"pressure_hertz": 1e9, "radius_equivalent": 0.015, "speed_entrainment": 5.0, "slide_to_roll": 0.2}
    given = {"temperature": 363.15, "roughness_rms": 0.4e-6}
    finish = Finish.load("ground")
    length = float(finish.length_at(0.4e-6 / np.sqrt(2.0)))
    texture = {"correlation_length": length, "peklenik_number": finish.lay_ratio.value}
    by_name, by_number = formula.mu(**point, **given, finish="ground"), formula.mu(**point, **given, **texture)
    assert float(by_name.mu) == pytest.approx(float(by_number.mu), rel=1e-12)
    assert float(formula.mu(**point, **given).mu) > 1.2 * float(by_name.mu)  # marks across the motion keep the oil
    both = float(np.sqrt(2.0)) * finish.roughness_rms.value
    own = {"temperature": 363.15, "roughness_rms": both, **texture, "correlation_length": 16e-6}
    assert formula.mu(**point, temperature=363.15, finish="ground").mu == pytest.approx(formula.mu(**point, **own).mu)
    high = [formula.uncertainty(**point, **given, **of).high for of in ({"finish": "ground"}, texture)]
    assert high[0] < 1.05 * high[1]
    smooth = formula.uncertainty(**point, temperature=363.15, roughness_rms=0.0, finish="ground")
    assert smooth.low < smooth.value < smooth.high
    mixed = formula.mu(**point | {"slide_to_roll": ["20 %", 0.2]}, **given)
    assert mixed.mu.tolist() == 2 * [formula.mu(**point, **given).mu]
    with refuses("slide_to_roll"):
        formula.mu(**point | {"slide_to_roll": [True, 0.2]}, **given)
    for wrong in ("grond", 5, ["ground"]):
        with refuses("finish"):
            formula.mu(**point, **given, finish=wrong)  # type: ignore[typeddict-item]
    options = point_options(radius="15 mm", slide_to_roll="0.2", temperature="90 degC", finish="ground")
    answer = mixed_ehl("mu", "75w90", *options, "--json")
    assert json.loads(answer.out)["friction_coefficient"] == pytest.approx(float(by_name.mu), rel=1e-12)


@pytest.mark.fast
@pytest.mark.parametrize("speed", [0.05, 0.5, 20.0])
def test_boundary_film_changes_the_load_share_of_the_asperities(monkeypatch: pytest.MonkeyPatch, speed: float) -> None:
    """A film twice as thick at one standard deviation, a slope of 1.5: odds of the share times 2^1.5, film by hand."""
    slopes = np.log([0.01, 100.0]), np.array([1.5, 1.5]), np.array([1.5, 1.5])
    monkeypatch.setattr("ehl.uncertainty.spread._slopes", lambda: {FILM_TO_SHARE: slopes})
    formula, oil = Formula.load("75w90"), Oil.load("75w90")
    state = contact_points(
        pressure_hertz=1e9, radius_equivalent=0.015, speed_entrainment=speed, slide_to_roll=0.3, temperature=363.15,
        roughness_rms=0.5e-6, correlation_length=20e-6, peklenik_number=3.0,
    )  # fmt: skip
    mu, film = (float(m.mu(state, oil=oil).mu) for m in (formula, formula.with_options(boundary_friction=0.0)))
    share = (mu - film) / formula.boundary_friction
    changes = friction_changes(formula, state, oil, UncertaintyInput.none(boundary_film=math.log(2.0)), level=0.6826895)
    found = next(change for change in changes.each if change.name == "boundary_film")
    for sign, change in ((-1.0, found.below), (1.0, found.above)):
        odds = share / (1.0 - share) * 2.0 ** (1.5 * sign)
        new = odds / (1.0 + odds)
        wanted = new * formula.boundary_friction + film * ((1.0 - new) / (1.0 - share)) ** 1.5
        assert float(np.ravel(change)[0]) == pytest.approx(math.log(wanted / mu), rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("name", ["mu", "lower", "flag"])
def test_an_exported_function_may_have_the_name_of_a_result(tmp_path: Path, name: str) -> None:
    names = FORMULA.export(tmp_path / f"{name}.py")
    arguments = dict(zip(names, (1.2e9, 0.012, 5.0, 0.3, 0.0, 353.15, 0.4e-6), strict=True))
    point = FORMULA.mu(**arguments)
    found = runpy.run_path(str(tmp_path / f"{name}.py"))[name](**arguments)
    assert np.allclose(found, (point.mu, point.lower, point.upper, point.flag), rtol=1e-12, atol=0.0)
    if compiler := shutil.which("gcc"):
        FORMULA.export(tmp_path / f"{name}.c")
        subprocess.run([compiler, "-std=c99", "-fsyntax-only", tmp_path / f"{name}.c"], check=True)


@pytest.mark.parametrize("file", ["for.c", "exp.c", "guard.c", "np.py", "lambda.py", "roughness_rms.f90", "mean.m"])
def test_an_exported_function_hides_no_word_of_its_code(tmp_path: Path, file: str) -> None:
    with refuses("path"):
        FORMULA.export(tmp_path / file)
    with refuses("oil"):  # one, or the oil as arguments
        FORMULA.export(tmp_path / "mu.c", oil="fva3", oil_arguments=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["75w90", "gear"])
def test_shear_of_a_varied_card_changes_friction_as_in_solved_contacts(name: str) -> None:
    """Both shear stresses are functions of the oil in the data: the networks are not extrapolated in them."""
    formula, oil = Formula.load(name), Oil.load("75w90")
    point: dict[str, Any] = {"pressure_hertz": "1.2 GPa", "radius_equivalent": "15 mm", "speed_entrainment": "5 m/s"}
    point |= {"slide_to_roll": 0.2, "temperature": "90 degC", "roughness_rms": "0.424 um", "finish": "ground"}
    solved = {"eyring_stress": (0.0224, 0.0338), "limiting_shear": (0.0258, 0.0326)}  # both ends of 90 %
    nominal = float(formula.mu(contact_points(**point), oil=oil).mu)
    for card, ends in solved.items():
        for score, expected in zip((-1.645, 1.645), ends, strict=True):
            varied = formula.mu(contact_points(**point), oil=oil.varied(**{card: score}))
            assert math.log(varied.mu / nominal) == pytest.approx(math.log(expected / 0.0308), abs=0.16)
