"""Units at the edge: strings such as ``"1.8 GPa"`` become SI numbers here and nowhere else."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import GetCoreSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

from ehl.common.errors import InputError


@cache
def _registry() -> Any:
    # importing pint takes longer than everything else in `mixed-ehl --help`
    import pint

    registry: Any = pint.UnitRegistry(autoconvert_offset_to_baseunit=True)
    registry.define("cSt = 1e-6 m ** 2 / s")
    registry.define("rpm = revolution / minute")
    return registry


# a unit follows after a space, or at once if it cannot be read as part of the number
_NUMBER_AND_UNIT = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?:\s+|(?=[^\d\s.+-]))(\S.*)")
# the pattern above takes a time that grows with the square of a text's length, and pint computes any power it finds
_LONGEST = 200
_RANGE = re.compile(r"\s*([^:]{1,40}):([^:]{1,40}):\s*(\d{1,9})\s*([^\d.:][^:]{0,40})")
_MAX_VALUES = 10_000  # of a range
_POWER, _SMALL_POWER = re.compile(r"\*\*|\^"), re.compile(r"(\*\*|\^)\s*[+-]?\d(\.\d+)?(?![\d^]|\*\*)")

KELVIN = 273.15  # zero of the Celsius scale [K]
ARCSEC = math.pi / (180.0 * 3600.0)  # an arc second [rad]

# units of input and output: the SI unit they belong to, factor, and zero in it. Input in any other, and what is wrong
# with it, is left to pint, which takes longer to load than a design to be read
UNITS = {
    "m": ("m", 1.0, 0.0),
    "mm": ("m", 1e-3, 0.0),
    "um": ("m", 1e-6, 0.0),
    "nm": ("m", 1e-9, 0.0),
    "1/mm": ("1/m", 1e3, 0.0),
    "m/s": ("m/s", 1.0, 0.0),
    "rad": ("rad", 1.0, 0.0),
    "deg": ("rad", math.pi / 180.0, 0.0),
    "arcmin": ("rad", 2.9088820866572163e-4, 0.0),  # as pint has it, an ulp above 60 ARCSEC
    "arcsec": ("rad", ARCSEC, 0.0),
    "rpm": ("rad/s", 2.0 * math.pi / 60.0, 0.0),
    "kN": ("N", 1e3, 0.0),
    "N m": ("N*m", 1.0, 0.0),
    "N/mm": ("N/m", 1e3, 0.0),
    "kW": ("W", 1e3, 0.0),
    "GW/m^2": ("W/m^2", 1e9, 0.0),
    "kWh": ("J", 3.6e6, 0.0),
    "h": ("s", 3600.0, 0.0),
    "MPa": ("Pa", 1e6, 0.0),
    "GPa": ("Pa", 1e9, 0.0),
    "bar": ("Pa", 1e5, 0.0),
    "1/GPa": ("1/Pa", 1e-9, 0.0),
    "mPa s": ("Pa*s", 1e-3, 0.0),
    "cSt": ("m^2/s", 1e-6, 0.0),
    "K": ("K", 1.0, 0.0),
    "degC": ("K", 1.0, KELVIN),
    "%": ("", 1e-2, 0.0),
}

# what a user may type for each SI unit, shown in error messages
_EXAMPLES = {
    "m": "10 mm",
    "m/s": "5 m/s",
    "Pa": "1.2 GPa",
    "1/Pa": "18 1/GPa",
    "Pa*s": "40 mPa s",
    "K": "80 degC",
    "N/m": "400 N/mm",
    "N*m": "250 N m",
    "rad/s": "1500 rpm",
    "m^2/s": "100 cSt",
    "rad": "20 deg",
    "W/(m*K)": "46 W/(m K)",
    "J/(kg*K)": "465 J/(kg K)",
    "kg/m^3": "7830 kg/m^3",
    "1/K": "0.04 1/K",
    "rad/m": "1 rad/m",
    "s": "30 s",
}


def _expectation(unit: str) -> str:
    if not unit:
        return "a number without unit"
    return f"a number in {unit} or a string with its unit such as {_EXAMPLES.get(unit, '1 ' + unit)!r}"


def parse_quantity(value: object, unit: str, *, field: str = "value", bare: bool = True) -> float:
    """Convert what a user typed to a number in the given SI unit.

    Parameters
    ----------
    value : float or str
        A number (already in `unit`) or a string with a unit.
    unit : str
        The SI unit of the result; ``""`` for a number without dimension.
    field : str
        Name of the field, for the error.
    bare : bool
        Whether a number without unit is accepted; on the command line it is not, where it would be ambiguous.

    Raises
    ------
    InputError
        The value is no number, is not finite, has a unit of another dimension, or has no unit where one is needed.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise InputError(field, value, _expectation(unit))
    if isinstance(value, str):
        number, has_unit = _from_text(value, unit, field)
    else:
        try:
            number, has_unit = float(value), False
        except OverflowError:  # an integer such as 10**400
            number, has_unit = math.inf, False
    if not math.isfinite(number):
        raise InputError(field, value, f"a finite value ({_expectation(unit)})")
    if unit and not has_unit and not bare:
        raise InputError(
            field,
            value,
            f"a value with its unit such as {_EXAMPLES.get(unit, '1 ' + unit)!r}",
            "A bare number is ambiguous here.",
        )
    return number


