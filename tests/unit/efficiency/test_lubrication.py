"""Film, temperatures, rolling traction against independent computations; lay of cut flanks and finishes of designs."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from refusals import refuses
from samples import AXLE_OIL as OIL
from samples import BEVEL as DESIGN
from samples import OPERATION, STEEL, tiny_mesh

from efficiency.contact.mesh_surface import undirected
from efficiency.design.design import Design, load_design
from efficiency.loss import lubrication
from efficiency.loss.kinematics import LoadedPoints, Operation
from efficiency.pair import GearPair
from ehl.common.validation import validate
from ehl.inputs import ContactProblem, ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.rough.dry_limit import flash_of_rubbing
from ehl.solve import solve_contact
from ehl.state import ContactState
from ehl.surface.finish import Figure, Finish, lay_seen
from ehl.uncertainty.result import score_of
from regression.friction.conditions import conditions_of
from regression.friction.models import ConstantFriction

BODIES = (STEEL, STEEL)
HYPOID = load_design("fm_hypoid_13x42")
MOTIONS = [(1e9, 5.0, 0.5, 5.0), (1.8e9, 2.0, 0.3, 0.0), (1e9, 20.0, 1.0, 10.0)]


def point(pressure: float, speed: float, slide: float, along: float, **more: float) -> tuple[ContactState, LineContact]:
    motion = {"pressure_hertz": pressure, "radius_equivalent": 0.015, "effective_modulus": 226e9}
    motion |= {"speed_entrainment": speed, "slide_to_roll": slide, "speed_sliding_lengthwise": along}
    state = ContactState.of(**{name: [value] for name, value in motion.items()}, temperature_oil=363.15, **more)
    return state, LineContact.from_pressure(**motion)


@pytest.mark.parametrize("motion", MOTIONS)
def test_blok_flash_is_that_of_the_moving_heat_source(motion: tuple[float, float, float, float]) -> None:
    """Against Jaeger's band sources on a grid; 1.11 is printed with three digits."""
    state, contact = point(*motion)
    rise = flash_of_rubbing(contact, 0.08, BODIES, (363.15, 363.15)) - 363.15
    assert lubrication.surface_temperature(state, np.array([0.08]), BODIES)[0] - 363.15 == pytest.approx(rise, rel=5e-3)


def test_heat_goes_to_the_faster_surface_and_both_bulks_count() -> None:
    state, _ = point(1e9, 4.0, 1.2, 0.0, temperature_bulk_1=400.0, temperature_bulk_2=370.0)
    # u1 = 6.4, u2 = 1.6 m/s: effusivities times sqrt(u) as 2 to 1, so that two thirds of the heat go to body 1
    np.testing.assert_allclose(lubrication.surface_temperature(state, np.zeros(1), BODIES), 390.0)


@pytest.mark.parametrize(("pressure", "speed"), [(1e8, 1.0), (3e8, 10.0), (1e9, 1.0), (1.8e9, 10.0)])
def test_rolling_traction_formula_against_the_solver(pressure: float, speed: float) -> None:
    _, contact = point(pressure, speed, 0.0, 0.0)
    lubricant = OIL.at(363.15)
    model = ModelInput(accuracy="fast", thermal="off")
    solved = solve_contact(ContactProblem(contact, lubricant, SurfaceInput(), model, BODIES, (363.15, 363.15)))
    scale = contact.effective_modulus * contact.radius_equivalent
    formula = lubrication.biboulet_houpert_2010(
        np.array([2.0 * lubricant.viscosity_inlet * speed / scale]), np.array([contact.load_per_length / scale])
    )
    assert 0.8 < formula[0] / solved.rolling_traction < 1.05


def test_rolling_traction_has_both_limits() -> None:
    speed = np.array([1e-11])
    # light loads: sqrt(U W); heavy ones: U^0.75, whatever the load
    light, heavy = (lubrication.biboulet_houpert_2010(speed, np.array([load])) * load for load in (1e-8, 1e-3))
    np.testing.assert_allclose(light, 1.42 * np.sqrt(speed * 1e-8), rtol=1e-3)
    np.testing.assert_allclose(heavy, 1.47 * speed**0.75, rtol=1e-9)


def loaded(state: ContactState) -> LoadedPoints:
    return LoadedPoints(state, np.array([100.0]), state.speed_sliding, np.zeros(1, np.int64), np.zeros(1, np.int64))


