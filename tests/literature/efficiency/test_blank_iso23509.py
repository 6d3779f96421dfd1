"""Printed samples of ISO 23509 Annex F, ISO/TR 10300-30 and AGMA 929 against the blank of a pair.

A printed number is met when ours rounds to its last digit, or is one unit off where the print carries rounded
intermediate values (3 decimals) on; what differs by more stands in `EXPLAINED` with the reason.
"""

import json
import math
import re
from collections.abc import Callable
from dataclasses import fields, replace
from decimal import Decimal
from math import asin, cos, degrees, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest
from refusals import refuses

import efficiency
from efficiency.blanks.agma_2003 import AgmaRating, hardness_ratio_factor, life_curves, stress_numbers
from efficiency.blanks.dimensions import DepthFactors, FaceAndRoot, Placement, ToothDepth
from efficiency.blanks.inputs import DepthTypeOne, PairBlankInput, load_blank
from efficiency.blanks.iso_10300 import FlankRating, rate_flank
from efficiency.blanks.lengthwise import Trace
from efficiency.blanks.pair import pair_blank
from efficiency.blanks.pair_blank import MemberBlank, PairBlank
from efficiency.blanks.rating import AgmaMember, RatingFactors, RatingInput, life_factor
from efficiency.blanks.slots import SlotGeometry, slots_and_lands
from efficiency.blanks.tangency import PitchCones
from efficiency.blanks.virtual_gears import VirtualGears
from efficiency.conditions.duty import DutyRow
from efficiency.design.design import load_design
from efficiency.geometry.design_rating import rated_pair
from efficiency.machine_settings.inputs import load_targets
from ehl.common.data import data_path
from ehl.common.quantities import quantities
from ehl.common.table import Table
from ehl.common.validation import validate

REFERENCE: dict[str, Any] = json.loads(data_path("reference", "iso23509_samples.json").read_text(encoding="utf-8"))

MM, DEG = 1e3, degrees(1.0)
FACTORS = {"mm": MM, "deg": DEG, "": 1.0}


def by_symbol(record: type) -> dict[str, tuple[str, float]]:
    """Symbol in the nomenclature without separators and the v of virtual gears -> field and factor of its unit."""
    listed = {field.name: quantities().get(field.name) for field in fields(record)}
    known = ((name, found) for name, found in listed.items() if found is not None and found.display in FACTORS)
    return {bare(found.symbol): (name, FACTORS[found.display]) for name, found in known}


def bare(symbol: str) -> str:
    return re.sub("[_,v]", "", symbol)


# the print has the index 1 or 2 behind the symbol of a member's quantity
MEMBER, PAIR, VIRTUAL = (by_symbol(record) for record in (MemberBlank, PairBlank, VirtualGears))
VIRTUAL["epsbeta"] = ("contact_ratio_overlap", 1.0)  # of the effective face width
SPECIAL: dict[str, Callable[[PairBlank], float]] = {
    "hm": lambda pair: pair.pinion.mean_whole_depth * MM,
    "alpha_n": lambda pair: 0.5 * (pair.pressure_angle_drive + pair.pressure_angle_coast) * DEG,
}
# intermediate values that are no result of ours: gear cone distances and spiral angles opposite to the pinion's ends
INTERMEDIATE = {"Re21", "Ri21", "beta_e21", "beta_i21"}


def ours(pair: PairBlank, symbol: str) -> float:
    """Our value of a printed symbol, in mm or deg."""
    if symbol in SPECIAL:
        return SPECIAL[symbol](pair)
    if bare(symbol) in PAIR:
        record, (name, factor) = pair, PAIR[bare(symbol)]
    else:
        record = pair.pinion if symbol.endswith("1") else pair.gear
        name, factor = MEMBER[bare(symbol[:-1])]
    return float(getattr(record, name)) * factor


def units_off(value: float, printed: str) -> float:
    """Difference in units of the last printed digit."""
    unit = 10.0 ** float(Decimal(printed).as_tuple().exponent)
    return abs(value - float(printed)) / unit


def sample(key: str) -> PairBlank:
    """Our blank of a printed sample, iteration as printed."""
    inputs = load_blank(f"iso23509_{key}")
    if key == "f2":
        # Annex F.2 carries the factors of data type I on with three decimals: x_hm1 = 0.505, x_smn = 0.046
        rounded = DepthTypeOne(data_type="I", profile_shift=0.505, thickness_modification=0.046)
        inputs = inputs.model_copy(update={"depth": rounded})
    return pair_blank(inputs)


