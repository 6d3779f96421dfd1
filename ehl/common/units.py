"""Units of inputs: strings such as ``"1.8 GPa"`` become SI numbers only in this module."""

import difflib
import math
import re
import unicodedata
from dataclasses import dataclass
from functools import cache
from numbers import Real
from typing import Any, get_args

from pydantic import GetCoreSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

from ehl.common.data import data_rows
from ehl.common.errors import InputError


@cache
def _registry() -> Any:
    # pint is imported late: its import takes longer than the rest of `mixed-ehl --help`
    import pint

    return pint.UnitRegistry()


# a unit follows after a space, or at once if it cannot be read as part of the number
_NUMBER_AND_UNIT = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?:\s+|(?=[^\d\s.+-]))(\S.*)")
_DEGREES = re.compile(
    r"([+-]?)(\d+) ?(?:°|deg) ?(\d+(?:\.\d+)?) ?(?:'|min|arcmin)(?: ?(\d+(?:\.\d+)?) ?(?:\"|s|arcsec))?"
)
_COMMA = re.compile(r"\d,\d")
_THOUSANDS = re.compile(r"['’]?\d{3}\b")  # beginning of the text after a number with a separator of thousands
_COMMA_HINT = (
    "A comma inside of a number is ambiguous. Write a decimal point, no separator of thousands, "
    "and separate the values of a list by a comma and a space, or by a semicolon."
)
_RQ_HINT = "Give the number of Rq alone. Rq is about 1.25 Ra (Gaussian heights)."
# the pattern of numbers takes a time that grows with the square of a text's length, and pint computes any power
_LONGEST = 200
_RANGE = re.compile(r"\s*([^:]{1,40}):([^:]{1,40}):\s*(\d{1,9})\s*([^\d.:][^:]{0,40}|)")
_MAX_VALUES = 10_000  # of a range
_POWERLESS = re.compile(r"(?<=[A-Za-z])(-?\d)")  # a power without its sign, as in m3
# raised, lowered or circled digits that are no power of a unit, and ``_``: ``2² mm`` is not 22 mm, ``0_1`` not 1
_RAISED = re.compile(r"\d_\d|(?:^|[\d\s.,+-])[\u00b2\u00b3\u00b9\u2070-\u2089\u2460-\u249b]")
_POWER, _SMALL_POWER = re.compile(r"\*\*|\^"), re.compile(r"(\*\*|\^)\s*[+-]?\d(\.\d+)?(?![\d^]|\*\*)")

SMALLEST = 1e-60  # numbers below it are zero: their products underflow (SI units)
KELVIN = 273.15  # zero of the Celsius scale [K]
ARCSEC = math.pi / (180.0 * 3600.0)  # an arc second [rad]

# units of output: the SI unit they belong to, factor, and zero in it
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
    "W/mm^2": ("W/m^2", 1e6, 0.0),
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

# words that have one meaning in any case; the others may differ by it, as mPa and MPa do
_ANY_CASE = (
    "rpm krpm min u upm umdr r rev revs rot tr hz rps rad deg degree degrees celsius fahrenheit cst centistoke "
    "centistokes lb lbf ft in inch inches zoll feet foot mil mils thou micron microns micrometer micrometre mikrometer "
    "millimeter millimetre microinch lbft ftlb lbfft ftlbf lbin inlb lbfin inlbf psi ksi km h kmh kph mph fpm fps "
    "newton newtons microinches angstrom angstroms metre metres meter meters pound pounds per percent pct prozent "
    "second seconds minute minutes hr hour hours"
)
# fields whose unit is never parsed by pint, where another spelling may have another meaning
_CLOSED = ("", "rad/s", "N*m", "rad")

# signs that look alike: degrees, primes, fractions, minus; blanks of no width
_ALIKE = str.maketrans(
    dict.fromkeys("\u00ba\u02da", "°")
    | dict.fromkeys("\u00b4`\u2018\u2019\u2032", "'")
    | dict.fromkeys("\u201c\u201d\u2033", '"')
    | dict.fromkeys("\u2044\u2215", "/")
    | dict.fromkeys("\u2010\u2011\u2012\u2013\u2212", "-")
    | dict.fromkeys("\u200b\u2060\ufeff")
    | {"\u03bc": "u"}
)


