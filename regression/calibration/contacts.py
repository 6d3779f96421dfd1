"""Rows of a measured table as contacts of the solver, in groups for warm starts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import compress

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.inputs import MAX_PRESSURE_OVER_MODULUS, MAX_SLIDING, SurfaceInput
from ehl.line_contact import LineContact
from ehl.material import effective_modulus
from regression.calibration.measurement import CONDITIONS, Measurement
from regression.calibration.setup import CalibrationSetup

# mean over maximum pressure: 2/3 of an ellipsoid, pi/4 of a half cylinder
MEAN_POINT, MEAN_LINE = 2.0 / 3.0, math.pi / 4.0
GROUP = 8  # contacts of a group, solved by one worker with warm starts


@dataclass(frozen=True)
class ContactGroup:
    """Neighbouring contacts of one surface."""

    rows: tuple[int, ...]  # rows of the measurement
    contacts: tuple[LineContact, ...]
    temperatures: tuple[float, ...]  # of the oil [K]
    surface: SurfaceInput

    def only(self, wanted: NDArray[np.bool_]) -> ContactGroup:
        """The contacts of selected rows; `wanted` is a mask over all rows of the measurement."""
        kept = wanted[list(self.rows)].tolist()
        temperatures = tuple(compress(self.temperatures, kept))
        return ContactGroup(
            tuple(compress(self.rows, kept)), tuple(compress(self.contacts, kept)), temperatures, self.surface
        )


def line_pressure(measurement: Measurement, setup: CalibrationSetup) -> FloatArray:
    """Hertz pressure of the line contact of each row, shape (n,) [Pa]."""
    modulus = effective_modulus(setup.solid_1.body(), setup.solid_2.body())
    specimens, radius = setup.specimens, measurement.columns["radius_equivalent"]
    load = measurement.columns[measurement.load]
    point = specimens.geometry == "point"
    if measurement.load == "pressure_hertz":
        pressure = load
    elif measurement.load == "load" and point:
        across = specimens.radius_transverse
        pressure = np.array(
            [hertz_point_pressure(w, r, across or r, modulus) for w, r in zip(load, radius, strict=True)]
        )
    elif point:
        hint = "Use the column load [N] or pressure_hertz for a point contact."
        raise InputError("specimens.geometry", "point", "line, for a load per length", hint)
    else:
        if measurement.load == "load":
            if specimens.length is None:
                hint = "It is the length of the contact line, the width of the disc or roller."
                raise InputError("specimens.length", None, "a length such as '10 mm'", hint)
            load = load / specimens.length
        pressure = np.sqrt(load * modulus / (2.0 * np.pi * radius))
    if point and specimens.match == "mean_pressure":
        pressure = pressure * (MEAN_POINT / MEAN_LINE)
    allowed = CONDITIONS["pressure_hertz"]
    most = min(allowed.le or np.inf, MAX_PRESSURE_OVER_MODULUS * modulus)
    least = allowed.ge or 0.0
    for row, value in enumerate(pressure):
        if not least <= value <= most:
            where = f"{measurement.name}, row {measurement.row_numbers[row]}, {measurement.load}"
            span = f"a Hertz pressure of {least:.3g} to {most:.3g} Pa; it is {value:.4g} Pa"
            raise InputError(where, float(load[row]), span, "Check load, radius and solids.")
    return np.asarray(pressure)


def contact_groups(measurement: Measurement, setup: CalibrationSetup) -> tuple[ContactGroup, ...]:
    """The contacts of all rows, grouped by curve and roughness."""
    modulus = effective_modulus(setup.solid_1.body(), setup.solid_2.body())
    pressure = line_pressure(measurement, setup)
    c = measurement.columns
    names = ("radius_equivalent", "speed_entrainment", "slide_to_roll")
    contacts = [
        LineContact.from_pressure(
            effective_modulus=modulus,
            pressure_hertz=float(pressure[i]),
            **{name: float(c[name][i]) for name in names},
        )
        for i in range(measurement.size)
    ]
    for row, contact in enumerate(contacts):
        if contact.speed_sliding > MAX_SLIDING:
            where = f"{measurement.name}, row {measurement.row_numbers[row]}, slide_to_roll"
            allowed = f"a sliding speed of at most {MAX_SLIDING:g} m/s; it is {contact.speed_sliding:.4g} m/s"
            raise InputError(where, contact.slide_to_roll, allowed)
    together: dict[tuple[str, float], list[int]] = {}
    for row, label in enumerate(measurement.curve):
        together.setdefault((label, float(c["roughness_rms"][row])), []).append(row)
    groups = []
    for (_, roughness), rows in together.items():
        each = roughness / 2.0**0.5
        surface = setup.surface.model_copy(update={"roughness_rms_1": each, "roughness_rms_2": each})
        pieces = -(-len(rows) // GROUP)
        for part in np.array_split(np.array(rows), pieces):
            temperatures = tuple(float(c["temperature_oil"][i]) for i in part)
            groups.append(ContactGroup(tuple(map(int, part)), tuple(contacts[i] for i in part), temperatures, surface))
    return tuple(groups)


def hertz_point_pressure(load: float, radius_1: float, radius_2: float, effective_modulus: float) -> float:
    """Maximum pressure of an elliptical Hertz contact [Pa] (Johnson 1985, Contact Mechanics, section 4.2).

    1/(2 R') = (p0/E*) b/(e^2 a^2) (K - E), 1/(2 R'') = (p0/E*) b/(e^2 a^2) ((a/b)^2 E - K), W = 2 pi a b p0/3, with
    E* = E'/2, R' the larger radius, a the longer half axis, e^2 = 1 - (b/a)^2, K and E complete elliptic integrals.

    load: W [N].
    radius_1, radius_2: equivalent radii in both directions [m].
    effective_modulus: E' [Pa].
    """
    stiff = 0.5 * effective_modulus
    larger, smaller = max(radius_1, radius_2), min(radius_1, radius_2)
    if larger / smaller < 1.0 + 1e-4:
        mean = math.sqrt(larger * smaller)
        return float((6.0 * load * stiff**2 / (math.pi**3 * mean**2)) ** (1.0 / 3.0))

    def ratio(log_axes: float) -> float:
        axes = math.exp(log_axes)
        m = 1.0 - axes**-2
        return float(math.log((axes**2 * ellipe(m) - ellipk(m)) / (ellipk(m) - ellipe(m))) - math.log(larger / smaller))

    axes = math.exp(brentq(ratio, 1e-5, math.log(larger / smaller) + 1.0, xtol=1e-12))
    m = 1.0 - axes**-2
    short = (3.0 * load * larger * float(ellipk(m) - ellipe(m)) / (math.pi * axes**3 * m * stiff)) ** (1.0 / 3.0)
    return float(1.5 * load / (math.pi * axes * short**2))
