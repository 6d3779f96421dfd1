"""Strength of a loaded pair: pressures against their limits, root stress, safety factors, scuffing, micropitting.

load  ->  pressures and their grades; root stress over the mesh  ->  permissible stresses  ->  safety factors
local conditions  ->  flash and integral temperature, specific film

Permissible stresses: ISO 10300 factors of case-hardened steel; yield and shakedown of a line contact.

Hertz pressure of a half-plane with a normal load and sliding friction mu. With the yield stress Y in tension and
k = Y/sqrt(3) in shear (von Mises):

    first yield, mu = 0:   p = 1.79 Y = 3.1 k, at 0.70 b; maximum shear stress 0.30 p at 0.79 b
    shakedown:             p = k/max |tau_zx/p|;  4 k at mu = 0, k/mu where the surface governs

Residual stresses of a rolling line contact cannot balance tau_zx. Where it exceeds k, cyclic plasticity occurs
(Johnson, Contact Mechanics; Johnson & Jefferis 1963, both unverified). The stresses are McEwen's.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from efficiency.blanks import iso_10300 as iso
from efficiency.blanks.rating import ROOT_ROUGHNESS
from efficiency.contact.gear_flanks import MEMBERS
from efficiency.contact.mesh_surface import EDGES
from efficiency.ltca.limits import EDGE_LIMIT, EDGE_NOTE, EdgeLoad, edges_carry, flank_place, hardness
from efficiency.ltca.load_distribution import LoadDistribution, TeethElasticity
from efficiency.strength.result import Grade, Strength
from efficiency.strength.root_stress import WOUND, RootTooth, root_stress
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.units import KELVIN

YIELD_RATIO = 1.79
"""Hertz pressure at which a line contact first yields below its surface over the yield stress, Poisson's ratio 0.3."""
HARDNESS_RATIO = 3.0
"""Hardness over yield stress (Tabor)."""
_FRICTIONS = np.linspace(0.0, 0.5, 26)


def shear_stress(across: FloatArray, depth: FloatArray, friction: float) -> FloatArray:
    """tau_zx over the Hertz pressure at points in half-widths, positive for depth (McEwen; Johnson)."""
    x, z = np.broadcast_arrays(across, depth)
    level = 1.0 - x**2 + z**2
    root = np.sqrt(level**2 + 4.0 * x**2 * z**2)
    m2, n2 = 0.5 * (root + level), 0.5 * (root - level)
    m, n = np.sqrt(m2), np.sqrt(np.maximum(n2, 0.0)) * np.sign(x)
    total = np.maximum(m2 + n2, 1e-300)
    normal = -n * (m2 - z**2) / total
    sideways = -(m * (1.0 + (z**2 + n2) / total) - 2.0 * z)
    return np.asarray(normal + friction * sideways)


@lru_cache(maxsize=1)
def _greatest_shear() -> FloatArray:
    """Maximum |tau_zx|/p for each of `_FRICTIONS`."""
    across, depth = np.linspace(-1.5, 1.5, 301)[:, None], np.linspace(1e-6, 1.5, 151)[None]
    return np.array([np.abs(shear_stress(across, depth, mu)).max() for mu in _FRICTIONS])


def shakedown_pressure(stress: float, friction: ArrayLike = 0.0) -> FloatArray:
    """Shakedown limit of a line contact: Hertz pressure above which cyclic plasticity occurs [Pa].

    `stress` is the yield stress in tension [Pa]; friction coefficients are limited to 0.5.
    """
    shear = np.interp(np.abs(np.asarray(friction, float)), _FRICTIONS, _greatest_shear())
    return np.asarray(stress / np.sqrt(3.0) / shear)


INTEGRAL = 1.5
"""C_2: weight of the mean flash in the integral temperature (ISO/TS 6336-21, unverified)."""
LUBRICANT = {"pao": 0.8, "polyglycol": 0.7}
"""X_L: lubricant factor of the scuffing temperature by base oil; others 1 (ISO/TS 6336-21, unverified)."""
RA_OF_RQ = math.sqrt(2.0 / math.pi)
ASSUMED = (
    "torque as given at constant speed: application and dynamic factors are 1; load distribution from the loaded tooth "
    "contact",
    "neglected, factor 1: life, work hardening, bevel factor (of nominal stresses)",
    "root stress within 5 % of an independent finite-element model under the same contact forces; friction neglected",
)
NO_STAGE = "the oil card has no FZG load stage: no safety factor against scuffing"
NO_FILM = "the oil card has no permissible film: no safety factor against micropitting"


