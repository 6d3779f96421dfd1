"""Viscosity index after ASTM D2270 (ISO 2909), and the second viscosity from it."""

from __future__ import annotations

import math

from ehl.common.errors import InputError

# lowest kinematic viscosity at 100 degC of a row [cSt]; L = a Y^2 + b Y + c, H = d Y^2 + e Y + f of the reference oils
# of VI 0 and 100 (equations of ASTM D2270, from memory; worked examples in the tests)
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

    Parameters
    ----------
    viscosity_40, viscosity_100 : float
        Kinematic viscosity at 40 and 100 degC, U and Y [m2/s]; Y of at least 2 cSt.

    Examples
    --------
    >>> round(astm_d2270(73.30e-6, 8.86e-6)), round(astm_d2270(22.83e-6, 5.05e-6))
    (92, 156)
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

    Raises
    ------
    InputError
        No oil has both.
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
