"""Families of friction formulas of the local conditions.

`xu`, `power_law` and `regimes` are linear in ln mu, `short` is nonlinear. All depend on slide_to_roll_total and
speed_sliding (magnitude of the sliding vector), `short` also on the magnitude of slide_to_roll. mu does not depend on
the sign of the sliding.
"""

from ehl.common.errors import check_choice
from regression.friction.families.family import Family
from regression.friction.families.linear import POWER_LAW, REGIMES, XU
from regression.friction.families.short import SHORT, short_parts

__all__ = ["FAMILIES", "POWER_LAW", "REGIMES", "SHORT", "XU", "Family", "family_named", "short_parts"]

FAMILIES: dict[str, Family] = {family.name: family for family in (XU, POWER_LAW, REGIMES, SHORT)}


def family_named(name: str) -> Family:
    """The family of that name; `InputError` with the available names if there is none."""
    check_choice("family", name, FAMILIES)
    return FAMILIES[name]
