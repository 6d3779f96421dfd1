"""Figure and animation of a rough contact show the solution they were given, and refuse what does not move."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from ehl.common.errors import InputError
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.result import ContactResult
from ehl.view.animation import roll_on
from ehl.view.rough_plots import running_mean

EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "examples"


def rough(**surface: Any) -> Contact:
    """Cheap, and thin enough that asperities touch."""
    return validate(
        Contact,
        {
            "contact": {
                "radius_equivalent": 0.01,
                "pressure_hertz": 1e9,
                "speed_entrainment": 0.5,
                "slide_to_roll": 0.4,
            },
            "lubricant": {"oil": "fva3", "temperature_oil": "100 degC"},
            "surface": {"roughness_rms_1": 0.3e-6, "correlation_length": 60e-6, "boundary_film": 2e-8} | surface,
            "model": {"roughness": "deterministic", "accuracy": "fast", "thermal": "off"},
        },
    )


@pytest.fixture(scope="module")
def solution() -> tuple[Contact, ContactResult]:
    case = rough()
    result = case.solve()
    assert result.transient is not None
    return case, result


def line_of(axes: Any, label: str) -> Any:
    return next(line for line in axes.get_lines() if line.get_label() == label)


def test_figure_holds_the_solution(solution: tuple[Contact, ContactResult], tmp_path: Path) -> None:
    result = solution[1]
    run = result.transient
    assert run is not None
    result.write(plot=tmp_path / "rough.png")
    figure = result.figure()
    panels = {axes.get_label(): axes for axes in figure.axes}
    assert set(panels) == {
        "pressure", "pressure_now", "film", "film_now", "filling", "friction", "heights", "correlation", "spectrum",
    }  # fmt: skip
    assert f"{result.friction_coefficient:.4f}" in figure.get_suptitle()
    assert line_of(panels["pressure"], "fluid").get_ydata() == pytest.approx(run.profiles.pressure_fluid / 1e9)
    assert line_of(panels["pressure"], "macroscopic").get_ydata().max() > 0.0
    assert line_of(panels["film_now"], "film").get_ydata() == pytest.approx(run.snapshot.film * 1e9)
    touching = int(np.count_nonzero(run.snapshot.pressure_asperity))
    assert line_of(panels["film_now"], "contact").get_xdata().size == touching
    assert line_of(panels["friction"], "each time step").get_ydata().size == run.history_friction.size
    assert "Rq 0.3 µm" in panels["heights"].get_title()
    assert "surface 2" not in panels["heights"].get_title()
    for axes in figure.axes:
        assert axes.get_xlabel() or axes.get_ylabel()
    with Image.open(tmp_path / "rough.png") as picture:
        assert picture.width > 1000


def test_running_mean_ends_at_the_result(solution: tuple[Contact, ContactResult]) -> None:
    run = solution[1].transient
    assert run is not None
    travel, mean, half_width = running_mean(run)
    assert np.all(np.diff(travel) > 0.0)
    # the last incomplete batch is the difference
    assert mean[-1] == pytest.approx(run.friction_coefficient, rel=0.03)
    assert np.isnan(half_width[:4]).all()
    assert np.all(half_width[4:] > 0.0)


def test_smooth_figure_keeps_two_axes(mixed_ehl: Callable[..., Any], tmp_path: Path) -> None:
    figure = tmp_path / "smooth.svg"
    assert mixed_ehl("solve", EXAMPLES / "contact_by_numbers.toml", "--plot", figure).code == 0
    assert "friction over" not in figure.read_text(encoding="utf-8")


def test_frames_move_with_their_surface_and_leave_the_solution_alone(solution: tuple[Contact, ContactResult]) -> None:
    case, result = solution
    run = result.transient
    assert run is not None
    before, pressure = run.run.travel, run.run.state.fluid_pressure.copy()
    frames = roll_on(run, count=6, travel=0.6)
    assert run.run.travel == before
    assert np.array_equal(run.run.state.fluid_pressure, pressure)
    x, b = frames[0].contact.x, case.line_contact().half_width
    for frame in frames:
        assert frame.upper - frame.lower == pytest.approx(frame.contact.film, abs=1e-15)
        assert frame.contact.film.min() >= 0.999 * run.boundary_film
    # surface 2 is smooth: the middle of the gap is half of surface 1 and moves at u1
    contact = case.line_contact()
    first, last = frames[0], frames[-1]
    shift = (last.travel - first.travel) * b * contact.speed_1 / contact.speed_entrainment
    carried = np.interp(x - shift, x, 0.5 * (first.upper + first.lower))
    seen = 0.5 * (last.upper + last.lower)
    known = x - shift > x[0]
    assert seen[known] == pytest.approx(carried[known], abs=0.02 * 0.3e-6)
    assert np.std(seen) > 0.05e-6


def test_gif_and_page(solution: tuple[Contact, ContactResult], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import ehl.view.animation

    result = solution[1]
    assert result.transient is not None
    frames = roll_on(result.transient, count=4, travel=0.4)
    monkeypatch.setattr(ehl.view.animation, "roll_on", lambda transient: frames)
    with Image.open(result.animate(tmp_path / "rough.gif")) as film:
        assert film.n_frames == len(frames)  # type: ignore[attr-defined]
        film.seek(0)
        first = np.asarray(film.convert("RGB"), dtype=int)
        film.seek(len(frames) - 1)
        assert np.abs(np.asarray(film.convert("RGB"), dtype=int) - first).max() > 50
    page = result.animate(tmp_path / "rough.html").read_text(encoding="utf-8")
    assert len(re.findall(r'"UklGR', page)) == len(frames)  # every WebP begins so
    assert "http" not in page  # nothing is loaded from elsewhere


def test_thick_film_has_nothing_to_show(tmp_path: Path) -> None:
    case = rough(roughness_rms_1=1e-9)
    result = case.solve()
    assert result.transient is None
    with pytest.raises(InputError, match="shortcuts"):
        result.animate(tmp_path / "rough.gif")


def test_what_cannot_move_is_refused_before_solving(tmp_path: Path) -> None:
    rough().check_animation(tmp_path / "rough.GIF")
    with pytest.raises(InputError, match="existing folder"):
        rough().check_animation(tmp_path / "nowhere" / "rough.html")
    with pytest.raises(InputError, match="rough surface"):
        rough(roughness_rms_1=0.0).check_animation(tmp_path / "rough.gif")


@pytest.mark.parametrize(
    ("example", "name", "word"),
    [
        ("contact_rough.toml", "film.mp4", ".gif or .html"),
        ("contact.toml", "film.gif", "Nothing moves in the load_sharing model"),
        ("contact_by_numbers.toml", "film.html", "Nothing moves"),
    ],
)
def test_command_line_says_why_not(
    mixed_ehl: Callable[..., Any], tmp_path: Path, example: str, name: str, word: str
) -> None:
    outcome = mixed_ehl("solve", EXAMPLES / example, "--animate", tmp_path / name)
    assert outcome.code == 2
    assert word in outcome.err
    assert outcome.err.count("\n") == 1
    assert outcome.out == ""
