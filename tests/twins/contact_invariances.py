"""Rough contacts of the gear range under changes that leave friction as it is.

Each contact is solved, and solved again with the surfaces exchanged (profiles and sliding), with the lengthwise sliding
turned round, written in other units, and at twice the size (lengths and speeds; isothermal contacts with a stated
boundary film only). Friction, film and load share must agree within both stated errors; most agree to rounding, some
histories near the boundary of contact go apart with the last digit.
"""

import math
import tempfile
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from twins.contact_stress import MODULUS, scenes

import ehl.rough.mixed
from ehl import Contact
from ehl.common.validation import validate
from ehl.result import ContactResult
from ehl.rough import TransientResult, solve_transient
from ehl.rough.accuracy import BUDGET

FILM = 30e-9  # boundary film [m]
ROUNDING = 1e-6
# relative; a share below a thousandth of the load is compared with that
FLOORS = {"friction_coefficient": 0.0, "film_central": 0.0, "asperity_load_share": 1e-3}
Row = dict[str, Any]


def content(row: Row, folder: Path, *, scale: float = 1.0) -> dict[str, Any]:
    """A contact as a file says it, with both profiles in files of their own."""
    surface: dict[str, Any] = {
        "correlation_length": scale * row["correlation_length"],
        "peklenik_number": row["peklenik_number"],
        "boundary_film": scale * FILM,
    }
    for number in (1, 2):
        rms = row[f"roughness_rms_{number}"]
        if rms > 0.0:
            path = folder / f"profile_{number}_{scale:g}.csv"
            cutoff = write_random_profile(path, rms, row["correlation_length"], row["index"] + number, scale)
            surface |= {f"profile_{number}": str(path), "cutoff_short": cutoff, "cutoff_long": None}
    names = ("viscosity_inlet", "pressure_viscosity", "eyring_stress", "rheology", "temperature_viscosity")
    return {
        "contact": {
            "effective_modulus": MODULUS,
            "pressure_hertz": row["pressure_hertz"],
            "radius_equivalent": scale * row["radius_equivalent"],
            "speed_entrainment": scale * row["speed_entrainment"],
            "slide_to_roll": row["slide_to_roll"],
            "speed_sliding_lengthwise": scale * row["speed_sliding_lengthwise"],
        },
        "lubricant": {
            **{key: row[key] for key in names},
            "temperature_oil": f"{row['temperature_celsius']} degC",
            "limiting_shear_coefficient": row["limiting_shear_coefficient"] or None,
        },
        "surface": surface,
        "model": {"accuracy": "fast", "thermal": row["thermal"]},
    }


