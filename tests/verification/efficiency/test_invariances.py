"""What must not change: a map point solved alone, the mirror image, another scale; face-hobbed hypoid pairs too."""

from typing import Any

import numpy as np
import pytest
from rebuilt_designs import mirror, rebuilt

from efficiency.contact.flank_pair import flank_pair
from efficiency.design.design import Design, load_design
from efficiency.mesh import Mesh

NAMES = ("fh_hypoid_9x34", "fm_spiral_bevel_14x39")
TORQUE = 300.0
POWERS = {"m": 1, "1/m": -1, "m^2": 2, "1/m^2": -2, "1/m^3": -3}  # of the length, by unit


def mesh_of(design: Design) -> Mesh:
    return Mesh.of(design, "drive", 6, 15, keep=True)


def scaled(factor: float) -> Any:
    def change(unit: str | None, name: str, value: Any) -> Any:
        return value * factor ** POWERS.get(unit or "", 0) if isinstance(value, float) else value

    return change


@pytest.mark.parametrize("name", NAMES[:1])
def test_the_mirror_image_has_the_same_load_and_efficiency(name: str) -> None:
    design = load_design(name)
    one, other = (mesh_of(found).load(TORQUE) for found in (design, rebuilt(design, mirror)))
    same(one.efficiency("constant:0.06"), other.efficiency("constant:0.06"))


@pytest.mark.parametrize("name", NAMES)
def test_a_pair_of_twice_the_size_has_the_same_pressure_and_efficiency(name: str) -> None:
    """Pressures stay where the torque grows with the cube of the lengths; 1e-4 is seen under load."""
    design = load_design(name)
    larger = rebuilt(design, scaled(2.0))
    one, other = mesh_of(design).load(TORQUE), mesh_of(larger).load(8.0 * TORQUE)
    same(one.efficiency("constant:0.06"), other.efficiency("constant:0.06"), 5e-4)
    paths = [flank_pair(found.flanks(), "drive").path for found in (design, larger)]
    np.testing.assert_allclose(paths[0].transmission_error, paths[1].transmission_error, atol=1e-10)


def same(one: Any, other: Any, relative: float = 1e-5) -> None:
    assert other.status == one.status == "converged"
    assert other.pressure_hertz_max == pytest.approx(one.pressure_hertz_max, rel=relative)
    assert 1.0 - other.efficiency == pytest.approx(1.0 - one.efficiency, rel=relative)
    assert other.cycle.transmission_error_loaded == pytest.approx(
        one.cycle.transmission_error_loaded, rel=10.0 * relative
    )
