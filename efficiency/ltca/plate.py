"""A tooth as a plate on an elastic root: the method of the field, for comparison and where no solid can be made.

The plate is the tooth unrolled along its trace: free at the tip, toe and heel, thickness and height varying.
Deflection and both rotations of Mindlin's plate are polynomials whose coefficients minimise the potential
energy (Rayleigh-Ritz), so every point of a tooth feels a load at every other point. The root gives way as an
elastic half-plane under each slice of the tooth. Left out: what one slice or tooth does to the body under its
neighbours, the rim and how it is held, lengthwise curvature of the tooth, root fillets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve

from efficiency.contact.tooth_grid import ToothShape
from efficiency.ltca.local_compliance import Points
from ehl.common.errors import InputError
from ehl.material import Material

FloatArray = NDArray[np.float64]

SHEAR_FACTOR = 5.0 / 6.0
WEBER_TRANSLATION = 1.4


def _legendre(degree: int, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Legendre polynomials up to a degree and their derivatives, each (points, degree + 1)."""
    identity = np.eye(degree + 1)
    values = np.asarray(legendre.legvander(x, degree), np.float64)
    return values, np.asarray(legendre.legval(x, legendre.legder(identity)).T, np.float64)


def root_compliance(thickness: FloatArray, youngs_modulus: float, poisson_ratio: float) -> FloatArray:
    """Rotation and deflection of the root of a tooth slice on a half-plane, per unit moment and force.

    Weber (1949), plane strain: ``[[a/t^2, c/t], [c/t, d]]/E``. a = 18 (1 - nu^2)/pi and c = (1 + nu)(1 - 2 nu)
    follow from the half-plane under linear bending and even shear stress (our derivation; Weber rounds to 5.2 and 1/2
    at nu 0.3). The translation d = 1.4 depends on where the body is held and is Weber's, from memory.

    Parameters
    ----------
    thickness : (n,) array
        At the root [m].
    youngs_modulus, poisson_ratio : float
        [Pa], [-].

    Returns
    -------
    (n, 2, 2) array
        Per unit length of root, for (rotation, deflection) under (moment, force).
    """
    nu = poisson_ratio
    turn = np.full_like(thickness, 18.0 * (1.0 - nu**2) / np.pi) / thickness**2
    mixed = (1.0 + nu) * (1.0 - 2.0 * nu) / thickness
    shift = np.full_like(thickness, WEBER_TRANSLATION)
    return np.stack([np.stack([turn, mixed], -1), np.stack([mixed, shift], -1)], -2) / youngs_modulus


