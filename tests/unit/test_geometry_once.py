"""Geometry and load are computed once: also bodies, roots and meshes on disk, with the same bits, for their content."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import efficiency
import efficiency.mesh
from efficiency.design.design import _key, load_design
from efficiency.design.flank_input import GridFlankInput
from efficiency.pair import GearPair

NAME = "fm_spiral_bevel_14x39"
DESIGN = load_design(NAME)


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often flanks were put in mesh, teeth made elastic and loads distributed."""
    counts: Counter[str] = Counter()
    monkeypatch.setenv("MIXED_EHL_CACHE", "off")

    def counted(name: str) -> None:
        real: Callable[..., Any] = getattr(efficiency.mesh, name)

        def call(*arguments: Any, **options: Any) -> Any:
            counts[name] += 1
            return real(*arguments, **options)

        monkeypatch.setattr(efficiency.mesh, name, call)

    for name in ("flank_pair", "elastic_teeth", "load_grids"):
        counted(name)
    return counts


def test_command_line_meshes_and_loads_once(calls: Counter[str], mixed_ehl: Callable[..., Any]) -> None:
    arguments = ("--friction", "xu_kahraman_2007", "--bulk-temperature", "estimate", "--uncertainty", "--json")
    assert mixed_ehl("gear", NAME, *arguments).code == 0
    assert calls == {"flank_pair": 1, "elastic_teeth": 1, "load_grids": 1}


def test_a_second_speed_costs_no_load_and_a_second_torque_no_geometry(calls: Counter[str]) -> None:
    mesh = efficiency.load(NAME).mesh(positions=4, points_per_line=9)
    for torque, speed in (("200 N m", "500 rpm"), ("200 N m", "1500 rpm"), ("300 N m", "1500 rpm")):
        mesh.load(torque).efficiency("constant:0.05", speed=speed)
    assert calls == {"flank_pair": 1, "elastic_teeth": 1, "load_grids": 2}


def _figures(pair: GearPair, **misalignment: Any) -> list[float]:
    loaded = pair.mesh("drive", 4, 9, **misalignment).load(300.0)
    result = loaded.efficiency("xu_kahraman_2007")
    roots = [] if misalignment else [result.strength.root_stress_pinion, result.strength.root_stress_gear]
    return [result.efficiency, result.pressure_hertz_max, *roots]


def test_a_later_pair_has_the_same_bits_and_computes_no_body(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MIXED_EHL_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = tmp_path / "mixed-ehl" / "designs"
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


def test_the_key_follows_the_content() -> None:
    what = ("drive", 24, 31)
    bodies, mesh = _key("bodies", DESIGN, what), _key("mesh", DESIGN, what)
    assert bodies != mesh
    moved = DESIGN.with_misalignment(E=1e-5)
    assert _key("bodies", moved, what) == bodies
    assert _key("mesh", moved, what) != mesh
    operation = DESIGN.model_copy(update={"operation": DESIGN.operation.model_copy(update={"torque": 1.0})})
    assert _key("mesh", operation, what) == mesh
    for other in ({"pinion": DESIGN.pinion.model_copy(update={"edge_rounding": 1e-4})}, {"name": "other"}):
        assert _key("mesh", DESIGN.model_copy(update=other), what) != mesh
    assert _key("mesh", DESIGN, ("coast", 24, 31)) != mesh


def test_the_key_follows_the_points_of_a_file(tmp_path: Path) -> None:
    points = tmp_path / "points.csv"
    points.write_text("1, 2, 3")
    flank = GridFlankInput.model_construct(grid=str(points))
    measured = DESIGN.model_copy(update={"gear": DESIGN.gear.model_copy(update={"convex": flank})})
    key = _key("mesh", measured, ())
    assert _key("mesh", measured, ()) == key
    points.write_text("1, 2, 4")
    assert _key("mesh", measured, ()) != key