# units of the last printed digit allowed beyond one, with the reason
EXPLAINED = {
    # product of rounded values: 4e-5 relative, from s(beta), cos(delta) with few digits
    ("f3", "dmn1"): 6.0,
    ("f3", "dmn2"): 4.0,
    # 0.002 deg: a 0.0016 deg smaller beta_m2 in the print would give all four
    **{("f3", symbol): 2.5 for symbol in ("beta_e1", "beta_i1", "beta_e2", "beta_i2")},
    # de1 = 2 Re1 sin delta1 with Re1 and delta1 rounded
    ("f3", "de1"): 1.5,
    # unexplained: d_mn sin(s_mn/d_mn) of the printed d_mn, s_mn is 4.921, and the printed h_amc1 is h_am1 itself
    ("f3", "smnc1"): 4.0,
    ("f3", "hamc1"): 48.0,
    # rounded t_zm2 and d_m2 cos zeta_m
    ("f4", "tz1"): 1.5,
    # the print gives R_mint of the last trial, 159.100, in place of R_m1; R_e1 - b_e1 of the same print is 159.087
    ("f5", "Rm1"): 1.5,
}


@pytest.mark.parametrize("key", ["f2", "f3", "f4", "f5"])
def test_every_printed_dimension(key: str) -> None:
    pair = sample(key)
    printed = {s: text for s, text in REFERENCE["samples"][key].items() if s not in INTERMEDIATE}
    assert len(printed) > 90
    off = {s: units_off(ours(pair, s), text) for s, text in printed.items()}
    assert {s: round(n, 1) for s, n in off.items() if n > EXPLAINED.get((key, s), 1.05)} == {}
    # most to half a unit: rounded intermediate values of the print are the exception
    assert sum(n <= 0.5 for n in off.values()) > 0.8 * len(off)


@pytest.mark.parametrize(("key", "trials", "low", "high"), [("f3", 3, 1e-6, 1e-4), ("f4", 1, 0.003, 0.01)])
def test_iteration_stops_as_printed_and_converges_elsewhere(key: str, trials: int, low: float, high: float) -> None:
    inputs = load_blank(f"iso23509_{key}")
    printed, converged = pair_blank(inputs), pair_blank(inputs.model_copy(update={"pitch_cones": "converged"}))
    assert printed.trials == trials
    assert low < abs(printed.closure) < high
    assert abs(converged.closure) < 1e-12
    if key == "f3":
        assert degrees(abs(printed.gear.pitch_angle - converged.gear.pitch_angle)) < 1e-3
    else:
        assert degrees(converged.gear.pitch_angle) == pytest.approx(63.1453, abs=1e-4)
        assert [w.kind for w in printed.warnings] == ["undercut", "tangency"]


@pytest.mark.parametrize("key", ["f2", "f3", "f4"])
def test_virtual_gears_of_the_technical_report(key: str) -> None:
    # the report starts from rounded blanks (its delta2 of sample 2 is 68.321, the annex implies 68.3235): 1.3e-4
    virtual = sample(key).virtual_drive
    for symbol, text in REFERENCE["virtual"][key].items():
        member = symbol[-1] in "12"
        name, factor = VIRTUAL[bare(symbol[:-1] if member else symbol)]
        value = np.atleast_1d(getattr(virtual, name))[int(symbol[-1]) - 1 if member else 0] * factor
        assert value == pytest.approx(float(text), rel=1.3e-4, abs=6e-4), symbol


def test_slots_and_top_lands_of_agma_929_c() -> None:
    # the annex starts from a finished blank; here F.2 with its clearance, addendum, backlash and thickness difference
    printed = REFERENCE["agma929_c"]
    given = {name: float(text) for name, text in printed["inputs"].items()}
    inputs = load_blank("iso23509_f2")
    module, tan20 = given["m_mn"], 0.36397023
    c_ham = given["ham2"] / (2.0 * module)
    shift = 2.0 * (0.5 - c_ham)
    k_t = (given["smn1"] - given["smn2"] - 4.0 * module * shift * tan20) / (2.0 * module)
    factors = {"gear_addendum_factor": c_ham, "clearance_factor": given["c"] / (2.0 * module), "thickness_factor": k_t}
    depth = inputs.depth.model_copy(update=factors)
    taper = inputs.taper
    # theta_f1 of the annex is 2.2259 deg
    taper = taper.model_copy(update={"addendum_angle_gear": 2.2259 / DEG, "dedendum_angle_gear": 6.4935 / DEG})
    backlash = inputs.backlash.model_copy(update={"value": given["j_en"] / MM})
    pair = pair_blank(inputs.model_copy(update={"depth": depth, "taper": taper, "backlash": backlash}))
    # 1e-3 mm: the annex's own check tolerance; its inputs have five to six digits
    for index, member in ((1, pair.pinion), (2, pair.gear)):
        slots = [float(printed[f"W_{place}{index}"]) for place in "ime"]
        for found, text in (
            (member.slot_width, slots),
            (member.normal_thickness, printed[f"s_n{index}"]),
            (member.top_land, printed[f"s_an{index}"]),
        ):
            np.testing.assert_allclose(np.array(found) * MM, np.array(text, float), rtol=0.0, atol=1e-3)