@cache
def _read() -> list[dict[str, str]]:
    """Groups of further spellings that are read, each with its SI unit, factor and zero."""
    return data_rows("units.csv")


@cache
def spellings(unit: str) -> dict[str, tuple[float, float]]:
    """Spellings that are read for an SI unit, in canonical form: factor and zero of each.

    unit: SI unit of a field; ``""`` for a ratio.
    """
    found = {_canonical(name): (factor, zero) for name, (common, factor, zero) in UNITS.items() if common == unit}
    found |= {_canonical(unit): (1.0, 0.0)} if unit else {}
    for row in _read():
        if row["unit"] == unit:
            names = (name.replace("_", " ") for name in row["spellings"].split())
            found |= dict.fromkeys(names, (float(row["factor"]), float(row["zero"])))
    return found


def _known(typed: str, unit: str) -> tuple[float, float] | None:
    """Factor and zero of a spelling of an SI unit; None if it is not one of `spellings`."""
    text, known = _canonical(typed), spellings(unit)
    if text not in known and _in_any_case(text):
        text = next((name for name in known if name.casefold() == text.casefold() and _in_any_case(name)), text)
    return known.get(text)


def _in_any_case(text: str) -> bool:
    return all(f" {word.casefold()} " in f" {_ANY_CASE} " for word in re.findall(r"[^\W\d_]+", text))


def _plain(text: str) -> str:
    """The text with one sign for those that look alike."""
    return unicodedata.normalize("NFKC", text.translate(_ALIKE)).translate(_ALIKE).strip()


def _canonical(text: str) -> str:
    """One form for the ways to write a unit: ``mm²/s``, ``mm^2/s``, ``mm**2/s`` and ``mm2 s-1`` are ``mm2/s``."""
    text = re.sub(r"(\*\*|\^)\s*(?=[+-]?\d)", "", text)  # powers
    text = re.sub(r"[*\u00b7\u2022\u2219\u22c5\u00d7()\[\]]", " ", _plain(text).replace("''", '"'))
    text = re.sub(r"\s*/\s*", "/", text)
    text = re.sub(r"\br\W?p\W?m\b", "rpm", text, flags=re.IGNORECASE)
    text = re.sub(r"(?<=[A-Za-z])[.-](?=[A-Za-z])", " ", text).rstrip(". ")  # N.m, lb-ft, in.
    text = re.sub(r"(?:°|\bdeg(?:rees?|\.)?) ?(?=(?:[CF]|celsius|fahrenheit)\b)", "°", text, flags=re.IGNORECASE)
    text = re.sub(r"\blbs\b", "lb", re.sub(r"\bsec\b", "s", " ".join(text.split())), flags=re.IGNORECASE)
    # negative powers behind a unit and alone
    text = re.sub(r"(?<=\w) ([^\W\d_]+)-(\d)", lambda found: f"/{found[1]}{found[2].replace('1', '')}", text)
    return re.sub(r"^(?:1?/|(?=[^\W\d_]+-1$))([^\W\d_]+)(?:-1)?$", r"1/\1", text)


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


def _expectation(unit: str, bare: bool = True) -> str:
    if not unit:
        return "a number without unit"
    example = f"with its unit such as {_EXAMPLES.get(unit, '1 ' + unit)!r}"
    return f"a number in {unit} or a string {example}" if bare else f"a value {example}"


def parse_quantity(value: object, unit: str, *, field: str = "value", bare: bool = True) -> float:
    """Convert what a user typed to a number in the given SI unit.

    value: a number (already in `unit`) or a string with a unit.
    unit: the SI unit of the result; ``""`` for a number without dimension.
    field: name of the field, for the error.
    bare: whether a number without unit is accepted; on the command line it is not, where it would be ambiguous.
    Raises `InputError`: the value is no number, is not finite, has a unit of another dimension, or has no unit where
    one is needed.
    """
    allowed = _expectation(unit, bare)
    if isinstance(value, bool) or not isinstance(value, (Real, str)):  # scalars of numpy are real numbers
        raise InputError(field, value, allowed)
    if isinstance(value, str):
        number, has_unit = _from_text(value, unit, field, allowed)
    else:
        try:
            number, has_unit = float(value), False
        except OverflowError:  # an integer such as 10**400
            number, has_unit = math.inf, False
    if not math.isfinite(number):
        raise InputError(field, value, f"a finite value ({allowed})")
    if abs(number) < SMALLEST:
        number = 0.0
    if unit and not has_unit and not bare:
        raise InputError(field, value, allowed, "A bare number is ambiguous here.")
    return number


