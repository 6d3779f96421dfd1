"""Families of friction formulas: what each computes from the local conditions and its coefficients.

Three are linear in ln mu (`xu`, `power_law`, `regimes`), `short` is nonlinear. All take slide_to_roll_total and
speed_sliding, the length of the whole sliding vector, `short` also the amount of slide_to_roll: mu
does not depend on the sign of the sliding.
"""

from __future__ import annotations

from ehl.common.errors import InputError
from regression.friction.families.family import Family
from regression.friction.families.film_regimes import REGIMES
from regression.friction.families.log_linear import POWER_LAW, XU
from regression.friction.families.short import SHORT, short_parts

__all__ = ["FAMILIES", "POWER_LAW", "REGIMES", "SHORT", "XU", "Family", "family_named", "short_parts"]

FAMILIES: dict[str, Family] = {family.name: family for family in (XU, POWER_LAW, REGIMES, SHORT)}


def family_named(name: str) -> Family:
    """The family of that name.

    Raises
    ------
    InputError
        There is none; the message lists those there are.
    """
    if name not in FAMILIES:
        raise InputError("family", name, "one of " + ", ".join(FAMILIES))
    return FAMILIES[name]