def scuffing_temperature(stage: int, viscosity_40: float, base: str) -> float:
    """Permissible integral temperature [K] from the failure load stage of the FZG test A/8.3/90.

    Bulk temperature and mean flash of the test at 3.726 stage^2 N m, the flash 1.5-fold (ISO/TS 6336-21, unverified);
    kinematic viscosity at 40 degC [m2/s], base of the oil.
    """
    torque, factor = 3.726 * stage**2, LUBRICANT.get(base, 1.0)
    bulk, flash = 80.0 + 0.23 * torque * factor, 0.2 * torque * (1e-4 / viscosity_40) ** 0.02 * factor
    return float(KELVIN + bulk + INTEGRAL * flash)


@dataclass(frozen=True)
class LocalConditions:
    """Local conditions of lubrication and motion for the strength."""

    friction: FloatArray  # (n,) friction coefficient at the loaded points [-]
    film: FloatArray  # (n,) central film thickness [m]
    temperature: FloatArray  # (n,) maximum surface temperature [K]
    bulk: tuple[float, float]  # bulk temperatures of pinion and gear teeth [K]
    roughness: tuple[float, float]  # Rq of both flanks [m]
    viscosity_40: float  # kinematic viscosity of the oil at 40 degC [m2/s]
    speed: float  # pitch line speed of the gear at its mean point [m/s]
    module: float  # mean normal module [m]
    hypoid: float  # hypoid factor Z_Hyp of the loaded flank [-]
    # of the oil card, nan if unknown: permissible integral temperature [K], permissible specific film [-]
    scuffing_temperature: float = math.nan
    film_permissible: float = math.nan


def rate_strength(
    load: LoadDistribution,
    teeth: TeethElasticity,
    edges: EdgeLoad,
    roots: tuple[RootTooth | str, RootTooth | str],
    local: LocalConditions,
    pitch: float,
) -> Strength:
    """Strength at one operating point: pressures, root stress, safety factors, scuffing and micropitting numbers.

    `roots`: roots of pinion and gear, or the reason why one is missing. `local` belongs to the loaded points of `load`;
    `pitch` is that of the pinion [rad].
    """
    count = load.loaded["force"].size
    for name in ("friction", "film", "temperature"):
        if getattr(local, name).shape != (count,):
            raise InputError(name, getattr(local, name).shape, f"a value for each of the {count} loaded points")
    sheet = _Sheet()
    if any(not isinstance(root, str) and root.winding > WOUND for root in roots):
        sheet.notes[-1] = (
            "root stress of teeth that wind around the pinion not checked, up to 15 % low; friction neglected"
        )
    parts = _contact_safety(load, teeth, edges, local, sheet)
    parts |= _root_safety(load, teeth, roots, local.module, pitch, sheet)
    parts |= _film_safety(load, local, sheet)
    grades = sorted(sheet.grades, key=lambda grade: grade.level != "warning")
    return Strength(
        status=grades[0].level if grades else "ok",
        grades=tuple(grades),
        factors=sheet.factors,
        notes=tuple(sheet.notes),
        **parts,
    )


@dataclass(frozen=True)
class _Sheet:
    """Grades, factors of the permissible stresses, and notes, to which each step of the rating adds its own."""

    grades: list[Grade] = field(default_factory=list)
    factors: dict[str, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=lambda: list(ASSUMED))


