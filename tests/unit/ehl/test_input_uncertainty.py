"""Spreads of inputs, how their changes make an interval, and the interval of one contact."""

import csv
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import samples
from matplotlib.figure import Figure
from refusals import refuses

import ehl
from ehl.common.data import data_path
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from ehl.fluid.oil_laws import standard_uncertainty
from ehl.inputs import ContactProblem
from ehl.surface.finish import Additive, Finish, lay_seen
from ehl.uncertainty import spread as spread_module
from ehl.uncertainty.contact_design import contact_uncertainty, uncertain_contact_inputs, varied_lubricant
from ehl.uncertainty.result import Change, InputUncertainty, combined, ends, score_of
from ehl.uncertainty.spread import DEFAULT, FILE, FILM_RATIOS, GROUPS, Spread, UncertaintyInput, stated_change


def uncertainty(*changes: Change) -> InputUncertainty:
    return InputUncertainty.of("friction_coefficient", 0.05, changes, lambda ln: 0.05 * math.exp(ln))


def test_sides_add_apart_and_the_largest_contribution_comes_first() -> None:
    down, up = combined([Change("a", "oil", 0.1, -0.3, 0.6), Change("b", "oil", 0.1, 0.8, -0.4)])
    assert down == pytest.approx(-0.5)
    assert up == pytest.approx(1.0)
    # raised by both ends: the lower side does not know it
    down, up = combined([Change("a", "oil", 0.1, 0.3, 0.4)])
    assert (down, up) == (0.0, pytest.approx(0.4))
    found = uncertainty(Change("viscosity", "oil", 0.1, -0.01, 0.01), Change("boundary_film", "film", 0.1, -0.2, 0.3))
    assert [source.name for source in found.sources] == ["boundary_film", "viscosity"]
    assert found.groups["film"] == pytest.approx(0.025 * (math.exp(0.3) - math.exp(-0.2)))
    assert found.to_frame()["share"].sum() == pytest.approx(1.0)
    assert len(found.plot(Figure().add_subplot()).get_yticklabels()) == 3  # with that of all inputs
    assert uncertainty().low == uncertainty().high == 0.05


def test_spreads() -> None:
    assert Spread(0.1).at(2.0, -1.0) == pytest.approx(2.0 * math.exp(-0.1))
    assert Spread(10.0, "absolute").at(350.0, 2.0) == 370.0
    for wrong in (-1.0, math.nan):
        with refuses("viscosity"):
            validate(UncertaintyInput, {"viscosity": wrong})
    with refuses("level"):
        score_of(0.0)
    # the ends of a range are those of its 90 % interval, to either side of the figure
    figure, z = Additive.load("EP").boundary_film, score_of(0.9)
    ends = [Spread.of_figure(figure).at(figure.value, side) for side in (-z, z)]
    assert ends == pytest.approx([figure.low, figure.high], rel=1e-9)
    # without information on the lay it is not below isotropic
    assert [DEFAULT.spread("peklenik_number").at(1.0, side) for side in (-z, z)] == pytest.approx([1.0, 5.0])


def test_spreads_of_rough_model_and_remembered_card() -> None:
    """The first decreases as the inverse square above a film ratio of 1; a card from memory adds 0.15 in quadrature."""
    assert spread_module.lateral_spread(np.array([0.5, 1.0, 2.0]), 0.08) == pytest.approx([0.08, 0.08, 0.02])
    law: Any = SimpleNamespace(deviation=0.08, law="law")
    known, memory = (standard_uncertainty(law, None, certainty) for certainty in ("verified", "unverified"))
    assert (known["pressure_viscosity"], memory["pressure_viscosity"]) == (0.08, 0.17)
    assert (known["viscosity"], memory["viscosity"]) == (0.05, 0.10)


def test_own_spreads_take_the_place_of_defaults() -> None:
    given = UncertaintyInput(viscosity=0.02, temperature_bulk=3.0)
    oil = Oil.load("75w90")
    assert given.spread("viscosity", oil).sd == 0.02
    assert given.spread("eyring_stress", oil).sd == oil.uncertainty.eyring_stress
    assert (given.spread("temperature_bulk").sd, given.spread("temperature_bulk").kind) == (3.0, "absolute")
    assert given.spread("roughness_rms") == DEFAULT.spread("roughness_rms")
    assert all(UncertaintyInput.none().spread(name).known for name in GROUPS)
    with refuses("oil"):
        given.spread("eyring_stress")


