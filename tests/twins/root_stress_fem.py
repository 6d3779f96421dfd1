"""Root stress under the pair's own contact forces against other finite elements of the same teeth.

An independent second computation: the mesh of `compliance_fem` (corners of the elements straight from `tooth_grid`,
27-node hexahedra of scikit-fem with flat sides, conjugate gradients) of three teeth in a ring, each loaded by the
contact forces of its pair; greatest principal stress at the faces of the elements that make the fillet. As a script it
prints the table of docs/strength.md.
"""

import math
import sys
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skfem import FacetBasis
from twins.compliance_fem import Counts, ToothElements, conjugate_gradients

import efficiency
from efficiency.contact.gear_flanks import Member
from efficiency.design.design import Design, MemberInput
from efficiency.ltca.solid_tooth import solid_tooth_of
from efficiency.mesh import LoadedMesh
from efficiency.strength.root_mesh import EDGE_RADIUS
from efficiency.strength.root_stress import root_stress, root_tooth

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
TEETH = 3


@dataclass(frozen=True)
class RootPeaks:
    """Greatest stress of the fillet of the loaded side at the worst position of the mesh, by both methods [Pa].

    Attributes
    ----------
    elements, model : float
    unknowns : int
        Of the elements of the check.
    seconds : float
    """

    elements: float
    model: float
    unknowns: int
    seconds: float

    @property
    def error(self) -> float:
        """Of the model [-]."""
        return self.model / self.elements - 1.0


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


def root_peaks(loaded: LoadedMesh, member: Member, counts: Counts, radius: float) -> RootPeaks:
    """Both methods on one member with an edge radius [m], under the contact forces of a loaded mesh."""
    design = with_edge_radius(loaded.mesh.bevel, radius)
    given = design.pinion if member == "pinion" else design.gear
    body, flanks, pitch = given.tooth_body(), design.flanks(), 2.0 * math.pi / design.pinion.blank.teeth
    tooth = root_tooth(flanks, member, solid_tooth_of(flanks, body, member, "drive"), loaded.mesh.pitch.module_normal)
    load = loaded.grids.fine
    model = root_stress(tooth, load.positions, pitch)
    roll = model.roll[model.history.argmax()]
    clock = time.perf_counter()
    material = body.material
    fem = ToothElements(
        design, member, body.rim_thickness, material.youngs_modulus, material.poisson_ratio, counts, TEETH, body.held
    )
    upper = fem.grid.sides[1] == flanks.loaded_side(member, "drive")
    # at the worst position; the next tooth in rising azimuth carries the next pair or the one before
    [(at, own)] = [
        (p, round((roll - p.position.pinion_angle) / pitch))
        for p in load.positions
        if abs((roll - p.position.pinion_angle) / pitch - round((roll - p.position.pinion_angle) / pitch)) < 1e-6
    ]
    ahead = (1 if upper else -1) * (1 if member == "pinion" else -1)
    forces = np.zeros((3, fem.basis.N))
    corner = fem.basis.nodal_dofs[0]
    face, height = (getattr(at.position, f"{name}_{member}") for name in ("face", "height"))
    for step in (-1, 0, 1):
        points = (at.position.pair == own + step * ahead) & (at.force > 0.0)
        _add(fem, forces, corner, face[points], height[points], at.force[points], upper, 1 + step)
    moved = np.asarray(fem.expand @ conjugate_gradients(fem.stiffness, fem.expand.T @ forces.reshape(-1, 1)))
    stress = _fillet_stress(fem, moved.reshape(3, -1), upper, material.youngs_modulus, material.poisson_ratio)
    return RootPeaks(stress.max(), model.tension, fem.stiffness.shape[0], time.perf_counter() - clock)


def _add(
    fem: ToothElements,
    forces: FloatArray,
    corner: IntArray,
    face: FloatArray,
    height: FloatArray,
    force: FloatArray,
    upper: bool,
    tooth: int,
) -> None:
    """Add normal forces at distances from the toe and over the root cone, shared out to the corners around them."""
    grid = fem.grid
    stations = grid.u[0] - grid.u[0, 0]
    levels = grid.height - grid.blank.root(grid.u[0])
    turn = tooth * grid.pitch
    matrix = np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    for x, h, f in zip(face, height, force, strict=True):
        k = int(np.clip(np.searchsorted(stations, x) - 1, 0, stations.size - 2))
        t = float(np.clip((x - stations[k]) / (stations[k + 1] - stations[k]), 0.0, 1.0))
        level = (1.0 - t) * levels[:, k] + t * levels[:, k + 1]
        i = int(np.clip(np.searchsorted(level, h) - 1, 0, level.size - 2))
        s = float(np.clip((h - level[i]) / (level[i + 1] - level[i]), 0.0, 1.0))
        rows, columns = np.array([i, i, i + 1, i + 1]), np.array([k, k + 1, k, k + 1])
        share = np.array([(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t])
        nodes = fem.node(rows, columns, upper, tooth)
        normals = fem.normals(rows, columns, upper) @ matrix.T
        np.subtract.at(forces, (slice(None), corner[nodes]), normals.T * share * f)


def _fillet_stress(fem: ToothElements, moved: FloatArray, upper: bool, modulus: float, poisson: float) -> FloatArray:
    """Greatest principal stress at the points of the fillet of the loaded side of the middle tooth."""
    counts, place = fem.counts, fem.place
    column = counts.tooth + counts.slot + (counts.tooth if upper else 0)
    at = (place[2] == column) & (place[1] >= counts.body) & (place[1] <= counts.body + counts.rows // 2)
    mesh = fem.basis.mesh
    facets = np.flatnonzero(at[mesh.facets].all(axis=0) & (mesh.f2t[1] == -1))
    basis = FacetBasis(mesh, fem.basis.elem, facets=facets, intorder=2)
    lame = modulus * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    shear = modulus / (2.0 * (1.0 + poisson))
    gradient = np.stack([np.asarray(basis.interpolate(moved[x]).grad) for x in range(3)])
    strain = np.moveaxis(0.5 * (gradient + gradient.transpose(1, 0, 2, 3)), (0, 1), (-2, -1))
    trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    # the mean of a face: the corners between flat sides raise the stress there
    return np.asarray(np.linalg.eigvalsh(lame * trace + 2.0 * shear * strain)[..., -1].mean(axis=1))


COUNTS = Counts(4, 3, 30, 4, 14)
DESIGNS = (
    "fm_spiral_bevel_14x39",
    "fm_hypoid_13x42",
    "fh_hypoid_9x34",
    "fh_hypoid_9x34_offset_10",
    "fh_spiral_bevel_12x37",
)


def main() -> None:
    """Print the stress of each member of the designs named, else of `DESIGNS`, by both methods."""
    for name in sys.argv[1:] or DESIGNS:
        loaded = efficiency.load(name).mesh().load()
        radius = EDGE_RADIUS * loaded.mesh.pitch.module_normal
        members: tuple[Member, Member] = ("pinion", "gear")
        for member in members:
            found = root_peaks(loaded, member, COUNTS, radius)
            print(
                f"| {name}, {member} | {found.elements / 1e6:.0f} | {found.model / 1e6:.0f} "
                f"| {100 * found.error:+.1f} % | {found.unknowns} | {found.seconds:.0f} s |",
                flush=True,
            )


if __name__ == "__main__":
    main()
