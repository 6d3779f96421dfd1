"""Write docs/references.md: every entry of data/references.toml with its uses.

python docs/make_references.py
"""

from __future__ import annotations

from pathlib import Path

from ehl.common.data import all_references, reference_line


def write() -> None:
    """Write the page."""
    rows = [
        f"{number}. {reference_line(entry)} *{', '.join(entry['uses'])}*"
        for number, entry in enumerate(all_references().values(), 1)
    ]
    page = "\n".join(["---", "orphan: true", "---", "", "# References", "", *rows]) + "\n"
    (Path(__file__).parent / "references.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    write()
