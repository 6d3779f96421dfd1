"""Tip and end relief: depth at points, gap against sections in space, and what it does to load, error and loss."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses

from efficiency.contact.contact_lines import conjugate_fields, sectioned_fields
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.gear_flanks import Side
from efficiency.contact.line_tracing import line_points, line_spans
from efficiency.contact.relief import EdgeRelief, MemberRelief
from efficiency.design.design import Design, bevel_names, load_design
from efficiency.geometry.pair_geometry import geometry_notes
from efficiency.machine_settings.inputs import load_targets
from efficiency.mesh import Mesh
from ehl.common.data import data_path

PAIR = "fm_hypoid_13x42"


def relieved(*members: str, **edges: dict[str, Any]) -> Design:
    """A shipped design with the same relief on some members."""
    design, relief = load_design(PAIR), {"edge_relief": MemberRelief.model_validate(edges)}
    return design.model_copy(update={name: getattr(design, name).model_copy(update=relief) for name in members})


def tip(amount: float, length: float = 1.5e-3, form: str = "parabolic") -> dict[str, Any]:
    return {"amount": amount, "length": length, "form": form}


@pytest.mark.parametrize(("form", "half"), [("linear", 0.5), ("parabolic", 0.25), ("circular", 0.25)])
def test_depth_is_the_amount_at_the_edge_and_nothing_at_the_length(form: Any, half: float) -> None:
    relief = EdgeRelief(amount=20e-6, length=2e-3, form=form)
    depth = relief.depth(np.array([0.0, 1e-3, 2e-3, 5e-3]))
    # an arc this flat departs from its parabola by amount^3/length^2
    np.testing.assert_allclose(depth, [20e-6, half * 20e-6, 0.0, 0.0], rtol=1e-4, atol=1e-18)


def test_each_edge_counts_from_itself_and_the_deeper_one_in_a_corner() -> None:
    blank = load_design(PAIR).gear.blank
    at_tip, at_toe = (EdgeRelief(amount=a, length=b, form="linear") for a, b in ((20e-6, 1e-3), (30e-6, 4e-3)))
    relief = MemberRelief(tip=at_tip, toe=at_toe, heel=None)
    half = 0.5 * blank.face_width
    u = np.array([-half, -half + 1e-3, 0.0, half, -half])
    below = np.array([2e-3, 3e-3, 0.25e-3, 0.5e-3, 0.0])
    depth = relief.depth(blank, u, blank.tip(u) - below)
    np.testing.assert_allclose(depth, [30e-6, 22.5e-6, 15e-6, 10e-6, 30e-6], rtol=1e-12)


@pytest.mark.parametrize("member", ["pinion", "gear"])
def test_gap_is_that_of_sections_in_space(member: str) -> None:
    tables = {"tip": tip(25e-6, 2e-3), "toe": tip(30e-6, 5e-3, "linear"), "heel": tip(20e-6, 4e-3, "circular")}
    design = relieved(member, **tables)
    surface = flank_pair(design.flanks(), "drive").surface
    rolls = np.linspace(*surface.roll_range, 9)[1:-1]
    points = line_points(surface, line_spans(surface, rolls)[0], 15)
    plain, across = sectioned_fields(surface, points.u, points.v, points.length)
    added = conjugate_fields(surface, points.u, points.v, points.length)["minimum_gap"] - plain["minimum_gap"]
    # second way: places in space, their coordinates on the blank, least of a dense row
    x = np.linspace(-1.5e-3, 1.5e-3, 6001)
    place = plain["position"][:, :, None] + plain["across"][:, :, None] * x
    assembly = surface.assembly
    if member == "gear":
        radius, z, blank = np.hypot(place[:, 0], place[:, 1]), place[:, 2], surface.gear.blank
    else:
        from_axis = place - assembly.pinion_origin[:, :1]
        z = np.einsum("nkx,k->nx", from_axis, assembly.pinion_axis[:, 0])
        radius, blank = np.sqrt((from_axis**2).sum(axis=1) - z**2), surface.pinion.blank
        z = z * np.sign(z.mean())
    depth = getattr(design.flanks().relief, member).depth(blank, *blank.coordinates(radius, z))
    bowl = 0.5 * across.curvature[:, None] * (x - across.centre[:, None]) ** 2
    expected = (bowl + depth).min(axis=1)
    assert added.max() > 15e-6
    # lines and blanks bend over the section: a hundredth of the amounts
    np.testing.assert_allclose(added, expected, atol=0.3e-6)
    assert (added >= 0.0).all()


def test_contact_pattern_leaves_relieved_ends() -> None:
    plain = flank_pair(load_design(PAIR).flanks(), "drive").pattern()
    relief = relieved("pinion", "gear", tip=tip(30e-6, 2e-3), toe=tip(30e-6, 6e-3))
    short = flank_pair(relief.flanks(), "drive").pattern()
    assert short.area_share < 0.9 * plain.area_share
    middle = plain.inside & (np.abs(plain.gear_u) < 2e-3)
    assert np.abs(plain.separation[middle] - short.separation[middle]).min() < 1e-12


TEXT = data_path("designs", f"{PAIR}.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("tables", "field"),
    [
        ('tip = { amount = "20 um", length = "30 mm" }', "tip.length"),
        ('tip = { amount = "-20 um", length = "1 mm" }', "tip.amount"),
        ('tip = { amount = "20 um", length = "1 mm", form = "wavy" }', "tip.form"),
        ('tip = { amount = "0.9 mm", length = "0.5 mm" }', "tip.amount"),
        ('heel = { amount = "20 um" }', "heel.length"),
        ('toe = { amount = "20 um", length = "20 mm" }\nheel = { amount = "20 um", length = "20 mm" }', "toe.length"),
    ],
)
def test_impossible_relief_is_refused(tmp_path: Path, tables: str, field: str) -> None:
    design = tmp_path / "design.toml"
    design.write_text(f"{TEXT}\n[gear.edge_relief]\n{tables}\n", encoding="utf-8")
    with refuses(f"gear.edge_relief.{field}"):
        load_design(design)


SHIPPED = [name for name in bevel_names() if name.endswith("_relieved")]


@pytest.mark.parametrize("side", ["drive", "coast"])
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_pairs_with_relief_are_clean(name: str, side: Side) -> None:
    design = load_design(name)
    for note in geometry_notes(design, side):
        # above the root of the whole depth lies the fillet, no working flank
        assert note.endswith("of the whole depth above the root cone"), note
    loaded = Mesh.of(design, side, 6, 13, keep=True).load().grids
    assert loaded.edges.share < 0.02
    assert loaded.fine.pressure_hertz_max < 1.6e9
    asked, kept = (given.pinion.edge_relief.tip for given in (load_targets(name), design))
    assert (kept.amount, kept.length) == pytest.approx((asked.amount, asked.length))
