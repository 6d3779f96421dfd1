"""Write docs/constants.md: the tuned module constants of the three packages, from their comments `# tuned ...`.

The comment above a constant states what its value was fitted to, or by which test it was chosen.

    python docs/make_constants.py
"""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "constants.md"
MARK, LONGEST = "# tuned", 90
HEAD = """---
orphan: true
---

# Tuned constants

Made from the comments `# tuned ...` of the source by `python docs/make_constants.py`; do not edit it.
Constants that follow from an equation, a unit or a stated limit are not listed.
"""


def tuned_constants(path: Path) -> list[tuple[str, str, str]]:
    """Name, value and basis of every marked constant of a module."""
    text = path.read_text(encoding="utf-8")
    lines, rows = text.splitlines(), []
    for node in ast.parse(text).body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        comment: list[str] = []
        for line in reversed(lines[: node.lineno - 1]):
            if not line.startswith("#"):
                break
            comment.insert(0, line)
            if line.startswith(MARK):
                basis = " ".join(part.removeprefix(MARK).lstrip(":# ") for part in comment)
                target = node.targets[0] if isinstance(node, ast.Assign) else node.target
                value = " ".join((ast.get_source_segment(text, node.value) or "").split())
                if len(value) > LONGEST:
                    value = "see the source"
                rows.append((ast.unparse(target).strip("()"), value, basis))
                break
    return rows


def page() -> str:
    """The page as text."""
    found = [HEAD, "| module | constant | value | fitted to or chosen by |", "|---|---|---|---|"]
    for package in ("ehl", "regression", "efficiency"):
        for path in sorted((ROOT / package).rglob("*.py")):
            for name, value, basis in tuned_constants(path):
                module = path.relative_to(ROOT).as_posix()
                cells = (f"`{module}`", f"`{name}`", f"`{value}`", basis)
                found.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(found) + "\n"


def write() -> None:
    """Write the page; the build of the documentation does so."""
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    write()