def slot_geometry(printed: dict[str, Any]) -> SlotGeometry:
    """Slots of a Formate pair from the finished blank an annex starts from."""
    given = {name: float(text) for name, text in printed["inputs"].items()}
    angles = ("delta1", "delta2", "theta", "beta")
    angle = {name: radians(value) for name, value in given.items() if name.split("_")[0] in angles}
    alphas = radians(given["alpha_cv1"]), radians(given["alpha_cx1"])
    rm1, rm2, z_0 = given["Rm1"] / MM, given["Rm2"] / MM, int(given["z0"])
    d_1, d_2, radius = angle["delta1"], angle["delta2"], given["r_c0"] / MM
    reach = 2.0 * (rm2 * sin(d_2) + rm1 * sin(d_1) * cos(d_2) / cos(d_1))
    zeta_m = asin(2.0 * given["a"] / MM / reach)
    zeta_mp = asin(sin(zeta_m) * sin(radians(given["Sigma"])) / cos(d_1))
    module = given["m_mn"] / MM
    lead = asin(0.5 * z_0 * module / radius)
    spiral = angle["beta_m2"]
    rho = sqrt(rm2**2 + radius**2 - 2.0 * rm2 * radius * sin(spiral - lead))
    fall = angle["theta_f1"], angle["theta_f2"]
    outer = given["Re1"] / MM, given["Re2"] / MM
    heights = (0.0, 0.0), (given["h_fm1"] / MM, given["h_fm2"] / MM), (given["c"] / MM, given["c"] / MM)
    tooth = ToothDepth(DepthFactors(0.0, 0.0, 0.0, 0.0), module, 0.0, 0.0, alphas, *heights, 0.0)
    return SlotGeometry(
        cones=PitchCones((d_1, d_2), (rm1, rm2), (spiral + zeta_mp, spiral)),
        place=Placement(zeta_m, zeta_mp, rm2 * sin(zeta_mp), (0.0, 0.0), (0.0, 0.0)),
        trace=Trace(radius, lead, rho, rho / (1.0 + z_0 / given["z2"] * sin(d_2))),
        angles=FaceAndRoot(
            0.0, 0.0, (d_1, d_2), (d_1 - fall[0], d_2 - fall[1]), (0.0, 0.0), fall, (0.0, 0.0), (0.0, 0.0)
        ),
        ends=((outer[0] - given["b1"] / MM, outer[0]), (outer[1] - given["b2"] / MM, outer[1])),
        tooth=tooth,
        thickness_gear=given["smn2"] / MM,
        backlash_in_plane=pi * module - (given["smn1"] + given["smn2"]) / MM,
        pitch_share=1.0 if z_0 else 0.0,
        cutter_tilt=radians(given["alpha_BX2"]) - alphas[0],
    )


@pytest.mark.parametrize("annex", ["agma929_d", "agma929_e"])
def test_slots_thicknesses_and_top_lands_of_formate_gears(annex: str) -> None:
    printed = REFERENCE[annex]["results"]
    names = {"W": "slot_width", "s_n": "normal_thickness", "s_an": "top_land"}
    geometry = slot_geometry(REFERENCE[annex])
    for index, member in enumerate((slots_and_lands(geometry, 0), slots_and_lands(geometry, 1)), 1):
        for symbol, name in names.items():
            wanted = [float(text) for text in printed[f"{symbol}{'_' * (symbol == 'W')}{index}"]]
            if (annex, symbol, index) == ("agma929_d", "W", 2):
                # Equation (64), with the mean of both pressure angles, contradicts (75), which the annex uses at the
                # ends and for W_m1: its own W_m1 = 2.68503 needs W_m2 = 2.6712
                assert member[name][1] * MM == pytest.approx(2.6712, abs=1e-3)
                wanted[1] = 2.6712
            assert np.array(member[name]) * MM == pytest.approx(wanted, rel=0.0025), symbol


