"""Efficiency with solved contacts of which some fail, and the texture of the flanks on its way to the contacts."""

import json
import math
import tomllib
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from refusals import refuses

from efficiency.conditions.duty import DutyRow
from efficiency.design.design import Design, load_design
from efficiency.loss import ehl_friction as module
from efficiency.loss.efficiency import LoadedGrids, load_grids, mesh_efficiency
from efficiency.loss.ehl_friction import EhlFriction, ehl_friction
from efficiency.loss.kinematics import Operation
from efficiency.loss.power_loss import friction_along_mesh, loss_by_region
from efficiency.mesh import Mesh
from efficiency.output.tables import efficiency_table, result_table
from efficiency.pair import GearPair
from efficiency.studies.parameter_study import Levels, run_study
from ehl.common.data import reason_text
from ehl.common.errors import InputError
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem
from regression.formula import friction_model
from regression.friction.conditions import Conditions
from regression.friction.models import ConstantFriction, FrictionEstimate

DESIGN = load_design("fm_spiral_bevel_14x39")
TEXTURED = DESIGN.model_copy(
    update={"surface": DESIGN.surface.model_copy(update={"correlation_length": 60e-6, "peklenik_number": 4.0})}
)
PAIR = GearPair(TEXTURED)
OIL = Oil.load("75w90")
OPERATION = Operation(125.0, 363.15, 0.4e-6, 0.4e-6)
COARSE = (4, 9)


@pytest.fixture(scope="module")
def loaded() -> LoadedGrids:
    return load_grids(Mesh.of(DESIGN, "drive", 6, 15, keep=True).grids, 200.0)


def solver(fails: Any) -> Any:
    """Friction falling with pressure; contacts that `fails` names fail."""

    def solve(problem: ContactProblem) -> Any:
        contact = problem.line
        if fails(contact):
            return SimpleNamespace(status="failed", reason="film_jump")
        return SimpleNamespace(
            status="converged",
            friction_coefficient=0.06 - 0.02 * contact.pressure_hertz / 1e9,
            friction_error=0.03,
            statistical_error=0.02,
            film_central=1e-7,
            film_ratio=0.5,
            temperature_flash=380.0,
            rolling_traction=1e-4,
        )

    return solve


def model(**changes: Any) -> EhlFriction:
    return replace(ehl_friction("ehl"), points=60, tolerance=0.0, jobs=1, **changes)


def test_failed_contacts_are_counted_and_an_error(loaded: LoadedGrids, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "solve_contact", solver(lambda contact: False))
    sound = mesh_efficiency(loaded, model(), OIL, OPERATION)
    pressure = np.sort(sound.points.state.pressure_hertz)
    hard = float(pressure[-8])
    monkeypatch.setattr(module, "solve_contact", solver(lambda contact: contact.pressure_hertz >= hard))
    result = mesh_efficiency(loaded, model(), OIL, OPERATION)
    assert (sound.solution.contacts, sound.solution.contacts_failed) == (60, {})
    assert result.status == "converged"
    assert result.solution.contacts == 60
    failed = result.solution.contacts_failed["film_jump"]
    assert 0 < failed < 6
    assert result.friction_range.flags["predicted"] > 0
    assert result.friction_range.flags["not_converged"] == 0
    assert result.outside_range_share == 0.0
    share = result.friction_range.flag_shares["predicted"]
    assert 0.0 < share < 0.1
    assert any(f"{failed} of 60 contacts not solved" in note for note in result.notes)
    assert result.efficiency == pytest.approx(sound.efficiency, abs=2e-5)
    assert result.efficiency_lower < sound.efficiency < result.efficiency_upper
    assert result.efficiency_upper - result.efficiency_lower > sound.efficiency_upper - sound.efficiency_lower
    # every share is of all the loss
    assert sum(result.friction_range.flag_shares.values()) == pytest.approx(1.0)
    assert loss_by_region(result).sum() == pytest.approx(1.0)
    assert np.all(np.isfinite(friction_along_mesh(result)))
    assert 0.0 < result.edges.loss_share < 1.0
    (rows,) = result_table(result).records()
    assert rows["contacts"] == 60
    assert rows[f"contacts failed {reason_text('film_jump')}"] == failed
    assert json.loads(json.dumps(result.to_dict()))["solution"]["contacts_failed"] == {"film_jump": failed}
    (shown,) = efficiency_table(result).records()
    assert (shown["contacts"], shown["failed"]) == (60, failed)
    assert shown["predicted_share"] == share
    (exact,) = efficiency_table(mesh_efficiency(loaded, ConstantFriction(0.05), OIL, OPERATION)).records()
    assert "contacts" not in exact


def test_where_too_much_failed_is_no_efficiency(loaded: LoadedGrids, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "solve_contact", solver(lambda contact: contact.pressure_hertz > 0.9e9))
    result = mesh_efficiency(loaded, model(), OIL, OPERATION)
    assert (result.status, result.reason) == ("failed", "friction_not_converged")
    assert math.isnan(result.efficiency)
    assert math.isnan(result.efficiency_lower)
    assert math.isnan(result.edges.loss_share)
    assert np.all(np.isnan(loss_by_region(result)))
    assert sum(result.friction_range.flag_shares.values()) == pytest.approx(1.0)
    assert result.friction_range.flag_shares["not_converged"] > module.MAX_FAILED
    monkeypatch.setattr(module, "solve_contact", solver(lambda contact: True))
    failed = mesh_efficiency(loaded, model(), OIL, OPERATION)
    assert failed.reason == "friction_not_converged"
    (shown,) = efficiency_table(failed).records()
    assert (shown["contacts"], shown["failed"], shown["film_ratio_min"]) == (60, 60, None)


