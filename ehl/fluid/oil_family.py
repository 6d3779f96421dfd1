"""Generic oil from base oil, viscosities at 40 and 100 degC or the ISO VG, and density.

ln(eta/eta0) has the form of the FVA 400 oils of the family (`ModulusLaw`): the mean of their constants, each set scaled
to a secant of 1 1/GPa at 0.2 GPa and 80 degC. The level follows from a fit of that secant for the family,
alpha = s nu^t, from 30 to 120 degC. The fits of PAO and ester include three more oils, whose laws fail at higher
pressure. Mean, spread and fit are own evaluations of data/reference/oils_fva400.csv.

Viscosity index after ASTM D2270 (ISO 2909), and the second viscosity from it.
"""

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from ehl.common.errors import InputError, check_choice, near, same_name
from ehl.common.units import KELVIN
from ehl.fluid.density import density_at
from ehl.fluid.rheology import LinearStress
from ehl.fluid.viscosity import walther_1931

# lowest kinematic viscosity at 100 degC of a row [cSt]; L = a Y^2 + b Y + c, H = d Y^2 + e Y + f of the reference oils
# of VI 0 and 100 (equations of ASTM D2270, unverified; worked examples in the tests)
_REFERENCE = (
    (2.0, 1.14673, 1.7576, -0.109, 0.84155, 1.5521, -0.077),
    (3.8, 3.38095, -15.4952, 33.196, 0.78571, 1.7929, -0.183),
    (4.4, 2.5, -7.2143, 13.812, 0.82143, 1.5679, 0.119),
    (5.0, 0.101, 16.635, -45.469, 0.04985, 9.1613, -18.557),
    (6.4, 3.35714, -23.5643, 78.466, 0.22619, 7.7369, -16.656),
    (7.0, 0.01191, 21.475, -72.870, 0.79762, -0.7321, 14.610),
    (7.7, 0.41858, 16.1558, -56.040, 0.05794, 10.5156, -28.240),
    (9.0, 0.88779, 7.5527, -16.600, 0.26665, 6.7015, -10.810),
    (12.0, 0.76720, 10.7972, -38.180, 0.20073, 8.4658, -22.490),
    (15.0, 0.97305, 5.3135, -2.200, 0.28889, 5.9741, -4.930),
    (18.0, 0.97256, 5.2500, -0.980, 0.24504, 7.4160, -16.730),
    (22.0, 0.91413, 7.4759, -21.820, 0.20323, 9.1267, -34.230),
    (28.0, 0.87031, 9.7157, -50.770, 0.18411, 10.1015, -46.750),
    (40.0, 0.84703, 12.6752, -133.310, 0.17029, 11.4866, -80.620),
    (55.0, 0.85921, 11.1009, -83.190, 0.17130, 11.3680, -76.940),
    (70.0, 0.83531, 14.6731, -216.246, 0.16841, 11.8493, -96.947),
)
LOWEST, HIGHEST = 2e-6, 2e-3  # kinematic viscosity at 100 degC [m2/s]
INDEX_RANGE = (-20.0, 400.0)


def astm_d2270(viscosity_40: float, viscosity_100: float) -> float:
    """Viscosity index of an oil.

    With L and H, the viscosities at 40 degC of reference oils of the same viscosity Y at 100 degC:

        VI = 100 (L - U)/(L - H) up to 100,  VI = 100 + (10^N - 1)/0.00715,  N = ln(H/U)/ln(Y) above

    viscosity_40, viscosity_100: kinematic viscosity at 40 and 100 degC, U and Y [m2/s]; Y of at least 2 cSt.
    """
    if viscosity_100 < LOWEST:
        raise InputError("viscosity_100", viscosity_100, "at least 2 cSt, the lower limit of the viscosity index")
    u, y = 1e6 * viscosity_40, 1e6 * viscosity_100
    _, a, b, c, d, e, f = next(row for row in reversed(_REFERENCE) if y >= row[0])
    low, high = a * y**2 + b * y + c, d * y**2 + e * y + f
    if u >= high:
        return float(100.0 * (low - u) / (low - high))
    return float(100.0 + (10.0 ** (math.log(high / u) / math.log(y)) - 1.0) / 0.00715)