def test_formate_blank_of_agma_929_d_from_what_the_designer_types() -> None:
    # the whole chain: pitch cones, depths and taper are ours
    pair, printed = pair_blank("fm_hypoid_11x45"), REFERENCE["agma929_d"]["results"]
    for index, member in ((1, pair.pinion), (2, pair.gear)):
        for symbol, values in (("s_n", member.normal_thickness), ("W_", member.slot_width), ("s_an", member.top_land)):
            for place, value in enumerate(values):
                # W_m2: see above. Lands of the gear: the annex subtracts the clearance of the gear root from h_fm1,
                # which gives 1.404 mm in place of its printed addendum of 1.531 mm
                limit = 0.026 if (symbol, index) == ("s_an", 2) else 0.004
                limit = 0.019 if (symbol, index, place) == ("W_", 2, 1) else limit
                assert value * MM == pytest.approx(float(printed[f"{symbol}{index}"][place]), rel=limit)
    assert all(point.member == "pinion" for point in pair.undercut)


def test_method_1_against_the_blank_of_agma_929_d_and_a_gleason_dimension_sheet() -> None:
    # the annex gives a finished blank whose pinion is not exactly tangent: R_m1 and R_e1 differ by 0.3 mm
    pair = pair_blank(load_blank("fm_hypoid_11x45"))
    for symbol in REFERENCE["agma929_d"].keys() - {"inputs", "results"}:
        limit = {"Rm1": 0.45, "Re1": 0.45, "smn1": 0.02, "smn2": 0.02}.get(symbol, 0.01)
        assert ours(pair, symbol) == pytest.approx(float(REFERENCE["agma929_d"][symbol]), abs=limit), symbol
    # another program's sheet with angles to a minute; its limit pressure angle is not printed
    pair = pair_blank(load_blank("fm_hypoid_10x41"))
    for symbol, text in REFERENCE["gleason_10x41"].items():
        angle = MEMBER[bare(symbol[:-1])][1] == DEG
        printed = float(text) * (1.0 if angle else 25.4)
        assert ours(pair, symbol) == pytest.approx(printed, abs=0.15 if angle else 0.35), symbol


# printed in ISO/TR 10300-30:2024, samples 1 to 3; read in the self test of the repository of docs/blank.md
RATED: dict[str, dict[str, tuple[float, ...]]] = {
    "iso23509_f2": {
        "force_tangential": (10925.3,), "force_normal": (14193.3,), "dynamic_factor": (1.020,),
        "face_load_factor": (1.650,), "face_load_factor_root": (1.650,), "transverse_load_factor": (1.161,),
        "contact_line": (22.442e-3,), "mid_zone_factor": (0.916,), "load_sharing_factor": (0.935,),
        "elasticity_factor": (191.646e3,), "hypoid_factor": (1.0,), "film_factors": (0.992 * 0.974 * 0.930,),
        "contact_stress_nominal": (1168.5e6,), "contact_stress": (1712.8e6,), "safety_pitting": (0.944, 0.944),
        "contact_stress_permissible": (1617.8e6, 1617.8e6), "contact_ratio_factor": (0.625,),
        "spiral_angle_factor": (1.054,), "form_factor": (2.033, 2.480), "notch": (3.630, 2.166),
        "stress_correction": (2.022, 1.706), "root_stress_nominal": (316.5e6, 325.9e6),
        "root_stress": (680.1e6, 700.1e6), "root_stress_permissible": (942.0e6, 929.8e6),
        "safety_root": (1.385, 1.328),
    },
    "iso23509_f3": {
        "force_tangential": (10427.4,), "force_normal": (15298.7,), "dynamic_factor": (1.016,),
        "face_load_factor": (1.650,), "face_load_factor_root": (1.556,), "transverse_load_factor": (1.000,),
        "contact_line": (13.397e-3,), "mid_zone_factor": (0.963,), "hypoid_factor": (0.952,),
        "load_sharing_factor": (0.703,),
        "contact_ratio_factor": (0.625,), "spiral_angle_factor": (1.909,), "form_factor": (2.047, 2.403),
        "notch": (2.910, 2.073), "stress_correction": (1.903, 1.690), "root_stress_permissible": (936.4e6, 929.0e6),
    },
    "iso23509_f4": {
        "force_tangential": (11567.5,), "force_normal": (14339.0,), "face_load_factor_root": (1.633,),
        "transverse_load_factor": (1.000,), "mid_zone_factor": (0.937,), "load_sharing_factor": (0.961,),
        "hypoid_factor": (0.829,), "film_factors": (0.966 * 0.998,), "contact_ratio_factor": (0.662,),
        "contact_line": (21.377e-3,), "contact_stress_nominal": (1194.5e6,), "contact_stress": (1609.2e6,),
        "spiral_angle_factor": (1.014,), "root_stress_nominal": (316.7e6, 328.8e6), "root_stress": (568.9e6, 590.5e6),
        "form_factor": (2.102, 2.586), "notch": (3.636, 2.118), "stress_correction": (1.988, 1.677),
        "root_stress_permissible": (1011.5e6, 997.9e6),
    },
}  # fmt: skip
# Z_R of sample 3 is 1 here (1.009): no more for flanks smoother than those of the test gears


