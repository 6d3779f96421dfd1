"""One-dimensional conduction at the points of a moving surface: the limit of `jaeger_matrix` at high Peclet numbers.

The transient solver conducts so; with `conducts_like_the_transient_solver` the steady one does as well.
"""

import math
from typing import Any

import numpy as np

import ehl.heat.traction
import ehl.smooth.hot_film


def material_point_matrix(x: Any, speed: float, body: Any) -> np.ndarray:
    """A of ``rise = A @ flux`` for a flux that is linear between nodes [K m2/W].

    T(x) = (pi rho c k |u|)^(-1/2) int q(s) |x - s|^(-1/2) ds over the part of the surface's way already done
    (Carslaw & Jaeger, Conduction of Heat in Solids, section 2.9, with t = |x - s|/|u|).
    """
    if speed < 0.0:
        return np.ascontiguousarray(material_point_matrix(-x[::-1], -speed, body)[::-1, ::-1])
    distance = np.maximum(x[:, None] - x[None, :], 0.0)
    root = np.sqrt(distance)
    upper, lower = root[:, :-1], root[:, 1:]
    width = distance[:, :-1] - distance[:, 1:]  # zero for cells the point has not passed
    total = np.where(upper > 0.0, upper + lower, 1.0)
    weight = (2.0 / 3.0) * width / total**2
    matrix = np.zeros((len(x), len(x)))
    matrix[:, :-1] += weight * (upper + 2.0 * lower)
    matrix[:, 1:] += weight * (2.0 * upper + lower)
    return np.asarray(matrix / (math.sqrt(math.pi * speed) * body.thermal_effusivity))


def conducts_like_the_transient_solver(monkeypatch: Any) -> None:
    """Let the steady heat balance use one-dimensional conduction."""

    def matrices(x: Any, contact: Any, bodies: Any) -> Any:
        speeds = (contact.speed_1, contact.speed_2)
        return tuple(material_point_matrix(x, u, body) for u, body in zip(speeds, bodies, strict=True))

    monkeypatch.setattr(ehl.smooth.hot_film, "surface_matrices", matrices)


def at_mid_film(monkeypatch: Any) -> None:
    """Let the steady heat balance take the viscosity at mid-film of a parabola, for shear and flow alike."""
    monkeypatch.setattr(ehl.heat.traction, "RISE", ((1.0, 0.0, 0.0, 0.0),) * 2)
    monkeypatch.setattr(ehl.heat.traction, "SHARES", (((1.0,), (1.0,)),) * 2)


def without_convection(monkeypatch: Any) -> None:
    """Let the steady heat balance conduct the heat of the shear to the walls where it arises."""
    monkeypatch.setattr(ehl.smooth.hot_film, "Convection", lambda *rows: None)


def without_flow_heat(monkeypatch: Any) -> None:
    """Let the steady heat balance leave out the heat of the pressure-driven flow."""
    monkeypatch.setattr(ehl.smooth.hot_film, "flow_heat", lambda x, *others: np.zeros_like(x))
