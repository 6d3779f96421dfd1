"""The figure of a rough contact shows the solution it was given."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from samples import contact_case

from ehl.result import ContactResult
from ehl.view.contact_report import running_mean


@pytest.fixture(scope="module")
def result() -> ContactResult:
    """Cheap, and thin enough that asperities touch."""
    contact = {"radius_equivalent": 0.01, "pressure_hertz": 1e9, "speed_entrainment": 0.5, "slide_to_roll": 0.4}
    return contact_case(
        contact=contact,
        lubricant={"oil": "fva3", "temperature_oil": "100 degC"},
        surface={"roughness_rms_1": 0.3e-6, "correlation_length": 60e-6, "boundary_film": 2e-8},
        model={"accuracy": "fast", "thermal": "off"},
    ).solve()


def line_of(axes: Any, label: str) -> Any:
    return next(line for line in axes.get_lines() if line.get_label() == label)


def test_figure_holds_the_solution(result: ContactResult, tmp_path: Path) -> None:
    run = result.transient
    assert run is not None
    result.write(plot=tmp_path / "rough.png")
    figure = result.figure()
    panels = {axes.get_label(): axes for axes in figure.axes}
    assert set(panels) == {
        "pressure", "pressure_now", "film", "film_now", "filling", "friction", "heights", "correlation", "spectrum",
    }  # fmt: skip
    shown = re.search(r"μ = (\d\.\d+) ", figure.get_suptitle())
    # as many digits as the error has meaning
    assert shown
    assert float(shown[1]) == pytest.approx(result.friction_coefficient, rel=0.3 * result.friction_error)
    assert len(shown[1].lstrip("0.")) <= 4
    assert line_of(panels["pressure"], "fluid").get_ydata() == pytest.approx(run.profiles.pressure_fluid / 1e9)
    assert line_of(panels["pressure"], "macroscopic").get_ydata().max() > 0.0
    assert line_of(panels["film_now"], "film").get_ydata() == pytest.approx(run.snapshot.film * 1e9)
    touching = int(np.count_nonzero(run.snapshot.pressure_asperity))
    assert line_of(panels["film_now"], "contact").get_xdata().size == touching
    assert line_of(panels["friction"], "each time step").get_ydata().size == run.history_friction.size
    with Image.open(tmp_path / "rough.png") as picture:
        assert picture.width > 1000


def test_running_mean_ends_at_the_result(result: ContactResult) -> None:
    run = result.transient
    assert run is not None
    travel, mean, half_width = running_mean(run)
    assert np.all(np.diff(travel) > 0.0)
    # the last incomplete batch is the difference
    assert mean[-1] == pytest.approx(run.friction_coefficient, rel=0.03)
    assert np.isnan(half_width[:4]).all()
    assert np.all(half_width[4:] > 0.0)
