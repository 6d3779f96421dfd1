"""Lay of cut flanks: marks of both members at the contact line, texture of finishes there, finish of a design."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refuses

import efficiency
from efficiency.contact.mesh_surface import undirected
from efficiency.design.design import Design
from efficiency.loss.kinematics import Operation
from ehl.common.validation import validate
from ehl.surface.finish import Figure, Finish, lay_seen
from ehl.uncertainty.result import score_of


@pytest.fixture(scope="module")
def pair():
    return efficiency.load("fm_hypoid_13x42")


@pytest.fixture(scope="module")
def loaded(pair):
    return pair.mesh(positions=4, points_per_line=9).load().grids.fine.loaded


def test_marks_of_a_formate_gear_are_circles_about_the_cutter(pair):
    flank = pair.design.flanks().gear["convex"]
    points, found = flank.solve(np.linspace(-0.01, 0.01, 5), np.zeros(5))
    assert found.all()
    marks = flank.marks(points)
    marks = marks / np.linalg.norm(marks, axis=0)
    np.testing.assert_allclose(np.sum(marks * points.normal, axis=0), 0.0, atol=1e-9)
    # the same point half a degree further round the cutter lies in that direction
    ahead, _, _ = flank.sweep(points.parameters + np.array([[0.0], [1e-6], [0.0]]))
    step = (ahead - points.position) / np.linalg.norm(ahead - points.position, axis=0)
    np.testing.assert_allclose(np.abs(np.sum(step * marks, axis=0)), 1.0, atol=1e-6)


def test_marks_run_along_the_teeth_of_both_members(loaded):
    # tooth traces of mating flanks touch: seen from opposite sides, marks of both make opposite angles with the line
    off = np.degrees(undirected(loaded["lay_pinion"] + loaded["lay_gear"]))
    assert np.max(np.abs(off)) < 15.0
    # contact lines of a hypoid pair run at an angle to its teeth
    assert 10.0 < np.median(np.degrees(np.abs(loaded["lay_pinion"]))) < 60.0


def test_texture_of_finishes(loaded):
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


def test_finish_in_a_design(pair):
    content = pair.design.model_dump(exclude_unset=True)
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


def test_the_range_of_the_lay_ratio_is_that_of_the_texture(pair, loaded):
    """Grinding marks are 3 to 9 times as long as wide: texture of both flanks, at every point of the mesh."""
    operation = pair.design.running(100.0, 363.15)
    lay = loaded["lay_pinion"], loaded["lay_gear"]
    texture = operation.texture(*lay)
    for side, ratio in ((-1.0, 3.0), (1.0, 9.0)):
        found = operation.uncertainty.lay_moved(*texture, side * score_of(0.9))
        ground = replace(operation.finish_pinion, lay_ratio=Figure(value=ratio, low=ratio, high=ratio))
        other = replace(operation, finish_pinion=ground, finish_gear=ground).texture(*lay)
        free = (texture[1] > 1.0 / 3.0) & (other[1] > 1.0 / 3.0)
        assert free.mean() > 0.9
        np.testing.assert_allclose(found[0][free], other[0][free], rtol=1e-6)
        np.testing.assert_allclose(found[1][free], other[1][free], rtol=1e-6)
