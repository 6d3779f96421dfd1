"""A design file: its fields, settings that cut no flank; blank coordinates, patches and curves of the geometry."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import fails, refuses
from samples import GEAR_BLANK as BLANK
from scipy.interpolate import Akima1DInterpolator, CubicSpline

from efficiency.contact.chebyshev import Patch, akima_curve, cubic_spline
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.tooth_grid import tooth_shapes
from efficiency.design.design import load_design
from ehl.common.data import data_path
from ehl.common.errors import InputError

TEXT = data_path("designs", "fm_spiral_bevel_14x39.toml").read_text(encoding="utf-8")


def changed(folder: Path, old: str, new: str) -> Path:
    assert TEXT.count(old) >= 1
    path = folder / "pair.toml"
    path.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    return path


def test_shipped_design_by_name_and_by_path(tmp_path: Path) -> None:
    design = load_design("fm_spiral_bevel_14x39")
    assert design == load_design(changed(tmp_path, "name = ", "name = "))
    assert design.operation.temperature == pytest.approx(363.15)
    assert design.gear.convex.machine.radial_setting == pytest.approx(0.09485354936)  # type: ignore[union-attr]
    for side, expected in (("drive", ["concave", "convex"]), ("coast", ["convex", "concave"])):
        assert [flank.blade.side for flank in design.flanks().mating(side)] == expected


RADIUS = 'point_radius = "114.47823644967657 mm"'
MISTAKES = [
    (RADIUS, "point_radius = nan", "pinion.concave.cutter.point_radius"),
    ('face_width = "25.4 mm"', 'face_width = "180 mm"', "pinion.blank.face_width"),
    ('face_width = "25.4 mm"', 'face_width = "100 mm"', "pinion.blank.face_width"),  # no tooth left at the toe
    ('face_width = "25.4 mm"', 'face_width = "0.0254 mm"', "pinion.blank.face_width"),
    ("teeth = 14", "teeth = 41", "pinion.blank.teeth"),
    ('hand = "left"', 'hand = "right"', "pinion.concave.machine.cradle_angle"),
    ('process = "generated"', 'process = "hand filed"', "pinion.concave.machine.process"),
    ('type = "face_milling"', 'type = "face_hobbing"', "pinion.concave.cutter.cutter_radius"),
    ('type = "face_milling"', "", "pinion.concave.cutter.type"),
    ('torque = "300 N m"', 'torque = "-300 N m"', "operation.torque"),
    ("E = 0.0", 'E = "5 mm"', "assembly.misalignment.E"),
    ('shaft_angle = "90 deg"\n', "", "assembly.shaft_angle"),
]


@pytest.mark.parametrize(("old", "new", "field"), MISTAKES)
def test_bad_input_names_its_field(tmp_path: Path, old: str, new: str, field: str) -> None:
    with refuses(field):
        load_design(changed(tmp_path, old, new))


def test_settings_that_cut_no_flank_are_refused_with_a_reason(tmp_path: Path) -> None:
    # a cradle twice as far out leaves the cutter beside the blank
    path = changed(tmp_path, 'radial_setting = "96.01838217906185 mm"', 'radial_setting = "300 mm"')
    with fails("flank"):
        flank_pair(load_design(path).flanks(), "drive")


@pytest.mark.parametrize(("old", "new"), [("115.40012999999999 mm", "121 mm"), ("113.19987 mm", "107.5 mm")])
def test_flanks_that_cross_are_told_by_member_and_place(tmp_path: Path, old: str, new: str) -> None:
    with pytest.raises(InputError, match=r"(pinion|gear): tooth thickness at the (tip|root)"):
        tooth_shapes(load_design(changed(tmp_path, old, new)).flanks())


@given(st.floats(-0.0127, 0.0127), st.floats(-0.006, 0.002), st.floats(-0.02, 0.02))
def test_blank_coordinates_round_trip(u: float, h: float, apex: float) -> None:
    blank = BLANK.model_copy(update={"pitch_apex_beyond_crossing": apex})
    back = blank.coordinates(*blank.axial(np.array([u]), np.array([h])))
    np.testing.assert_allclose(np.real(back)[:, 0], [u, h], atol=1e-15)


@settings(max_examples=20)
@given(st.integers(0, 2), st.integers(0, 2), st.floats(-0.9, 1.9), st.floats(0.1, 0.9))
def test_patch_is_exact_for_polynomials_and_their_derivatives(du: int, dv: int, u: float, v: float) -> None:
    nodes_u, nodes_v = Patch.nodes((-1.0, 2.0), (0.0, 1.0), (6, 5))
    fields = {"f": nodes_u**3 * nodes_v**2 + nodes_v, "one": 0.0 * nodes_u + 1.0}
    patch = Patch.fit((-1.0, 2.0), (0.0, 1.0), (6, 5), fields)
    up = [u**3, 3.0 * u**2, 6.0 * u][du]
    vp = [v**2, 2.0 * v, 2.0][dv]
    extra = [v, 1.0, 0.0][dv] if du == 0 else 0.0
    value = patch(np.array([u]), np.array([v]), ("f", "one"), du=du, dv=dv)[:, 0]
    np.testing.assert_allclose(value, [up * vp + extra, float(du == 0 and dv == 0)], atol=1e-11)


def test_patch_tail_tells_resolved_from_unresolved_fields() -> None:
    u, v = Patch.nodes((0.0, 1.0), (0.0, 1.0), (10, 10))
    patch = Patch.fit((0.0, 1.0), (0.0, 1.0), (10, 10), {"smooth": np.exp(u * v), "kink": np.abs(u - 0.4) + v})
    assert patch.tail["smooth"] < 1e-7
    assert patch.tail["kink"] > 1e-3


def test_curves_are_those_of_scipy() -> None:
    rng = np.random.default_rng(1)
    x = np.cumsum(rng.uniform(0.2, 2.0, 30))
    # a flat part, a straight part and a kink among the rest
    y = np.concatenate([rng.normal(size=15), np.zeros(5), 2.0 * x[20:26] - 3.0, rng.normal(size=4)])
    at = np.append(np.linspace(x[0] - 0.5, x[-1] + 0.5, 500), x)
    np.testing.assert_allclose(akima_curve(x, y, at), Akima1DInterpolator(x, y, method="makima")(at), atol=1e-13)
    assert np.all(akima_curve(x, y, np.linspace(x[16], x[18], 9)) == 0.0)
    for n in (5, 7, 15):
        rows, near = np.stack([y[:n], y[-n:]]), np.linspace(x[0] - 0.3, x[n - 1] + 0.3, 101)
        exact = CubicSpline(x[:n], rows, axis=-1)(near)
        np.testing.assert_allclose(cubic_spline(x[:n], rows, near), exact, atol=1e-12 * n)
        np.testing.assert_allclose(cubic_spline(x[:n], rows[1], near), exact[1], atol=1e-12 * n)
