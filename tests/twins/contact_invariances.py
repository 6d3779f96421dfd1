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

import numpy as np
from twins.contact_stress import bounded, scenes, tables

from ehl import Contact
from ehl.common.validation import validate
from ehl.result import ContactResult

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
    lengths = ("radius_equivalent", "speed_entrainment", "speed_sliding_lengthwise")
    return tables(row | {name: scale * row[name] for name in lengths}, surface, "fast")


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
    contact = given["contact"]
    turned = {name: -contact[name] for name in ("slide_to_roll", "speed_sliding_lengthwise")}
    return given | {"surface": surface, "contact": contact | turned}


def mirrored(given: dict[str, Any]) -> dict[str, Any]:
    """Seen in a mirror across the contact line: lengthwise sliding the other way."""
    contact = given["contact"]
    return given | {"contact": contact | {"speed_sliding_lengthwise": -contact["speed_sliding_lengthwise"]}}


def in_other_units(given: dict[str, Any]) -> dict[str, Any]:
    """The same numbers in millimetres, megapascals, kilometres per hour ..."""

    def written(table: str, **units: tuple[str, float]) -> dict[str, str]:
        return {name: f"{given[table][name] * factor!r} {unit}" for name, (unit, factor) in units.items()}

    changed = {
        "contact": written(
            "contact",
            effective_modulus=("GPa", 1e-9),
            pressure_hertz=("MPa", 1e-6),
            radius_equivalent=("mm", 1e3),
            speed_entrainment=("km/h", 3.6),
        ),
        "lubricant": written(
            "lubricant",
            viscosity_inlet=("mPa s", 1e3),
            pressure_viscosity=("1/GPa", 1e9),
            eyring_stress=("MPa", 1e-6),
        ),
        "surface": written("surface", correlation_length=("um", 1e6)) | {"boundary_film": "30 nm"},
    }
    return given | {name: given[name] | table for name, table in changed.items()}


def solved(given: dict[str, Any], travel: float, nodes: int) -> ContactResult:
    """The contact over a window of `travel` half-widths on at most `nodes` nodes."""
    with bounded("fast", travel, nodes):
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
