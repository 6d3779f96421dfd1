"""Bodies, roots and geometry of a design from disk: the same bits, and another entry for other content."""

from pathlib import Path
from typing import Any

import pytest

import efficiency
import efficiency.mesh
from efficiency.design.design import Design, _key, load_design
from efficiency.design.flank_input import GridFlankInput
from efficiency.pair import GearPair

NAME = "fm_spiral_bevel_14x39"
DESIGN = load_design(NAME)


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("MIXED_EHL_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "mixed-ehl" / "designs"


def _figures(pair: GearPair, **misalignment: Any) -> list[float]:
    loaded = pair.mesh("drive", 4, 9, **misalignment).load(300.0)
    result = loaded.efficiency("xu_kahraman_2007")
    roots = [] if misalignment else [result.strength.root_stress_pinion, result.strength.root_stress_gear]
    return [result.efficiency, result.pressure_hertz_max, *roots]


def test_a_later_pair_has_the_same_bits_and_computes_no_body(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = _figures(GearPair(DESIGN, keep=False))
    assert not folder.exists()
    first = _figures(efficiency.load(NAME))
    assert len(list(folder.iterdir())) == 3

    def refuse(*arguments: Any) -> Any:
        raise AssertionError("computed again")

    moved = _figures(GearPair(DESIGN, keep=False), E=5e-5)
    for name in ("elastic_teeth", "root_tooth"):
        monkeypatch.setitem(vars(efficiency.mesh), name, refuse)
    # another position takes bodies and roots from disk
    assert _figures(efficiency.load(NAME).misaligned(E=5e-5))[:2] == moved
    assert len(list(folder.iterdir())) == 4
    monkeypatch.setitem(vars(efficiency.mesh), "flank_pair", refuse)
    assert _figures(efficiency.load(NAME)) == first == plain


def _changed(design: Design, member: str, **values: Any) -> Design:
    return design.model_copy(update={member: getattr(design, member).model_copy(update=values)})


def test_the_key_follows_the_content() -> None:
    what = ("drive", 24, 31)
    bodies, mesh = _key("bodies", DESIGN, what), _key("mesh", DESIGN, what)
    assert bodies != mesh
    moved = DESIGN.with_misalignment(E=1e-5)
    assert _key("bodies", moved, what) == bodies
    assert _key("mesh", moved, what) != mesh
    operation = DESIGN.model_copy(update={"operation": DESIGN.operation.model_copy(update={"torque": 1.0})})
    assert _key("mesh", operation, what) == mesh
    for other in (_changed(DESIGN, "pinion", edge_rounding=1e-4), DESIGN.model_copy(update={"name": "other"})):
        assert _key("mesh", other, what) != mesh
    assert _key("mesh", DESIGN, ("coast", 24, 31)) != mesh


def test_the_key_follows_the_points_of_a_file(tmp_path: Path) -> None:
    points = tmp_path / "points.csv"
    points.write_text("1, 2, 3")
    measured = _changed(DESIGN, "gear", convex=GridFlankInput.model_construct(grid=str(points)))
    key = _key("mesh", measured, ())
    assert _key("mesh", measured, ()) == key
    points.write_text("1, 2, 4")
    assert _key("mesh", measured, ()) != key
