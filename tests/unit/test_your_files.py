"""The examples of the page "Your files" are read as it says."""

import re
from pathlib import Path

import pytest

from efficiency.conditions.duty import read_duty
from efficiency.cutting.summary import parse_summary
from efficiency.vehicle.loss_map import read_axle_losses
from regression.calibration.measurement import read_measurement

PAGE = (Path(__file__).parents[2] / "docs" / "your_files.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```text\n(.*?)```", PAGE, flags=re.S)


def example(start: str, folder: Path, encoding: str = "utf-8") -> Path:
    """File of the example that begins so."""
    path = folder / "example.csv"
    path.write_bytes(next(text for text in EXAMPLES if text.startswith(start)).encode(encoding))
    return path


def test_examples_of_tables(tmp_path: Path) -> None:
    rig = read_measurement(example("MTM", tmp_path, "latin-1"), {"radius_equivalent": 0.0095})
    assert rig.friction == pytest.approx([0.0107])
    assert rig.columns["slide_to_roll"] == pytest.approx([0.01])
    first, second = read_duty(example("time", tmp_path, "utf-16"), tyre_radius=0.32, ratio=39 / 14)
    assert first.torque == pytest.approx(1114.3 * 14 / 39)
    assert second.speed == pytest.approx(37.5 / 3.6 / 0.32 * 39 / 14)
    assert read_axle_losses(example("Input Speed", tmp_path)).loss.tolist() == [[1.5], [2.5]]


def test_example_of_a_setting_sheet() -> None:
    found = parse_summary(next(text for text in EXAMPLES if text.startswith("units")), {"gear": "left"})
    machine = found.tables["gear"]["machine"]
    assert machine == {"process": "formate", "radial_setting": "116.573 mm", "cradle_angle": "-60.465 deg"}
    assert len(found.left_out) == 1
