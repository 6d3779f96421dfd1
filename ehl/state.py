"""`ContactState`: the local conditions of many contact points, as arrays."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ehl.common.arrays import FloatArray
from ehl.line_contact import half_width_of_pressure, hertz_load
from ehl.surface.finish import default_correlation_length


@dataclass(frozen=True)
class ContactState:
    """Local conditions at contact points: arrays of one shape, one entry per point, SI units.

    Parameters
    ----------
    pressure_hertz : array
        Maximum Hertz pressure [Pa].
    radius_equivalent : array
        Radius R normal to the contact line [m].
    effective_modulus : array
        E' [Pa].
    speed_entrainment : array
        Mean surface velocity across the contact line [m/s], positive.
    slide_to_roll : array
        Signed sliding across the line over `speed_entrainment` [-].
    speed_sliding_lengthwise : array
        Sliding along the line [m/s].
    temperature_oil : array
        Oil inlet temperature [K].
    roughness_rms_1, roughness_rms_2 : array
        Rq of both surfaces [m].
    temperature_bulk_1, temperature_bulk_2 : array
        Bulk temperatures of both bodies [K].
    correlation_length : array
        Lag at which the autocorrelation of the roughness of each surface is 1/e [m].
    peklenik_number : array
        Correlation length along y over that along x [-]: 1 for isotropic roughness.

    Examples
    --------
    >>> state = ContactState.of(
    ...     pressure_hertz=[0.8e9, 1.2e9], radius_equivalent=0.015, effective_modulus=226e9, speed_entrainment=5.0)
    >>> state.size, state.half_width.round(6).tolist()
    (2, [0.000212, 0.000319])
    """

    pressure_hertz: FloatArray
    radius_equivalent: FloatArray
    effective_modulus: FloatArray
    speed_entrainment: FloatArray
    slide_to_roll: FloatArray
    speed_sliding_lengthwise: FloatArray
    temperature_oil: FloatArray
    roughness_rms_1: FloatArray
    roughness_rms_2: FloatArray
    temperature_bulk_1: FloatArray
    temperature_bulk_2: FloatArray
    correlation_length: FloatArray
    peklenik_number: FloatArray

    @classmethod
    def of(cls, **values: ArrayLike) -> ContactState:
        """A state from scalars and arrays, broadcast to one shape.

        Default values are 0 for sliding and roughness, 80 degC for the oil, the oil temperature for both bodies, 40 Rq
        for the correlation length and 1 for the Peklenik number.
        """
        oil = values.get("temperature_oil", 353.15)
        temperatures = dict.fromkeys(("temperature_oil", "temperature_bulk_1", "temperature_bulk_2"), oil)
        zero = ("slide_to_roll", "speed_sliding_lengthwise", "roughness_rms_1", "roughness_rms_2")
        values = {**temperatures, **dict.fromkeys(zero, 0.0), "peklenik_number": 1.0, **values}
        if "correlation_length" not in values:
            rms = values["roughness_rms_1"], values["roughness_rms_2"]
            values["correlation_length"] = default_correlation_length(*rms)
        names = [field.name for field in fields(cls)]
        arrays = np.broadcast_arrays(*(np.asarray(values[name], dtype=np.float64) for name in names))
        return cls(**{name: np.array(array) for name, array in zip(names, arrays, strict=True)})

    def __repr__(self) -> str:
        def span(values: FloatArray) -> str:
            low, high = (float(f(values)) for f in (np.min, np.max)) if values.size else (np.nan, np.nan)
            return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"

        ranges = ", ".join(f"{field.name} {span(getattr(self, field.name))}" for field in fields(self))
        return f"ContactState({self.size} points: {ranges})"

    def at(self, points: Any) -> ContactState:
        """The state at some of the points, by an index of NumPy."""
        return ContactState(**{field.name: getattr(self, field.name)[points] for field in fields(self)})

    @property
    def size(self) -> int:
        """Number of contact points."""
        return int(self.pressure_hertz.size)

    @property
    def half_width(self) -> FloatArray:
        """Hertz half-width b = 4 R p_h/E' [m]."""
        return half_width_of_pressure(self.pressure_hertz, self.radius_equivalent, self.effective_modulus)

    @property
    def load_per_length(self) -> FloatArray:
        """w' = pi b p_h/2 [N/m]."""
        return hertz_load(self.pressure_hertz, self.radius_equivalent, self.effective_modulus)

    @property
    def speed_sliding(self) -> FloatArray:
        """Length of the sliding vector [m/s]."""
        return np.hypot(self.slide_to_roll * self.speed_entrainment, self.speed_sliding_lengthwise)

    @property
    def slide_to_roll_total(self) -> FloatArray:
        """Magnitude of the sliding vector over that of u_r [-]."""
        return np.asarray(self.speed_sliding / np.abs(self.speed_entrainment))

    @property
    def roughness_rms(self) -> FloatArray:
        """Composite Rq [m]."""
        return np.hypot(self.roughness_rms_1, self.roughness_rms_2)