def both_viscosities(index: float, viscosity_40: float | None, viscosity_100: float | None) -> tuple[float, float]:
    """Kinematic viscosities at 40 and 100 degC from one of them and the viscosity index [m2/s].

    Raises `InputError`: no oil has both.
    """
    if not INDEX_RANGE[0] <= index <= INDEX_RANGE[1]:
        raise InputError("viscosity_index", index, f"{INDEX_RANGE[0]:g} to {INDEX_RANGE[1]:g}")
    known = viscosity_100 if viscosity_40 is None else viscosity_40
    assert known is not None

    def excess(other: float) -> float:
        pair = (other, known) if viscosity_40 is None else (known, other)
        return astm_d2270(*pair) - index

    ends = (1.05 * known, 200.0 * known) if viscosity_40 is None else (LOWEST, min(known / 1.05, HIGHEST))
    from scipy.optimize import brentq

    try:
        other = float(brentq(excess, *ends, xtol=1e-15, rtol=1e-12))
    except ValueError:
        where = "40" if viscosity_40 is not None else "100"
        hint = "The viscosity at 100 degC must be at least 2 cSt."
        allowed = f"the index of an oil of {1e6 * known:g} cSt at {where} degC"
        raise InputError("viscosity_index", index, allowed, hint) from None
    return (other, known) if viscosity_40 is None else (known, other)


LEVEL_TEMPERATURE = 80.0 + KELVIN  # temperature of the secant of a family [K]
STRESS_TEMPERATURE = 40.0 + KELVIN  # of tau00 [K]
TEMPERATURES = (20.0 + KELVIN, 150.0 + KELVIN)
ISO_VG = (10, 15, 22, 32, 46, 68, 100, 150, 220, 320, 460, 680, 1000, 1500)
_CST = r"(\d*\.?\d+)(?: ?cst)?"
_NAME = re.compile(rf"([a-z]+)[ :]+(?:(?:(?:iso )?vg ?(\d+)|{_CST})(?:[ ,]+vi ?(\d*\.?\d+))?|{_CST} ?/ ?{_CST})")


@dataclass(frozen=True)
class OilFamily:
    """Mean properties of the oils of one base; shear for oils whose card has none (docs/shear.md).

    Shear: tau0 = tau00 + c (T - 40 degC) + s p and tau_L = Lambda p. tau0 is the mean of 2 Lambda_A/alpha(p, T),
    alpha = d ln(eta)/dp, over the FVA 400 oils of the family. Formula and Lambda_A are from Arana, Larranaga & Ulacia
    (2019): Eyring flow with a constant ratio of the activation volumes of stress and pressure. The three constants are
    fitted from 40 to 120 degC and 0 to 1.2 GPa.
    """

    # a1 [Pa], a2 [Pa/K], b1, b2 [1/K] of the modulus law, T in degC, times the secant at 80 degC in 1/GPa
    shape: tuple[float, float, float, float]
    secant: tuple[float, float]  # s and t of the secant at 0.2 GPa, s nu^t 1/GPa, nu in cSt
    # standard deviation of ln(eta/eta0) of the oils of the family, 40 to 120 degC, 0.2 to 1.2 GPa [-]
    spread: float
    viscosity_100: tuple[float, float]  # k and m of nu100 = k nu40^m in cSt, if only the ISO VG is given
    density_15: float  # typical value [kg/m3]
    oils: tuple[str, ...]  # cards of the family
    stress: float  # tau00, at 40 degC and ambient pressure [Pa]
    stress_temperature: float  # c [Pa/K]
    stress_pressure: float  # s [-]
    ratio: float  # Lambda_A [-]
    limit_slope: float  # Lambda [-]
    limit_range: tuple[float, float]  # range of published values of Lambda [-]
    source: str  # of Lambda_A and Lambda

    def eyring_stress(self, temperature: Any) -> LinearStress:
        """tau0 over pressure at an inlet temperature [K]; constant below 0 degC."""
        above = np.maximum(temperature, KELVIN) - STRESS_TEMPERATURE
        return LinearStress(self.stress + self.stress_temperature * above, self.stress_pressure)