@dataclass(frozen=True)
class CantileverPlate:
    """Mindlin plate held along its root line, free on the three other edges.

    Height and thickness vary along it, thickness also over the height.

    Parameters
    ----------
    station : (m,) array
        Coordinate along the plate at which the shape is given [m], increasing from 0; linear in between.
    height : (m,) array
        Height of the free edge over the root line [m].
    thickness_root, thickness_tip : (m,) arrays
        Thickness at the root line and at the free edge [m]; linear over the height.
    youngs_modulus, poisson_ratio : float
        Elastic constants [Pa], [-].
    terms_height, terms_length : int
        Polynomials in the height and along the plate for each of the three fields.
    elastic_root : bool
        Hold the root by `root_compliance` instead of clamping it.

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
    elastic_root: bool = False
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
        """Extent along the root line [m]."""
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
            Coordinates along the root line and over it [m].

        Returns
        -------
        (n, n) array
            Symmetric positive semidefinite compliance [m/N].
        """
        basis = self._basis(np.asarray(along, float), np.asarray(height, float), self.elastic_root)[0]
        padded = np.zeros((self._factor[0].shape[0], basis.shape[0]))
        padded[: basis.shape[1]] = basis.T
        compliance = basis @ cho_solve(self._factor, padded)[: basis.shape[1]]
        return 0.5 * (compliance + compliance.T)

    def _basis(
        self, along: FloatArray, height: FloatArray, free_root: bool
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Basis functions and their derivatives along the plate and over the height, each (n, unknowns)."""
        local = self.local_height(along)
        slope = np.interp(along, self.station, np.gradient(self.height, self.station))
        eta = height / local
        p, dp = _legendre(self.terms_height - 1, 2.0 * eta - 1.0)
        q, dq = _legendre(self.terms_length - 1, 2.0 * (along - self.station[0]) / self.length - 1.0)
        if free_root:
            shape, by_eta = p, 2.0 * dp
        else:
            shape, by_eta = eta[:, None] * p, p + 2.0 * eta[:, None] * dp

        def product(a: FloatArray, b: FloatArray) -> FloatArray:
            return (a[:, :, None] * b[:, None, :]).reshape(along.size, -1)

        over_eta = product(by_eta, q)
        over_length = product(shape, dq) * (2.0 / self.length) - over_eta * (eta * slope / local)[:, None]
        return product(shape, q), over_length, over_eta / local[:, None]

    def _stiffness(self) -> FloatArray:
        """Stiffness of deflection, rotation along and rotation over the height."""
        x, wx = np.polynomial.legendre.leggauss(self.terms_length + 4)
        e, we = np.polynomial.legendre.leggauss(self.terms_height + 4)
        root = self.station[0] + 0.5 * self.length * (1.0 + x)
        along = np.repeat(root, e.size)
        local = self.local_height(along)
        height = np.tile(0.5 * (1.0 + e), x.size) * local
        weight = np.repeat(wx, e.size) * np.tile(we, x.size) * 0.25 * self.length * local
        t = self.thickness(along, height)
        nu, modulus = self.poisson_ratio, self.youngs_modulus
        bending = (weight * modulus * t**3 / (12.0 * (1.0 - nu**2)))[:, None]
        shear = (weight * SHEAR_FACTOR * modulus * t / (2.0 * (1.0 + nu)))[:, None]
        f, fs, fz = self._basis(along, height, self.elastic_root)  # deflection, rotation over the height
        g, gs, gz = self._basis(along, height, False)  # rotation along: held by the root
        twist = 0.5 * (1.0 - nu)
        ww = fs.T @ (shear * fs) + fz.T @ (shear * fz)
        ws, wz = -fs.T @ (shear * g), -fz.T @ (shear * f)
        ss = gs.T @ (bending * gs) + twist * gz.T @ (bending * gz) + g.T @ (shear * g)
        zz = fz.T @ (bending * fz) + twist * fs.T @ (bending * fs) + f.T @ (shear * f)
        sz = nu * gs.T @ (bending * fz) + twist * gz.T @ (bending * fs)
        if self.elastic_root:
            at_root = self._basis(root, np.zeros_like(root), True)[0]
            thickness = self.thickness(root, np.zeros_like(root))
            spring = np.linalg.inv(root_compliance(thickness, modulus, nu))
            spring *= (wx * 0.5 * self.length)[:, None, None]
            ww += at_root.T @ (spring[:, 1, 1, None] * at_root)
            wz += at_root.T @ (spring[:, 0, 1, None] * at_root)
            zz += at_root.T @ (spring[:, 0, 0, None] * at_root)
        return np.block([[ww, ws, wz], [ws.T, ss, sz], [wz.T, sz.T, zz]])


@dataclass(frozen=True)
class PlateTooth:
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
        elastic_root: bool = True,
    ) -> PlateTooth:
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
            elastic_root=elastic_root,
        )
        return cls(plate, cos_spiral, pressure_angle)

    @property
    def face_width(self) -> float:
        """Face width [m]."""
        return self.plate.length * self.cos_spiral

    def whole_depth(self, face: ArrayLike) -> FloatArray:
        """Height of the tip over the root cone at a distance from the toe [m]."""
        return self.plate.local_height(np.asarray(face, float) / self.cos_spiral)

    def influence(self, face: ArrayLike, height: ArrayLike, tooth: ArrayLike = 0) -> FloatArray:
        """Deflection along the contact normal per unit normal force [m/N], (n, n).

        The force acts where its line meets the middle plane (below the contact, towards the root), so its
        component along the height bends nothing; compression by that component is left out.

        Parameters
        ----------
        face, height : (n,) array_like
            Contact points: distance from the toe along the pitch cone and over the root cone [m].
        tooth : (n,) array_like
            The tooth each lies on. Teeth do not feel each other: the body under the plate is rigid.
        """
        along, height = self._on_plate(face, height)
        lowered = height - 0.5 * self.plate.thickness(along, height) * np.tan(self.pressure_angle)
        number = np.broadcast_to(tooth, along.shape)
        own = self.plate.influence(along, np.maximum(lowered, 0.0))
        return float(np.cos(self.pressure_angle)) ** 2 * np.where(number[:, None] == number, own, 0.0)

    def influences(self, sets: Sequence[Points]) -> list[FloatArray]:
        """`influence` of several sets of points that do not know of each other."""
        return [self.influence(*points) for points in sets]

    def depth(self, face: ArrayLike, height: ArrayLike) -> FloatArray:
        """Distance along the contact normal from the flank to the middle plane [m], (n,)."""
        along, height = self._on_plate(face, height)
        return np.asarray(0.5 * self.plate.thickness(along, height) / np.cos(self.pressure_angle))

    def outline(self) -> FloatArray:
        """Closed outline of the flank: distance from the toe and over the root cone [m], (2, k)."""
        face = (self.plate.station - self.plate.station[0]) * self.cos_spiral
        there = np.stack([face, np.zeros_like(face)])
        back = np.stack([face, self.plate.height])[:, ::-1]
        return np.concatenate([there, back, there[:, :1]], axis=1)

    def _on_plate(self, face: ArrayLike, height: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Plate coordinates of flank points; points a little beyond an edge are put on it."""
        station = self.plate.station
        along = np.clip(np.asarray(face, float) / self.cos_spiral, station[0], station[-1])
        return along, np.clip(np.asarray(height, float), 0.0, self.plate.local_height(along))
