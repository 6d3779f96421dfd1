"""Compliance of the teeth: bending and shear of each tooth as a cantilever plate, and local contact
compliance.

The plate is the tooth unrolled along its trace: clamped at the root, free at the tip, toe and heel,
thickness and height varying. Deflection and both rotations of Mindlin's plate are polynomials whose
coefficients minimise the potential energy (Rayleigh-Ritz), so every point of a tooth feels a load at every
other point. Left out: rotation of the tooth's foundation, lengthwise curvature of the tooth, root fillets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve

from efficiency.blank import ToothShape
from ehl.errors import InputError
from ehl.material import Material

FloatArray = NDArray[np.float64]

SHEAR_FACTOR = 5.0 / 6.0


def _legendre(degree: int, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Legendre polynomials up to a degree and their derivatives, each (points, degree + 1)."""
    identity = np.eye(degree + 1)
    values = np.asarray(legendre.legvander(x, degree), np.float64)
    return values, np.asarray(legendre.legval(x, legendre.legder(identity)).T, np.float64)


@dataclass(frozen=True)
class CantileverPlate:
    """Mindlin plate clamped along its root line, free on the three other edges, of varying height and
    thickness.

    Parameters
    ----------
    station : (m,) array
        Coordinate along the plate at which the shape is given [m], increasing from 0; linear in between.
    height : (m,) array
        Height of the free edge over the clamped one [m].
    thickness_root, thickness_tip : (m,) arrays
        Thickness at the clamped and at the free edge [m]; linear over the height.
    youngs_modulus, poisson_ratio : float
        Elastic constants [Pa], [-].
    terms_height, terms_length : int
        Polynomials in the height and along the plate for each of the three fields.

    Raises
    ------
    InputError
        If the shape arrays disagree in length or are not positive.
    """

    station: FloatArray
    height: FloatArray
    thickness_root: FloatArray
    thickness_tip: FloatArray
    youngs_modulus: float
    poisson_ratio: float
    terms_height: int = 8
    terms_length: int = 20
    _factor: tuple[FloatArray, bool] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        shape = self.station.shape
        if self.station.ndim != 1 or shape[0] < 2 or np.any(np.diff(self.station) <= 0.0):
            raise InputError("station", self.station.tolist(), "at least two increasing values")
        for name in ("height", "thickness_root", "thickness_tip"):
            values = getattr(self, name)
            if values.shape != shape or not np.all(np.isfinite(values)) or np.any(values <= 0.0):
                raise InputError(name, values.tolist(), f"{shape[0]} finite values above 0 m")
        object.__setattr__(self, "_factor", cho_factor(self._stiffness(), lower=True))

    @property
    def length(self) -> float:
        """Extent along the clamped edge [m]."""
        return float(self.station[-1] - self.station[0])

    def local_height(self, along: ArrayLike) -> FloatArray:
        """Height of the free edge at a coordinate along the plate [m]."""
        return np.asarray(np.interp(np.asarray(along, float), self.station, self.height))

    def thickness(self, along: ArrayLike, height: ArrayLike) -> FloatArray:
        """Thickness at a point [m]."""
        along = np.asarray(along, float)
        share = np.asarray(height, float) / self.local_height(along)
        root = np.interp(along, self.station, self.thickness_root)
        tip = np.interp(along, self.station, self.thickness_tip)
        return np.asarray(root + (tip - root) * share)

    def influence(self, along: ArrayLike, height: ArrayLike) -> FloatArray:
        """Deflection at each point per unit force at each point, square to the plate.

        Parameters
        ----------
        along, height : (n,) array_like
            Coordinates along the clamped edge and over it [m].

        Returns
        -------
        (n, n) array
            Symmetric positive semidefinite compliance [m/N].
        """
        basis = self._basis(np.asarray(along, float), np.asarray(height, float))[0]
        unknowns = basis.shape[1]
        padded = np.zeros((3 * unknowns, basis.shape[0]))
        padded[:unknowns] = basis.T
        compliance = basis @ cho_solve(self._factor, padded)[:unknowns]
        return 0.5 * (compliance + compliance.T)

    def _basis(self, along: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Basis functions and their derivatives along the plate and over the height, each (n, unknowns)."""
        local = self.local_height(along)
        slope = np.interp(along, self.station, np.gradient(self.height, self.station))
        eta = height / local
        p, dp = _legendre(self.terms_height - 1, 2.0 * eta - 1.0)
        q, dq = _legendre(self.terms_length - 1, 2.0 * (along - self.station[0]) / self.length - 1.0)
        clamped, dclamped = eta[:, None] * p, p + 2.0 * eta[:, None] * dp
        n = along.size

        def product(a: FloatArray, b: FloatArray) -> FloatArray:
            return (a[:, :, None] * b[:, None, :]).reshape(n, -1)

        by_eta = product(dclamped, q)
        over_height = by_eta / local[:, None]
        over_length = product(clamped, dq) * (2.0 / self.length) - by_eta * (eta * slope / local)[:, None]
        return product(clamped, q), over_length, over_height

    def _stiffness(self) -> FloatArray:
        """Stiffness of deflection, rotation along and rotation over the height."""
        x, wx = np.polynomial.legendre.leggauss(self.terms_length + 4)
        e, we = np.polynomial.legendre.leggauss(self.terms_height + 4)
        along = self.station[0] + 0.5 * self.length * (1.0 + np.repeat(x, e.size))
        local = self.local_height(along)
        height = np.tile(0.5 * (1.0 + e), x.size) * local
        weight = np.repeat(wx, e.size) * np.tile(we, x.size) * 0.25 * self.length * local
        t = self.thickness(along, height)
        nu, modulus = self.poisson_ratio, self.youngs_modulus
        bending = (weight * modulus * t**3 / (12.0 * (1.0 - nu**2)))[:, None]
        shear = (weight * SHEAR_FACTOR * modulus * t / (2.0 * (1.0 + nu)))[:, None]
        f, fs, fz = self._basis(along, height)
        twist = 0.5 * (1.0 - nu)
        block_ww = fs.T @ (shear * fs) + fz.T @ (shear * fz)
        block_ws, block_wz = -fs.T @ (shear * f), -fz.T @ (shear * f)
        mass = f.T @ (shear * f)
        block_ss = fs.T @ (bending * fs) + twist * fz.T @ (bending * fz) + mass
        block_zz = fz.T @ (bending * fz) + twist * fs.T @ (bending * fs) + mass
        block_sz = nu * fs.T @ (bending * fz) + twist * fz.T @ (bending * fs)
        return np.block(
            [
                [block_ww, block_ws, block_wz],
                [block_ws.T, block_ss, block_sz],
                [block_wz.T, block_sz.T, block_zz],
            ]
        )


@dataclass(frozen=True)
class Tooth:
    """One tooth of a member: its plate, and how the contact normal stands to it.

    Parameters
    ----------
    plate : CantileverPlate
        The tooth unrolled along its trace.
    cos_spiral : float
        Cosine of the mean spiral angle: face width over length of the trace.
    pressure_angle : float
        Angle between the contact normal and the normal of the plate [rad].
    """

    plate: CantileverPlate
    cos_spiral: float
    pressure_angle: float

    @classmethod
    def from_shape(
        cls,
        shape: ToothShape,
        spiral_angle: float,
        pressure_angle: float,
        material: Material,
        terms: tuple[int, int] = (8, 20),
    ) -> Tooth:
        """The plate of a tooth of a blank; angles in rad, ``terms`` over the height and along."""
        cos_spiral = float(np.cos(spiral_angle))
        plate = CantileverPlate(
            shape.face / cos_spiral,
            shape.height,
            shape.thickness_root,
            shape.thickness_tip,
            material.youngs_modulus,
            material.poisson_ratio,
            *terms,
        )
        return cls(plate, cos_spiral, pressure_angle)

    def influence(self, face: ArrayLike, height: ArrayLike) -> FloatArray:
        """Deflection along the contact normal per unit normal force [m/N], (n, n).

        The force acts where its line meets the middle plane (below the contact, towards the root), so its
        component along the height bends nothing; compression by that component is left out.

        Parameters
        ----------
        face, height : (n,) array_like
            Contact points: distance from the toe along the pitch cone and over the root cone [m].
        """
        along, height = self._on_plate(face, height)
        lowered = height - 0.5 * self.plate.thickness(along, height) * np.tan(self.pressure_angle)
        return float(np.cos(self.pressure_angle)) ** 2 * self.plate.influence(along, np.maximum(lowered, 0.0))

    def depth(self, face: ArrayLike, height: ArrayLike) -> FloatArray:
        """Distance along the contact normal from the flank to the middle plane [m], (n,)."""
        along, height = self._on_plate(face, height)
        return np.asarray(0.5 * self.plate.thickness(along, height) / np.cos(self.pressure_angle))

    def _on_plate(self, face: ArrayLike, height: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Plate coordinates of flank points; points a little beyond an edge are put on it."""
        station = self.plate.station
        along = np.clip(np.asarray(face, float) / self.cos_spiral, station[0], station[-1])
        return along, np.clip(np.asarray(height, float), 0.0, self.plate.local_height(along))


def weber_local(
    load_per_length: ArrayLike,
    half_width: ArrayLike,
    depth: ArrayLike,
    youngs_modulus: float,
    poisson_ratio: float,
) -> FloatArray:
    """Approach of a Hertz line contact to a point under it, one body [m].

    Plane strain of the Hertz stresses on the axis of symmetry, integrated from the surface to a depth h
    (ours):

        d = 2 w'(1 - nu^2)/(pi E) [asinh(h/b) - nu/(1 - nu) (H sqrt(1 + H^2) - H^2)],  H = h/b.

    For h >> b it is the formula of Weber (1949), ``ln(2 h/b) - nu/(2 (1 - nu))`` in the bracket; unlike
    that it never turns negative.

    Parameters
    ----------
    load_per_length : array_like
        w' [N/m].
    half_width, depth : array_like
        b and h [m].
    youngs_modulus, poisson_ratio : float
        Of the body [Pa], [-].
    """
    ratio = np.asarray(depth, float) / np.asarray(half_width, float)
    scale = 2.0 * np.asarray(load_per_length, float) * (1.0 - poisson_ratio**2) / (np.pi * youngs_modulus)
    # H sqrt(1+H^2) - H^2 written without cancellation
    lateral = ratio / (np.sqrt(1.0 + ratio**2) + ratio)
    return np.asarray(scale * (np.arcsinh(ratio) - poisson_ratio / (1.0 - poisson_ratio) * lateral))


@dataclass(frozen=True)
class LocalCompliance:
    """Nonlinear local compliance of both bodies at a set of contact points.

    Parameters
    ----------
    radius_equivalent : (n,) array
        Equivalent radius normal to the contact line [m].
    depths : sequence of two (n,) arrays
        Distance from the flank to the middle plane of pinion and gear tooth [m].
    materials : sequence of two Material
        Pinion and gear.
    effective_modulus : float
        E' [Pa].
    """

    radius_equivalent: FloatArray
    depths: Sequence[FloatArray]
    materials: Sequence[Material]
    effective_modulus: float

    def approach(self, load_per_length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Approach of both middle planes [m] and its derivative by the load per length [m2/N].

        Parameters
        ----------
        load_per_length : (n,) array
            w' [N/m]; must be positive.
        """
        b = np.sqrt(8.0 * load_per_length * self.radius_equivalent / (np.pi * self.effective_modulus))
        total, slope = np.zeros_like(b), np.zeros_like(b)
        for depth, material in zip(self.depths, self.materials, strict=True):
            nu = material.poisson_ratio
            part = weber_local(load_per_length, b, depth, material.youngs_modulus, nu)
            scale = 2.0 * (1.0 - nu**2) / (np.pi * material.youngs_modulus)
            ratio = depth / b
            # d/dw of w f(h/b), b ~ sqrt(w): f - (H/2) f'(H)
            root = np.sqrt(1.0 + ratio**2)
            dlateral = (root - ratio) ** 2 / root
            total += part
            slope += part / load_per_length - scale * 0.5 * ratio * (1.0 / root - nu / (1.0 - nu) * dlateral)
        return total, slope
