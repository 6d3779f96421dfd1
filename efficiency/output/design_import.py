"""Import of a machine summary into a design file."""

import os
from pathlib import Path
from typing import Any

from efficiency.cutting.summary import Summary, read_summary
from efficiency.design.design import Design, load_design
from ehl.common.data import data_path
from ehl.common.errors import InputError
from ehl.common.validation import read_toml, validate

_OF_SHEET = ("blank", "cutter", "machine", "concave", "convex")


def design_from_sheet(sheet: Path, like: str | None = None) -> tuple[str, list[str]]:
    """Text of a design file with the blanks, cutters and settings of a machine summary.

    Parameters
    ----------
    sheet : Path
        File for `efficiency.cutting.summary.read_summary`.
    like : str, optional
        Design file or name of a shipped design for the data that a sheet does not contain: assembly, operating point,
        materials, and members without data in the sheet. The resulting design is checked.

    Returns
    -------
    text : str
        The design file.
    notes : list of str
        Lines that were not read, and missing data.

    Raises
    ------
    InputError
        The sheet cannot be read, or the design is inconsistent.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import efficiency
    >>> folder = Path(tempfile.mkdtemp())
    >>> files = efficiency.load("fm_spiral_bevel_14x39").export(folder, ["summary"])
    >>> text, notes = efficiency.import_design(folder / "setting_sheet.csv", like="fm_spiral_bevel_14x39")
    >>> text.splitlines()[0]
    'name = "setting_sheet"'
    """
    content: dict[str, Any] = {}
    hands: dict[str, str] = {}
    if like is not None:
        hands = {name: getattr(load_design(like), name).blank.hand for name in ("pinion", "gear")}
        path = Path(like)
        shipped = not path.suffix and not os.path.exists(path)
        content = read_toml(data_path("designs", f"{like}.toml") if shipped else path)
    summary = read_summary(sheet, hands)
    if not any(summary.tables.values()):
        allowed = "a machine summary: one label and its value per line, such as 'radial setting, 98.1'"
        hint = "No line has this form; `mixed-ehl export DESIGN -o FOLDER --what summary` writes setting_sheet.csv."
        raise InputError("summary", str(sheet), allowed, hint)
    notes = [f"not read: {line}" for line in summary.unread] + [f"omitted: {line}" for line in summary.left_out]
    if like is None:
        notes.append("name, assembly and operation are missing; --like DESIGN takes them from another design")
        return summary.toml(), notes
    content |= {"name": sheet.stem, "source": f"machine summary {sheet.name}; the rest as {content['name']}"}
    for member, tables in summary.tables.items():
        kept = {key: value for key, value in content[member].items() if key not in _OF_SHEET}
        content[member] = kept | _complete(tables, content[member])
    validate(Design, content)
    return Summary(content, summary.unread).toml(), notes


def _complete(tables: dict[str, Any], base: dict[str, Any]) -> dict[str, Any]:
    """Tables of a member; its blank or the hand of the blank is that of the base if the sheet has none."""
    if "blank" not in tables:
        return {"blank": base["blank"]} | tables
    if tables["blank"].keys() == {"hand"}:
        return tables | {"blank": base["blank"] | tables["blank"]}
    return tables | {"blank": {"hand": base["blank"]["hand"]} | tables["blank"]}
