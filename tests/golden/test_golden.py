"""Our own outputs, pinned: a change that moves them must be meant. Regenerate with `pytest --regenerate-golden`."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import efficiency
from ehl.contact import Contact
from ehl.state import ContactState
from regression.formula import ANY_OIL, Formula, shipped_formulas

HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parents[1] / "docs" / "examples"
# libm and compilers differ in the last bits; the solvers stop at about 1e-9
RELATIVE = 1e-6


def contact_figures(name: str) -> dict[str, float]:
    result = Contact.from_file(EXAMPLES / name).solve().to_dict()
    keep = ("friction_coefficient", "friction_fluid", "film_central", "film_min", "pressure_max", "rolling_traction")
    return {key: result[key] for key in (*keep, "temperature_film_max", "asperity_load_share")}


def gear_figures(friction: str) -> dict[str, float]:
    result = efficiency.load("fm_spiral_bevel_14x39").at(friction, torque=250.0).to_dict()
    found = {key: result[key] for key in ("efficiency", "power_loss", "pressure_hertz_max")}
    return found | {key: result["cycle"][key] for key in ("transmission_error_loaded", "transmission_error_unloaded")}


def formula_figures(name: str) -> dict[str, float]:
    """Friction and upper end of the interval at a dozen points, from thick to thin films, hot and cold."""
    steps = np.arange(12)
    state = ContactState.of(
        pressure_hertz=0.4e9 + 0.1e9 * steps,
        radius_equivalent=0.006 + 0.003 * ((5 * steps) % 12),
        effective_modulus=226e9,
        speed_entrainment=0.2 * 1.5 ** ((7 * steps) % 12),
        slide_to_roll=0.02 * 1.4 ** ((5 * steps + 3) % 12),
        speed_sliding_lengthwise=0.3 * (steps % 4),
        temperature_oil=313.15 + 20.0 * (steps % 5),
        roughness_rms_1=0.1e-6 * (1 + steps % 5),
        roughness_rms_2=0.2e-6,
    )
    value = Formula.load(name).mu(state, oil="75w90" if name == ANY_OIL else None)
    pairs = zip(np.ravel(value.mu), np.ravel(value.upper), strict=True)
    return {
        f"{word} {k}": float(x) for k, both in enumerate(pairs) for word, x in zip(("mu", "upper"), both, strict=True)
    }


CASES: dict[str, Callable[[], dict[str, float]]] = {
    "contact": lambda: contact_figures("contact.toml"),
    "contact_by_numbers": lambda: contact_figures("contact_by_numbers.toml"),
    "gear_constant": lambda: gear_figures("constant:0.05"),
    "gear_xu_kahraman_2007": lambda: gear_figures("xu_kahraman_2007"),
    **{f"formula_{name}": partial(formula_figures, name) for name in shipped_formulas()},
}


@pytest.mark.parametrize("name", CASES)
def test_output_is_as_pinned(name: str, request: pytest.FixtureRequest) -> None:
    path = HERE / f"{name}.json"
    computed: dict[str, Any] = CASES[name]()
    if request.config.getoption("--regenerate-golden"):
        path.write_text(json.dumps(computed, indent=2) + "\n", encoding="utf-8")
    pinned = json.loads(path.read_text(encoding="utf-8"))
    assert computed == pytest.approx(pinned, rel=RELATIVE)