def test_solved_contacts_bring_their_own_lubrication() -> None:
    state, _ = point(1e9, 3.0, 0.2, 0.0, roughness_rms_1=3e-7, roughness_rms_2=4e-7)
    mu, one = np.array([0.05]), np.ones(1)
    given = lubrication.SolvedFriction(mu, mu, mu, np.zeros(1, np.int8), 1e-7 * one, 0.5 * one, 400.0 * one, 1e-4 * one)
    own = lubrication.local_lubrication(loaded(state), given, conditions_of(state, OIL), BODIES)
    assert (own.source, own.film_central[0], own.film_ratio[0]) == ("ehl", 1e-7, 0.5)
    plain = ConstantFriction(0.05).mu(state, oil=OIL)
    formula = lubrication.local_lubrication(loaded(state), plain, conditions_of(state, OIL), BODIES)
    assert formula.source == "formula"
    # the film ratio is that of the isothermal film, the film itself thinner by the heat of the inlet
    assert 0.8 < formula.film_central[0] / (formula.film_ratio[0] * 5e-7) < 1.0


SIZE = (91.5e-3, 14e-3)


def warm_operation(loss: Callable[[Operation], float]) -> Operation:
    """The operation in balance with a loss."""
    run = lubrication.warming(OPERATION, SIZE, 1.0)
    trial = next(run)
    while True:
        try:
            trial = run.send(loss(trial))
        except StopIteration as end:
            found: Operation = end.value
            return found


def test_formula_by_hand() -> None:
    """FZG type C: 0.3 kW over 91.5 mm times 14 mm: 7400 (2.342e-4)^0.72/1.2 = 15.0 K, dip lubrication."""
    rise = lubrication.iso_15144_bulk_rise(300.0, *SIZE)
    assert rise == pytest.approx(7400.0 * (0.3 / (91.5 * 14.0)) ** 0.72 / 1.2, rel=1e-12)
    assert rise == pytest.approx(15.0, rel=1e-3)
    assert lubrication.iso_15144_bulk_rise(300.0, *SIZE, 0.2) == pytest.approx(0.2 * rise)
    assert lubrication.iso_15144_bulk_rise(0.0, *SIZE) == 0.0


@pytest.mark.parametrize("slope", [-0.02, 0.0, 0.02])
def test_temperature_and_loss_are_in_balance(slope: float) -> None:
    """A loss that changes by a share for each kelvin of the teeth."""

    def loss(at: Operation) -> float:
        return 400.0 * (1.0 + slope * (at.bulk[0] - at.temperature))

    found = warm_operation(loss)
    rise = found.bulk[0] - found.temperature
    assert rise == pytest.approx(lubrication.iso_15144_bulk_rise(loss(found), *SIZE), abs=0.05)
    assert found.bulk[0] == found.bulk[1] == found.inlet


def test_a_loss_that_runs_away_ends_at_the_hottest_oil() -> None:
    found = warm_operation(lambda at: 400.0 * 1.2 ** (at.bulk[0] - at.temperature))
    assert found.bulk[0] == pytest.approx(473.15, abs=0.1)


@pytest.mark.parametrize("friction", ["constant:0.05", "75w90", "ehl:smooth"])
def test_teeth_are_warm_by_default_and_as_the_oil_on_request(friction: str) -> None:
    loaded = tiny_mesh().load(100.0)
    warm, cold = (loaded.efficiency(friction, bulk=bulk) for bulk in (None, "oil"))
    assert cold.conditions.temperature_bulk_pinion == cold.conditions.temperature
    rise = warm.conditions.temperature_bulk_pinion - warm.conditions.temperature
    size = sum(loaded.mesh.pitch.radius), DESIGN.common_face_width
    # of the loss without friction in the torque balance, on the coarse grid, of a formula where contacts are solved
    within = 0.3 if friction == "ehl:smooth" else 0.06
    assert rise == pytest.approx(lubrication.iso_15144_bulk_rise(warm.power_loss, *size), rel=within)
    with refuses("bulk"):
        loaded.efficiency(friction, bulk="hot")  # type: ignore[arg-type]


def test_a_bulk_temperature_at_the_end_of_the_oil_laws_has_a_note() -> None:
    loaded = tiny_mesh().load(100.0)
    hot, cold = (loaded.efficiency("constant:0.05", temperature=473.0, bulk=bulk) for bulk in (None, "oil"))
    assert hot.conditions.temperature_bulk_pinion == pytest.approx(473.15, abs=0.1)
    assert len(set(hot.notes) - set(cold.notes)) == 1


def test_lubrication_of_the_design_counts() -> None:
    cooling = validate(lubrication.CoolingInput, {"lubrication": "submerged"})
    rises = []
    for design in (DESIGN, DESIGN.model_copy(update={"cooling": cooling})):
        result = GearPair(design).mesh("drive", 4, 9).load(100.0).efficiency("constant:0.05")
        rises.append(result.conditions.temperature_bulk_pinion - result.conditions.temperature)
    assert rises[1] / rises[0] == pytest.approx(0.2, rel=1e-3)
    with refuses("lubrication"):
        validate(lubrication.CoolingInput, {"lubrication": "dry"})


