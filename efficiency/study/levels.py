"""Values of the parameters of a study, and what of them is the reference."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import radians
from typing import TYPE_CHECKING

from ehl.io.errors import InputError

if TYPE_CHECKING:
    from efficiency.design.design import Design

OPERATING = ("torque", "speed", "temperature_oil", "roughness_rms")
MISALIGNED = ("E", "P", "G", "alpha")

# shares of the design's own torque and speed; Celsius; metres; ours, after the ranges of automotive axles
_TORQUES, _SPEEDS = (0.1, 0.3, 0.6, 1.0, 1.5), (0.1, 0.25, 0.5, 1.0)
_TEMPERATURES = (313.15, 333.15, 363.15, 393.15)
_ROUGHNESSES = (1e-7, 2e-7, 4e-7, 8e-7)
_SHIFTS = (-1e-4, -5e-5, 5e-5, 1e-4)
_ARCMIN = radians(1.0 / 60.0)
_TURNS = (-4.0 * _ARCMIN, -2.0 * _ARCMIN, 2.0 * _ARCMIN, 4.0 * _ARCMIN)
_MAX_POINTS = 200_000


@dataclass(frozen=True)
class Levels:
    """Values of each parameter in SI units; all combinations of the first four, one misalignment at a time.

    Parameters
    ----------
    torque, speed, temperature_oil, roughness_rms : tuple of float
        Pinion torque [N m] and speed [rad/s], oil temperature [K], Rq of both flanks, each [m].
    E, P, G, alpha : tuple of float
        Misalignments added to those of the design [m], [rad]; zero is always computed.
    """

    torque: tuple[float, ...]
    speed: tuple[float, ...]
    temperature_oil: tuple[float, ...]
    roughness_rms: tuple[float, ...]
    E: tuple[float, ...] = _SHIFTS
    P: tuple[float, ...] = _SHIFTS
    G: tuple[float, ...] = _SHIFTS
    alpha: tuple[float, ...] = _TURNS

    def __post_init__(self) -> None:
        for name in OPERATING:
            if not getattr(self, name):
                raise InputError(name, (), "at least one value")
        size = len(self.torque) * len(self.speed) * len(self.temperature_oil) * len(self.roughness_rms)
        if size > _MAX_POINTS:
            raise InputError("levels", f"{size} operating points", f"at most {_MAX_POINTS} for each design")

    @classmethod
    def around(cls, design: Design, **given: tuple[float, ...]) -> Levels:
        """Default levels about the operating point of a design; `given` replaces some of them."""
        point = design.operation
        default = cls(
            torque=tuple(share * point.torque for share in _TORQUES),
            speed=tuple(share * point.speed for share in _SPEEDS),
            temperature_oil=_TEMPERATURES,
            roughness_rms=_ROUGHNESSES,
        )
        ordered = {name: tuple(sorted(set(values))) for name, values in given.items()}
        return replace(default, **ordered)

    def reference(self, design: Design) -> dict[str, float]:
        """The level of each operating parameter next to the design's own."""
        own = design.operation
        wanted = {
            "torque": own.torque,
            "speed": own.speed,
            "temperature_oil": own.temperature_oil,
            "roughness_rms": design.pinion.roughness_rms,
        }
        return {name: min(getattr(self, name), key=lambda level: abs(level - value)) for name, value in wanted.items()}

    def shifts(self) -> list[dict[str, float]]:
        """Misalignments, one at a time, zero left out."""
        return [{name: value} for name in MISALIGNED for value in getattr(self, name) if value != 0.0]

    def to_dict(self) -> dict[str, list[float]]:
        """For JSON."""
        return {f.name: list(getattr(self, f.name)) for f in fields(self)}