def _from_text(text: str, unit: str, field: str) -> tuple[float, bool]:
    if len(text) > _LONGEST or _POWER.search(_SMALL_POWER.sub("", text)):
        raise InputError(field, text, _expectation(unit), "It could not be read.")
    try:
        return float(text), False
    except ValueError:
        pass
    cleaned = text.strip().replace("°C", "degC").replace("µ", "u").replace("μ", "u")
    match = _NUMBER_AND_UNIT.fullmatch(cleaned)
    if match is not None and match[2] in UNITS:
        common, factor, zero = UNITS[match[2]]
        if common == unit:
            return float(match[1]) * factor + zero, True
    import pint

    registry = _registry()
    try:
        if match is None:
            raise ValueError(text)
        # ValueRange(value, unit) and not a product: offset units (degC) are not multiplicative
        quantity = registry.Quantity(float(match[1]), registry.Unit(match[2]))
        return float(quantity.to(registry.Unit(unit) if unit else registry.dimensionless).magnitude), True
    except pint.DimensionalityError:
        raise InputError(field, text, _expectation(unit), "The unit is of another dimension.") from None
    except Exception:  # pint raises its own, tokenizer and attribute errors for unreadable text
        raise InputError(field, text, _expectation(unit), "It could not be read.") from None


def _format(number: float, unit: str) -> str:
    return f"{number:.6g} {unit}".strip()


@dataclass(frozen=True)
class ValueRange:
    """Annotation of a pydantic float field: SI unit and range of its values.

    Parameters
    ----------
    unit : str
        SI unit; ``""`` for a number without dimension.
    gt, ge, lt, le : float, optional
        Bounds in `unit`.
    hint : str, optional
        What to do when the value is outside.

    Examples
    --------
    ``radius: Annotated[float, ValueRange("m", gt=0.0, le=10.0)]``
    """

    unit: str
    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    hint: str = ""

    @property
    def allowed(self) -> str:
        """The allowed range in words."""
        bounds = []
        if self.gt is not None:
            bounds.append(f"above {_format(self.gt, self.unit)}")
        if self.ge is not None:
            bounds.append(f"at least {_format(self.ge, self.unit)}")
        if self.lt is not None:
            bounds.append(f"below {_format(self.lt, self.unit)}")
        if self.le is not None:
            bounds.append(f"at most {_format(self.le, self.unit)}")
        return " and ".join(bounds) if bounds else "any finite value"

    @property
    def expected(self) -> str:
        """The allowed range and an example with its unit."""
        return f"{self.allowed} ({_expectation(self.unit)})"

    def check(self, value: object, field: str, *, bare: bool = True) -> float:
        """Parse and check one value outside a pydantic model (the command line)."""
        number = parse_quantity(value, self.unit, field=field, bare=bare)
        if not self._inside(number):
            raise InputError(field, value, self.expected, self.hint)
        return number

    def check_list(self, text: str, field: str) -> list[float]:
        """Values of a list ``"a, b, c unit"`` or a range ``"from:to:number unit"``.

        In a list the last unit holds for entries without one. A range has `number` equally
        spaced values, both ends among them: ``"50:200:4 N m"`` is 50, 100, 150, 200 N m.

        Raises
        ------
        InputError
            Neither of them, or a value out of range.
        """
        if ":" not in text:
            return [self.check(entry, field, bare=False) for entry in _entries(text)]
        match = _RANGE.fullmatch(text)
        count = int(match[3]) if match else 0
        if match is None or not 2 <= count <= _MAX_VALUES:
            hint = f"The number counts the values, both ends among them: at least 2 and at most {_MAX_VALUES}."
            raise InputError(field, text, f"'from:to:number unit' such as {self._range_example!r}", hint)
        first, last = (self.check(f"{match[k].strip()} {match[4]}", field, bare=False) for k in (1, 2))
        # values that are zero but for the last binary digit are zero
        steps = (first + (last - first) * k / (count - 1) for k in range(count))
        return [0.0 if abs(step) < 1e-12 * abs(last - first) else step for step in steps]

    @property
    def _range_example(self) -> str:
        number, _, unit = _EXAMPLES.get(self.unit, f"1 {self.unit}").partition(" ")
        return f"{number}:{4 * float(number):g}:4 {unit}".strip()

    def _inside(self, number: float) -> bool:
        return not (
            (self.gt is not None and number <= self.gt)
            or (self.ge is not None and number < self.ge)
            or (self.lt is not None and number >= self.lt)
            or (self.le is not None and number > self.le)
        )

    def _validate(self, value: object) -> float:
        try:
            number = parse_quantity(value, self.unit)
        except InputError as error:
            raise PydanticCustomError(
                "quantity", "allowed: {allowed}. {hint}", {"allowed": error.allowed, "hint": error.hint}
            ) from None
        if not self._inside(number):
            raise PydanticCustomError(
                "quantity_range",
                "allowed: {allowed}. {hint}",
                {"allowed": self.expected, "hint": self.hint},
            )
        return number

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._validate)


def _entries(text: str) -> list[str]:
    """Entries of a list such as ``"100, 200, 300 N m"``, each with its unit."""
    entries = [entry.strip() for entry in text.split(",")]
    last = _NUMBER_AND_UNIT.fullmatch(entries[-1])
    default = f" {last[2]}" if last else ""
    return [entry if _NUMBER_AND_UNIT.fullmatch(entry) else entry + default for entry in entries]
