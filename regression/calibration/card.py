"""Oil card of a calibration: the initial card with calibrated values and a record of their origin."""

from __future__ import annotations

import datetime
from pathlib import Path

from ehl import SOLVER
from ehl.fluid.oil import CalibratedValue, CalibrationRecord, Oil
from regression.calibration.calibrate import Calibration, reference_temperature
from regression.calibration.measurement import Measurement
from regression.calibration.parameters import RISING, card_with
from regression.calibration.setup import CalibrationSetup

SURFACE = ("boundary_friction", "boundary_film")


def calibrated_card(
    name: str, measurement: Measurement, setup: CalibrationSetup, result: Calibration, date: datetime.date
) -> Oil:
    """The card with the calibrated values and their record.

    Undetermined values remain those of the initial card unless the data exclude them.
    """
    base = Oil.load(setup.oil)
    moved = set(setup.parameters)
    if set(RISING) & moved:
        moved |= set(RISING)
    oil_values = {name: value for name, value in result.values.items() if name in moved and name not in SURFACE}
    card = card_with(base, oil_values, reference_temperature(measurement))
    used = [i for i in range(measurement.size) if measurement.row_numbers[i] not in result.excluded]
    record = CalibrationRecord(
        file=measurement.name,
        file_hash=measurement.file_hash,
        date=date.isoformat(),
        solver_version=SOLVER,
        card=setup.oil,
        model=_model_words(setup),
        geometry=_geometry_words(setup),
        coating=setup.specimens.coating,
        rows_used=len(used),
        rows_excluded=len(result.excluded),
        outliers=result.outliers,
        noise=result.noise,
        fitted={
            estimate.name: CalibratedValue(**{name: getattr(estimate, name) for name in CalibratedValue.model_fields})
            for estimate in result.parameters
            if estimate.name in result.fitted
        },
        undetermined=tuple(e.name for e in result.parameters if e.status == "undetermined"),
        held={e.name: e.held for e in result.parameters if e.status == "undetermined"},
        conditions={
            column: (float(values[used].min()), float(values[used].max()))
            for column, values in measurement.columns.items()
        },
        surface={key: result.values[key] for key in SURFACE if key in result.values},
    )
    words = f"calibrated from {measurement.name} ({len(used)} rows) on {date.isoformat()}, initial card {setup.oil}"
    if not result.misfit_credible:
        words += f"; forced: {result.misfit_words()}"
    changes = {
        "name": name,
        "description": f"{base.description}; {words}".removeprefix("; "),
        "source": f"{', '.join(result.fitted)} {words}; all other values: {base.source}",
        "calibration": record,
    }
    return card.model_copy(update=changes)


def _model_words(setup: CalibrationSetup) -> str:
    stress = "rising" if setup.rising else "constant"
    return f"{setup.model.accuracy}, thermal {setup.model.thermal}, {stress} Eyring stress"


def _geometry_words(setup: CalibrationSetup) -> str:
    specimens = setup.specimens
    if specimens.geometry == "line":
        return "line contact"
    return f"point contact, solved as a line contact of the same {specimens.match.replace('_', ' ')}"


def use_lines(path: Path, setup: CalibrationSetup, result: Calibration) -> list[str]:
    """Lines of an input file that use the calibrated values."""
    lines = [f'[lubricant]  oil = "{path}"' + ('  eyring_stress_law = "pressure"' if setup.rising else "")]
    surface = [f"{name} = {result.values[name]:.4g}" for name in SURFACE if name in result.fitted]
    return lines + (["[surface]  " + "  ".join(surface)] if surface else [])