def test_stated_slopes_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    """ln mu moves by slope times shift: 0.2 x -0.3 x 2 below, 0.4 x 0.5 x 2 above at the first entry."""
    nodes = (np.log([0.1, 0.4]), np.array([0.2, 0.4]), np.array([0.4, 1.2]))
    monkeypatch.setattr("ehl.uncertainty.spread._slopes", lambda: {"boundary_film": nodes, "temperature_bulk": nodes})
    spread = Spread(0.5, sd_below=0.3)
    found = stated_change("boundary_film", spread, np.array([0.1, 0.2, math.inf]), 2.0)
    np.testing.assert_allclose(found[0], [0.2 * -0.6, 0.3 * -0.6, 0.0], rtol=1e-12)
    np.testing.assert_allclose(found[1], [0.4 * 1.0, 0.8 * 1.0, 0.0], rtol=1e-12)
    bodies = stated_change("temperature_bulk", Spread(10.0, "absolute"), np.array([math.inf]), 1.0)
    assert (bodies[0][0], bodies[1][0]) == (pytest.approx(-4.0), pytest.approx(12.0))
    assert stated_change("viscosity", spread, np.array([1.0]), 1.0) is None


@pytest.mark.parametrize("place", range(len(FILM_RATIOS)))
def test_stated_slopes_are_those_of_the_table(place: int) -> None:
    with data_path(FILE).open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if float(row["film_ratio"]) == FILM_RATIOS[place]]
    assert len(rows) == 5
    for row in rows:
        found = stated_change(row["input"], Spread(0.1), np.array([FILM_RATIOS[place]]), 1.0)
        wanted = (-0.1 * float(row["slope_below"]), 0.1 * float(row["slope_above"]))
        assert (found[0][0], found[1][0]) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(
    ("angle", "range_of_gamma"),
    [(0.0, (3.0, 9.0)), (25.0, (1.766, 2.089)), (45.0, (1.0, 1.0)), (90.0, (1.0 / 3.0, 1.0 / 3.0))],
)
def test_lay_ratio_at_the_angle_of_the_marks(angle: float, range_of_gamma: tuple[float, float]) -> None:
    """Grinding marks are 3 to 9 times as long as wide; gamma and the length along x follow, of at least 1/3."""
    ground, z = DEFAULT.of_surface(finish="ground"), score_of(0.9)
    for side, ratio, gamma in zip((-1.0, 1.0), (3.0, 9.0), range_of_gamma, strict=True):
        length, found = ground.lay_moved(*lay_seen(16e-6, 5.0, math.radians(angle)), side * z)
        assert float(found) == pytest.approx(gamma, abs=1e-3)
        assert float(length) == pytest.approx(float(lay_seen(16e-6, ratio, math.radians(angle))[0]), rel=1e-6)


def test_a_given_peklenik_number_has_a_range_of_its_own() -> None:
    z = score_of(0.9)
    given = DEFAULT.of_surface(peklenik_number=3.0, finish="ground")
    assert [float(given.lay_moved(2e-5, 3.0, side)[1]) for side in (-z, z)] == pytest.approx([1.0, 9.0])
    assert given.lay_moved(2e-5, 3.0, z)[0] == 2e-5
    stated = UncertaintyInput(peklenik_number=0.1).of_surface(finish="ground")
    assert float(stated.lay_moved(2e-5, 2.0, 1.0)[1]) == pytest.approx(2.0 * math.exp(0.1))
    kept = DEFAULT.of_surface(finish="ground", correlation_length=2e-5)
    assert kept.lay_moved(2e-5, 1.0 / 3.0, z)[0] == 2e-5
    assert UncertaintyInput().with_surface_of(kept).spread("correlation_length").at(1.0, z) == pytest.approx(2.6)
    own = DEFAULT.of_surface(roughness_rms=1e-6)
    assert own.with_surface_of(kept).lay_ratio is None


