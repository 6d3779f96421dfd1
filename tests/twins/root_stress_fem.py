"""Root stress against three-dimensional finite elements of the same teeth on the same ring.

An independent second computation: the elements of `compliance_fem` (27-node hexahedra of scikit-fem, corners straight
from `tooth_grid`), loaded along lines on one flank; greatest principal stress at the faces of the elements that make
the fillet. As a script it draws docs/figures/root_stress_fem.png, for a ring of teeth loaded alike.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from skfem import FacetBasis
from twins.compliance_fem import Counts, ToothElements, conjugate_gradients

from efficiency.contact.gear_flanks import Member
from efficiency.design.design import Design, MemberInput, load_design
from efficiency.ltca.solid_tooth import solid_tooth_of
from efficiency.strength.root_stress import root_tooth

FloatArray = NDArray[np.float64]

# lines of load: places at the ends, share of the face and of the depth
LINES = {"high, along the middle": ((0.25, 0.8), (0.75, 0.8)), "across, root to tip": ((0.2, 0.55), (0.7, 1.0))}
FORCE = 1e4


@dataclass(frozen=True)
class RootPeaks:
    """Greatest stress along the fillet of the loaded side under a line load of 10 kN, by both methods.

    Attributes
    ----------
    face : (k,) array
        Distance from the toe [m].
    elements, model : (k,) arrays
        [Pa].
    unknowns : int
    seconds : float
    """

    face: FloatArray
    elements: FloatArray
    model: FloatArray
    unknowns: int
    seconds: float


def with_edge_radius(design: Design, radius: float) -> Design:
    """The design with an edge radius [m] on all blades, so that both methods see the same cut fillet."""

    def member(given: MemberInput) -> MemberInput:
        found = given
        for side in ("concave", "convex"):
            flank = getattr(found, side)
            cutter = flank.cutter.model_copy(update={"edge_radius": radius})
            found = found.model_copy(update={side: flank.model_copy(update={"cutter": cutter})})
        return found

    return design.model_copy(update={name: member(getattr(design, name)) for name in ("pinion", "gear")})


def root_peaks(design: Design, member: Member, counts: Counts, cells: int, module: float) -> dict[str, RootPeaks]:
    """Both methods on one member, loaded on its drive flank."""
    given = design.pinion if member == "pinion" else design.gear
    body, blank = given.tooth_body(), given.blank
    material = body.material
    clock = time.perf_counter()
    fem = ToothElements(
        design, member, body.rim_thickness, material.youngs_modulus, material.poisson_ratio, counts, cells, body.held
    )
    grid = fem.grid
    upper = grid.sides[1] == design.flanks().loaded_side(member, "drive")
    corner = fem.basis.nodal_dofs[0]
    solid = solid_tooth_of(design.flanks(), body, member, "drive")
    loads, tooth = [], root_tooth(design.flanks(), member, solid, module, cells)
    forces, points = np.zeros((3, fem.basis.N, len(LINES))), []
    for number, ((c0, h0), (c1, h1)) in enumerate(LINES.values()):
        stations = np.arange(round(c0 * counts.along), round(c1 * counts.along) + 1)
        share = (stations / counts.along - c0) / (c1 - c0)
        depth = (grid.height[:, stations] - grid.height[0, stations]) / (
            grid.height[-1, stations] - grid.height[0, stations]
        )
        rows = np.abs(depth - (h0 + share * (h1 - h0))).argmin(axis=0)
        weight = np.sqrt(np.clip(1.0 - (2.0 * share - 1.0) ** 2, 0.0, 1.0)) + 0.2
        weight *= FORCE / weight.sum()
        nodes, normals = fem.node(rows, stations, upper), fem.normals(rows, stations, upper)
        forces[:, corner[nodes], number] -= normals.T * weight
        face = grid.u[0, stations] - grid.u[0, 0]
        points.append((face, grid.height[rows, stations] - blank.root(grid.u[0, stations]), weight))
        loads.append(number)
    right = fem.expand.T @ forces.reshape(-1, len(LINES))
    moved = np.asarray(fem.expand @ conjugate_gradients(fem.stiffness, right)).reshape(3, fem.basis.N, -1)
    seconds = time.perf_counter() - clock
    station, stress = _fillet_stress(fem, moved, upper, material.youngs_modulus, material.poisson_ratio)
    result = {}
    for number, name in enumerate(LINES):
        carried = tooth.forces.of(*points[number])
        model = np.einsum("xs,xsp->sp", carried, tooth.loaded).max(axis=1)
        # greatest over the fillet in each column of elements
        peaks = np.array([stress[station == k, :, number].max() for k in range(counts.along)])
        face = (np.arange(counts.along) + 0.5) / counts.along * tooth.forces.cell.width
        result[name] = RootPeaks(face, peaks, np.interp(face, tooth.station, model), fem.stiffness.shape[0], seconds)
    return result


def _fillet_stress(
    fem: ToothElements, moved: FloatArray, upper: bool, modulus: float, poisson: float
) -> tuple[FloatArray, FloatArray]:
    """Column of each face of the fillet of the loaded side, and the greatest principal stress at its points."""
    counts, place = fem.counts, fem.place
    column = counts.tooth if upper else 0
    at = (place[2] == column) & (place[1] >= counts.body) & (place[1] <= counts.body + counts.rows // 2)
    mesh = fem.basis.mesh
    facets = np.flatnonzero(at[mesh.facets].all(axis=0) & (mesh.f2t[1] == -1))
    basis = FacetBasis(mesh, fem.basis.elem, facets=facets, intorder=2)
    station = place[0][mesh.facets[:, facets]].min(axis=0)
    lame = modulus * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    shear = modulus / (2.0 * (1.0 + poisson))
    found = []
    for number in range(moved.shape[2]):
        gradient = np.stack([np.asarray(basis.interpolate(moved[x, :, number]).grad) for x in range(3)])
        strain = np.moveaxis(0.5 * (gradient + gradient.transpose(1, 0, 2, 3)), (0, 1), (-2, -1))
        trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
        found.append(np.linalg.eigvalsh(lame * trace + 2.0 * shear * strain)[..., -1].mean(axis=1, keepdims=True))
    return station, np.stack(found, axis=-1)


MEMBERS: tuple[tuple[str, Member, float], ...] = (
    ("fm_spiral_bevel_14x39", "gear", 0.8e-3),
    ("fm_hypoid_13x42", "pinion", 0.65e-3),
    ("fh_hypoid_9x34", "gear", 1.0e-3),
)
COUNTS = Counts(4, 3, 24, 4, 10)


def main() -> None:
    """Draw docs/figures/root_stress_fem.png: stress along the face of three members by both methods."""
    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    for axes, (name, member, radius) in zip(figure.subplots(1, len(MEMBERS)), MEMBERS, strict=True):
        found = root_peaks(with_edge_radius(load_design(name), radius), member, COUNTS, 1, 4.0 * radius)
        for color, (load, peaks) in zip(("#1f5a99", "#c8651b"), found.items(), strict=True):
            elements, model = peaks.elements.max() / 1e6, peaks.model.max() / 1e6
            print(f"{name} {member}, {load}: elements {elements:.0f} MPa, model {model:.0f} MPa, {peaks.seconds:.0f} s")
            axes.plot(1e3 * peaks.face, peaks.elements / 1e6, "o", color=color, label=f"{load}: elements")
            axes.plot(1e3 * peaks.face, peaks.model / 1e6, "-", color=color, label="model")
        axes.set(title=f"{name}, {member}", xlabel="distance from the toe [mm]", ylabel="root stress [MPa]")
    figure.axes[0].legend(frameon=False, fontsize=7, loc="lower center")
    figure.savefig(Path(__file__).parents[2] / "docs" / "figures" / "root_stress_fem.png", dpi=130)


if __name__ == "__main__":
    main()
