"""Finish cards of measured profiles: written from a trace or map, accepted wherever a finish is named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples import contact_case
from small_plans import sweep_plan

import ehl
from efficiency.design.design import load_design
from ehl.common.errors import InputError
from ehl.common.validation import validate
from ehl.surface.finish import Finish
from ehl.surface.roughness import generate_profile
from regression.plan.plan import Plan


@pytest.fixture
def trace(tmp_path: Path) -> Path:
    """4 mm of a Gaussian profile: Rq 0.4 um, lc 16 um."""
    heights = generate_profile(0.4e-6, 16e-6, 4e-3, 0.5e-6, 3).heights
    path = tmp_path / "flank.csv"
    rows = "\n".join(f"{0.5 * k:.4f}, {1e6 * z:.6f}" for k, z in enumerate(heights))
    path.write_text(f"x [um], z [um]\n{rows}\n", encoding="utf-8")
    return path


def test_card_holds_what_was_measured(trace: Path, tmp_path: Path) -> None:
    measured = ehl.measured_surface(trace)
    card = tmp_path / "mine.toml"
    card.write_text(Finish.from_profile(trace).to_toml(), encoding="utf-8")
    finish = Finish.load(str(card))
    assert finish.name == "flank"
    assert finish.roughness_rms.value == pytest.approx(measured.roughness_rms, rel=1e-9)
    assert finish.correlation_length.value == pytest.approx(measured.correlation_length, rel=1e-9)
    assert finish.roughness_rms.low < 0.4e-6 < finish.roughness_rms.high
    assert finish.correlation_length.low < 16e-6 < finish.correlation_length.high
    assert (finish.lay_ratio.value, finish.lay_ratio.high) == (1.0, 5.0)
    assert finish.measured is not None
    assert finish.measured.rsm == measured.rsm
    power = np.trapezoid(finish.measured.spectral_density, finish.measured.frequency)
    assert power == pytest.approx(measured.roughness_rms**2, rel=0.15)
    for names in ((card, "new"), (tmp_path / "none.toml",)):
        with pytest.raises(InputError):
            Finish.load(*map(str, names))


def test_card_is_accepted_where_a_finish_is(
    trace: Path, tmp_path: Path, mixed_ehl: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = mixed_ehl("new", "finish", trace, "-o", "mine.toml")
    assert outcome.code == 0, outcome.err
    assert mixed_ehl("new", "finish", trace, "-o", "mine.toml").code == 2
    finish = Finish.load("mine.toml")
    content = sweep_plan("own")
    del content["variables"]["roughness_rms"]
    content["surface"] = {"finish": "mine.toml"}
    _, case = next(validate(Plan, content).cases())
    for contact in (case, contact_case(surface={"finish": "mine.toml"})):
        assert contact.surface.roughness_rms_1 == finish.roughness_rms.value
        assert contact.surface.correlation_length == pytest.approx(finish.correlation_length.value)
    design = load_design("fm_spiral_bevel_14x39").with_finish("mine.toml")
    assert design.pinion.roughness_rms == finish.roughness_rms.value
    assert design.gear.surface_finish() == finish