def test_marks_of_a_formate_gear_are_circles_about_the_cutter():
    flank = HYPOID.flanks().gear["convex"]
    points, found = flank.solve(np.linspace(-0.01, 0.01, 5), np.zeros(5))
    assert found.all()
    marks = flank.marks(points)
    marks = marks / np.linalg.norm(marks, axis=0)
    np.testing.assert_allclose(np.sum(marks * points.normal, axis=0), 0.0, atol=1e-9)
    # the same point half a degree further round the cutter lies in that direction
    ahead, _, _ = flank.sweep(points.parameters + np.array([[0.0], [1e-6], [0.0]]))
    step = (ahead - points.position) / np.linalg.norm(ahead - points.position, axis=0)
    np.testing.assert_allclose(np.abs(np.sum(step * marks, axis=0)), 1.0, atol=1e-6)


def test_marks_run_along_the_teeth_of_both_members():
    lines = tiny_mesh(design=HYPOID.name).load().grids.fine.loaded
    # tooth traces of mating flanks touch: seen from opposite sides, marks of both make opposite angles with the line
    off = np.degrees(undirected(lines["lay_pinion"] + lines["lay_gear"]))
    assert np.max(np.abs(off)) < 15.0
    # contact lines of a hypoid pair run at an angle to its teeth
    assert 10.0 < np.median(np.degrees(np.abs(lines["lay_pinion"]))) < 60.0


def test_texture_of_finishes():
    ground = Finish.load("ground")
    rms = ground.roughness_rms.value
    both = Operation(100.0, 363.15, rms, rms, finish_pinion=ground, finish_gear=ground)
    angle = np.array([0.0, 0.5, 1.5])
    length, gamma = both.texture(angle, angle)
    expected = lay_seen(ground.correlation_length.value, ground.lay_ratio.value, angle)
    np.testing.assert_allclose(length, expected[0])
    np.testing.assert_allclose(gamma, np.maximum(expected[1], 1.0 / 3.0))
    # twice the Rq of the same finish: waves longer by 2^(2/3)
    twice = replace(both, roughness_rms_pinion=2.0 * rms, roughness_rms_gear=2.0 * rms)
    np.testing.assert_allclose(twice.texture(angle, angle)[0], length * 2.0 ** (2.0 / 3.0))
    given = replace(both, correlation_length=33e-6, peklenik_number=4.0).texture(angle, angle)
    np.testing.assert_array_equal(np.transpose(given), [[33e-6, 4.0]] * 3)
    # without finish it is isotropic, also of smooth flanks
    np.testing.assert_allclose(Operation(100.0, 363.15, 0.4e-6, 0.4e-6).texture(angle, angle)[0], 16e-6)
    np.testing.assert_allclose(Operation(100.0, 363.15).texture(angle, angle)[1], 1.0)


def test_finish_in_a_design():
    content = HYPOID.model_dump(exclude_unset=True)
    for member in ("pinion", "gear"):
        content[member] = {k: v for k, v in content[member].items() if k not in ("roughness_rms", "finish")}
    content |= {"pinion": content["pinion"] | {"finish": "lapped", "finish_state": "new"}}
    design = validate(Design, content)
    assert design.pinion.roughness_rms == Finish.load("lapped", "new").roughness_rms.value
    assert design.gear.roughness_rms == 0.0
    assert design.running(100.0, 363.15).finish_pinion == Finish.load("lapped", "new")
    given = content["gear"] | {"finish": "ground", "roughness_rms": "0.3 um"}
    own = validate(Design, content | {"gear": given})
    assert own.gear.roughness_rms == pytest.approx(0.3e-6)
    with refuses("gear.finish"):
        validate(Design, content | {"gear": content["gear"] | {"finish": "polished"}})


def test_the_range_of_the_lay_ratio_is_that_of_the_texture():
    """Grinding marks are 3 to 9 times as long as wide: texture of both flanks, at every point of the mesh."""
    operation, lines = HYPOID.running(100.0, 363.15), tiny_mesh(design=HYPOID.name).load().grids.fine.loaded
    lay = lines["lay_pinion"], lines["lay_gear"]
    texture = operation.texture(*lay)
    for side, ratio in ((-1.0, 3.0), (1.0, 9.0)):
        found = operation.uncertainty.lay_moved(*texture, side * score_of(0.9))
        ground = replace(operation.finish_pinion, lay_ratio=Figure(value=ratio, low=ratio, high=ratio))
        other = replace(operation, finish_pinion=ground, finish_gear=ground).texture(*lay)
        free = (texture[1] > 1.0 / 3.0) & (other[1] > 1.0 / 3.0)
        assert free.mean() > 0.9
        np.testing.assert_allclose(found[0][free], other[0][free], rtol=1e-6)
        np.testing.assert_allclose(found[1][free], other[1][free], rtol=1e-6)
