"""Write docs/units.md: every unit that is read, and what becomes of each spelling in docs/spellings.tsv.

python docs/make_units.py
"""

from __future__ import annotations

from pathlib import Path

from ehl.common.errors import InputError
from ehl.common.quantities import quantities
from ehl.common.units import parse_quantity, spellings

HERE = Path(__file__).parent
HEAD = """# Units

A value is a number and its unit, such as `1.2 GPa` or `350Nm`; a bare number in a file or in Python is in SI units.
`mm²`, `mm^2` and `mm2` are the same, as are `N m`, `N*m` and `N·m`, and `kg/m3` and `kg m-3`. A comma within a number
is refused: values of a list are separated by a comma and a space, or by a semicolon.

## Spellings

| field in | written | read as |
|---|---|---|
"""
UNITS = """
## Units by field

Speeds of shafts, torques, angles and ratios are read in these units only. A rate such as `1500 1/min` is a number of
rotations, an energy is not a torque, an angle is not a ratio. Other fields are read in any unit of their dimension that
[pint](https://pint.readthedocs.io) has. Angles may have minutes and seconds: `35° 12' 30"`. Words such as `rpm`, `inch`
and `Celsius` are read in any case; `mPa` and `MPa` differ.

| SI unit of the field | units that are read |
|---|---|
"""


def read_as(text: str, unit: str) -> str:
    """The value of a text in the unit of its field, or why it is refused."""
    try:
        return f"{parse_quantity(text, unit, bare=not unit):.9g} {unit}".strip()
    except InputError as error:
        return f"refused: {error.hint.partition('. ')[0].rstrip('.') or 'not a finite number'}"


def write() -> None:
    """Write the page."""
    rows: dict[tuple[str, str], list[str]] = {}
    for line in (HERE / "spellings.tsv").read_text(encoding="utf-8").splitlines()[1:]:
        unit, _, *texts = line.split("\t")
        for text in filter(None, texts):
            rows.setdefault((unit, read_as(text, unit)), []).append(text)
    table = [
        f"| {unit or 'ratio'} | {' '.join(f'`{text}`' for text in texts)} | {a} |" for (unit, a), texts in rows.items()
    ]
    units = [
        f"| {u or 'ratio'} | {' '.join(f'`{name}`' for name in spellings(u))} |"
        for u in sorted({entry.unit for entry in quantities().values()} | {u for u, _ in rows})
    ]
    (HERE / "units.md").write_text(HEAD + "\n".join(table) + "\n" + UNITS + "\n".join(units) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write()
