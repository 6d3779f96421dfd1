"""Geometry and load are computed once, whatever is asked of them afterwards."""

from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest

import efficiency.mesh


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
    assert mixed_ehl("gear", "fm_spiral_bevel_14x39", *arguments).code == 0
    assert calls == {"flank_pair": 1, "elastic_teeth": 1, "load_grids": 1}


def test_a_second_speed_costs_no_load_and_a_second_torque_no_geometry(calls: Counter[str]) -> None:
    mesh = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9)
    for torque, speed in (("200 N m", "500 rpm"), ("200 N m", "1500 rpm"), ("300 N m", "1500 rpm")):
        mesh.load(torque).efficiency("constant:0.05", speed=speed)
    assert calls == {"flank_pair": 1, "elastic_teeth": 1, "load_grids": 2}
