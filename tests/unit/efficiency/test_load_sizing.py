"""Crowning and relief sized for a torque."""

import tomllib

import efficiency
from efficiency.machine_settings.inputs import SettingsInput
from efficiency.optimisation.load_sizing import EDGE_LIMIT, _grown, sized_for_load
from ehl.common.validation import validate


def targets() -> SettingsInput:
    return validate(SettingsInput, tomllib.loads(efficiency.new_file("targets", "own")))


def test_edges_of_a_template_carry_next_to_nothing() -> None:
    """In the aligned pair the load on the edges is that of the sizing."""
    start = targets()
    found = sized_for_load(start, misalignment={"P": "0.05 mm"})
    assert found.shares[-1] < EDGE_LIMIT < found.shares[0]
    pair = efficiency.GearPair(efficiency.settings(found.targets).design)
    result = pair.mesh("drive", 12, 21).load(start.operation.torque).efficiency("constant:0.05")
    assert result.edges.load_share < EDGE_LIMIT
    assert found.targets.blank == start.blank


def test_relief_grows_where_an_edge_carries() -> None:
    start = targets()
    relief = {"amount": 1e-5, "length": 1e-3}
    start = start.model_copy(
        update={
            name: getattr(start, name).model_validate({"edge_relief": dict.fromkeys(("tip", "toe", "heel"), relief)})
            for name in ("pinion", "gear")
        }
    )
    grown = _grown(start, {"pinion tip": 0.1, "gear heel": 0.02})
    assert grown.pinion.edge_relief.tip.amount > 1.5e-5
    assert grown.gear.edge_relief.heel.amount > grown.gear.edge_relief.toe.amount == 1e-5
    assert grown.targets.drive.crowning_heel > grown.targets.drive.crowning_toe == start.targets.drive.crowning_toe