@pytest.mark.parametrize("name", RATED)
def test_load_capacity_of_the_technical_report(name: str) -> None:
    rated = pair_blank(load_blank(name)).rating_drive
    for quantity, printed in RATED[name].items():
        value = np.atleast_1d(getattr(rated, quantity))
        assert value == pytest.approx(printed, rel=1e-3), quantity


def test_dynamic_factor_of_the_technical_report() -> None:
    """K of sample 3 to the printed digit, at a contact ratio of 2.04; K_v of the others stands in `RATED`."""
    inputs = load_blank("iso23509_f4")
    rating = inputs.rating.model_copy(update={"dynamic_factor": None})
    found = pair_blank(inputs.model_copy(update={"rating": rating})).rating_drive.dynamic_factor
    # discs of steel on the virtual gears, 20 N/(mm um)
    pinion, gear = (pi / 8.0 * 7860.0 * (d / cos(radians(20.0))) ** 2 for d in (51.258e-3, 146.7e-3))
    speed = rating.speed * 9.0 / sqrt(20e9 * (1.0 / pinion + 1.0 / gear))
    assert (found - 1.0) / speed == pytest.approx(0.589, abs=1.5e-3)


def test_dynamic_and_transverse_factors_over_the_contact_ratio() -> None:
    """Perfect teeth: K_v is continuous at a contact ratio of 2, falls with it at resonance, 1 at most far above it."""
    pair, inputs = rated_pair(load_design("fm_spiral_bevel_14x39")), load_blank("iso23509_f2").rating
    resonance = 3.306e3  # pinion speed [rad/s] of both discs of steel on 20 N/(mm um)

    def factors(total: float, speed: float, deviation: float = 0.0) -> tuple[float, float]:
        flank = replace(pair.virtual_drive, contact_ratio_total=total)
        own = inputs.model_copy(update={"speed": speed, "pitch_deviation_gear": deviation})
        rated = rate_flank(replace(pair, virtual_drive=flank), own, "drive")
        return rated.dynamic_factor, rated.transverse_load_factor

    for speed in (0.5, 1.0, 2.0):
        below, above = (factors(total, speed * resonance)[0] for total in (2.0, 2.0 + 1e-9))
        assert above == pytest.approx(below, rel=0.04)
    at_resonance = [factors(total, resonance)[0] for total in (2.0, 2.4, 3.0, 4.0)]
    assert at_resonance == sorted(at_resonance, reverse=True)
    assert at_resonance[-1] == pytest.approx(1.145, abs=1e-3)
    assert [factors(total, 10.0 * resonance)[0] for total in (1.2, 2.0, 3.0)] == pytest.approx([0.75, 0.875, 1.0])
    # the most loaded tooth over the mean one: K_Halpha is proportional to the number of teeth that share the load
    few, many = (factors(total, 1.0, 2e-4)[1] for total in (1.4, 2.0))
    assert many > 2.0
    assert few == pytest.approx(0.7 * many, rel=1e-3)


# printed in ANSI/AGMA 2003-D19, Annex E, in psi and hp; read in the self test of the same repository
PSI, HP = 6894.757, 745.6999
AGMA: dict[str, tuple[tuple[float, ...], float]] = {
    "dynamic_factor": ((1.081,), 1.5e-3), "face_load_factor": ((1.1036,), 1e-4),
    "size_factor_pitting": ((0.5625,), 1e-4), "size_factor_root": ((0.5248,), 1e-4),
    "curvature_factor": ((1.0,), 1e-9), "elasticity_factor": ((2290.0 * math.sqrt(PSI),), 1e-3),
    "contact_stress": ((149384.0 * PSI,), 1.5e-3), "root_stress": ((18194.0 * PSI, 18613.0 * PSI), 1.5e-3),
    # rounded life factors, used as printed in what follows
    "life_factor_pitting": ((1.0, 1.06), 4e-3), "life_factor_root": ((0.94, 0.95), 6e-3),
    "hardness_ratio_factor": ((1.0, 1.0), 1e-9),
    "contact_stress_permissible": ((200000.0 * PSI, 212000.0 * PSI), 5e-3),
    "root_stress_permissible": ((28200.0 * PSI, 28500.0 * PSI), 6e-3),
    "power_pitting": ((71.67 * HP, 80.53 * HP), 7e-3), "power_root": ((62.0 * HP, 61.2 * HP), 6e-3),
}  # fmt: skip