# asperity load share (logit, and its slope) and slopes of both parts of the friction, whose ratio is exp(level)
@pytest.mark.parametrize(
    ("logit", "turn", "asperities", "film", "level"),
    [(0.0, 1.0, 0.2, 0.4, 0.0), (0.0, 0.8, 0.1, 0.3, -0.5), (-1.0, 1.0, 0.2, 0.4, 1.0), (-1.5, 0.7, 0.2, 0.4, 1.2)],
)
def test_inputs_that_interact_hold_their_share_of_random_draws(logit, turn, asperities, film, level):
    """ln mu = ln(X e^(level + a z1) + (1 - X) e^(b z2)), X = 1/(1 + e^-(logit + c z3)): 90 +- 2 % inside."""
    z, names, axes = score_of(0.9), ("asperities", "film", "share"), np.eye(3)

    def change(scores: Any) -> Any:
        first, second, third = np.moveaxis(np.asarray(scores), -1, 0)
        share = 1.0 / (1.0 + np.exp(-logit - turn * third))
        return np.log(share * np.exp(level + asperities * first) + (1.0 - share) * np.exp(film * second))

    start = change(np.zeros(3))

    def together(cases: Any) -> list[float]:
        return [float(change([z * case.get(name, 0.0) for name in names]) - start) for case in cases]

    alone = ([float(change(side * z * axis) - start) for side in (-1.0, 1.0)] for axis in axes)
    changes = [Change(name, "oil", 1.0, *ends_of) for name, ends_of in zip(names, alone, strict=True)]
    down, up = ends(changes, together, together)
    drawn = change(np.random.default_rng(1).normal(size=(100_000, 3))) - start
    assert np.mean((drawn > down) & (drawn < up)) == pytest.approx(0.9, abs=0.02)
    for name in names:
        lower, upper = ends([one for one in changes if one.name != name], together, together)
        assert lower > down - 0.01
        assert upper < up + 0.01


OIL = Oil.load("75w90")
CONTACT = ehl.Contact(oil="75w90", temperature="90 degC", roughness_rms="0.4 um", **samples.CONTACT)


def product(problem: ContactProblem) -> tuple[float, float, float]:
    """mu = eta0 mu_b sqrt(boundary film), a film ratio of 0.5."""
    surface = problem.surface
    film = math.sqrt(surface.film_of_contact)
    return problem.lubricant.viscosity_inlet * surface.boundary_friction * film, 0.01, 0.5


def smooth(problem: ContactProblem) -> tuple[float, float, float]:
    return product(problem)[0], 0.01, 5.0


def test_a_product_adds_as_squares_thick_films_do_not_ask_for_roughness_and_nothing_leaves_nothing() -> None:
    spreads = UncertaintyInput.none(viscosity=0.1, boundary_friction=0.2, boundary_film=0.2)
    found = contact_uncertainty(CONTACT.problem(), product, spreads, OIL, jobs=1)
    reach = score_of(0.9) * math.sqrt(0.1**2 + 0.2**2 + 0.1**2)
    assert math.log(found.high / found.value) == pytest.approx(reach, rel=1e-9)
    assert math.log(found.low / found.value) == pytest.approx(-reach, rel=1e-9)
    assert {source.name for source in found.sources} == {"viscosity", "boundary_friction", "boundary_film"}
    found = contact_uncertainty(CONTACT.problem(), smooth, DEFAULT, OIL, jobs=1)
    assert {source.group for source in found.sources} == {"oil", "bulk temperature", "steel"}
    exact = contact_uncertainty(CONTACT.problem(), product, UncertaintyInput.none(), OIL, jobs=1)
    assert exact.low == exact.high == exact.value
    by_numbers = contact_uncertainty(CONTACT.problem(), smooth, UncertaintyInput.none(), None, jobs=1)
    assert "no oil card" in by_numbers.notes[0]


def test_every_input_is_moved_by_its_own_spread() -> None:
    z, problem = score_of(0.9), CONTACT.problem()
    inputs = uncertain_contact_inputs(problem, DEFAULT, OIL, 0.5)
    below = {entry.name: entry.moved(problem, -z) for entry in inputs}
    above = {entry.name: entry.moved(problem, z) for entry in inputs}
    assert above["boundary_film"].surface.boundary_film == pytest.approx(2.0 * problem.surface.film_of_contact)
    ratio = below["roughness_rms_1"].surface.roughness_rms_1 / problem.surface.roughness_rms_1
    assert ratio == pytest.approx(1.0 / 1.2)
    assert below["roughness_rms_1"].surface.roughness_rms_2 == problem.surface.roughness_rms_2
    assert above["temperature_bulk"].temperature_bulk[1] - problem.temperature_bulk[1] == pytest.approx(10.0 * z)
    for number, body in enumerate(problem.bodies):  # 30 +- 10 W/(m K)
        ratio = above["conductivity_solid"].bodies[number].thermal_conductivity / body.thermal_conductivity
        assert ratio == pytest.approx(math.exp(0.30 * z))
    thick = above["pressure_viscosity"].lubricant
    rise = float(thick.log_viscosity_ratio(0.8e9) / problem.lubricant.log_viscosity_ratio(0.8e9))
    beyond = problem.lubricant.continuation_difference(problem.line.pressure_hertz) / z
    assert rise == pytest.approx(math.exp(z * math.hypot(OIL.uncertainty.pressure_viscosity, beyond)))