# tuned: nu100 over nu40 (own fit) for mineral from fva2 and minr, for pao from pao100 and paor, for the others from one
# oil each with a typical exponent; densities are typical of the cards
#
# Lambda: mineral is the mean of LVI 260 (.047, Arana et al. 2019) and Shell T9 (.083, Habchi 2018). The ratios of PAO
# and polyglycol to it are those of Arana et al. (.035 and .044 to .047), whose limit concerns mean friction. Ester lies
# between paraffinic oil and PAO (order at 40 degC: Lubricants 2025 13:485). Lambda does not depend on temperature, as
# for T9, the only published data. Lower ends are measured mean tractions of thrust ball bearings (FEUP)
OIL_FAMILIES = {
    "mineral": OilFamily(
        (402.1e6, 6.120e6, 0.5834, -5.261e-4), (9.20, 0.159), 0.11, (0.616, 0.623), 880.0,
        ("fva3_400", "fva2", "fva2a", "fva2b", "hvi"),
        4.08e6, 3.22e4, 8.90e-3, 0.047, 0.065, (0.056, 0.083),
        "ratio published for LVI 260; limit: mean of LVI 260 and T9",
    ),
    "hydrocracked": OilFamily(
        (463.1e6, 5.592e6, 0.4051, 5.301e-4), (6.72, 0.174), 0.08, (0.790, 0.600), 850.0,
        ("hc", "hc_additive", "hc_pma", "hc_pma_additive"),
        5.05e6, 4.31e4, 8.46e-3, 0.041, 0.057, (0.044, 0.065),
        "ratio and limit: mean of mineral oil and PAO (this work)",
    ),
    "pao": OilFamily(
        (411.8e6, 6.395e6, 0.4598, -9.628e-4), (7.09, 0.144), 0.14, (0.531, 0.720), 850.0,
        ("pao_ester", "pao_ester_additive", "pao_ester_additive_pma", "pao_ester_pao100", "pao_ester_pib"),
        4.26e6, 3.90e4, 7.10e-3, 0.035, 0.048, (0.044, 0.062),
        "ratio published for PAO 100; limit: in proportion to that of mineral oil",
    ),
    "ester": OilFamily(
        (462.6e6, 5.523e6, 0.3128, 2.062e-3), (6.02, 0.178), 0.14, (0.546, 0.720), 940.0,
        ("pti_additive", "dia_pma", "ke", "ke_additive"),
        4.15e6, 4.94e4, 1.085e-2, 0.041, 0.057, (0.043, 0.065),
        "ratio and limit: mean of mineral oil and PAO (order published)",
    ),
    "polyglycol": OilFamily(
        (511.1e6, 5.452e6, 0.06515, 2.482e-3), (4.19, 0.222), 0.22, (0.390, 0.850), 1050.0,
        ("pg_1_1", "pg_0_1", "pg_kom1", "pg_kom2"),
        5.44e6, 6.73e4, 5.88e-3, 0.044, 0.061, (0.044, 0.078),
        "ratio published; limit: in proportion to that of mineral oil",
    ),
}  # fmt: skip

# apparent modulus of the film without the compliance of the bodies: traction tests of 5P4E and Santotrac gave 0.3 to
# 1 GPa (unverified); the lowest value is used for all oils (own choice, uncertain by a factor of 3)
SHEAR_MODULUS = 0.3e9


def vogel_constants(viscosity_40: float, viscosity_100: float, density_15: float, coefficient: float) -> dict[str, Any]:
    """K [Pa s], B, C [K] of eta0 = K exp(B/(T + C)), T in degC, from Walther's nu times rho at 40, 100 and 160 degC.

    viscosity_40, viscosity_100: kinematic viscosity [m2/s].
    density_15, coefficient: of `density_at` [kg/m3, 1/K].
    """
    low, middle, high = (
        math.log(walther_1931(at, viscosity_40, viscosity_100) * density_at(at, density_15, coefficient))
        for at in (40.0 + KELVIN, 100.0 + KELVIN, 160.0 + KELVIN)
    )
    ratio = (low - middle) / (middle - high)  # = (160 + C)/(40 + C)
    shift = (160.0 - 40.0 * ratio) / (ratio - 1.0)
    rise = (low - middle) * (40.0 + shift) * (100.0 + shift) / 60.0
    return {"K": math.exp(low - rise / (40.0 + shift)), "B": rise, "C": shift}


