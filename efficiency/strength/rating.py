"""Strength of a loaded pair: pressures against their limits, root stress, safety factors, scuffing, micropitting.

load  ->  pressures and their grades; root stress over the mesh  ->  permissible stresses  ->  safety factors
local conditions  ->  flash and integral temperature, specific film
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from efficiency.contact.mesh_surface import EDGES
from efficiency.ltca.limits import EDGE_LIMIT, EDGE_NOTE, EdgeLoad, edges_carry, flank_place
from efficiency.ltca.load_distribution import LoadDistribution, TeethElasticity
from efficiency.strength import permissible_stress as permissible
from efficiency.strength.result import Grade, Strength
from efficiency.strength.root_stress import RootStress, RootTooth, root_stress
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError

INTEGRAL = 1.5
"""C_2: weight of the mean flash in the integral temperature (ISO/TS 6336-21, from memory)."""
RA_OF_RQ = math.sqrt(2.0 / math.pi)
ASSUMED = (
    "torque as given at constant speed: application and dynamic factors are 1; load distribution from the loaded tooth "
    "contact",
    "neglected, factor 1: life, work hardening, bevel factor (of nominal stresses)",
    "root stress within 5 % of a finer finite-element mesh under the same contact forces; friction neglected",
    "no scuffing temperature and permissible film in the oil data: no safety factor against scuffing and micropitting",
)


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
    loaded = load.loaded
    count = loaded["force"].size
    for name in ("friction", "film", "temperature"):
        if getattr(local, name).shape != (count,):
            raise InputError(name, getattr(local, name).shape, f"a value for each of the {count} loaded points")
    grades: list[Grade] = []
    notes = list(ASSUMED)
    inside = loaded["at_edge"] < 0.5
    pressure = np.where(inside, loaded["pressure_hertz"], 0.0)
    worst = int(np.argmax(pressure))
    flank = float(pressure[worst])
    materials = {"pinion": teeth.material_pinion, "gear": teeth.material_gear}
    soft = permissible.yield_stress(min(m.hardness for m in materials.values()))
    known = np.isfinite(local.friction)
    mu = float(np.max(np.abs(local.friction), where=known, initial=0.0))
    first, shakes = permissible.yield_pressure(soft), float(permissible.shakedown_pressure(soft, mu))
    limits = [m.contact_endurance for m in materials.values() if m.contact_endurance is not None]
    endurance = min(limits) if len(limits) == len(materials) else math.nan
    where = flank_place(load, teeth, int(load.loaded_position[worst]), int(load.loaded_index[worst]))
    grades += _flank_grades(flank, endurance, first, shakes, where)
    if not math.isfinite(endurance):
        unknown = ", ".join(f"{name} ({m.name})" for name, m in materials.items() if m.contact_endurance is None)
        text = f"contact_endurance is missing in the material of {unknown}: not graded"
        grades.append(Grade("contact endurance", "note", text))
    grades += _edge_grades(edges, first, shakes)
    rz = permissible.RZ_OF_RQ * 0.5 * sum(local.roughness)
    factors = _contact_factors(endurance, local, rz, float(loaded["radius_equivalent"][worst]))
    safety = endurance * math.prod(factors.values()) / flank if flank > 0.0 else math.nan
    if safety < 1.0 and flank <= endurance:
        text = f"pitting safety {safety:.3f} below 1 with the factors of film and roughness ({where}): finer finish, "
        grades.append(Grade("pitting", "warning", text + "higher oil viscosity"))
    results, safeties = [], []
    for (member, material), root in zip(materials.items(), roots, strict=True):
        stress = None if isinstance(root, str) else root_stress(root, load.positions, pitch)
        results.append(stress)
        safeties.append(math.nan)
        if stress is None:
            text = f"root stress of the {member} not computed: {root}"
            grades.append(Grade(f"root of the {member}", "note", text))
            continue
        if stress.fillet.startswith("assumed"):
            notes.append(f"root fillet of the {member} {stress.fillet}")
        if material.bending_endurance is None:
            text = f"bending_endurance is missing in the material of the {member} ({material.name}): not graded"
            grades.append(Grade(f"root of the {member}", "note", text))
            continue
        own = _root_factors(stress, local.module)
        factors |= {f"{name}_{member}": value for name, value in own.items()}
        allowed = material.bending_endurance * permissible.STRESS_CORRECTION * math.prod(own.values())
        safeties[-1] = allowed / stress.tension
        if stress.tension > allowed:
            text = (
                f"root stress of the {member} {stress.tension / 1e6:.0f} MPa above the permissible "
                f"{allowed / 1e6:.0f} MPa, {stress.face * 1e3:.1f} mm from the toe: larger edge radius of the cutter, "
                "thicker or larger teeth, less torque"
            )
            grades.append(Grade(f"root of the {member}", "warning", text))
    bulk = max(local.bulk)
    weight = np.concatenate([p.position.length[p.force > 0.0] for p in load.positions])
    hot = np.isfinite(local.temperature)
    mean = float(np.average(local.temperature[hot] - bulk, weights=weight[hot])) if hot.any() else math.nan
    rough = RA_OF_RQ * 0.5 * sum(local.roughness)
    film = local.film / rough if rough > 0.0 else np.full(count, np.inf)
    usable = film[np.isfinite(film)]
    grades.sort(key=lambda grade: grade.level != "warning")
    tension = [math.nan if r is None else r.tension for r in results]
    compression = [math.nan if r is None else r.compression for r in results]
    return Strength(
        status=grades[0].level if grades else "ok",
        grades=tuple(grades),
        pressure_flank=flank,
        contact_endurance=endurance,
        pressure_yield=first,
        pressure_shakedown=shakes,
        pressure_edge=edges.pressure,
        edge_load_share=edges.share,
        safety_contact=safety,
        root_stress_pinion=tension[0],
        root_stress_gear=tension[1],
        root_compression_pinion=compression[0],
        root_compression_gear=compression[1],
        safety_root_pinion=safeties[0],
        safety_root_gear=safeties[1],
        temperature_flash=float(local.temperature[hot].max()) if hot.any() else math.nan,
        temperature_integral=bulk + INTEGRAL * max(mean, 0.0) if math.isfinite(mean) else math.nan,
        film_specific=float(usable.min()) if usable.size else math.nan,
        factors=factors,
        notes=tuple(notes),
        pinion=results[0],
        gear=results[1],
        points_film_specific=film,
        points_temperature=local.temperature,
    )


def _flank_grades(flank: float, endurance: float, first: float, shakes: float, where: str) -> list[Grade]:
    """Grades of the pressure inside the flanks, for the highest exceeded limit and the endurance."""
    found = []
    value = f"{flank / 1e9:.3g} GPa"
    remedy = "less torque, a larger pattern (less crowning), larger teeth"
    if flank > shakes:
        text = f"flank pressure {value} above shakedown, {shakes / 1e9:.3g} GPa: cyclic plasticity"
        found.append(Grade("shakedown", "warning", f"{text}; {where}; {remedy}"))
    elif flank > first:
        text = f"flank pressure {value} above first yield below the surface, {first / 1e9:.3g} GPa"
        found.append(Grade("yield", "warning", f"{text}; {where}; {remedy}"))
    if flank > endurance:
        text = f"flank pressure {value} above the contact endurance, {endurance / 1e9:.3g} GPa: pitting is expected"
        found.append(Grade("contact endurance", "warning", f"{text}; {where}; {remedy}"))
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


def _contact_factors(endurance: float, local: LocalConditions, rz: float, radius: float) -> dict[str, float]:
    if not math.isfinite(endurance):
        return {}
    return {
        "Z_L": permissible.lubricant_factor(endurance, local.viscosity_40),
        "Z_v": permissible.speed_factor(endurance, local.speed),
        "Z_R": permissible.roughness_factor(endurance, rz, radius),
        "Z_Hyp": local.hypoid,
    }


def _root_factors(stress: RootStress, module: float) -> dict[str, float]:
    return {
        "Y_delta_relT": permissible.notch_factor(stress.notch),
        "Y_R_relT": permissible.surface_factor(permissible.ROOT_ROUGHNESS),
        "Y_X": permissible.size_factor(module),
    }