def _contact_safety(
    load: LoadDistribution, teeth: TeethElasticity, edges: EdgeLoad, local: LocalConditions, sheet: _Sheet
) -> dict[str, Any]:
    """Pressures with their limits, and S_H (ISO 10300-2)."""
    loaded = load.loaded
    pressure = np.where(loaded["at_edge"] < 0.5, loaded["pressure_hertz"], 0.0)
    worst = int(np.argmax(pressure))
    flank, soft = float(pressure[worst]), hardness(teeth) / HARDNESS_RATIO
    mu = float(np.max(np.abs(local.friction), where=np.isfinite(local.friction), initial=0.0))
    first, shakes = YIELD_RATIO * soft, float(shakedown_pressure(soft, mu))
    materials = {"pinion": teeth.material_pinion, "gear": teeth.material_gear}
    limits = [m.contact_endurance for m in materials.values() if m.contact_endurance is not None]
    endurance = min(limits) if len(limits) == len(materials) else math.nan
    where = flank_place(load, teeth, int(load.loaded_position[worst]), int(load.loaded_index[worst]))
    sheet.grades.extend(_flank_grades(flank, endurance, first, shakes, where))
    if math.isfinite(endurance):
        rz = iso.RZ_OF_RQ * 0.5 * sum(local.roughness)
        sheet.factors.update(
            Z_L=iso.lubricant_factor(endurance, local.viscosity_40),
            Z_v=iso.speed_factor(endurance, local.speed),
            Z_R=iso.roughness_factor(endurance, rz, float(loaded["radius_equivalent"][worst])),
            Z_Hyp=local.hypoid,
        )
    else:
        unknown = ", ".join(f"{name} ({m.name})" for name, m in materials.items() if m.contact_endurance is None)
        text = f"contact_endurance is missing in the material of {unknown}: not graded"
        sheet.grades.append(Grade("contact endurance", "note", text))
    sheet.grades.extend(_edge_grades(edges, first, shakes))
    safety = endurance * math.prod(sheet.factors.values()) / flank if flank > 0.0 else math.nan
    if safety < 1.0 and flank <= endurance:
        text = f"pitting safety {safety:.3f} below 1 with the factors of film and roughness ({where}): finer finish, "
        sheet.grades.append(Grade("pitting", "warning", text + "higher oil viscosity"))
    return {
        "pressure_flank": flank,
        "contact_endurance": endurance,
        "pressure_yield": first,
        "pressure_shakedown": shakes,
        "pressure_edge": edges.pressure,
        "edge_load_share": edges.share,
        "safety_contact": safety,
    }


def _root_safety(
    load: LoadDistribution,
    teeth: TeethElasticity,
    roots: tuple[RootTooth | str, RootTooth | str],
    module: float,
    pitch: float,
    sheet: _Sheet,
) -> dict[str, Any]:
    """Root stress over the mesh and S_F of both members (ISO 10300-3)."""
    parts: dict[str, Any] = {}
    for member, material, root in zip(MEMBERS, (teeth.material_pinion, teeth.material_gear), roots, strict=True):
        stress = None if isinstance(root, str) else root_stress(root, load.positions, pitch)
        tension, compression = (math.nan, math.nan) if stress is None else (stress.tension, stress.compression)
        parts |= {member: stress, f"safety_root_{member}": math.nan}
        parts |= {f"root_stress_{member}": tension, f"root_compression_{member}": compression}
        kind, of = f"root of the {member}", f"root stress of the {member}"
        if stress is None:
            sheet.grades.append(Grade(kind, "note", f"{of} not computed: {root}"))
            continue
        if stress.fillet.startswith("assumed"):
            sheet.notes.append(f"root fillet of the {member} {stress.fillet}")
        if material.bending_endurance is None:
            text = f"bending_endurance is missing in the material of the {member} ({material.name}): not graded"
            sheet.grades.append(Grade(kind, "note", text))
            continue
        own = {"Y_delta_relT": iso.notch_factor(stress.notch), "Y_R_relT": iso.surface_factor(ROOT_ROUGHNESS)}
        own["Y_X"] = iso.size_factor(module)
        sheet.factors.update({f"{name}_{member}": value for name, value in own.items()})
        allowed = material.bending_endurance * iso.STRESS_CORRECTION * math.prod(own.values())
        parts[f"safety_root_{member}"] = allowed / stress.tension
        if stress.tension > allowed:
            found = f"{stress.tension / 1e6:.0f} MPa above the permissible {allowed / 1e6:.0f} MPa"
            text = f"{of} {found}, {stress.face * 1e3:.1f} mm from the toe: "
            text += "larger edge radius of the cutter, thicker or larger teeth, less torque"
            sheet.grades.append(Grade(kind, "warning", text))
    return parts


