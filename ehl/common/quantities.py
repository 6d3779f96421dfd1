"""Quantities of the program: name, symbol, SI unit, display unit, label and definition, from `data/quantities.csv`.

Table heads, plot axes, units in files and the page docs/nomenclature.md use them.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from ehl.common.data import data_rows
from ehl.common.units import UNITS

_TYPOGRAPHY = {"degC": "°C", "um": "µm", "*": " ", "^2": "²", "^3": "³"}


@dataclass(frozen=True, slots=True)
class Quantity:
    """One quantity of the program.

    Parameters
    ----------
    name : str
        Name in files and results; the part before a dot is the name of its table.
    symbol : str
        Symbol in the literature; empty if there is none.
    unit : str
        SI unit in the program and its files, e.g. ``"Pa*s"``; empty for a dimensionless number or a text.
    display : str
        Unit in tables and figures: a key of `ehl.common.units.UNITS`, ``unit`` itself, or empty.
    label : str
        Text for axes and table heads.
    definition : str
        Definition.
    digits : int
        Significant digits shown.

    Examples
    --------
    >>> film = quantity("film_central")
    >>> film.head
    'central film thickness [nm]'
    >>> film.text(2.5e-7)
    '250 nm'
    """

    name: str
    symbol: str = ""
    unit: str = ""
    display: str = ""
    label: str = ""
    definition: str = ""
    digits: int = 4

    def to_display(self, values: Any) -> Any:
        """SI values (float or array) in the display unit."""
        if self.display == self.unit:
            return values
        _, factor, zero = UNITS[self.display]
        return (values - zero) / factor

    def to_si(self, values: Any) -> Any:
        """Values in the display unit (float or array) in SI."""
        if self.display == self.unit:
            return values
        _, factor, zero = UNITS[self.display]
        return values * factor + zero

    @property
    def head(self) -> str:
        """Label with the display unit in brackets, for the head of a column."""
        return f"{self.label} [{printed_unit(self.display)}]" if self.display else self.label

    @property
    def axis_label(self) -> str:
        """Label with the typeset display unit, for the axis of a figure."""
        return f"{self.label} [{typeset_unit(self.display) or '-'}]"

    def text(self, value: float, digits: int = 0) -> str:
        """An SI value in the display unit, with that unit."""
        return f"{_brief(self.to_display(value), digits or self.digits)} {printed_unit(self.display)}".strip()

    def span(self, low: float, high: float, digits: int = 3) -> str:
        """Range between two SI values in the display unit."""
        ends = (_brief(self.to_display(end), digits) for end in (low, high))
        return f"{' to '.join(ends)} {printed_unit(self.display)}".strip()


def format_number(value: float, digits: int = 4) -> str:
    """A number with the given significant digits, at least those before the point; a dash for a non-finite number."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if not -5 <= exponent < 9:
        return f"{value:.{digits - 1}e}"
    # rounding may reach the next power of ten
    exponent = int(f"{value:.{digits - 1}e}".partition("e")[2])
    return f"{value:.{max(0, digits - 1 - exponent)}f}"


def rounded(value: float, digits: int) -> float:
    """A number rounded to significant digits, also before the point."""
    if value == 0.0 or not math.isfinite(value):
        return value
    return round(value, digits - 1 - math.floor(math.log10(abs(value))))


def rounded_towards(value: float, towards: Callable[[float], int]) -> float:
    """A number rounded to three digits by `math.floor` or `math.ceil`."""
    digit = 10.0 ** (math.floor(math.log10(abs(value))) - 2) if value else 1.0
    return float(f"{towards(value / digit) * digit:.3g}")


def _brief(value: float, digits: int) -> str:
    """A number for a sentence, without trailing zeros."""
    mantissa, mark, exponent = format_number(value, digits).partition("e")
    return (mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa) + mark + exponent


def percent(share: float) -> str:
    """A share in per cent with two digits, without exponent."""
    return f"{float(f'{100.0 * share:.2g}'):g} %"


def plus_minus(error: float) -> str:
    """A relative error in per cent."""
    return f"±\N{NO-BREAK SPACE}{percent(error)}" if math.isfinite(error) else "unknown"


def printed_unit(unit: str) -> str:
    """A unit in plain characters: ``Pa s`` for ``Pa*s``."""
    return unit.replace("*", " ")


def typeset_unit(unit: str) -> str:
    """A unit as typeset in figures and pages: ``µm``, ``°C``, ``m²/s``."""
    for plain, typeset in _TYPOGRAPHY.items():
        unit = unit.replace(plain, typeset)
    return unit


_UNITS_SAID = re.compile(r"(?<=\d) (degC|um|%|N m|rpm|[GM]Pa|[num]?m|arc(?:sec|min)|k?W|m/s|K|kg|s)(?![\w/])")


def typeset_units(text: str) -> str:
    """A sentence with typeset units, with no line break between number and unit."""

    def joined(found: re.Match[str]) -> str:
        return "\N{NO-BREAK SPACE}" + typeset_unit(found[1]).replace(" ", "\N{NO-BREAK SPACE}")

    return _UNITS_SAID.sub(joined, text)


@cache
def quantities() -> Mapping[str, Quantity]:
    """Every quantity of the program by its name; rows of the table whose name begins with "# " are headings."""
    found = {}
    for row in data_rows("quantities.csv"):
        name, unit = row["name"], row["unit"]
        label = row["label"] or name.rpartition(".")[2].replace("_", " ")
        digits = int(row["digits"] or 4)
        found[name] = Quantity(name, row["symbol"], unit, row["display"] or unit, label, row["definition"], digits)
    return found


def quantity(name: str) -> Quantity:
    """The quantity of a name.

    Parameters
    ----------
    name : str
        Name in results and files.

    Returns
    -------
    Quantity

    Raises
    ------
    KeyError
        There is no quantity of this name.

    Examples
    --------
    >>> quantity("film_central").unit
    'm'
    """
    return quantities()[name]


def si_unit(name: str) -> str:
    """SI unit of a quantity in files, e.g. ``"Pa*s"``; empty for a dimensionless number."""
    return quantities()[name].unit


def si_units(names: Iterable[str]) -> dict[str, str]:
    """SI units of several quantities by their names."""
    return {name: si_unit(name) for name in names}


def to_display(name: str, values: Any) -> Any:
    """SI values (float or array) of a quantity in its display unit."""
    return quantity(name).to_display(values)


def axis_label(name: str) -> str:
    """Label of a quantity with its display unit, for the axis of a figure."""
    return quantity(name).axis_label
