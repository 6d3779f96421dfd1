"""Published friction formulas, one function each, with arguments in SI units.

The units of the authors are converted inside each function. Definitions that differ between authors:
`speed_entrainment` is the mean (u1 + u2)/2 and `speed_sum` is u1 + u2; Rq is the RMS and Ra the mean absolute
roughness. "Published" coefficients are from a public secondary source; "unverified" ones should be checked in the
original. Ranges and these marks are in `regression.friction.published_registry`.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# b1..b9, found; P in GPa, u in m/s, viscosity in mPa s, R in m, roughness in um
XU_COEFFICIENTS = (-8.916465, 1.03303, 1.036077, -0.354068, 2.812084, -0.100601, 0.752755, -0.390958, 0.620305)

INCH = 0.0254
MICROINCH = 2.54e-8
KGF_PER_CM2 = 98066.5


def xu_kahraman_2007(
    pressure_hertz: Array,
    slide_to_roll_total: Array,
    speed_entrainment: Array,
    viscosity_inlet: Array,
    radius_equivalent: Array,
    roughness_rms: Array,
) -> Array:
    """Regression of EHL results for 75W90 (Xu, Kahraman, Anderson & Maddock 2007, J. Mech. Des. 129).

    mu = e^f P^b2 |SR|^b3 Ve^b6 n0^b7 R^b8, f = b1 + b4 |SR| P log10 n0 + b5 exp(-|SR| P log10 n0) + b9 e^S.
    Coefficients found. The film ratio is no variable. mu increases without limit with S (8 times from 0.1 to 1.5 um),
    is not meaningful below 1 mPa s, and vanishes for SR -> 0.

    pressure_hertz: P [Pa].
    slide_to_roll_total: sliding over entrainment speed [-]; the sign has no effect.
    speed_entrainment: Ve = (u1 + u2)/2 [m/s].
    viscosity_inlet: n0, dynamic viscosity at inlet temperature [Pa s].
    radius_equivalent: R [m].
    roughness_rms: S, composite Rq [m].
    """
    b1, b2, b3, b4, b5, b6, b7, b8, b9 = XU_COEFFICIENTS
    pressure = pressure_hertz * 1e-9
    sliding = np.abs(slide_to_roll_total)
    viscosity = viscosity_inlet * 1e3
    group = sliding * pressure * np.log10(viscosity)
    f = b1 + b4 * group + b5 * np.exp(-group) + b9 * np.exp(roughness_rms * 1e6)
    powers = pressure**b2 * sliding**b3 * speed_entrainment**b6 * viscosity**b7
    return np.exp(f) * powers * radius_equivalent**b8


def benedict_kelley_1961(
    load_per_length: Array,
    viscosity_inlet: Array,
    speed_sliding: Array,
    speed_sum: Array,
    roughness_rms: Array | float = 0.0,
) -> Array:
    """Disc tests (Benedict & Kelley 1961, ASLE Trans. 4).

    mu = 0.0127 log10(29660 w/(eta Vs VS^2)) 50/(50 - S), w in N/mm, eta in mPa s, speeds in m/s, S in microinch.
    The smooth part is published, the roughness factor is unverified. Values at or below zero mean conditions outside
    the range of the tests.

    load_per_length: w [N/m].
    viscosity_inlet: eta [Pa s].
    speed_sliding: Vs [m/s].
    speed_sum: VS = u1 + u2 [m/s].
    roughness_rms: S, RMS roughness [m], below 30 microinch (0.76 um); 0 gives a factor of 1.
    """
    load = load_per_length * 1e-3
    viscosity = viscosity_inlet * 1e3
    ratio = 29660.0 * load / (viscosity * speed_sliding * speed_sum**2)
    return 0.0127 * np.log10(ratio) * 50.0 / (50.0 - roughness_rms / MICROINCH)


def schlenk_1994(
    load_per_length: Array,
    viscosity_inlet: Array,
    speed_sum: Array,
    radius_equivalent: Array,
    roughness_ra: Array,
    lubricant_factor: Array | float = 1.0,
) -> Array:
    """Mean friction of a gear mesh (Schlenk; Niemann, Hoehn & Michaelis).

    mu = 0.048 ((Fbt/b)/(vSum rho))^0.2 eta^-0.05 Ra^0.25 XL; N/mm, m/s, mm, mPa s, um. Published (the year is
    unverified). It is a mean over the path of contact with quantities at the pitch point, applied here with local
    quantities.

    load_per_length: fbt/b [N/m].
    viscosity_inlet: dynamic viscosity at oil temperature [Pa s].
    speed_sum: u1 + u2 [m/s].
    radius_equivalent: rho [m].
    roughness_ra: mean of both Ra [m].
    lubricant_factor: XL, see `lubricant_factor_niemann`.
    """
    smooth = _mesh_mean(0.048, load_per_length, viscosity_inlet, speed_sum, radius_equivalent)
    return smooth * (roughness_ra * 1e6) ** 0.25 * lubricant_factor


def _mesh_mean(factor: float, load_per_length: Array, viscosity: Array, speed_sum: Array, radius: Array) -> Array:
    """The mean of a mesh by load, speed, radius and viscosity, without the roughness."""
    group = load_per_length * 1e-3 / (speed_sum * radius * 1e3)
    return factor * group**0.2 * (viscosity * 1e3) ** -0.05


def lubricant_factor_niemann(base: str, speed_sum: Array) -> Array:
    """XL by base oil: mineral 1, PAO and ester 0.8, polyglycol 0.75 (6/vSum)^0.2 (unverified; vSum in m/s).

    Hydrocracked oils count as mineral oils (own choice). Fits to measurements gave 0.846, 0.65 and 0.585 instead
    (found).
    """
    if base == "polyglycol":
        return 0.75 * (6.0 / speed_sum) ** 0.2
    return np.full_like(speed_sum, {"mineral": 1.0, "hydrocracked": 1.0, "pao": 0.8, "ester": 0.8}[base])


def iso_tr_14179_1(viscosity_kinematic: Array, load_intensity: Array, speed_pitch_line: Array) -> Array:
    """Mesh friction of ISO/TR 14179-1: nu^-0.223 K^-0.40/(3.239 V^0.70); unverified.

    Range: V of 2 to 25 m/s, K of 1.4 to 14 N/mm2.

    viscosity_kinematic: nu at oil temperature [m2/s] (in the formula cSt).
    load_intensity: K factor [Pa] (in the formula N/mm2).
    speed_pitch_line: V [m/s].
    """
    viscosity = viscosity_kinematic * 1e6
    intensity = load_intensity * 1e-6
    return viscosity**-0.223 * intensity**-0.40 / (3.239 * speed_pitch_line**0.70)


def iso_tr_14179_2(
    load_per_length: Array,
    viscosity_inlet: Array,
    speed_sum: Array,
    radius_equivalent: Array,
    roughness_ra: Array,
    pinion_diameter: Array,
) -> Array:
    """Mesh friction of ISO/TR 14179-2, unverified.

    mu = 0.045 ((KA Fbt/b)/(vSum rho))^0.2 eta^-0.05 XR, XR = 3.8 (Ra/d1)^0.25;
    N/mm, m/s, mm, mPa s, Ra in um, d1 in mm.

    load_per_length: KA Fbt/b [N/m].
    viscosity_inlet, speed_sum, radius_equivalent, roughness_ra: as in `schlenk_1994`.
    pinion_diameter: d1, pitch diameter of the pinion [m].
    """
    rough = 3.8 * (roughness_ra * 1e6 / (pinion_diameter * 1e3)) ** 0.25
    return _mesh_mean(0.045, load_per_length, viscosity_inlet, speed_sum, radius_equivalent) * rough


def misharin_1958(viscosity_kinematic: Array, speed_sliding: Array, speed_sum: Array) -> Array:
    """Disc tests (Misharin 1958): 0.325 (Vs VS nu)^-0.25, limited to 0.02 to 0.08; m/s and cSt; unverified.

    viscosity_kinematic: nu [m2/s].
    speed_sliding: Vs [m/s].
    speed_sum: VS = u1 + u2 [m/s].
    """
    return np.clip(0.325 * (speed_sliding * speed_sum * viscosity_kinematic * 1e6) ** -0.25, 0.02, 0.08)


def drozdov_gavrikov_1967(
    pressure_hertz: Array, viscosity_kinematic: Array, speed_sliding: Array, speed_sum: Array
) -> Array:
    """Disc tests (Drozdov & Gavrikov 1967), unverified.

    mu = 1/(0.8 sqrt(nu) Vs + VS phi + 13.4), phi = 0.47 - 0.13e-4 p - 0.4e-3 nu; p in kgf/cm2, nu in cSt, m/s.

    pressure_hertz: maximum pressure p [Pa].
    viscosity_kinematic: nu [m2/s].
    speed_sliding: Vs [m/s].
    speed_sum: VS = u1 + u2 [m/s].
    """
    viscosity = viscosity_kinematic * 1e6
    phi = 0.47 - 0.13e-4 * pressure_hertz / KGF_PER_CM2 - 0.4e-3 * viscosity
    return 1.0 / (0.8 * np.sqrt(viscosity) * speed_sliding + speed_sum * phi + 13.4)


def odonoghue_cameron_1966(
    viscosity_kinematic: Array,
    speed_sliding: Array,
    speed_entrainment: Array,
    radius_equivalent: Array,
    roughness_ra: Array,
) -> Array:
    """Disc tests (O'Donoghue & Cameron 1966), unverified and uncertain.

    mu = 0.6 ((S + 22)/35)/(nu^(1/8) Vs^(1/3) Ve^(1/6) R^(1/2)), S in microinch, R in inch, speeds in inch/s, nu in cSt.
    The unit of viscosity may be mPa s in the original, which would change mu by 2 %, and the rolling speed the sum
    2 Ve, which would reduce it by 11 %.

    viscosity_kinematic: nu [m2/s].
    speed_sliding, speed_entrainment: Vs and the mean speed Ve [m/s].
    radius_equivalent: R [m].
    roughness_ra: S, centre-line average roughness [m].
    """
    rough = (roughness_ra / MICROINCH + 22.0) / 35.0
    speeds = (speed_sliding / INCH) ** (1 / 3) * (speed_entrainment / INCH) ** (1 / 6)
    viscosity = (viscosity_kinematic * 1e6) ** 0.125
    return 0.6 * rough / (viscosity * speeds * np.sqrt(radius_equivalent / INCH))


def arana_2019_fluid(
    pressure: Array,
    viscosity: Array,
    pressure_viscosity: Array,
    speed_sliding: Array,
    film: Array,
    limiting_shear_coefficient: Array | float,
) -> Array:
    """Film friction of Arana, Larranaga & Ulacia (2019), Ree-Eyring with a limiting shear stress; found.

    mu_f = min[(2 Lam/(alpha p)) asinh(eta alpha Vs/(2 Lam h)), Lam]: the Eyring stress is 2 Lam/alpha.

    pressure: p, mean pressure of the contact [Pa].
    viscosity: eta at that pressure and oil temperature [Pa s].
    pressure_viscosity: alpha [1/Pa].
    speed_sliding: Vs [m/s].
    film: h = phi_T h_c, central film with its thermal inlet factor [m].
    limiting_shear_coefficient: lam [-]: mineral 0.047, naphthenic 0.053, PAO 0.035, polyglycol 0.044.
    """
    stress = 2.0 * limiting_shear_coefficient / pressure_viscosity
    strain = np.arcsinh(viscosity * speed_sliding / (stress * film))
    return np.minimum(stress / pressure * strain, limiting_shear_coefficient)


def share_arana_2019(film_ratio: Array) -> Array:
    """Asperity load share 1 - erf(lambda); found (Arana, Larranaga & Ulacia 2019)."""
    from scipy.special import erfc

    return erfc(film_ratio)


def share_doleschel_2002(film_ratio: Array) -> Array:
    """Asperity load share (1 - lambda/2)^2 for lambda <= 2, else 0, lambda on the mean Ra; found (Doleschel)."""
    return np.square(1.0 - 0.5 * np.clip(film_ratio, 0.0, 2.0))


def share_matsumoto_2014(severity: Array) -> Array:
    """Asperity load share 0.5 log10 D, D = (Rz1 + Rz2)/h_min in 1..100 (Matsumoto & Morikawa; year unverified)."""
    return 0.5 * np.log10(np.clip(severity, 1.0, 100.0))


def share_masjedi_khonsari_2012(
    speed_group: Array,
    load_group: Array,
    material_group: Array,
    roughness_over_radius: Array,
    hardness_over_modulus: Array,
) -> Array:
    """Asperity load share of a rough line contact, unverified (Masjedi & Khonsari 2012, J. Tribol. 134).

    La = 0.005 W^-0.408 U^-0.088 G^0.103 ln(1 + 4470 s^6.015 V^1.168 W^0.485 U^-3.741 G^-2.898) in per cent: a fit to a
    statistical model, whose asperity load is the load above the macroscopic pressure. Values above 1, at film ratios
    below about 0.1, become nan.

    speed_group, load_group, material_group: U = eta0 u_e/(E' R), W = w'/(E' R), G = alpha E' of Dowson & Higginson [-].
    roughness_over_radius: s = Rq/R [-].
    hardness_over_modulus: V = hardness/E' [-].
    """
    u, w, g = speed_group, load_group, material_group
    s, v = roughness_over_radius, hardness_over_modulus
    inside = 4470.0 * s**6.015 * v**1.168 * w**0.485 * u**-3.741 * g**-2.898
    share = 0.01 * 0.005 * w**-0.408 * u**-0.088 * g**0.103 * np.log1p(inside)
    return np.where(share <= 1.0, share, np.nan)


def pan_hamrock_1989_minimum(speed: Array, load: Array, material: Array) -> Array:
    """Minimum film h_min/R = 1.714 U^0.694 G^0.568 W^-0.128 (Pan & Hamrock 1989, J. Tribol. 111; unverified)."""
    return 1.714 * speed**0.694 * material**0.568 * load**-0.128
