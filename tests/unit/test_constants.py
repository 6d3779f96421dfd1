"""The page of tuned constants is made from the comments of the source."""

import runpy
from pathlib import Path

MADE = Path(__file__).resolve().parents[2] / "docs" / "make_constants.py"


def test_every_tuned_constant_states_its_basis() -> None:
    rows = [line.split(" | ") for line in runpy.run_path(str(MADE))["page"]().splitlines() if line.startswith("| `")]
    assert sum(row[0].startswith("| `ehl/") for row in rows) > 20
    for module, name, value, basis in rows:
        assert len(basis) > 10, (module, name)
        assert value, (module, name)
