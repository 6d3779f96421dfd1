"""Tooth compliance against three-dimensional finite elements of the same teeth on the same ring.

An independent second computation: the mesh takes the corners of its elements straight from `tooth_grid` (stations of
the face, levels of the depth), elements are 27-node hexahedra of scikit-fem with flat-sided geometry, solved by
conjugate gradients. As a script it draws docs/figures/tooth_compliance.png (four minutes a member).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from scipy.sparse import coo_matrix, diags_array, kron
from scipy.sparse.linalg import cg
from skfem import Basis, ElementHex2, ElementVector, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

from efficiency.contact.gear_flanks import Member
from efficiency.contact.tooth_grid import ToothGrid, tooth_grid
from efficiency.cutting.machine import rotation
from efficiency.design.design import Design, load_design
from efficiency.ltca.solid_tooth import SolidTooth, solid_tooth_of
from ehl.common.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Counts:
    """Elements of the mesh: across the tooth, across a slot, over the depth of the tooth and of the body, along."""

    tooth: int
    slot: int
    rows: int
    body: int
    along: int


class ToothElements:
    """Finite elements of a ring of some teeth (`cells`), which is closed by a turn of as many pitches."""

    def __init__(self, design: Design, member: Member, counts: Counts, cells: int) -> None:
        self.counts, given = counts, getattr(design, member)
        self.grid = grid = tooth_grid(design.flanks(), member, counts.rows + 1, counts.along + 1)
        azimuth, height = _section(grid, counts, cells, given.body.thickness(given.blank))
        self.columns, levels = azimuth.shape[1] - 1, azimuth.shape[0] - 1
        index = MeshHex.init_tensor(*(np.arange(n + 1.0) for n in (counts.along, levels, self.columns)))
        centre = index.p[:, index.t].mean(axis=1)
        slot = np.floor(centre[2]) % (counts.tooth + counts.slot) >= counts.tooth
        index = index.remove_elements(np.flatnonzero((centre[1] > counts.body) & slot))
        self.place = index.p.round().astype(np.int64)
        station, level, column = self.place
        points = grid.point(azimuth[level, column, station], grid.u[0, station], height[level, station])
        mesh = MeshHex(np.ascontiguousarray(points.T), index.t)
        self.basis = Basis(mesh, ElementHex2(), intorder=4)
        material = given.elastic_material()
        stiffness = elasticity(self.basis, material.youngs_modulus, material.poisson_ratio)
        # places of all nodes of the elements, twice the index of a corner
        places = (2.0 * Basis(index, ElementHex2(), intorder=1).doflocs).round().astype(np.int64)
        body = places[1] <= 2 * counts.body
        held_at = {
            "base": places[1] == 0,
            "toe": (places[0] == 0) & body,
            "heel": (places[0] == 2 * counts.along) & body,
        }
        fixed = np.any([held_at[name] for name in given.body.held], axis=0)
        last = places[2] == 2 * self.columns
        first = (places[2] == 0) & body
        # both in the order of stations and levels
        at = [np.flatnonzero(side)[np.lexsort(places[1::-1, side])] for side in (first, last)]
        self.expand = closing(self.basis.N, *at, grid.pitch * cells)[:, np.tile(~fixed & ~last, 3)].tocsr()
        self.stiffness = (self.expand.T @ stiffness @ self.expand).tocsr()

    def node(self, rows: IntArray, stations: IntArray, upper: bool, tooth: int = 0) -> IntArray:
        """Corner numbers on a flank of a tooth of the ring by level of its depth and station."""
        column = tooth * (self.counts.tooth + self.counts.slot) + (self.counts.tooth if upper else 0)
        wanted = np.stack([stations, rows + self.counts.body, np.full(rows.size, column)])
        return np.asarray((self.place[:, None] == wanted[:, :, None]).all(axis=0).argmax(axis=1))

    def normals(self, rows: IntArray, stations: IntArray, upper: bool) -> FloatArray:
        """Unit normals (n, 3) of the flank at its corners, out of the tooth."""
        g = self.grid
        flank = g.point(g.upper if upper else g.lower, g.u, g.height)
        over = np.stack([np.gradient(flank[..., k], axis=0) for k in range(3)], -1)
        along = np.stack([np.gradient(flank[..., k], axis=1) for k in range(3)], -1)
        normal = np.cross(along, over)[rows, stations] * (1.0 if upper else -1.0)
        inside = g.point(0.5 * (g.lower + g.upper), g.u, g.height)[rows, stations]
        normal *= np.sign(np.sum(normal * (flank[rows, stations] - inside), axis=1))[:, None]
        return normal / np.linalg.norm(normal, axis=1)[:, None]

    def deflection(self, loaded: IntArray, normals: FloatArray) -> FloatArray:
        """Displacements (3, nodes, loads) under a unit force on each corner against its normal [m/N]."""
        corner = self.basis.nodal_dofs[0]
        force = np.zeros((3, self.basis.N, loaded.size))
        force[:, corner[loaded], np.arange(loaded.size)] = -normals.T
        jacobi = diags_array(1.0 / self.stiffness.diagonal())
        forces = (self.expand.T @ force.reshape(-1, loaded.size)).T
        found = [cg(self.stiffness, each, rtol=1e-7, M=jacobi) for each in forces]
        assert not any(failed for _, failed in found)
        solution = np.stack([each for each, _ in found], axis=1)
        return np.asarray(self.expand @ solution).reshape(3, self.basis.N, -1)

    def at(self, deflection: FloatArray, nodes: IntArray, normals: FloatArray) -> FloatArray:
        """Deflection (points, loads) at corners against their normals [m/N]."""
        return np.asarray(-np.einsum("knl,nk->nl", deflection[:, self.basis.nodal_dofs[0][nodes]], normals))


def elasticity(basis: Basis, youngs_modulus: float, poisson_ratio: float) -> Any:
    """Stiffness of all components of all nodes, component by component."""
    both = Basis(basis.mesh, ElementVector(basis.elem), quadrature=basis.quadrature)
    stiffness = linear_elasticity(*lame_parameters(youngs_modulus, poisson_ratio)).assemble(both)
    order = np.arange(3 * basis.N).reshape(-1, 3).T.ravel()
    return stiffness[order][:, order]


def closing(size: int, first: IntArray, last: IntArray, angle: float) -> Any:
    """Square matrix that writes the displacements of the last nodes as those of the first, turned."""
    pairs = coo_matrix((np.ones(last.size), (last, first)), shape=(size, size))
    rest = np.setdiff1d(np.arange(size), last)
    keep = coo_matrix((np.ones(rest.size), (rest, rest)), shape=(size, size))
    return (kron(np.eye(3), keep) + kron(rotation(angle), pairs)).tocsc()


def _section(grid: ToothGrid, counts: Counts, cells: int, rim: float) -> tuple[FloatArray, FloatArray]:
    """Azimuths (levels, columns, stations) and heights (levels, stations) of all corners."""
    tooth = np.linspace(0.0, 1.0, counts.tooth + 1)[:-1, None]
    slot = np.linspace(0.0, 1.0, counts.slot + 1)[:-1, None]
    lower, upper = grid.lower[:, None], grid.upper[:, None]
    cell = np.concatenate([lower + tooth * (upper - lower), upper + slot * (lower + grid.pitch - upper)], axis=1)
    azimuth = np.concatenate([*(cell + j * grid.pitch for j in range(cells)), lower + cells * grid.pitch], axis=1)
    # levels of the body closer together under the root
    depth = np.linspace(1.0, 0.0, counts.body + 1)[:-1, None] ** 1.5
    base = grid.blank.root(grid.u[0]) - rim
    below = grid.height[0] + depth * (base - grid.height[0])
    return np.concatenate([np.repeat(azimuth[:1], counts.body, axis=0), azimuth]), np.concatenate([below, grid.height])


@dataclass(frozen=True)
class NinePoints:
    """Deflection at nine points of a flank, three heights by three places along the face, by finite elements.

    Distance from the toe and over the root cone [m], (9,); deflection of the points per unit force on each of them, and
    of the same points of the next tooth in rising azimuth [m/N], (9, 9).
    """

    face: FloatArray
    height: FloatArray
    own: FloatArray
    ahead: FloatArray

    def errors(self, tooth: SolidTooth) -> FloatArray:
        """Difference of a tooth model, away from the load and in the unit of the largest deflection there, (72,)."""
        away = ~np.eye(9, dtype=bool)
        largest = np.max(np.where(away, np.abs(self.own), 0.0), axis=0)
        return np.asarray(((influence(tooth, self.face, self.height) - self.own) / largest)[away])


def nine_points(design: Design, member: Member, counts: Counts, cells: int) -> NinePoints:
    """Finite elements of one member, loaded on its drive flank."""
    elements = ToothElements(design, member, counts, cells)
    grid = elements.grid
    upper = grid.sides[1] == design.flanks().loaded_side(member, "drive")
    levels = [round(share * counts.rows) for share in (0.25, 0.625, 1.0)]
    stations = [round(share * counts.along) for share in (0.125, 0.5, 0.875)]
    rows, columns = (np.asarray(x).ravel() for x in np.meshgrid(levels, stations, indexing="ij"))
    nodes, normals = elements.node(rows, columns, upper), elements.normals(rows, columns, upper)
    deflection = elements.deflection(nodes, normals)
    own = elements.at(deflection, nodes, normals)
    ahead = own
    if cells > 1:
        turned = normals @ rotation(grid.pitch).T
        ahead = elements.at(deflection, elements.node(rows, columns, upper, 1), turned)
    face = grid.u[0] - grid.u[0, 0]
    height = grid.height[rows, columns] - grid.blank.root(grid.u[0, columns])
    return NinePoints(face[columns], height, own, ahead)


def influence(tooth: SolidTooth, face: FloatArray, height: FloatArray) -> FloatArray:
    """Deflection along the contact normal per unit normal force on one tooth [m/N], (n, n)."""
    return tooth.influences([(face, height, np.zeros(face.size, np.int64))])[0]


def main() -> None:
    """Draw docs/figures/tooth_compliance.png: deflection at nine points of four members by elements and models."""
    figure = Figure(figsize=(8.0, 7.0), layout="constrained")
    panels = figure.subplots(2, 2).ravel()
    away = ~np.eye(9, dtype=bool)
    members: tuple[Member, Member] = ("pinion", "gear")
    for axes, (name, member) in zip(panels, product(("fm_spiral_bevel_14x39", "fh_hypoid_9x34"), members), strict=True):
        design = load_design(name)
        solid = solid_tooth_of(design.flanks(), getattr(design, member).tooth_body(), member, "drive", cells=3)
        points = nine_points(design, member, Counts(3, 3, 8, 4, 16), 3)
        errors = points.errors(solid)
        worst, rms = 100 * np.abs(errors).max(), 100 * np.sqrt(np.mean(errors**2))
        print(f"{name} {member}: away from the load worst {worst:.1f} %, rms {rms:.1f} %")
        x = 1e9 * points.own[away]
        axes.loglog(x, x, color="#909090", lw=1)
        of_solid = influence(solid, points.face, points.height)[away]
        axes.loglog(x, 1e9 * of_solid, "o", ms=4, color="#1f5a99", label="solid on its ring")
        axes.set(title=f"{name}, {member}", xlabel="finite elements [nm/N]", ylabel="model [nm/N]")
        axes.set(xlim=(0.08, 8.0), ylim=(1e-3, 8.0))
        axes.xaxis.set_minor_formatter(NullFormatter())
    panels[0].legend(frameon=False)
    figure.savefig(Path(__file__).parents[2] / "docs" / "figures" / "tooth_compliance.png", dpi=130)


if __name__ == "__main__":
    main()
