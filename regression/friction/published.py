"""Published friction formulas, one function each, with arguments in SI units.

The units of the authors are converted inside each function. Definitions that differ between authors:
`speed_entrainment` is the mean (u1 + u2)/2 and `speed_sum` is u1 + u2; Rq is the RMS and Ra the mean absolute
roughness. "Published" coefficients are from a public secondary source; "unverified" ones should be checked in the
original. Ranges and these marks are in `regression.friction.published_registry`.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# b1..b9, found; P in GPa, u in m/s, viscosity in mPa s, R in m, roughness in um
XU_COEFFICIENTS = (-8.916465, 1.03303, 1.036077, -0.354068, 2.812084, -0.100601, 0.752755, -0.390958, 0.620305)

INCH = 0.0254
MICROINCH = 2.54e-8
KGF_PER_CM2 = 98066.5


def xu_kahraman_2007(
    pressure_hertz: ArrayLike,
    slide_to_roll_total: ArrayLike,
    speed_entrainment: ArrayLike,
    viscosity_inlet: ArrayLike,
    radius_equivalent: ArrayLike,
    roughness_rms: ArrayLike,
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
    pressure = np.asarray(pressure_hertz, dtype=float) * 1e-9
    sliding = np.abs(np.asarray(slide_to_roll_total, dtype=float))
    viscosity = np.asarray(viscosity_inlet, dtype=float) * 1e3
    group = sliding * pressure * np.log10(viscosity)
    f = b1 + b4 * group + b5 * np.exp(-group) + b9 * np.exp(np.asarray(roughness_rms, dtype=float) * 1e6)
    powers = pressure**b2 * sliding**b3 * np.asarray(speed_entrainment, dtype=float) ** b6 * viscosity**b7
    return np.asarray(np.exp(f) * powers * np.asarray(radius_equivalent, dtype=float) ** b8)


def benedict_kelley_1961(
    load_per_length: ArrayLike,
    viscosity_inlet: ArrayLike,
    speed_sliding: ArrayLike,
    speed_sum: ArrayLike,
    roughness_rms: ArrayLike = 0.0,
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
    load = np.asarray(load_per_length, dtype=float) * 1e-3
    viscosity = np.asarray(viscosity_inlet, dtype=float) * 1e3
    ratio = 29660.0 * load / (viscosity * np.asarray(speed_sliding) * np.asarray(speed_sum) ** 2)
    return np.asarray(0.0127 * np.log10(ratio) * 50.0 / (50.0 - np.asarray(roughness_rms) / MICROINCH))


def schlenk_1994(
    load_per_length: ArrayLike,
    viscosity_inlet: ArrayLike,
    speed_sum: ArrayLike,
    radius_equivalent: ArrayLike,
    roughness_ra: ArrayLike,
    lubricant_factor: ArrayLike = 1.0,
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
    rough = np.asarray(roughness_ra, dtype=float) * 1e6
    smooth = _mesh_mean(0.048, load_per_length, viscosity_inlet, speed_sum, radius_equivalent)
    return np.asarray(smooth * rough**0.25 * np.asarray(lubricant_factor))


def _mesh_mean(
    factor: float, load_per_length: ArrayLike, viscosity: ArrayLike, speed_sum: ArrayLike, radius: ArrayLike
) -> Array:
    """The mean of a mesh by load, speed, radius and viscosity, without the roughness."""
    load, millimetres = np.asarray(load_per_length, dtype=float) * 1e-3, np.asarray(radius, dtype=float) * 1e3
    group = load / (np.asarray(speed_sum) * millimetres)
    return np.asarray(factor * group**0.2 * (np.asarray(viscosity, dtype=float) * 1e3) ** -0.05)


def lubricant_factor_niemann(base: str, speed_sum: ArrayLike) -> Array:
    """XL by base oil: mineral 1, PAO and ester 0.8, polyglycol 0.75 (6/vSum)^0.2 (unverified; vSum in m/s).

    Hydrocracked oils count as mineral oils (own choice). Fits to measurements gave 0.846, 0.65 and 0.585 instead
    (found).
    """
    speed = np.asarray(speed_sum, dtype=float)
    if base == "polyglycol":
        return np.asarray(0.75 * (6.0 / speed) ** 0.2)
    return np.full_like(speed, {"mineral": 1.0, "hydrocracked": 1.0, "pao": 0.8, "ester": 0.8}[base])


def iso_tr_14179_1(viscosity_kinematic: ArrayLike, load_intensity: ArrayLike, speed_pitch_line: ArrayLike) -> Array:
    """Mesh friction of ISO/TR 14179-1: nu^-0.223 K^-0.40/(3.239 V^0.70); unverified.

    Range: V of 2 to 25 m/s, K of 1.4 to 14 N/mm2.

    viscosity_kinematic: nu at oil temperature [m2/s] (in the formula cSt).
    load_intensity: K factor [Pa] (in the formula N/mm2).
    speed_pitch_line: V [m/s].
    """
    viscosity = np.asarray(viscosity_kinematic, dtype=float) * 1e6
    intensity = np.asarray(load_intensity, dtype=float) * 1e-6
    return np.asarray(viscosity**-0.223 * intensity**-0.40 / (3.239 * np.asarray(speed_pitch_line) ** 0.70))


def iso_tr_14179_2(
    load_per_length: ArrayLike,
    viscosity_inlet: ArrayLike,
    speed_sum: ArrayLike,
    radius_equivalent: ArrayLike,
    roughness_ra: ArrayLike,
    pinion_diameter: ArrayLike,
) -> Array:
    """Mesh friction of ISO/TR 14179-2, unverified.

    mu = 0.045 ((KA Fbt/b)/(vSum rho))^0.2 eta^-0.05 XR, XR = 3.8 (Ra/d1)^0.25;
    N/mm, m/s, mm, mPa s, Ra in um, d1 in mm.

    load_per_length: KA Fbt/b [N/m].
    viscosity_inlet, speed_sum, radius_equivalent, roughness_ra: as in `schlenk_1994`.
    pinion_diameter: d1, pitch diameter of the pinion [m].
    """
    rough = 3.8 * (np.asarray(roughness_ra) * 1e6 / (np.asarray(pinion_diameter) * 1e3)) ** 0.25
    return np.asarray(_mesh_mean(0.045, load_per_length, viscosity_inlet, speed_sum, radius_equivalent) * rough)


def misharin_1958(viscosity_kinematic: ArrayLike, speed_sliding: ArrayLike, speed_sum: ArrayLike) -> Array:
    """Disc tests (Misharin 1958): 0.325 (Vs VS nu)^-0.25, limited to 0.02 to 0.08; m/s and cSt; unverified.

    viscosity_kinematic: nu [m2/s].
    speed_sliding: Vs [m/s].
    speed_sum: VS = u1 + u2 [m/s].
    """
    viscosity = np.asarray(viscosity_kinematic, dtype=float) * 1e6
    mu = 0.325 * (np.asarray(speed_sliding) * np.asarray(speed_sum) * viscosity) ** -0.25
    return np.asarray(np.clip(mu, 0.02, 0.08))


def drozdov_gavrikov_1967(
    pressure_hertz: ArrayLike, viscosity_kinematic: ArrayLike, speed_sliding: ArrayLike, speed_sum: ArrayLike
) -> Array:
    """Disc tests (Drozdov & Gavrikov 1967), unverified.

    mu = 1/(0.8 sqrt(nu) Vs + VS phi + 13.4), phi = 0.47 - 0.13e-4 p - 0.4e-3 nu; p in kgf/cm2, nu in cSt, m/s.

    pressure_hertz: maximum pressure p [Pa].
    viscosity_kinematic: nu [m2/s].
    speed_sliding: Vs [m/s].
    speed_sum: VS = u1 + u2 [m/s].
    """
    viscosity = np.asarray(viscosity_kinematic, dtype=float) * 1e6
    phi = 0.47 - 0.13e-4 * np.asarray(pressure_hertz, dtype=float) / KGF_PER_CM2 - 0.4e-3 * viscosity
    return np.asarray(1.0 / (0.8 * np.sqrt(viscosity) * np.asarray(speed_sliding) + np.asarray(speed_sum) * phi + 13.4))


def odonoghue_cameron_1966(
    viscosity_kinematic: ArrayLike,
    speed_sliding: ArrayLike,
    speed_entrainment: ArrayLike,
    radius_equivalent: ArrayLike,
    roughness_ra: ArrayLike,
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
    rough = (np.asarray(roughness_ra, dtype=float) / MICROINCH + 22.0) / 35.0
    speeds = (np.asarray(speed_sliding) / INCH) ** (1 / 3) * (np.asarray(speed_entrainment) / INCH) ** (1 / 6)
    viscosity = (np.asarray(viscosity_kinematic, dtype=float) * 1e6) ** 0.125
    return np.asarray(0.6 * rough / (viscosity * speeds * np.sqrt(np.asarray(radius_equivalent) / INCH)))


def arana_2019_fluid(
    pressure: ArrayLike,
    viscosity: ArrayLike,
    pressure_viscosity: ArrayLike,
    speed_sliding: ArrayLike,
    film: ArrayLike,
    limiting_shear_coefficient: ArrayLike,
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
    limit, alpha = np.asarray(limiting_shear_coefficient), np.asarray(pressure_viscosity)
    stress = 2.0 * limit / alpha
    strain = np.arcsinh(np.asarray(viscosity) * np.asarray(speed_sliding) / (stress * np.asarray(film)))
    return np.asarray(np.minimum(stress / np.asarray(pressure) * strain, limit))


def share_arana_2019(film_ratio: ArrayLike) -> Array:
    """Asperity load share 1 - erf(lambda); found (Arana, Larranaga & Ulacia 2019)."""
    from scipy.special import erfc

    return np.asarray(erfc(np.asarray(film_ratio, dtype=float)))


def share_doleschel_2002(film_ratio: ArrayLike) -> Array:
    """Asperity load share (1 - lambda/2)^2 for lambda <= 2, else 0, lambda on the mean Ra; found (Doleschel)."""
    return np.asarray(np.square(1.0 - 0.5 * np.clip(np.asarray(film_ratio, dtype=float), 0.0, 2.0)))


def share_matsumoto_2014(severity: ArrayLike) -> Array:
    """Asperity load share 0.5 log10 D, D = (Rz1 + Rz2)/h_min in 1..100 (Matsumoto & Morikawa; year unverified)."""
    return np.asarray(0.5 * np.log10(np.clip(np.asarray(severity, dtype=float), 1.0, 100.0)))


def share_masjedi_khonsari_2012(
    speed_group: ArrayLike,
    load_group: ArrayLike,
    material_group: ArrayLike,
    roughness_over_radius: ArrayLike,
    hardness_over_modulus: ArrayLike,
) -> Array:
    """Asperity load share of a rough line contact, unverified (Masjedi & Khonsari 2012, J. Tribol. 134).

    La = 0.005 W^-0.408 U^-0.088 G^0.103 ln(1 + 4470 s^6.015 V^1.168 W^0.485 U^-3.741 G^-2.898) in per cent: a fit to a
    statistical model, whose asperity load is the load above the macroscopic pressure. Values above 1, at film ratios
    below about 0.1, become nan.

    speed_group, load_group, material_group: U = eta0 u_e/(E' R), W = w'/(E' R), G = alpha E' of Dowson & Higginson [-].
    roughness_over_radius: s = Rq/R [-].
    hardness_over_modulus: V = hardness/E' [-].
    """
    u, w, g = (np.asarray(group, dtype=float) for group in (speed_group, load_group, material_group))
    s, v = np.asarray(roughness_over_radius, dtype=float), np.asarray(hardness_over_modulus, dtype=float)
    inside = 4470.0 * s**6.015 * v**1.168 * w**0.485 * u**-3.741 * g**-2.898
    share = 0.01 * 0.005 * w**-0.408 * u**-0.088 * g**0.103 * np.log1p(inside)
    return np.asarray(np.where(share <= 1.0, share, np.nan))


def pan_hamrock_1989_minimum(speed: Array, load: Array, material: Array) -> Array:
    """Minimum film h_min/R = 1.714 U^0.694 G^0.568 W^-0.128 (Pan & Hamrock 1989, J. Tribol. 111; unverified)."""
    return np.asarray(1.714 * speed**0.694 * material**0.568 * load**-0.128)
