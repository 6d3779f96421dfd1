"""Constructed reference settings of the face-hobbed pair 9x34 (see docs/machine_settings.md), as given to this project.

They come from another program on the blank of ISO 23509:2016 Annex F.4, rounded to five or six digits: that rounding
moves the flanks by a few hundredths of a micrometre in the mean, which is the tolerance below.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from reference_flanks import HEAD, HOBBED, LENGTHS, MM, hobbed_pinion

from efficiency.blanks.inputs import load_blank
from efficiency.blanks.pair import pair_blank
from efficiency.contact.contact_search import transmission
from efficiency.contact.ease_off import conjugate_points, ease_off, pinion_phase
from efficiency.contact.mesh_surface import mesh_surface
from efficiency.cutting.cutter import FLANK_SIDES, FlankSide
from efficiency.machine_settings import conjugate
from efficiency.machine_settings.conjugate import conjugate_start, fit_grid, target_flank, target_relief
from efficiency.machine_settings.fit import PARAMETERS, FitParameter, TargetFlank, fit, measure
from efficiency.machine_settings.gear import PairDimensions, cut_gear, pair_dimensions
from efficiency.machine_settings.generating import tilt_and_swivel
from efficiency.machine_settings.inputs import FlankTarget, load_targets
from efficiency.machine_settings.solve import free_settings
from ehl.common.units import ARCSEC

DEG, TARGET = np.pi / 180.0, FlankTarget()


@cache
def pair_of(offset: float = 0.03175) -> tuple[PairDimensions, dict[FlankSide, conjugate.ConjugateFlankStart]]:
    """The pair with a Formate gear and its conjugate pinion flanks; a smaller offset needs another addendum."""
    blank = load_blank("fh_hypoid_9x34").model_copy(update={"gear_cutting": "formate"})
    if offset < 0.03:
        depth = blank.depth.model_copy(update={"gear_addendum_factor": 0.18})
        blank = blank.model_copy(update={"hypoid_offset": offset, "depth": depth})
    pair = pair_dimensions(pair_blank(blank))
    gear = cut_gear(pair)
    return pair, {side: conjugate_start(pair, gear, side, fit_grid(pair)) for side in FLANK_SIDES}


def test_conjugate_start_is_the_given_one() -> None:
    machine = pair_of()[1]["concave"].flank.machine
    given = {
        "radial_setting": (105.92 * MM, 0.005 * MM), "cradle_angle": (-67.491 * DEG, 0.0005 * DEG),
        "tilt": (26.788 * DEG, 0.0005 * DEG), "swivel": (-21.647 * DEG, 0.0005 * DEG),
        "blank_offset": (31.75 * MM, 0.005 * MM), "sliding_base": (21.801 * MM, 0.001 * MM),
        "roll_ratio": (3.7778, 5e-5), "machine_root_angle": (0.0, 1e-12),
    }  # fmt: skip
    for name, (value, half_digit) in given.items():
        assert getattr(machine, name) == pytest.approx(value, abs=half_digit), name


def test_gear_settings_are_the_given_ones() -> None:
    gear = cut_gear(pair_of()[0])
    for name, given in HOBBED["settings"].items():
        unit, half_digit = (MM, 2e-5 if name == "radial_setting" else 1e-5) if name in LENGTHS else (DEG, 5e-5)
        assert getattr(gear.concave.machine, name) == pytest.approx(given * unit, abs=half_digit * unit), name
    # the blade phase turns the flank by phase times groups over teeth; half a slot was given
    for side, turned in (("concave", -HEAD["phase_rotation"]), ("convex", HEAD["phase_rotation"])):
        flank = gear.flank(side)
        assert flank.blade.blade_angle == pytest.approx(HEAD[f"alpha_{side}"] * DEG, abs=5e-5 * DEG)
        assert -flank.blade.phase * flank.index_ratio == pytest.approx(turned, abs=1e-5)


@pytest.mark.parametrize(
    ("side", "rms", "largest", "missing", "together"),
    [("convex", 1.27, 6.8, 0, 13.75), ("concave", 1.45, 5.8, 3, 14.37)],
)
def test_given_settings(side: FlankSide, rms: float, largest: float, missing: int, together: float) -> None:
    pair, starts = pair_of()
    gear, grid, start = cut_gear(pair), fit_grid(pair), starts[side]
    flank = replace(hobbed_pinion(side), blank=pair.pinion)
    # the rotation of the flank about its axis is not part of the given settings: the best one is taken
    mate = gear.flank(conjugate.opposite(side))
    middle = mate.solve(np.array([grid.u[67]]), np.array([grid.h[67]]))[0]
    phase = pinion_phase(conjugate_points(middle, pair.assembly), flank)
    parameters = ease_off(start.points, flank, phase)[1]
    relief = target_relief(TARGET, grid.x, grid.y)
    wanted = TargetFlank(flank, phase, start.points.position, start.points.normal, relief, parameters)
    for _ in range(6):
        now = measure(wanted, flank, phase, parameters)
        position, normal = wanted.position, wanted.normal
        arm = (position[0] * normal[1] - position[1] * normal[0])[now.found]
        phase -= float(arm @ now.residual[now.found] / (arm @ arm))
    assert now.rms * 1e6 == pytest.approx(rms, abs=0.05)
    assert now.largest * 1e6 == pytest.approx(largest, abs=0.8)
    assert np.sum(~now.found) == pytest.approx(missing, abs=1)

    mesh = transmission(mesh_surface(mate, flank, pair.assembly))
    assert mesh.peak_to_peak / ARCSEC == pytest.approx(together, abs=0.3)


def target_flanks(offset: float, root_weight: float) -> list[TargetFlank]:
    pair, starts = pair_of(offset)
    grid = fit_grid(pair)
    relief = target_relief(TARGET, grid.x, grid.y)
    return [target_flank(pair, start, relief, root_weight) for start in starts.values()]


@pytest.mark.parametrize(("offset", "convex", "concave"), [(0.03175, 0.51, 0.48), (0.010, 0.50, 0.48)])
def test_setting_per_flank_reaches_the_given_residuals(offset: float, convex: float, concave: float) -> None:
    tilt = FitParameter("machine", "tilt", 0.01)
    names = ("radial_setting", "point_radius", "blade_angle", "curvature", "phase")
    radial, *blade = (PARAMETERS[name] for name in names)
    found = {}
    for wanted in target_flanks(offset, 0.0):
        # tilt alone is free, its direction is held: no free axis
        flank = tilt_and_swivel(wanted.flank)
        shift = np.array([[0.0], [flank.index_zero - wanted.flank.index_zero], [0.0]])
        held = replace(wanted, flank=flank, parameters=wanted.parameters + shift)
        result = fit([held], (), (radial, tilt, *blade))
        found[flank.side] = result.rms * 1e6
        assert result.iterations < 12
    assert found["convex"] == pytest.approx(convex, abs=0.02)
    assert found["concave"] == pytest.approx(concave, abs=0.02)


@pytest.mark.parametrize(("offset", "given"), [(0.03175, (1.27, 1.45)), (0.010, (1.21, 2.44))])
def test_one_setting_for_both_flanks_is_no_worse_than_given(offset: float, given: tuple[float, float]) -> None:
    # both flanks and the root are weighed against each other: only the sum of squares can be compared
    free = free_settings(load_targets("fh_hypoid_9x34"))
    result = fit(target_flanks(offset, 0.02), free.common, free.own)
    here = np.array([flank.rms * 1e6 for flank in result.flanks])
    assert np.hypot(*here) < np.hypot(*given) + 0.05
    assert result.iterations < 20
    for flank in result.flanks:
        assert np.abs(flank.root_error).max() < 0.5 * MM