def generic_card(
    base: str,
    viscosity_40: float | None = None,
    viscosity_100: float | None = None,
    iso_vg: float | None = None,
    density_15: float | None = None,
    name: str | None = None,
    viscosity_index: float | None = None,
) -> dict[str, Any]:
    """Content of a generic card in SI units.

    base: a key of `OIL_FAMILIES`.
    viscosity_40, viscosity_100: kinematic viscosity [m2/s].
    iso_vg: instead of both viscosities.
    density_15: density at 15 degC [kg/m3]; default: typical of the family.
    name: of the card; default: base and viscosities.
    viscosity_index: with one of the viscosities or iso_vg.
    """
    base = same_name(base, OIL_FAMILIES)
    check_choice("base", base, OIL_FAMILIES, near(base, OIL_FAMILIES) or "For a semi-synthetic oil use the main base.")
    family = OIL_FAMILIES[base]
    given = [value is not None for value in (viscosity_40, viscosity_100, viscosity_index)]
    if (sum(given) != 2) if iso_vg is None else any(given[:2]):
        hint = "Use both viscosities of the data sheet, or one of them and the index; otherwise the ISO VG."
        raise InputError("iso_vg", iso_vg, "the ISO VG, or two of: viscosities at 40 and 100 degC, index", hint)
    if iso_vg is not None and iso_vg not in ISO_VG:
        raise InputError("iso_vg", iso_vg, "one of " + ", ".join(map(str, ISO_VG)), "Or give both viscosities.")
    known = iso_vg is None
    if viscosity_index is not None:
        nominal = viscosity_40 if iso_vg is None else 1e-6 * iso_vg
        viscosity_40, viscosity_100 = both_viscosities(viscosity_index, nominal, viscosity_100)
    elif iso_vg is not None:
        scale, exponent = family.viscosity_100
        viscosity_40, viscosity_100 = iso_vg * 1e-6, scale * iso_vg**exponent * 1e-6
    assert viscosity_40 is not None
    assert viscosity_100 is not None
    check_viscosities(viscosity_40, viscosity_100, "nu_100")
    density, coefficient = density_15 or family.density_15, -6.75e-4
    scale, exponent = family.secant
    secant = scale * (1e6 * walther_1931(LEVEL_TEMPERATURE, viscosity_40, viscosity_100)) ** exponent
    words = f"{base} {1e6 * viscosity_40:.6g}/{1e6 * viscosity_100:.6g}"
    if iso_vg is not None:
        words = f"{base} vg {iso_vg:g}" + (f" vi {viscosity_index:g}" if viscosity_index is not None else "")
    second = f"nu100 = {family.viscosity_100[0]:g} nu40^{family.viscosity_100[1]:g}"
    if viscosity_index is not None:
        second = f"viscosity index {viscosity_index:g} (ASTM D2270)"
    elif known:
        second = "nu40 and nu100 given"
    moduli = dict(zip(("a1", "a2", "b1", "b2"), (value / secant for value in family.shape), strict=True))
    return {
        "name": name or words,
        "description": f"generic {base} oil" + (f" ISO VG {iso_vg:g}" if iso_vg is not None else ""),
        "source": f"Estimated: ln(eta/eta0) has the mean shape of {len(family.oils)} FVA 400 oils "
        f"({', '.join(family.oils)}) and their secant at 0.2 GPa, {scale:g} nu^{exponent:g} = {secant:.2f} 1/GPa at "
        f"80 degC; {second}.  Typical values, not verified: conductivity and heat capacity.",
        "certainty": "mixed",
        "base": base,
        "viscosity_kinematic_40": viscosity_40,
        "viscosity_kinematic_100": viscosity_100,
        "density_15": density,
        "viscosity": {"law": "modulus", **vogel_constants(viscosity_40, viscosity_100, density, coefficient), **moduli},
        "pressure_viscosity": {"law": "modulus"},
        "temperature_valid": TEMPERATURES,
        "pressure_valid": 0.7e9,
        "uncertainty": {
            "pressure_viscosity": family.spread,
            "viscosity": 0.05 if known else 0.10,
            "source": "Estimated: scatter of the FVA 400 oils of the family about this shape and level; viscosity: "
            + ("data sheet compared with the oil in the gear" if known else "oils of one ISO VG")
            + (", nu100 estimated" if viscosity_index is None and not known else ""),
        },
    }


def check_viscosities(viscosity_40: float, viscosity_100: float, field: str) -> None:
    """Check that the viscosity decreases with temperature, and that the Walther equation applies.

    field: name of the viscosity at 100 degC.
    """
    if not viscosity_100 < viscosity_40:
        allowed = f"below the viscosity at 40 degC, {1e6 * viscosity_40:.6g} cSt"
        hint = "Are the two exchanged?" if viscosity_100 > viscosity_40 else ""
        raise InputError(field, f"{1e6 * viscosity_100:.6g} cSt", allowed, hint)
    if not viscosity_100 > 0.5e-6:
        raise InputError(field, f"{1e6 * viscosity_100:.6g} cSt", "above 0.5 cSt", "Write the unit: '13.3 cSt'.")


def generic_name(name: str) -> dict[str, Any] | None:
    """Arguments of `generic_card` from a name such as ``pao 97.5/13.3`` or ``mineral vg 220``; None for other names."""
    match = _NAME.fullmatch(name.strip().lower())
    if match is None:
        return None
    base, iso_vg, nu, index, *both = match.groups()
    if both != [None, None]:
        low, high = (1e-6 * float(value) for value in both)
        return {"base": base, "viscosity_40": low, "viscosity_100": high}
    given: dict[str, Any] = {} if index is None else {"viscosity_index": float(index)}
    if iso_vg is not None:
        return {"base": base, "iso_vg": int(iso_vg), **given}
    return {"base": base, "viscosity_40": 1e-6 * float(nu), **given} if given else None