def _from_text(text: str, unit: str, field: str, allowed: str) -> tuple[float, bool]:
    if len(text) > _LONGEST or _POWER.search(_SMALL_POWER.sub("", text)) or _RAISED.search(text):
        raise InputError(field, text, allowed, "It could not be read.")
    cleaned = _plain(text)
    try:
        return float(cleaned), False
    except ValueError:
        pass
    if _COMMA.search(text):
        raise InputError(field, text, allowed, _COMMA_HINT)
    if unit == "rad" and (match := _DEGREES.fullmatch(_canonical(cleaned))) is not None:
        minutes, seconds = float(match[3]), float(match[4] or 0.0)
        if minutes < 60.0 and seconds < 60.0:
            angle = math.radians(float(match[2])) + (60.0 * minutes + seconds) * ARCSEC
            return -angle if match[1] == "-" else angle, True
    match = _NUMBER_AND_UNIT.fullmatch(cleaned)
    if match is not None:
        known = _known(match[2], unit)
        if known is not None:
            return float(match[1]) * known[0] + known[1], True
    if match is None or unit in _CLOSED or _THOUSANDS.match(match[2]):
        # such as "Ra 0.4 um"
        named = re.match(r"\s*R[apqtz]\d*\b", text)
        hint = _RQ_HINT if named else _refusal(match[2] if match else "", unit)
        raise InputError(field, text, allowed, hint)
    return _by_pint(float(match[1]), match[2], text, unit, field, allowed), True


def _by_pint(number: float, typed: str, text: str, unit: str, field: str, allowed: str) -> float:
    """A number in a unit that no table of this module has."""
    import pint

    registry = _registry()
    hint = ""
    for name in dict.fromkeys((typed, _POWERLESS.sub(r"**\1", typed))):
        try:
            # Quantity(value, unit) and not a product: offset units (degC) are not multiplicative
            quantity = registry.Quantity(number, registry.Unit(name))
            return float(quantity.to(registry.Unit(unit)).magnitude)
        except pint.DimensionalityError:
            hint = _near_unit(typed, unit, "The unit is of another dimension.")
        except Exception:  # pint raises its own, tokenizer and attribute errors for unreadable text
            hint = hint or _near_unit(typed, unit)
    raise InputError(field, text, allowed, hint)


def _refusal(typed: str, unit: str) -> str:
    """Reason why a unit is invalid for this quantity."""
    if _THOUSANDS.match(typed):
        return "Write the number without a separator of thousands."
    others = {common for common, _, _ in UNITS.values()} | {row["unit"] for row in _read()}
    if any(_known(typed, other) for other in others):
        return _near_unit(typed, unit, "The unit is of another dimension.")
    return _near_unit(typed, unit)


def _near_unit(typed: str, unit: str, hint: str = "The unit could not be read.") -> str:
    """A hint that names the spelling that was most likely meant."""
    names = {name.casefold().replace(" ", ""): name for name in spellings(unit)}
    close = difflib.get_close_matches(_canonical(typed).casefold().replace(" ", ""), names, 1, 0.75)
    return f"{hint} Did you mean {names[close[0]]!r}?" if close else hint if typed else "It could not be read."