def write_random_profile(path: Path, rms: float, length: float, seed: int, scale: float) -> float:
    """Write a Gaussian profile, filtered to a correlation length; returns its short cut-off [m]."""
    step, count = length / 12.0, 1600
    white = np.random.default_rng(seed).standard_normal(count + 200)
    window = np.exp(-((np.arange(-60, 61) * step / length) ** 2))
    heights = np.convolve(white, window, mode="valid")[:count]
    heights *= rms / np.std(heights)
    x = np.arange(count) * step
    lines = (f"{scale * a * 1e6:.12g},{scale * b * 1e6:.12g}" for a, b in zip(x, heights, strict=True))
    path.write_text("x [um], height [um]\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return scale * 4.0 * step


def exchanged(given: dict[str, Any]) -> dict[str, Any]:
    """Surface 1 is surface 2, and slides the other way."""
    surface = dict(given["surface"])
    one, two = (surface.pop(name, None) for name in ("profile_1", "profile_2"))
    surface |= {name: path for name, path in (("profile_1", two), ("profile_2", one)) if path}
    contact = given["contact"] | {
        "slide_to_roll": -given["contact"]["slide_to_roll"],
        "speed_sliding_lengthwise": -given["contact"]["speed_sliding_lengthwise"],
    }
    return given | {"surface": surface, "contact": contact}


def mirrored(given: dict[str, Any]) -> dict[str, Any]:
    """Seen in a mirror across the contact line: lengthwise sliding the other way."""
    contact = given["contact"]
    return given | {"contact": contact | {"speed_sliding_lengthwise": -contact["speed_sliding_lengthwise"]}}


def in_other_units(given: dict[str, Any]) -> dict[str, Any]:
    """The same numbers in millimetres, megapascals, kilometres per hour ..."""
    contact, oil, surface = (dict(given[name]) for name in ("contact", "lubricant", "surface"))
    contact |= {
        "effective_modulus": f"{contact['effective_modulus'] / 1e9!r} GPa",
        "pressure_hertz": f"{contact['pressure_hertz'] / 1e6!r} MPa",
        "radius_equivalent": f"{contact['radius_equivalent'] * 1e3!r} mm",
        "speed_entrainment": f"{contact['speed_entrainment'] * 3.6!r} km/h",
    }
    oil |= {
        "viscosity_inlet": f"{oil['viscosity_inlet'] * 1e3!r} mPa s",
        "pressure_viscosity": f"{oil['pressure_viscosity'] * 1e9!r} 1/GPa",
        "eyring_stress": f"{oil['eyring_stress'] / 1e6!r} MPa",
    }
    surface |= {"correlation_length": f"{surface['correlation_length'] * 1e6!r} um", "boundary_film": "30 nm"}
    return given | {"contact": contact, "lubricant": oil, "surface": surface}


def solved(given: dict[str, Any], travel: float, nodes: int) -> ContactResult:
    """The contact over a window of `travel` half-widths on at most `nodes` nodes."""

    def solve(*values: Any, **options: Any) -> TransientResult:
        return solve_transient(*values, **(options | {"travel": options.get("travel") or travel}))

    budget = mock.patch.dict(BUDGET, {"fast": (nodes, nodes)})
    with mock.patch.object(ehl.rough.mixed, "solve_transient", solve), budget:
        return validate(Contact, given).solve()


def compared(plain: ContactResult, changed: ContactResult, scale: float) -> Row:
    """Largest relative difference, whether it is rounding, and whether it lies within both stated errors."""
    worst, inside = 0.0, True
    if "failed" in (plain.status, changed.status):
        same = plain.status == changed.status and plain.reason == changed.reason
        return {"difference": 0.0 if same else math.inf, "equal": same, "inside": same}
    for name, floor in FLOORS.items():
        one, two = getattr(plain, name), getattr(changed, name) / (scale if name == "film_central" else 1.0)
        stated = {"film_central": (plain.film_error, changed.film_error)}.get(
            name, (plain.friction_error, changed.friction_error)
        )
        difference = abs(one - two) / max(abs(one), floor, 1e-300)
        worst = max(worst, difference)
        # the share of the load has no error of its own: that of the friction it makes, and a hundredth of the load
        allowed = sum(stated) + (0.01 / max(one, floor) if floor else 0.0)
        inside = inside and difference <= max(allowed, ROUNDING)
    return {"difference": worst, "equal": worst <= ROUNDING, "inside": inside}


def checked(index: int, row: Row, travel: float, nodes: int) -> list[Row]:
    """One row for each change of one contact."""
    row = row | {"index": index}
    with tempfile.TemporaryDirectory() as folder:
        given = content(row, Path(folder))
        plain = solved(given, travel, nodes)
        changes = {"exchanged": exchanged(given), "other units": in_other_units(given)}
        if row["speed_sliding_lengthwise"]:
            changes["mirrored"] = mirrored(given)
        if row["thermal"] == "off":
            changes["twice the size"] = content(row, Path(folder), scale=2.0)
        mu = {
            "index": index,
            "film_ratio": plain.film_ratio,
            "friction_coefficient": plain.friction_coefficient,
            "reason": plain.reason,
        }
        rows = []
        for change, other in changes.items():
            scale = 2.0 if change == "twice the size" else 1.0
            rows.append({**mu, "change": change, **compared(plain, solved(other, travel, nodes), scale)})
    return rows


def cases(count: int, seed: int) -> list[Row]:
    """Contacts of the gear range, every second one isothermal so that it can be scaled."""
    found = [scene.row for scene in scenes("gear", count, seed)]
    return [row | ({"thermal": "off"} if number % 2 else {}) for number, row in enumerate(found)]
