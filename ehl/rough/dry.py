"""Dry, frictionless, rough line contact of elastic bodies with an optional limit of the pressure (hardness).

The conditions p >= 0, gap >= 0, p gap = 0 and the load are solved by conjugate gradients on the nodes in contact.

Elastic deflection of a line contact on a uniform grid, with exactly integrated kernel, by FFT or dense matrix.

V(x) = -(4/(pi E')) int p(s) ln|x - s| ds for both bodies, with x in metres. The deflection of a line contact is defined
up to a constant: only differences of V (or h0 + V) are meaningful.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import fft

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.line_contact import LineContact


def influence_coefficients(count: int, spacing: float, effective_modulus: float) -> FloatArray:
    """Deflection at distance 0, 1, 2... nodes from a cell of constant unit pressure about its node [m/Pa].

    count: number of distances.
    spacing: [m].
    effective_modulus: E' with 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [Pa].
    Returns: shape (count,).
    """
    distance = np.arange(count, dtype=float)
    weight = _log_integral(distance + 0.5) - _log_integral(distance - 0.5)
    # far field by the moments of the cell, exact to 1e-13: differences of large numbers lose digits there
    far = distance > 60.0
    square = distance[far] ** 2
    weight[far] = np.log(distance[far]) - 1.0 / (24.0 * square) - 1.0 / (320.0 * square**2)
    return np.asarray(-4.0 / (math.pi * effective_modulus) * spacing * (weight + math.log(spacing)))


def _log_integral(t: FloatArray) -> FloatArray:
    """Antiderivative of ln|t|: t ln|t| - t."""
    return np.asarray(t * np.log(np.where(t == 0.0, 1.0, np.abs(t))) - t)


class DeflectionOperator:
    """Deflection by a pressure on n uniform nodes; zero padding avoids periodic images.

    count: number of nodes.
    spacing: node distance [m].
    effective_modulus: E' [Pa].
    """

    def __init__(self, count: int, spacing: float, effective_modulus: float) -> None:
        if count < 2 or not spacing > 0.0 or not effective_modulus > 0.0:
            given = (count, spacing, effective_modulus)
            raise InputError("count, spacing, effective_modulus", given, "at least 2 nodes, > 0 m, > 0 Pa")
        self.count, self.spacing = count, spacing
        self.coefficients = influence_coefficients(count, spacing, effective_modulus)
        self._size = fft.next_fast_len(2 * count - 1, real=True)
        kernel = np.zeros(self._size)
        kernel[:count] = self.coefficients
        kernel[self._size - count + 1 :] = self.coefficients[:0:-1]
        self._spectrum = fft.rfft(kernel)

    def __call__(self, pressure: FloatArray) -> FloatArray:
        """Deflection V [m] of a pressure [Pa], both of shape (n,); O(n log n)."""
        product = fft.irfft(fft.rfft(pressure, self._size) * self._spectrum, self._size)
        return np.asarray(product[: self.count])


REASONS = ("hardness_too_low", "domain_too_small", "iteration_limit")


@dataclass(frozen=True)
class DryContactResult:
    """Pressure and gap of the dry contact."""

    status: Literal["converged", "failed"]
    # empty, "hardness_too_low" (the nodes cannot carry the load at that pressure), "domain_too_small" (contact at the
    # edge) or "iteration_limit"
    reason: str
    # [m, Pa, m]; the gap is zero in contact, negative (material yielded) where the pressure is capped; shape (n,)
    x: FloatArray
    pressure: FloatArray
    gap: FloatArray
    pressure_max: float  # [Pa]
    contact_length: float  # length in contact [m]
    plastic_length: float  # length at the limit of the pressure [m]
    approach: float  # h0 in gap = h0 + x^2/(2R) - roughness + V [m], with the level of V of `ehl.rough.dry`
    # largest violation of gap = 0 in contact and gap >= 0 elsewhere, over the deflection scale b^2/R [-]
    gap_residual: float
    load_residual: float  # relative [-]
    iterations: int


def uniform_grid(contact: LineContact, count: int, reach: float = 2.0) -> FloatArray:
    """Cell centres of `count` equal cells from -reach b to reach b [m]."""
    spacing = 2.0 * reach * contact.half_width / count
    return np.asarray(spacing * (np.arange(count) + 0.5 - 0.5 * count), dtype=float)


def solve_dry(
    contact: LineContact,
    x: FloatArray,
    roughness: FloatArray | None = None,
    *,
    hardness: float = math.inf,
    tolerance: float = 1e-8,
    max_iterations: int = 5000,
) -> DryContactResult:
    """Solve the dry contact of a cylinder with a rough plane.

    Method of Polonsky & Keer (1999), Wear 231, 206-219, with the kernel of the line contact. The pressure is limited
    after Almqvist, Sahlin, Larsson & Glavatskih (2007), Tribol. Int. 40, 574-579: nodes at the limit leave the
    conjugate set and may overlap.

    contact: radius, modulus and load.
    x (n,): uniform nodes [m]; must contain the whole contact.
    roughness (n,): sum of both profiles at one time, positive out of the material [m].
    hardness: largest pressure [Pa].
    tolerance: on `gap_residual` and on the change of pressure.
    Raises `InputError`: the nodes are not uniform, or shapes differ.
    """
    spacing = float(x[1] - x[0])
    if not np.allclose(np.diff(x), spacing, rtol=1e-6):
        raise InputError("x", "array", "uniform nodes")
    rough = np.zeros_like(x) if roughness is None else np.asarray(roughness, dtype=float)
    if rough.shape != x.shape or not np.all(np.isfinite(rough)):
        raise InputError("roughness", rough.shape, f"finite heights of shape {x.shape}")
    if not hardness > 0.0:
        raise InputError("hardness", hardness, "> 0 Pa")
    total = contact.load_per_length / spacing
    # a node cannot carry more than the whole load: a finite limit in every case
    hardness = min(hardness, 2.0 * total)
    shape = x**2 / (2.0 * contact.radius_equivalent) - rough
    scale = contact.half_width**2 / contact.radius_equivalent
    operator = DeflectionOperator(len(x), spacing, contact.effective_modulus)
    reason, iterations = "iteration_limit", 0
    if hardness * len(x) <= total:
        reason, pressure, max_iterations = "hardness_too_low", np.zeros_like(x), 0
    else:
        pressure = contact.pressure_hertz * np.sqrt(np.maximum(1.0 - (x / contact.half_width) ** 2, 0.0))
        pressure = _loaded(np.minimum(pressure + 1e-3 * contact.pressure_hertz, hardness), total, hardness)
    direction, norm_before, conjugate = np.zeros_like(x), 1.0, 0.0
    while iterations < max_iterations:
        iterations += 1
        touching = (pressure > 0.0) & (pressure < hardness)
        if not np.any(touching):
            reason = "hardness_too_low"
            break
        gap = shape + operator(pressure)
        gap -= float(np.mean(gap[touching]))
        residual = np.where(touching, gap, 0.0)
        norm = float(residual @ residual)
        direction = np.where(touching, residual + conjugate * norm / norm_before * direction, 0.0)
        norm_before = norm if norm > 0.0 else 1.0
        bent = operator(direction)
        bent -= float(np.mean(bent[touching]))
        curvature = float(bent[touching] @ direction[touching])
        step = float(residual @ direction) / curvature if curvature > 0.0 else 0.0
        before = pressure
        pressure = np.where(touching, np.clip(pressure - step * direction, 0.0, hardness), pressure)
        # overlapping nodes without pressure enter the conjugate set, opening nodes at the limit return to it
        pulled_in = (pressure == 0.0) & (gap < 0.0)
        released = (pressure == hardness) & (gap > 0.0)
        changed = (pulled_in | released) & ~touching
        pressure = np.where(changed, np.clip(pressure - step * gap, 0.0, hardness), pressure)
        conjugate = 0.0 if bool(np.any(changed)) else 1.0
        pressure = _loaded(pressure, total, hardness)
        if float(np.sum(np.abs(pressure - before))) < tolerance * total:
            violation = float(np.max(np.abs(residual)))
            violation = max(violation, float(-np.min(np.where(pressure < hardness, gap, 0.0))))
            if violation < tolerance * scale:
                reason = ""
                break
    if not reason and (pressure[0] > 0.0 or pressure[-1] > 0.0):
        reason = "domain_too_small"
    touching = (pressure > 0.0) & (pressure < hardness)
    gap = shape + operator(pressure)
    approach = -float(np.mean(gap[touching])) if bool(np.any(touching)) else 0.0
    gap = gap + approach
    elastic = np.where(touching, np.abs(gap), np.where(pressure == 0.0, np.maximum(-gap, 0.0), 0.0))
    load = float(np.sum(pressure)) * spacing
    return DryContactResult(
        status="failed" if reason else "converged",
        reason=reason,
        x=x,
        pressure=pressure,
        gap=gap,
        pressure_max=float(np.max(pressure)),
        contact_length=float(np.count_nonzero(pressure > 0.0)) * spacing,
        plastic_length=float(np.count_nonzero(pressure >= hardness)) * spacing,
        approach=approach,
        gap_residual=float(np.max(elastic)) / scale,
        load_residual=abs(load / contact.load_per_length - 1.0),
        iterations=iterations,
    )


def _loaded(pressure: FloatArray, total: float, hardness: float) -> FloatArray:
    """The pressure scaled to the load, except at nodes at the limit."""
    for _ in range(50):
        capped = pressure >= hardness
        free = float(np.sum(pressure[~capped]))
        wanted = total - hardness * float(np.count_nonzero(capped))
        if free <= 0.0 or wanted <= 0.0:
            return pressure * (total / float(np.sum(pressure)))
        pressure = np.where(capped, hardness, np.minimum(pressure * (wanted / free), hardness))
        if abs(float(np.sum(pressure)) - total) <= 1e-14 * total:
            break
    return pressure