def test_rq_of_a_finish_is_one_cause_and_its_waves_another() -> None:
    z, problem = score_of(0.9), CONTACT.problem()
    ground = DEFAULT.of_surface(finish="ground", finish_state="new")
    entries = {entry.name: entry for entry in uncertain_contact_inputs(problem, ground, OIL, 0.5)}
    assert not {"finish", "roughness_rms_1", "roughness_rms_2"} & set(entries)
    rough = entries["roughness_rms"].moved(problem, z).surface
    figure = Finish.load("ground", "new").roughness_rms
    for number in ("1", "2"):
        ratio = getattr(rough, f"roughness_rms_{number}") / getattr(problem.surface, f"roughness_rms_{number}")
        assert ratio == pytest.approx(figure.high / figure.value)
    assert rough.correlation_length == problem.surface.correlation_length
    longer = entries["correlation_length"].moved(problem, z).surface
    length = Finish.load("ground", "new").correlation_length
    assert longer.correlation_length / problem.surface.correlation_length == pytest.approx(length.high / length.value)
    assert longer.roughness_rms == problem.surface.roughness_rms
    apart = DEFAULT, UncertaintyInput(same_surface=False).of_surface(finish="ground")
    assert not any(spreads.shared_rms for spreads in apart)
    assert UncertaintyInput(same_surface=True).shared_rms


def test_lubricant_figures_are_scaled_one_by_one() -> None:
    oil = CONTACT.problem().lubricant
    fields = {"viscosity": "viscosity_inlet", "limiting_shear": "limiting_shear_coefficient"}
    for name in (*fields, "thermal_conductivity"):
        field = fields.get(name, name)
        assert getattr(varied_lubricant(oil, name, 1.5), field) == pytest.approx(1.5 * getattr(oil, field))
    stress = [one.shear_law.scale(np.array([0.0, 1e9])) for one in (varied_lubricant(oil, "eyring_stress", 1.5), oil)]
    np.testing.assert_allclose(stress[0], 1.5 * stress[1], rtol=1e-12)


def test_a_failed_end_is_named_and_left_out() -> None:
    def fails(problem: ContactProblem) -> tuple[float, float, float]:
        mu, error, ratio = product(problem)
        return (math.nan if problem.surface.boundary_friction > 0.1 else mu), error, ratio

    spreads = UncertaintyInput.none(boundary_friction=0.2, viscosity=0.1)
    found = contact_uncertainty(CONTACT.problem(), fails, spreads, OIL, jobs=1)
    assert [source.name for source in found.sources] == ["viscosity"]
    assert "boundary_friction" in found.notes[-1]


@pytest.mark.parametrize(
    ("surface", "ends"),
    [({"finish": "ground", "lay_angle": "25 deg"}, (1.766, 2.089)), ({"peklenik_number": 3.0}, (1.0, 9.0))],
)
def test_range_of_the_peklenik_number(monkeypatch, surface, ends):
    """That of a finish by its lay ratio of 3 to 9 at the angle of the marks, a given one by a factor of 3."""
    given: list[Any] = []
    monkeypatch.setattr("ehl.uncertainty.contact_design.contact_uncertainty", lambda *parts: given.append(parts))
    CONTACT.replace(**surface).uncertainty()
    ((problem, _, spreads, oil, *_),) = given
    inputs = {entry.name: entry for entry in uncertain_contact_inputs(problem, spreads, oil, 0.5)}
    moved = [inputs["peklenik_number"].moved(problem, z).surface for z in (-score_of(0.9), score_of(0.9))]
    assert [one.peklenik_number for one in moved] == pytest.approx(ends, abs=1e-3)
    if "finish" not in surface:
        assert {one.correlation_length for one in moved} == {problem.surface.correlation_length}


def test_skewed_inputs_hold_their_share_of_random_draws() -> None:
    """ln mu of eight inputs with quadratic responses, all skewed to the same side: 90 % within a point and a half."""
    z, rng = score_of(0.9), np.random.default_rng(1)
    slopes, bends = np.linspace(0.1, 0.5, 8), np.linspace(0.0, 0.08, 8)
    ends_of = zip(-z * slopes + z * z * bends, z * slopes + z * z * bends, strict=True)
    down, up = combined([Change(str(k), "oil", 1.0, *both) for k, both in enumerate(ends_of)])
    draws = rng.normal(size=(200_000, 8))
    drawn = draws @ slopes + draws**2 @ bends
    assert np.mean((drawn > down) & (drawn < up)) == pytest.approx(0.9, abs=0.015)
