"""Crowning and relief sized for a torque."""

import tomllib
from collections.abc import Callable
from typing import Any

import pytest

import efficiency
from efficiency.machine_settings.inputs import SettingsInput
from efficiency.optimisation.load_sizing import EDGE_LIMIT, FlankLoad, _grown, sized_for_load
from ehl.common.errors import InputError
from ehl.common.validation import validate


def targets() -> SettingsInput:
    return validate(SettingsInput, tomllib.loads(efficiency.new_file("targets", "own")))


def test_edges_of_a_template_carry_next_to_nothing_on_both_flanks() -> None:
    """In the aligned pair the load on the edges is that of the sizing, and the load is central."""
    start = targets()
    found = sized_for_load(start, misalignment={"P": "0.05 mm", "E": "0 mm", "G": "0 mm"})
    assert found.shares[-1] < EDGE_LIMIT < found.shares[0]
    pair = efficiency.GearPair(efficiency.settings(found.targets).design)
    for side in ("drive", "coast"):
        loaded = pair.mesh(side, 12, 21).load(start.operation.torque)
        assert loaded.efficiency("constant:0.05").edges.load_share < EDGE_LIMIT
        assert found.sides[side].worst < EDGE_LIMIT
        assert abs(found.sides[side].centre) < 0.15
        assert len(found.sides[side].shares) == 3
    assert found.targets.blank == start.blank


def test_sizing_of_the_drive_side_alone() -> None:
    start = targets()
    box = dict.fromkeys(("E", "P", "G"), "0 mm")
    found = sized_for_load(start, misalignment=box, coast_torque="0 N m")
    assert list(found.sides) == ["drive"]
    assert found.targets.targets.coast == start.targets.coast
    for name, wrong in (("coast_torque", "-5 N m"), ("coast_torque", "5 mm")):
        with pytest.raises(InputError):
            sized_for_load(start, **{name: wrong})


@pytest.mark.fast
@pytest.mark.parametrize(("name", "width"), [("E", "5 mm"), ("P", "-0.1 mm"), ("G", "1 arcmin"), ("X", "0.1 mm")])
def test_half_widths_are_checked_as_typed(name: str, width: str) -> None:
    with pytest.raises(InputError, match=f"= '{name if name == 'X' else width}' cannot be used"):
        sized_for_load(targets(), misalignment={name: width})


def test_a_search_starts_from_the_sized_pair() -> None:
    """Its pressure away from edges is limited too."""
    found = efficiency.optimise(
        targets(), {"bias": "-0.2:0.2"}, misalignment={}, friction="constant:0.05", evaluations=4, check=0, sized=True
    )
    assert found.start.figures["edge_load_share"] < EDGE_LIMIT
    assert found.allowed["pressure_flank"] == found.start.figures["pressure_flank"]
    assert 0.5e9 < found.start.figures["pressure_flank"] <= found.start.figures["pressure_hertz_max"]


@pytest.mark.fast
@pytest.mark.parametrize("option", ["--torque", "--coast-torque", "--E"])
def test_options_of_the_sizing_need_it(option: str, mixed_ehl: Callable[..., Any]) -> None:
    outcome = mixed_ehl("settings", "fh_hypoid_9x34", option, "0.1 mm" if option == "--E" else "100 N m")
    assert (outcome.code, option in outcome.err) == (2, True)


def test_relief_grows_where_an_edge_carries() -> None:
    start = targets()
    relief = {"amount": 1e-5, "length": 1e-3}
    start = start.model_copy(
        update={
            name: getattr(start, name).model_validate({"edge_relief": dict.fromkeys(("tip", "toe", "heel"), relief)})
            for name in ("pinion", "gear")
        }
    )
    shares = {"drive": {"pinion tip": 0.1, "gear heel": 0.02}, "coast": {}}
    grown = _grown(start, {side: FlankLoad((0.1,), edges, -0.2) for side, edges in shares.items()})
    assert grown.pinion.edge_relief.tip.amount > 1.5e-5
    assert grown.gear.edge_relief.heel.amount > grown.gear.edge_relief.toe.amount == 1e-5
    assert grown.targets.drive.crowning_heel > grown.targets.drive.crowning_toe == start.targets.drive.crowning_toe
    assert grown.targets.coast.crowning_heel == start.targets.coast.crowning_heel
    # the load lies towards the toe: the contact moves to the heel
    assert grown.targets.coast.contact_face > 0.0
