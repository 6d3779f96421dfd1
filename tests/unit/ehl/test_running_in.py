"""Running-in: peaks worn to plateaus."""

from typing import Any

import numpy as np
import pytest
from refusals import refuses
from samples import CONTACT

import ehl
from ehl.rough.mixed import rough_surfaces, worn
from ehl.surface.roughness import generate_profile
from ehl.uncertainty.contact_design import uncertain_contact_inputs
from ehl.uncertainty.spread import DEFAULT
from regression.sweeping.evaluators import input_row

GIVEN: dict[str, Any] = CONTACT | {"oil": "75w90", "temperature": 353.15, "speed_entrainment": 1.0, "accuracy": "fast"}


@pytest.mark.fast
def test_wear_keeps_the_valleys_and_gives_the_measured_skewness() -> None:
    new = generate_profile(0.5e-6, 12e-6, 24e-3, 1e-6, 3)
    run_in = worn(new, 0.3e-6)
    assert run_in.rms == pytest.approx(0.3e-6, rel=1e-9)
    # of a half-worn Gaussian distribution; a disc that ran in from 0.5 to 0.3 um had -1.38
    assert -1.8 < run_in.skewness < -1.3
    removed = new.heights - run_in.heights
    removed -= removed.min()
    assert np.median(removed[new.heights < 0.0]) == pytest.approx(0.0, abs=1e-12)
    assert removed.max() > 0.5e-6
    assert worn(new, new.rms) is worn(new, 1e-5) is new
    assert worn(new, 0.1 * new.rms).rms == pytest.approx(0.1 * new.rms, rel=1e-6)
    assert ehl.Contact(**GIVEN, roughness_rms="0.4 um", running_in=None).surface.running_in == "none"
    assert any("running_in" in note for note in ehl.Contact(**GIVEN, running_in="0.3 um").unused_inputs())


@pytest.mark.fast
@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"running_in": "wear", "roughness_rms": "0.4 um"}, "running_in"),
        ({"running_in": "0 um", "roughness_rms": "0.4 um"}, "running_in"),
        ({"running_in": "-1 um", "roughness_rms": "0.4 um"}, "running_in"),
        ({"running_in": "0.3 um", "finish": "ground"}, "finish_state"),
        ({"running_in": "0.05 um", "roughness_rms": "0.4 um"}, "running_in"),
    ],
)
def test_refused(given: dict[str, Any], field: str) -> None:
    with refuses(field):
        ehl.Contact(**GIVEN, **given)


def test_run_in_flanks_have_less_friction_and_their_own_film_ratio() -> None:
    fresh = ehl.Contact(**GIVEN, finish="ground", finish_state="new")
    contact = fresh.replace(running_in="0.3 um")
    new, run_in = fresh.solve(), contact.solve()
    surfaces = rough_surfaces(contact.surface, contact.problem().line)
    assert surfaces.rms == pytest.approx(0.3e-6 * 2.0**0.5, rel=1e-6)
    assert run_in.friction_coefficient < new.friction_coefficient
    assert run_in.film_ratio > 1.4 * new.film_ratio
    assert any("worn" in note for note in run_in.notes)
    row = input_row(contact)
    assert row["roughness_rms_1"] == row["roughness_rms_2"] == 0.3e-6
    causes = uncertain_contact_inputs(contact.problem(), DEFAULT, None, run_in.film_ratio)
    assert {cause.name for cause in causes if cause.input == "roughness_rms"} == {"running_in"}
