"""The rough contact as a user meets it: results, seeds, measured profiles, and its shortcuts."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples import contact_case

from ehl.common.errors import ConvergenceError
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.inputs import SurfaceInput
from ehl.rough import solve_transient

EXAMPLE = Path(__file__).resolve().parents[3] / "docs" / "examples" / "contact_rough.toml"
Cli = Callable[..., Any]


def case(seed: int = 1, rms: float = 0.085e-6, slide_to_roll: float = 0.05, **model: Any) -> Contact:
    """A thick film over slight roughness; film ratio 6.2 where nothing else is said."""
    contact = {"radius_equivalent": 0.01, "pressure_hertz": 0.8e9, "speed_entrainment": 3.0}
    return contact_case(
        contact=contact | {"slide_to_roll": slide_to_roll},
        lubricant={"viscosity_inlet": 0.04, "pressure_viscosity": 16e-9},
        surface={"roughness_rms_1": rms, "correlation_length": 60e-6, "seed": seed},
        model={"accuracy": "fast", "thermal": "off"} | model,
    )


def test_example_gives_all_figures_and_the_same_ones_again(mixed_ehl: Cli) -> None:
    first = json.loads(mixed_ehl("solve", EXAMPLE, "--json").out)
    assert first["status"] == "converged"
    for name in ("friction_asperity", "asperity_load_share", "film_ratio", "mesh_error", "statistical_error"):
        assert first[name] > 0.0
    assert first["friction_error"] >= math.hypot(first["mesh_error"], first["statistical_error"])
    assert first["statistical_error"] <= 0.035
    assert first["friction_coefficient"] == pytest.approx(first["friction_fluid"] + first["friction_asperity"])
    assert first["asperity_load_share"] < first["roughness_load_share"]
    # a thicker boundary film touches sooner
    assert first["friction_boundary_half"] < first["friction_coefficient"] < first["friction_boundary_double"]
    again = json.loads(mixed_ehl("solve", EXAMPLE, "--json").out)
    assert first | {"seconds": 0.0} == again | {"seconds": 0.0}


def test_roughness_left_out_of_a_thick_film_changes_no_more_than_said() -> None:
    change, unsure, skipped = [], [], case().solve()
    assert skipped.film_ratio == pytest.approx(6.2, rel=0.02)
    assert skipped.transient is None
    assert any("roughness and time: estimated change" in text for text in skipped.skipped)
    for seed in (1, 2, 3):
        full = case(seed, shortcuts="off").solve()
        assert full.transient is not None
        change.append(full.friction_coefficient / skipped.friction_coefficient - 1.0)
        unsure.append(full.friction_error)
        assert abs(change[-1]) < skipped.friction_error + full.friction_error
    assert len(set(change)) == 3  # the seed makes the surface
    assert abs(np.mean(change)) < skipped.friction_error + np.mean(unsure) / math.sqrt(3.0)
    # the estimate is no blank cheque either
    assert skipped.friction_error < 0.02


def test_roughness_left_out_of_a_viscous_film_counts_for_more() -> None:
    viscous = {"slide_to_roll": 1e-3, "friction_tolerance": 0.5}
    skipped = case(**viscous).solve()
    assert skipped.transient is None
    eyring = case(friction_tolerance=0.5).solve()
    assert skipped.friction_error > 3.0 * eyring.friction_error
    changes = []
    for seed in (1, 2):
        full = case(seed, **viscous, shortcuts="off").solve()
        changes.append(full.friction_coefficient / skipped.friction_coefficient - 1.0)
        assert abs(changes[-1]) < skipped.friction_error + full.friction_error
    # what is said holds without the error of the run, and what is said of other films would not
    assert eyring.friction_error < np.mean(changes) < skipped.friction_error
    assert case(slide_to_roll=1e-3).solve().transient is not None
    assert case(slide_to_roll=0.0).solve().transient is None


@pytest.mark.parametrize("kind", ["waves", "scratch"])
def test_measured_roughness_left_out_changes_no_more_than_said(kind: str, tmp_path: Path) -> None:
    x = np.arange(0.0, 1.2e-3, 1e-6)
    heights = np.sin(2.0 * np.pi * x / 60e-6) if kind == "waves" else -4.2 * np.exp(-(((x - 0.6e-3) / 10e-6) ** 2))
    path = tmp_path / "profile.csv"
    rows = "\n".join(f"{a:.9g},{b:.9g}" for a, b in zip(x * 1e6, heights * 0.12, strict=True))
    path.write_text("x [um], height [um]\n" + rows + "\n", encoding="utf-8")
    surface = {"profile_1": str(path), "cutoff_short": "4 um", "cutoff_long": None}
    measured = case().model_copy(update={"surface": validate(SurfaceInput, surface)})
    skipped = measured.solve()
    full = measured.model_copy(update={"model": measured.model.model_copy(update={"shortcuts": "off"})}).solve()
    assert skipped.transient is None
    assert full.transient is not None
    assert skipped.film_ratio == pytest.approx(full.film_ratio, rel=1e-6)
    change = abs(full.friction_coefficient / skipped.friction_coefficient - 1.0)
    assert change < skipped.friction_error + full.friction_error
    assert skipped.friction_error < 0.025


def test_a_contact_of_far_too_much_work_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shown with a limit below the work of an ordinary contact."""
    monkeypatch.setattr("ehl.rough.averaging.LIMIT", 1e-4)
    result = case(rms=0.3e-6).solve()
    assert (result.status, result.reason) == ("failed", "work_limit")


@pytest.mark.parametrize("finer", ["converged", "unsettled", "ConvergenceError"])
def test_steps_that_do_not_converge_are_repeated_on_a_finer_mesh(finer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    solved: list[int] = []

    def solve(*arguments: Any, nodes: int | None = None, **settings: Any) -> Any:
        found = solve_transient(*arguments, nodes=nodes, **settings)
        solved.append(found.nodes)
        if nodes is None:
            return replace(found, status="unsettled", reason="lagged_steps")
        assert nodes == 2 * solved[0]
        if finer == "ConvergenceError":
            raise ConvergenceError("mesh_budget", "")
        return replace(found, status=finer)

    monkeypatch.setattr("ehl.rough.mixed.solve_transient", solve)
    result = case(rms=0.4e-6).solve()
    assert len(solved) == 2
    assert 1.8 * solved[0] < solved[1] < 2.2 * solved[0]
    assert result.status == ("converged" if finer == "converged" else "unsettled")
    assert any("time step halved" in note for note in result.notes) == (finer == "converged")
