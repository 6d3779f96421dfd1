"""Write docs/nomenclature.md: every quantity of data/quantities.csv under the headings of this table.

python docs/make_nomenclature.py
"""

from __future__ import annotations

import csv
from pathlib import Path

from ehl.common.data import data_path
from ehl.common.quantities import typeset_unit

HEAD = """# Nomenclature

Names of TOML keys, result fields, dataset columns and JSON keys (`data/quantities.csv`). Files and results
are in SI units unless a text has a unit; tables and figures show the unit of the column "shown in".
x is normal to the contact line, y along it. If authors differ by a factor, the program uses the definition
given here. The part of a name before a dot is the name of its table.
"""


def write() -> None:
    """Write the page."""
    lines = []
    with data_path("quantities.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if row["name"].startswith("# "):
                lines += ["", f"## {row['name'][2:]}", ""] + ([row["definition"], ""] if row["definition"] else [])
                lines += ["| name | symbol | unit | shown in | definition |", "|---|---|---|---|---|"]
                continue
            unit = typeset_unit(row["unit"]) or "-"
            shown = "" if row["display"] == row["unit"] else typeset_unit(row["display"])
            lines.append(f"| `{row['name']}` | {row['symbol']} | {unit} | {shown} | {row['definition']} |")
    page = HEAD + "\n".join(lines) + "\n"
    (Path(__file__).parent / "nomenclature.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    write()