def _film_safety(load: LoadDistribution, local: LocalConditions, sheet: _Sheet) -> dict[str, Any]:
    """Integral temperature and specific film, with their safeties against scuffing and micropitting."""
    bulk = max(local.bulk)
    weight = np.concatenate([p.position.length[p.force > 0.0] for p in load.positions])
    hot = np.isfinite(local.temperature)
    mean = float(np.average(local.temperature[hot] - bulk, weights=weight[hot])) if hot.any() else math.nan
    integral = bulk + INTEGRAL * max(mean, 0.0)
    rough = RA_OF_RQ * 0.5 * sum(local.roughness)
    film = local.film / rough if rough > 0.0 else np.full(local.film.shape, np.inf)
    usable = film[np.isfinite(film)]
    least = float(usable.min()) if usable.size else math.nan
    # in degC (ISO/TS 6336-21), without meaning at 0 degC and below
    scuffing = (local.scuffing_temperature - KELVIN) / (integral - KELVIN) if integral > KELVIN else math.nan
    micropitting = least / local.film_permissible
    for kind, number, limit, unknown, remedy in (
        ("scuffing", scuffing, local.scuffing_temperature, NO_STAGE, "cooler oil, higher load stage, finer finish"),
        ("micropitting", micropitting, local.film_permissible, NO_FILM, "finer finish, thicker or cooler oil"),
    ):
        if not math.isfinite(limit):
            sheet.notes.append(unknown)
        elif number < 1.0:
            sheet.grades.append(Grade(kind, "warning", f"safety against {kind} {number:.3g} below 1: {remedy}"))
    return {
        "temperature_flash": float(local.temperature[hot].max()) if hot.any() else math.nan,
        "temperature_integral": integral if math.isfinite(mean) else math.nan,
        "safety_scuffing": scuffing,
        "film_specific": least,
        "safety_micropitting": micropitting,
        "points_film_specific": film,
    }


def _flank_grades(flank: float, endurance: float, first: float, shakes: float, where: str) -> list[Grade]:
    """Grades of the pressure inside the flanks, for the highest exceeded limit and the endurance."""
    found = []
    value = f"{flank / 1e9:.3g} GPa"
    remedy = "less torque, a larger pattern (less crowning), larger teeth"
    if flank > shakes:
        text = f"pressure of {value} away from edges is above shakedown, {shakes / 1e9:.3g} GPa: cyclic plasticity"
        found.append(Grade("shakedown", "warning", f"{text}; {where}; {remedy}"))
    elif flank > first:
        text = f"pressure of {value} away from edges is above first yield below the surface, {first / 1e9:.3g} GPa"
        found.append(Grade("yield", "warning", f"{text}; {where}; {remedy}"))
    if flank > endurance:
        text = f"pressure of {value} away from edges is above the contact endurance, {endurance / 1e9:.3g} GPa"
        found.append(Grade("contact endurance", "warning", f"{text}: pitting is expected; {where}; {remedy}"))
    return found


def _edge_grades(edges: EdgeLoad, first: float, shakes: float) -> list[Grade]:
    """Grade of the load at the edges, with remedies."""
    if edges.share < EDGE_NOTE:
        return []
    names = ", ".join(f"{name} {100.0 * share:.2g} %" for name, share in edges.shares.items())
    tips = [name.split()[0] for name in EDGES if name.endswith("tip") and edges.shares.get(name, 0.0) >= EDGE_NOTE]
    ends = [name for name in EDGES if not name.endswith("tip") and edges.shares.get(name, 0.0) >= EDGE_NOTE]
    remedies = [f"add or increase the tip relief of the {' and the '.join(tips)}"] if tips else []
    if ends:
        remedies.append(f"more lengthwise crowning, or relief at the {', '.join(ends)}")
    severe = edges.share >= EDGE_LIMIT or edges.pressure > shakes
    text = f"{edges_carry(edges, severe)} of the load ({names}): {'; '.join(remedies)}"
    pressure = f"{edges.pressure / 1e9:.3g} GPa"
    if edges.pressure > shakes:
        text += f"; {pressure} at the {edges.edge} is above shakedown, {shakes / 1e9:.3g} GPa: cyclic plasticity"
    elif edges.pressure > first:
        text += f"; {pressure} at the {edges.edge} is above first yield, {first / 1e9:.3g} GPa: local yielding"
    return [Grade("edges", "warning" if severe else "note", text)]