def agma(**changes: Any) -> dict[str, Any]:
    """Annex E of AGMA 2003 as a table `rating`."""
    steel = {"contact_stress_number": 200e3 * PSI, "bending_stress_number": 30e3 * PSI}
    factors = {"pitting_geometry_factor": 0.109, **changes}
    factors |= {
        member: {"bending_geometry_factor": value} | steel for member, value in (("pinion", 0.222), ("gear", 0.217))
    }
    return {
        "torque": 1440.0 * 0.112984829, "speed": 1750.0 * pi / 30.0, "life": None, "accuracy_grade": 5,
        "cantilevered": "one", "edge_radius_pinion": 8e-4, "edge_radius_gear": 1.2e-3, "agma_2003": factors,
    }  # fmt: skip


def rated_agma(rating: dict[str, Any], name: str = "iso23509_f2") -> AgmaRating:
    """Rating of a blank, by default that of Annex E: 14x39, 5.6 teeth per inch, face 1 inch, cutter 9 inches."""
    inputs = load_blank(name).model_copy(update={"rating": validate(RatingInput, rating)})
    return pair_blank(inputs).rating_agma


def test_load_capacity_of_agma_2003_annex_e() -> None:
    found = rated_agma({**agma(), "life": 1e9 / 60.0 / 1750.0})
    for name, (printed, tolerance) in AGMA.items():
        assert np.atleast_1d(getattr(found, name)) == pytest.approx(printed, rel=tolerance), name
    assert found.safety_pitting[0] == pytest.approx(200000.0 / 149384.0, rel=2e-3)
    tables = stress_numbers(AgmaMember(bending_geometry_factor=0.2), "pinion")
    assert tables == pytest.approx((1380e6, 205e6))
    with refuses("rating.agma_2003"):
        rated_agma(agma(), "iso23509_f4")


def test_factors_of_agma_2003_by_hand() -> None:
    plain = rated_agma(agma())
    rare, hot = rated_agma(agma(one_failure_in=1000)), rated_agma(agma(temperature_blank=273.15 + 159.0))
    assert rare.safety_pitting[0] == pytest.approx(plain.safety_pitting[0] / 1.12)
    assert rare.safety_root[1] == pytest.approx(plain.safety_root[1] / 1.25)
    assert hot.safety_root[0] == pytest.approx(plain.safety_root[0] / (432.0 / 393.0))
    assert rated_agma(agma(crowning_factor=2.0)).contact_stress == pytest.approx(plain.contact_stress * sqrt(2.0 / 1.5))
    # S_H at the torque that the power allows is 1
    there = {**agma(), "torque": agma()["torque"] * plain.safety_pitting[0] ** 2}
    assert rated_agma(there).safety_pitting[0] == pytest.approx(1.0)
    # K_L has a knee at 3e6 cycles, below 1e3 it is constant
    pitting, root = life_curves(False)
    assert root[0][1] == pytest.approx(3.0e6, rel=0.02)
    assert life_factor(root, 10.0) == pytest.approx(6.1514 * 1e3**-0.1192)
    assert life_factor(pitting, 1e7) == pytest.approx(3.4822 * 1e7**-0.0602)
    assert life_factor(life_curves(True)[1], 1e9) == pytest.approx(1.683 * 1e9**-0.0323)
    soft = AgmaMember(bending_geometry_factor=0.2, material="through_hardened", brinell=250.0)
    harder = soft.model_copy(update={"brinell": 400.0})
    assert stress_numbers(soft, "gear") == pytest.approx((750.39e6, 89.48e6))
    assert hardness_ratio_factor(harder, soft, 3.0, 0.8e-6) == pytest.approx(1.0 + 2.0 * (0.00898 * 1.6 - 0.00829))
    assert hardness_ratio_factor(soft, soft, 3.0, 0.8e-6) == 1.0
    case = AgmaMember(bending_geometry_factor=0.2)
    assert hardness_ratio_factor(case, soft, 3.0, 1e-6) == pytest.approx(1.0 + 0.15 * math.exp(-0.52))
    with refuses("brinell"):
        validate(AgmaMember, {"bending_geometry_factor": 0.2, "material": "through_hardened"})
    with refuses("rating.agma_2003.gear.grade"):
        stress_numbers(AgmaMember(bending_geometry_factor=0.2, material="nitralloy"), "gear")