@dataclass(frozen=True)
class ValueRange:
    """Annotation of a pydantic float field: SI unit and range of its values."""

    unit: str  # SI unit; ``""`` for a number without dimension
    # bounds in `unit`
    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    hint: str = ""  # remedy for a value outside the range

    def expected(self, value: object = None, *, bare: bool = True) -> str:
        """The allowed range in the unit of a typed value, otherwise in a usual one, and an example with its unit."""
        match = _NUMBER_AND_UNIT.fullmatch(_plain(value)) if isinstance(value, str) else None
        usual = _EXAMPLES.get(self.unit, "").partition(" ")[2]
        known = {name: _known(name, self.unit) for name in (match[2] if match else "", usual) if name}
        unit, (factor, zero) = next(((name, scale) for name, scale in known.items() if scale), (self.unit, (1.0, 0.0)))
        ends = {"above": self.gt, "at least": self.ge, "below": self.lt, "at most": self.le}
        bounds = [f"{word} {(x - zero) / factor:.6g} {unit}".strip() for word, x in ends.items() if x is not None]
        return f"{' and '.join(bounds) or 'any finite value'} ({_expectation(self.unit, bare)})"

    def check(self, value: object, field: str, *, bare: bool = True) -> float:
        """Parse and check one value outside a pydantic model (the command line)."""
        number = parse_quantity(value, self.unit, field=field, bare=bare)
        if not self._inside(number):
            raise InputError(field, value, self.expected(value, bare=bare), self._remedy(value))
        return number

    def check_given(self, value: object, field: str) -> float:
        """Check a value of the Python interface: a number is in SI units, a text has its unit."""
        return self.check(value, field, bare=not isinstance(value, str))

    def _remedy(self, value: object) -> str:
        """The hint, and for a bare number the unit in which it would be inside of the range."""
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            return self.hint
        others = {name: (factor, zero) for name, (unit, factor, zero) in UNITS.items() if unit == self.unit}
        for name, (factor, zero) in (others | spellings(self.unit)).items():
            usual = 1e-3 <= abs(number) < 1e5 and (factor, zero) != (1.0, 0.0)
            if self.unit and usual and self._inside(number * factor + zero):
                return f"A bare number is in {self.unit}. Did you mean '{number:g} {name}'? {self.hint}".strip()
        return self.hint

    def check_list(self, text: str, field: str) -> list[float]:
        """Values of a list ``"a, b, c unit"`` or a range ``"from:to:number unit"``.

        Entries are separated by a comma and a space, or by a semicolon; a single unit, at the end, applies to all.
        A range has `number` equally spaced values, both ends among them: ``"50:200:4 N m"`` is 50, 100, 150, 200 N m.

        Raises `InputError`: neither of them, or a value out of range.
        """
        if ":" not in text:
            if _COMMA.search(text):
                raise InputError(field, text, _expectation(self.unit, bare=False), _COMMA_HINT)
            entries = [entry.strip() for entry in re.split("[,;]", text)]
            stated = [_NUMBER_AND_UNIT.fullmatch(entry) for entry in entries]
            units = {found[2] for found in stated if found}
            unit = f" {units.pop()}" if stated[-1] and len(units) == 1 else ""  # of the entries without one
            whole = (entry if found else entry + unit for entry, found in zip(entries, stated, strict=True))
            return [self.check(entry, field, bare=False) for entry in whole]
        match = _RANGE.fullmatch(text)
        count = int(match[3]) if match else 0
        if match is None or not 2 <= count <= _MAX_VALUES:
            hint = f"The number of values includes both ends: at least 2 and at most {_MAX_VALUES}."
            number, _, unit = _EXAMPLES.get(self.unit, f"1 {self.unit}").partition(" ")
            example = f"{number}:{4 * float(number):g}:4 {unit}".strip()
            raise InputError(field, text, f"'from:to:number unit' such as {example!r}", hint)
        first, last = (self.check(f"{match[k].strip()} {match[4]}", field, bare=False) for k in (1, 2))
        # values that are zero but for the last binary digit are zero
        steps = (first + (last - first) * k / (count - 1) for k in range(count))
        return [0.0 if abs(step) < 1e-12 * abs(last - first) else step for step in steps]

    def _inside(self, number: float) -> bool:
        return not (
            (self.gt is not None and number <= self.gt)
            or (self.ge is not None and number < self.ge)
            or (self.lt is not None and number >= self.lt)
            or (self.le is not None and number > self.le)
        )

    def _validate(self, value: object) -> float:
        try:
            return self.check(value, "value")
        except InputError as error:
            words = {"allowed": error.allowed, "hint": error.hint}
            raise PydanticCustomError("quantity", "allowed: {allowed}. {hint}", words) from None

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._validate)


def value_range(annotation: Any) -> ValueRange:
    """The unit and the allowed range of an annotated type."""
    return next(part for part in get_args(annotation) if isinstance(part, ValueRange))


def is_list(text: str) -> bool:
    """Whether a text is a list ``a, b, c unit`` or a range ``from:to:number unit``."""
    return any(sign in _COMMA.sub("", text) for sign in ",;:")  # a comma within a number raises an error later
