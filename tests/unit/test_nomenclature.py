"""The table of quantities holds every TOML key and every result field."""

import dataclasses
import typing
from collections.abc import Iterator

from pydantic import BaseModel

from efficiency.axle.axle_input import AxleInput
from efficiency.axle.result import AxlePoint
from efficiency.blanks.inputs import PairBlankInput
from efficiency.design.design import Design
from efficiency.geometry.misalignment import MisalignmentPoint, MisalignmentStudy
from efficiency.geometry.pair_geometry import FlankSummary, PairGeometry, SideGeometry
from efficiency.loss.compare import Comparison, ComparisonRow
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.machine_settings.inputs import SettingsInput
from efficiency.studies.parameter_study import Study, StudyPoint
from efficiency.vehicle.axle_test import AxleTestRow
from efficiency.vehicle.loss_map import LossPoint
from ehl.common.quantities import quantities
from ehl.contact import Contact
from ehl.fluid.oil import Oil
from ehl.material import Material
from ehl.result import ContactResult
from ehl.state import ContactState
from regression.calibration.calibrate import Calibration, ParameterEstimate
from regression.calibration.measurement import COLUMNS
from regression.calibration.setup import CalibrationSetup
from regression.data.result_files import NUMBER_UNITS
from regression.formula import Formula
from regression.friction.conditions import UNITS
from regression.plan.plan import Plan

NAMES = {part for name in quantities() for part in name.split(".")}


def models_in(annotation: object) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in typing.get_args(annotation):
        yield from models_in(argument)


def keys(model: type[BaseModel], seen: set[type[BaseModel]]) -> Iterator[str]:
    if model not in seen:
        seen.add(model)
        for name, info in model.model_fields.items():
            yield name
            for inner in models_in(info.annotation):
                yield from keys(inner, seen)


def test_every_key_of_an_input_is_listed() -> None:
    gear = (Design, AxleInput, PairBlankInput, SettingsInput)
    for model in (Contact, Oil, Material, Plan, *gear, Formula, CalibrationSetup):
        assert set(keys(model, set())) <= NAMES


def test_every_result_is_listed() -> None:
    contact = (ContactResult, ContactState, Calibration, ParameterEstimate)
    gear = (EfficiencyResult, Comparison, ComparisonRow, PairGeometry, SideGeometry, FlankSummary, MisalignmentPoint)
    studies = (MisalignmentStudy, Study, StudyPoint, LossPoint, AxleTestRow, AxlePoint)
    for record in (*contact, *gear, *studies):
        assert {field.name for field in dataclasses.fields(record) if field.compare} <= NAMES


def test_every_column_is_listed() -> None:
    assert set(UNITS) | set(NUMBER_UNITS) | set(COLUMNS) <= NAMES


def test_units_of_dataset_columns_are_those_of_the_table() -> None:
    for name, unit in {**UNITS, **NUMBER_UNITS}.items():
        assert quantities()[name].unit == unit