def test_load_spectrum_after_agma_2003() -> None:
    step = {"torque": agma()["torque"], "speed": 183.0, "hours": 1e3}
    found, twice = rated_agma({**agma(), "loads": [step]}), rated_agma({**agma(), "loads": [step, step]})
    assert twice.spectrum.damage_root == pytest.approx([2.0 * x for x in found.spectrum.damage_root])
    cycles = 1800.0 * 1e3 * 183.0 / pi
    # one step: the safety of its own life
    alone = rated_agma({**agma(), "life": 1e3, "speed": 183.0})
    assert found.spectrum.safety_root_spectrum == pytest.approx(alone.safety_root, rel=1e-6)
    assert life_factor(life_curves(False)[0], cycles) == pytest.approx(alone.life_factor_pitting[0])


def test_design_is_rated_after_agma_2003_as_its_blank() -> None:
    design = load_design("fm_spiral_bevel_14x39")
    factors = RatingFactors(**{k: v for k, v in agma().items() if k in RatingFactors.model_fields})
    rated = efficiency.GearPair(design.model_copy(update={"rating": factors})).rating("162.7 N m", "1750 rpm")
    assert rated.agma_2003.contact_stress == pytest.approx(149384.0 * PSI, rel=5e-3)
    names = [item.name for item in rated.sections()[0].items if isinstance(item, Table)]
    assert names == ["rating", "safety", "rating_agma", "safety_agma"]
    assert json.dumps(rated.to_dict(), allow_nan=False)


@pytest.mark.parametrize(("design", "name"), [("fh_hypoid_9x34", "iso23509_f4"), ("fm_hypoid_13x42", "iso23509_f3")])
def test_load_capacity_of_a_design_is_that_of_its_blank(design: str, name: str) -> None:
    """The flanks give spiral and pressure angles within 0.25 deg of the blank, and its thicknesses within 1 %."""
    inputs, geometry = load_blank(name).rating, rated_pair(load_design(design))
    for quantity, printed in RATED[name].items():
        value = np.atleast_1d(getattr(rate_flank(geometry, inputs, "drive"), quantity))
        assert value == pytest.approx(printed, rel=1.3e-2), quantity


@pytest.mark.parametrize("offset", [0.01, -0.01])
def test_load_capacity_of_a_new_design_is_that_of_its_blank(offset: float) -> None:
    targets = load_targets("fh_hypoid_9x34_offset_10")
    targets = targets.model_copy(update={"blank": targets.blank.model_copy(update={"hypoid_offset": offset})})
    pair = efficiency.GearPair(efficiency.settings(targets).design)
    rated, blank = pair.rating(), pair_blank(targets.blank)
    for side in ("drive", "coast"):
        own, expected = getattr(rated, side), rate_flank(blank, rated.inputs, side)
        assert own.safety_pitting == pytest.approx(expected.safety_pitting, rel=5e-3)
        assert own.safety_root == pytest.approx(expected.safety_root, rel=5e-3)


def test_rating_of_a_design_with_a_duty_cycle() -> None:
    pair = efficiency.load("fh_hypoid_9x34")
    drive, coast = DutyRow(300.0, 300.0, 363.0, 100.0), DutyRow(-100.0, 200.0, 363.0, 10.0)
    rated, alone = pair.rating("300 N m", duty=[drive, coast]), pair.rating("300 N m")
    assert alone.drive.spectrum is None
    assert rated.drive.safety_root == alone.drive.safety_root
    assert rated.drive.spectrum.damage_pitting[0] > 1.0 > rated.coast.spectrum.damage_pitting[0]
    for row, loaded, other in ((drive, "drive", "coast"), (coast, "coast", "drive")):
        single = pair.rating(duty=[row])
        sheet = next(t for t in single.sections()[0].items if isinstance(t, Table) and t.name == "safety").to_frame()
        known = sheet.set_index("side")["damage_root"].notna()
        assert known[loaded].all()
        assert not known[other].any()
    assert len(alone.notes) == 2
    assert json.dumps(alone.to_dict(), allow_nan=False)
    with refuses("torque"):
        pair.rating("-5 N m")
    with refuses("design"):
        efficiency.load("eaxle_helical_23x75").rating()


def test_rating_is_continuous_towards_straight_teeth_and_refuses_a_root_without_thickness() -> None:
    inputs = load_blank("iso23509_f2")
    stresses = [
        pair_blank(inputs.model_copy(update={"mean_spiral_angle_gear": angle})).rating_drive.contact_stress
        for angle in (0.0, 1e-4, 1e-2)
    ]
    assert stresses == pytest.approx([stresses[0]] * 3, rel=5e-3)
    with refuses("rating.edge_radius_pinion"):
        pair_blank(inputs.model_copy(update={"rating": inputs.rating.model_copy(update={"edge_radius_pinion": 0.02})}))