def test_error_of_solved_contacts_is_that_of_their_mean(loaded: LoadedGrids, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "solve_contact", solver(lambda contact: False))
    result = mesh_efficiency(loaded, model(), OIL, OPERATION)
    contacts = (1.0 - result.efficiency) * result.friction.mean_error  # type: ignore[attr-defined]
    assert result.errors.contacts == pytest.approx(contacts)
    mesh = result.errors.positions + result.errors.points
    assert result.efficiency_error == pytest.approx(contacts + mesh)
    # what is no chance, of every contact; what is chance is averaged
    method = np.sqrt(0.03**2 - 0.02**2)
    assert method < result.friction.mean_error < 1.1 * method  # type: ignore[attr-defined]
    # what is not known of the inputs is another number
    assert result.efficiency_lower < result.efficiency < result.efficiency_upper


def test_the_peklenik_number_is_told_where_friction_does_not_know_it(loaded: LoadedGrids) -> None:
    ground = replace(OPERATION, peklenik_number=5.0)
    for name in ("xu_kahraman_2007", "schlenk_1994"):
        notes = mesh_efficiency(loaded, friction_model(name), OIL, ground).notes
        assert any("Peklenik number has no effect" in note for note in notes)
        assert not any(
            "Peklenik" in note for note in mesh_efficiency(loaded, friction_model(name), OIL, OPERATION).notes
        )
    # the data of this one vary the lay, and marks across the motion rub less
    by_formula = mesh_efficiency(loaded, friction_model("75w90"), OIL, ground)
    assert not any("Peklenik" in note for note in by_formula.notes)
    isotropic = mesh_efficiency(loaded, friction_model("75w90"), OIL, OPERATION)
    assert by_formula.friction_coefficient_mean < 0.98 * isotropic.friction_coefficient_mean
    assert ehl_friction("ehl").uses_texture
    assert not ehl_friction("ehl:smooth").uses_texture


def test_texture_in_the_design_file_and_its_limits() -> None:
    assert (DESIGN.surface.correlation_length, DESIGN.surface.peklenik_number) == (None, None)
    content = DESIGN.model_dump(exclude_none=True)
    given = content | tomllib.loads('[surface]\ncorrelation_length = "45 um"\npeklenik_number = 3')
    assert validate(Design, given).surface.correlation_length == pytest.approx(45e-6)
    for wrong in ({"correlation_length": "0.1 um"}, {"peklenik_number": 0.1}, {"rq": 1}):
        with pytest.raises(InputError, match=r"surface\."):
            validate(Design, content | {"surface": wrong})
    with refuses("correlation_length"):
        Operation(100.0, 363.15, correlation_length=1e-9)
    with refuses("peklenik_number"):
        Operation(100.0, 363.15, peklenik_number=0.0)


class Witness(ConstantFriction):
    seen: ClassVar[list[tuple[float, ...]]] = []

    def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
        # points of several conditions may be evaluated together
        self.seen += set(zip(conditions["correlation_length"], conditions["peklenik_number"], strict=True))
        return super().evaluate(conditions, oil)


def test_texture_reaches_points_maps_duty_and_study() -> None:
    witness = Witness(0.05)
    witness.seen.clear()
    rows = [DutyRow(200.0, 125.0, 363.15, 1.0)]
    result = PAIR.at(witness, grid=COARSE)
    assert (result.conditions.correlation_length, result.conditions.peklenik_number) == (60e-6, 4.0)
    PAIR.over(witness, grid=COARSE, torque=[200.0], speed=[100.0])
    PAIR.duty(rows, witness, grid=COARSE)
    levels = Levels((200.0,), (125.0,), (363.15,), (2e-7,), E=(), P=(), G=(), shaft_angle_error=())
    assert run_study([TEXTURED], witness, levels, grid=COARSE).points[0].reason == ""
    assert set(witness.seen) == {(60e-6, 4.0)}
    assert len(witness.seen) >= 4
    smooth, long = PAIR.over("75w90", grid=COARSE, correlation_length=[2e-5, 1e-4]).results
    assert smooth.efficiency != long.efficiency
    state = PAIR.duty_points(rows, grid=COARSE)[0].state
    assert np.all(state.correlation_length == 60e-6)
    found = PAIR.over(witness, grid=COARSE, correlation_length=[2e-5, 1e-4])
    assert found.shape == (2,)
    assert set(witness.seen) == {(60e-6, 4.0), (2e-5, 4.0), (1e-4, 4.0)}


def test_texture_reaches_the_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = set()

    def solve(problem: ContactProblem) -> Any:
        seen.add((problem.surface.correlation_length, problem.surface.peklenik_number))
        return solver(lambda contact: False)(problem)

    monkeypatch.setattr(module, "solve_contact", solve)
    PAIR.at(model(), grid=COARSE)
    assert seen == {(60e-6, 4.0)}