def test_damage_of_a_spectrum_by_hand() -> None:
    inputs = load_blank("iso23509_f2")
    inputs = inputs.model_copy(update={"rating": inputs.rating.model_copy(update={"torque": 200.0, "speed": 100.0})})
    step = {"torque": 200.0, "speed": 100.0, "hours": 500.0}

    def rated(*loads: dict[str, float]) -> FlankRating:
        rating = RatingInput(**{**inputs.rating.model_dump(), "loads": loads})
        return pair_blank(inputs.model_copy(update={"rating": rating})).rating_drive

    once, twice = rated(step), rated(step, {**step, "torque": 350.0, "hours": 10.0})
    cycles = 500.0 * 3600.0 * 100.0 / (2.0 * math.pi)
    alone = pair_blank(inputs).rating_drive
    for i, u in enumerate((1.0, 39.0 / 14.0)):
        factor = (5e7 / (cycles / u)) ** (math.log(1.6) / math.log(500.0))
        slow = (cycles / u / 5e7) ** (math.log(0.85) / math.log(200.0))
        wanted = alone.safety_pitting[i] * (factor if cycles / u < 5e7 else slow)
        assert once.spectrum.safety_pitting_spectrum[i] == pytest.approx(wanted, rel=1e-9)
        assert twice.spectrum.damage_root[i] >= once.spectrum.damage_root[i]
        assert twice.spectrum.safety_root_spectrum[i] < once.spectrum.safety_root_spectrum[i]
    assert rated().spectrum is None
    with refuses("torque"):
        validate(RatingInput, {"torque": -1.0, "speed": 1.0, "edge_radius_pinion": 1e-3, "edge_radius_gear": 1e-3})


@pytest.mark.parametrize("name", list(REFERENCE["high_reduction"]))
def test_measured_parts_of_high_reductions(name: str) -> None:
    part = REFERENCE["high_reduction"][name]
    given, angle = part["inputs"], {symbol: radians(float(part[symbol])) for symbol in part if symbol[:5] == "delta"}
    inputs: dict[str, Any] = {
        "name": name, "method": 1, "process": "face_milling", "teeth_pinion": given["teeth"][0],
        "teeth_gear": given["teeth"][1], "hand_pinion": part["hand_pinion"],
        "hypoid_offset": f"{given['offset']} mm", "outer_pitch_diameter_gear": f"{given['outer_diameter']} mm",
        "face_width_gear": f"{given['face_width']} mm", "cutter_radius": f"{given['cutter_radius']} mm",
        "mean_spiral_angle_pinion": f"{given['spiral_pinion']} deg",
        "taper": {
            "type": "given", "addendum_angle_gear": angle["delta_a2"] - angle["delta2"],
            "dedendum_angle_gear": angle["delta2"] - angle["delta_f2"],
        },
    }  # fmt: skip

    def mean_height(kind: str, cone: str, member: int, outside: float) -> float:
        """Height at the calculation point from the one at the heel [mm]."""
        slope = tan(abs(angle[f"delta_{cone}{member}"] - angle[f"delta{member}"]))
        return float(part[f"h{kind}e{member}"]) - MM * outside * slope

    pair = pair_blank(validate(PairBlankInput, inputs))
    module, outside = MM * pair.module_normal, (pair.pinion.face_width_outside, pair.gear.face_width_outside)
    addendum, dedendum = ([mean_height(kind, kind, i, outside[i - 1]) / module for i in (1, 2)] for kind in ("a", "f"))
    inputs["depth"] = {
        "data_type": "I",
        "profile_shift": 0.5 * (addendum[0] - addendum[1]),
        "addendum_factor": 0.5 * sum(addendum),
        "dedendum_factor": 0.5 * sum(dedendum),
    }
    pair = pair_blank(validate(PairBlankInput, inputs))
    for i, member in ((1, pair.pinion), (2, pair.gear)):
        assert degrees(abs(member.pitch_angle - angle[f"delta{i}"])) < 0.03
        # the measured face and root angle of the 5x75 pinion do not belong to those of its gear: 0.3 and 0.4 deg
        loose = 0.45 if (name, i) == ("5x75", 1) else 0.06
        assert degrees(abs(member.face_angle - angle[f"delta_a{i}"])) < loose
        assert degrees(abs(member.root_angle - angle[f"delta_f{i}"])) < loose
        assert MM * member.outer_tip_diameter == pytest.approx(float(part[f"dae{i}"]), rel=7e-3)
    assert MM * pair.pinion.face_width == pytest.approx(float(part["b1"]), rel=0.02)
    assert degrees(pair.gear.mean_spiral_angle) == pytest.approx(float(part["beta_m2"]), abs=0.6)
